//! Records as lines of CSV.

use std::fs::File;
use std::path::Path;

use csv::{StringRecord, Writer, WriterBuilder};
use serde::Serialize;

/// A file of records under a header; what is not given, or no number, is an empty field.
pub struct RecordTable {
    file: Writer<File>,
    is_empty: bool,
}

impl RecordTable {
    /// Creates the file, and replaces an existing one.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn create(path: &Path) -> csv::Result<Self> {
        Ok(RecordTable {
            file: Writer::from_path(path)?,
            is_empty: true,
        })
    }

    /// Adds a record, the header before the first.
    ///
    /// # Errors
    /// If it cannot be written, or is not a record of plain values.
    pub fn push(&mut self, record: &impl Serialize) -> csv::Result<()> {
        let mut fields = WriterBuilder::new()
            .has_headers(self.is_empty)
            .from_writer(Vec::new());
        fields.serialize(record)?;
        fields.flush()?;
        self.is_empty = false;
        let lines = fields.get_ref().as_slice();
        let mut lines = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(lines);
        let mut line = StringRecord::new();
        while lines.read_record(&mut line)? {
            // NaN stands for what is unknown, such as the step size of a loop from a file.
            let known = |field| if field == "NaN" { "" } else { field };
            self.file.write_record(line.iter().map(known))?;
        }
        Ok(())
    }

    /// Writes what is still in memory.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn flush(&mut self) -> csv::Result<()> {
        Ok(self.file.flush()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Row {
        name: &'static str,
        number: f64,
        other: Option<f64>,
    }

    #[test]
    fn unknown_numbers_are_empty_fields() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("table.csv");
        let mut table = RecordTable::create(&path).unwrap();
        for (number, other) in [
            (f64::NAN, None),
            (0.1, Some(f64::NAN)),
            (-1e-300, Some(2.0)),
        ] {
            let name = "a \"name\", quoted";
            table
                .push(&Row {
                    name,
                    number,
                    other,
                })
                .unwrap();
        }
        table.flush().unwrap();
        let name = "\"a \"\"name\"\", quoted\"";
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            format!("name,number,other\n{name},,\n{name},0.1,\n{name},-1e-300,2.0\n")
        );
    }
}
