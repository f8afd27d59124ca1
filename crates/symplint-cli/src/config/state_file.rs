//! Initial states from files: `.npy` with two rows, `.csv` with two columns.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use npyz::{NpyFile, Order};

/// Why a state file is of no use, and what to do.
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
                format!("{name} is neither .npy nor .csv"),
                "give a NumPy array of two rows (.npy) or a table of two columns (.csv)",
            ));
        }
    };
    if q.len() != dof {
        return Err(unusable(
            format!(
                "{name} holds {} degrees of freedom where the system has {dof}",
                q.len()
            ),
            "make the two agree",
        ));
    }
    for (coordinate, values) in [("position", &q), ("momentum", &p)] {
        if let Some(i) = values.iter().position(|value| !value.is_finite()) {
            return Err(unusable(
                format!(
                    "{name} has {} as {coordinate} of degree of freedom {i}",
                    values[i]
                ),
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
            "paths are relative to the configuration file",
        )
    })
}

fn read_npy(path: &Path) -> Result<(Vec<f64>, Vec<f64>), StateFileError> {
    let name = path.display();
    let broken = |error: std::io::Error| {
        unusable(
            format!("{name} is no NumPy array that can be read: {error}"),
            "write an array of double precision by numpy.save",
        )
    };
    let bytes = open(path)?.get_ref().metadata().map_err(broken)?.len();
    let file = NpyFile::new(open(path)?).map_err(broken)?;
    let shape = file.shape().to_vec();
    let [2, columns] = shape[..] else {
        return Err(unusable(
            format!("{name} has the shape {shape:?}"),
            "give an array of shape (2, dof): row 0 positions, row 1 momenta",
        ));
    };
    let order = file.order();
    let descr = file.dtype().descr();
    let width = match descr.trim_matches('\'') {
        "<f8" | ">f8" => 8,
        "<f4" | ">f4" => 4,
        _ => {
            return Err(unusable(
                format!("{name} holds {descr} values"),
                "give double or single precision numbers",
            ));
        }
    };
    // Before anything is allocated: a header can claim any size.
    if columns
        .checked_mul(2 * width)
        .is_none_or(|needed| needed > bytes)
    {
        return Err(unusable(
            format!("{name} is cut short: its header promises 2 × {columns} numbers"),
            "write it again",
        ));
    }
    let columns = columns as usize;
    let values: Vec<f64> = if width == 4 {
        let single: Vec<f32> = file.into_vec().map_err(broken)?;
        single.into_iter().map(f64::from).collect()
    } else {
        file.into_vec().map_err(broken)?
    };
    let at = |row: usize| {
        (0..columns)
            .map(|column| match order {
                Order::C => values[row * columns + column],
                Order::Fortran => values[2 * column + row],
            })
            .collect()
    };
    Ok((at(0), at(1)))
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
            // A first row of words is a header; a number mistyped is none.
            _ if row == 0 && !record.as_slice().contains(|c: char| c.is_ascii_digit()) => {}
            _ => {
                return Err(unusable(
                    format!(
                        "{name} has no numbers in row {}: {}",
                        row + 1,
                        record.as_slice()
                    ),
                    columns,
                ));
            }
        }
    }
    Ok((q, p))
}
