//! Tables of numbers: columns q_0 … q_{d−1}, p_0 … p_{d−1}, one line for each sample.

use std::path::{Path, PathBuf};

use csv::StringRecord;
use symplint::Snapshot;

use super::array::Array;
use super::{LoopFile, LoopFileError, MIN_SAMPLES};

/// From this number of digits on, a number is a double.
const DIGITS_OF_DOUBLE: u32 = 16;

/// Up to this number of digits, it may be a single precision number that was written out.
const DIGITS_OF_SINGLE: u32 = 9;

pub fn read(path: &Path) -> Result<LoopFile, LoopFileError> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_path(path)
        .map_err(|error| LoopFileError::Read {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
    let wrong = |line: u64, message: String| LoopFileError::Table {
        path: path.to_owned(),
        line,
        message,
    };
    let mut columns: Option<Columns> = None;
    let (mut q, mut p) = (Vec::new(), Vec::new());
    let (mut samples, mut digits) = (0, 0);
    for record in reader.records() {
        let record = record.map_err(|error| LoopFileError::Read {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        let columns = match &columns {
            Some(columns) => columns,
            None => {
                let header = is_header(&record);
                let found = if header {
                    Columns::named(&record)
                } else {
                    Columns::counted(record.len())
                };
                let found = columns.insert(found.map_err(|message| wrong(line, message))?);
                if header {
                    continue;
                }
                found
            }
        };
        if record.len() != columns.of_all {
            let message = format!(
                "{} columns where there were {}",
                record.len(),
                columns.of_all
            );
            return Err(wrong(line, message));
        }
        for (values, wanted) in [(&mut q, &columns.q), (&mut p, &columns.p)] {
            for &column in wanted {
                let text = &record[column];
                let value: f64 = (text.parse())
                    .map_err(|_| wrong(line, format!("\"{text}\" is not a number")))?;
                digits = digits.max(significant_digits(text));
                values.push(value);
            }
        }
        samples += 1;
    }
    let dof = columns.map_or(0, |columns| columns.q.len());
    let array = |values| Array {
        shape: vec![samples, dof],
        values,
        single: false,
    };
    let mut loaded = LoopFile::from_arrays(path, &array(q), &array(p), MIN_SAMPLES)?;
    loaded.unit_roundoff = match digits {
        DIGITS_OF_DOUBLE.. => Snapshot::DOUBLE,
        _ => {
            let rounding = 0.5 * 0.1f64.powi(digits.max(2) as i32 - 1);
            if digits <= DIGITS_OF_SINGLE {
                rounding.max(Snapshot::SINGLE)
            } else {
                rounding
            }
        }
    };
    Ok(loaded)
}

/// Which columns hold what.
struct Columns {
    q: Vec<usize>,
    p: Vec<usize>,
    of_all: usize,
}

impl Columns {
    /// Without a header: the first half positions, the second half momenta.
    fn counted(count: usize) -> Result<Self, String> {
        if count == 0 || count % 2 == 1 {
            let remedy = match count {
                1 => "separate the columns by commas",
                _ => "give as many q as p, or a first line with the names of the columns",
            };
            return Err(format!(
                "{count} columns are not as many positions as momenta; {remedy}"
            ));
        }
        Ok(Columns {
            q: (0..count / 2).collect(),
            p: (count / 2..count).collect(),
            of_all: count,
        })
    }

    /// By a header: q, q_0 or q0 and so on, and `s`, which is ignored.
    fn named(header: &StringRecord) -> Result<Self, String> {
        let mut found = [Vec::new(), Vec::new()];
        for (column, name) in header.iter().enumerate() {
            let (which, number) = match name.split_at_checked(1) {
                Some(("q", rest)) => (0, rest),
                Some(("p", rest)) => (1, rest),
                Some(("s", "")) => continue,
                _ => return Err(format!("unknown column \"{name}\"")),
            };
            let dof: usize = match number.strip_prefix('_').unwrap_or(number) {
                "" => 0,
                digits => digits
                    .parse()
                    .map_err(|_| format!("\"{name}\" names no degree of freedom"))?,
            };
            found[which].push((dof, column));
        }
        let [q, p] = found.map(|mut columns: Vec<(usize, usize)>| {
            columns.sort_unstable();
            columns
        });
        let complete = |columns: &[(usize, usize)]| {
            columns
                .iter()
                .enumerate()
                .all(|(expected, &(dof, _))| dof == expected)
        };
        if q.is_empty() || q.len() != p.len() || !complete(&q) || !complete(&p) {
            let names: Vec<&str> = header.iter().collect();
            return Err(format!(
                "the columns {} are not q and p of degrees of freedom 0, 1, …",
                names.join(", ")
            ));
        }
        let only = |columns: Vec<(usize, usize)>| columns.into_iter().map(|(_, c)| c).collect();
        Ok(Columns {
            q: only(q),
            p: only(p),
            of_all: header.len(),
        })
    }
}

/// A first line of names; a mistyped number is not a name.
pub fn is_header(record: &StringRecord) -> bool {
    (record.iter()).all(|field| {
        field.starts_with(|c: char| c.is_alphabetic()) && field.parse::<f64>().is_err()
    })
}

/// Digits of a number as written, without leading zeros and the exponent.
fn significant_digits(text: &str) -> u32 {
    let mantissa = text.split(['e', 'E']).next().unwrap_or("");
    let digits = mantissa.chars().filter(char::is_ascii_digit);
    digits.skip_while(|&digit| digit == '0').count() as u32
}

pub fn write(file: &LoopFile) -> Result<Vec<PathBuf>, LoopFileError> {
    let states = &file.states;
    let dof = states.dof();
    let write = || -> csv::Result<()> {
        let mut writer = csv::Writer::from_path(&file.path)?;
        let names = |c: &str| (0..dof).map(|i| format!("{c}_{i}")).collect::<Vec<_>>();
        writer.write_record([names("q"), names("p")].concat())?;
        for k in 0..states.samples() {
            let q = (0..dof).map(|i| states.q().row(i)[k]);
            let p = (0..dof).map(|i| states.p().row(i)[k]);
            // The shortest text that reads back as the same double.
            writer.write_record(q.chain(p).map(|value| format!("{value:?}")))?;
        }
        Ok(writer.flush()?)
    };
    write().map_err(|error| LoopFileError::Write {
        path: file.path.clone(),
        reason: error.to_string(),
    })?;
    Ok(vec![file.path.clone()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_as_written() {
        for (text, digits) in [
            ("1", 1),
            ("-0.00125", 3),
            ("1.2500e-7", 5),
            ("0", 0),
            ("3.141592653589793", 16),
        ] {
            assert_eq!(significant_digits(text), digits, "{text}");
        }
    }
}
