//! Initial states from files: `.npy` with two rows, `.csv` with two columns.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use symplint_files::loop_file::{Array, NumberKind, is_header};

/// Why a state file cannot be used, and the remedy.
#[derive(Debug)]
pub struct StateFileError {
    pub message: String,
    pub remedy: String,
}

fn unusable(message: impl Into<String>, remedy: impl Into<String>) -> StateFileError {
    StateFileError {
        message: message.into(),
        remedy: remedy.into(),
    }
}

/// Positions and momenta of `dof` degrees of freedom.
pub fn read_state(path: &Path, dof: usize) -> Result<(Vec<f64>, Vec<f64>), StateFileError> {
    let name = path.display();
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let (q, p) = match extension {
        "npy" => read_npy(path)?,
        "csv" => read_csv(path)?,
        _ => {
            return Err(unusable(
                format!("{name} is not a .npy or .csv file"),
                "give a NumPy array of two rows (.npy) or a table of two columns (.csv)",
            ));
        }
    };
    if q.len() != dof {
        return Err(unusable(
            format!(
                "{name} has {} degrees of freedom, but the system has {dof}",
                q.len()
            ),
            "give one position and one momentum for each degree of freedom of the system",
        ));
    }
    for (coordinate, values) in [("q", &q), ("p", &p)] {
        if let Some(i) = values.iter().position(|value| !value.is_finite()) {
            return Err(unusable(
                format!("in {name} {coordinate}[{i}] is {}", values[i]),
                "give finite numbers",
            ));
        }
    }
    Ok((q, p))
}

fn open(path: &Path) -> Result<BufReader<File>, StateFileError> {
    File::open(path).map(BufReader::new).map_err(|error| {
        unusable(
            format!("cannot open {}: {error}", path.display()),
            "check the path; it is relative to the folder of the configuration file",
        )
    })
}

fn read_npy(path: &Path) -> Result<(Vec<f64>, Vec<f64>), StateFileError> {
    let broken =
        |reason: String| unusable(reason, "write an array of double precision with numpy.save");
    let mut bytes = Vec::new();
    let read = open(path)?.read_to_end(&mut bytes);
    read.map_err(|error| broken(format!("cannot read {}: {error}", path.display())))?;
    let mut array = Array::decode(&bytes, NumberKind::Floats, path, "")
        .map_err(|error| broken(error.to_string()))?;
    let [2, dof] = array.shape[..] else {
        return Err(unusable(
            format!("{} has the shape {:?}", path.display(), array.shape),
            "give an array of shape (2, dof): row 0 positions, row 1 momenta",
        ));
    };
    let p = array.values.split_off(dof);
    Ok((array.values, p))
}

fn read_csv(path: &Path) -> Result<(Vec<f64>, Vec<f64>), StateFileError> {
    let name = path.display();
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(open(path)?);
    let (mut q, mut p) = (Vec::new(), Vec::new());
    for (row, record) in reader.records().enumerate() {
        let columns = "give two columns, positions and momenta, separated by a comma";
        let record =
            record.map_err(|error| unusable(format!("{name} cannot be read: {error}"), columns))?;
        if record.len() != 2 {
            return Err(unusable(
                format!("{name} has {} columns in row {}", record.len(), row + 1),
                columns,
            ));
        }
        match (record[0].parse(), record[1].parse()) {
            (Ok(position), Ok(momentum)) => {
                q.push(position);
                p.push(momentum);
            }
            _ if row == 0 && is_header(&record) && record.iter().all(is_name) => {}
            _ => {
                return Err(unusable(
                    format!(
                        "{name} has \"{}\" in row {} instead of two numbers",
                        record.iter().collect::<Vec<_>>().join(", "),
                        row + 1
                    ),
                    columns,
                ));
            }
        }
    }
    Ok((q, p))
}

/// Whether a field of the first row is a column name: without a digit, or as in tables of loops, q_0 or p0. Any
/// other field with a digit may be a mistyped number, such as O.1, and must not be skipped.
fn is_name(field: &str) -> bool {
    let bare = field.trim_end_matches(|c: char| c.is_ascii_digit());
    let of_loops = matches!(bare.strip_suffix('_').unwrap_or(bare), "q" | "p");
    of_loops || !field.contains(|c: char| c.is_ascii_digit())
}
