//! Arrays in NumPy's format.

use std::io;
use std::path::Path;

use npyz::{NpyFile, Order, WriterBuilder};

use super::LoopFileError;

/// Bytes of a header at most, as `numpy.load` has it.
const LONGEST_HEADER: usize = 10_000;

/// Brackets of a header that are opened at most. A dictionary with a shape has 2, one with a structured type some more;
/// where they are inside one another the parser takes up to four times as long for each.
const MOST_BRACKETS: usize = 8;

/// An array of numbers in row-major order.
pub struct Array {
    /// Lengths along each axis.
    pub shape: Vec<usize>,
    /// The values.
    pub values: Vec<f64>,
    /// Whether they were stored in single precision.
    pub single: bool,
}

/// Which numbers are taken.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Accept {
    /// Floating-point numbers: what a step computes.
    Floats,
    /// Integers, too: people write h = 1.
    Numbers,
}

impl Array {
    /// Decodes the bytes of an `.npy` file; `array` is its name in an archive, or empty.
    pub fn decode(
        bytes: &[u8],
        accept: Accept,
        path: &Path,
        array: &str,
    ) -> Result<Self, LoopFileError> {
        let broken = |reason: String| LoopFileError::Broken {
            path: path.to_owned(),
            array: array.to_owned(),
            reason,
        };
        let cut_short = |promised: u128| LoopFileError::CutShort {
            path: path.to_owned(),
            array: array.to_owned(),
            promised,
            there: bytes.len(),
        };
        // Before anything is allocated: a header can claim any size, for itself and for the values.
        if let Some(promised) = header_size(bytes).filter(|&size| size > bytes.len() as u128) {
            return Err(cut_short(promised));
        }
        check_header(bytes).map_err(broken)?;
        let file = NpyFile::new(bytes).map_err(|error| broken(error.to_string()))?;
        let descr = file.dtype().descr();
        let kind = descr.trim_matches('\'').to_owned();
        let width: u128 = match (kind.as_str(), accept) {
            ("<f8" | ">f8", _) | ("<i8" | ">i8", Accept::Numbers) => 8,
            ("<f4" | ">f4", _) | ("<i4" | ">i4", Accept::Numbers) => 4,
            _ => {
                return Err(LoopFileError::Type {
                    path: path.to_owned(),
                    array: array.to_owned(),
                    descr,
                });
            }
        };
        let shape = file.shape().to_vec();
        let promised =
            (shape.iter()).fold(width, |size, &axis| size.saturating_mul(u128::from(axis)));
        if promised > bytes.len() as u128 {
            return Err(cut_short(promised));
        }
        let shape: Vec<usize> = shape.into_iter().map(|axis| axis as usize).collect();
        // With an axis of length zero there are no values, and the other axes can claim any length: nothing is
        // read. Callers that need values refuse the shape.
        if shape.contains(&0) {
            return Ok(Array {
                shape,
                values: Vec::new(),
                single: kind.ends_with("f4"),
            });
        }
        let order = file.order();
        let stored: io::Result<Vec<f64>> = match &kind[1..] {
            "f8" => file.into_vec(),
            "f4" => (file.into_vec::<f32>()).map(|v| v.into_iter().map(f64::from).collect()),
            "i4" => (file.into_vec::<i32>()).map(|v| v.into_iter().map(f64::from).collect()),
            _ => (file.into_vec::<i64>()).map(|v| v.into_iter().map(|i| i as f64).collect()),
        };
        let stored = stored.map_err(|error| broken(error.to_string()))?;
        let values = match (order, &shape[..]) {
            (Order::Fortran, &[rows, columns]) => (0..rows)
                .flat_map(|row| (0..columns).map(move |column| column * rows + row))
                .map(|index| stored[index])
                .collect(),
            _ => stored,
        };
        Ok(Array {
            shape,
            values,
            single: kind.ends_with("f4"),
        })
    }

    /// The bytes of an `.npy` file in double precision.
    pub fn encode(&self) -> io::Result<Vec<u8>> {
        let shape: Vec<u64> = self.shape.iter().map(|&axis| axis as u64).collect();
        let mut bytes = Vec::new();
        let mut writer = npyz::WriteOptions::new()
            .default_dtype()
            .shape(&shape)
            .writer(&mut bytes)
            .begin_nd()?;
        writer.extend(self.values.iter())?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// Refuses headers that take the parser long: none that numpy writes of an array of numbers.
fn check_header(bytes: &[u8]) -> Result<(), String> {
    let header = match header_size(bytes) {
        Some(size) => &bytes[..bytes.len().min(size as usize)],
        None => return Ok(()),
    };
    if header.len() > LONGEST_HEADER {
        return Err(format!(
            "its header has {} bytes, and {LONGEST_HEADER} are the most that is read",
            header.len()
        ));
    }
    let opens = |byte: &&u8| matches!(byte, b'{' | b'[' | b'(');
    let brackets = header.iter().filter(opens).count();
    if brackets > MOST_BRACKETS {
        return Err(format!(
            "its header has {brackets} brackets, and {MOST_BRACKETS} are the most that is read"
        ));
    }
    Ok(())
}

/// Size of the header of an `.npy` file with all that comes before it; `None` if it is not such a file.
fn header_size(bytes: &[u8]) -> Option<u128> {
    if !bytes.starts_with(b"\x93NUMPY") {
        return None;
    }
    match *bytes.get(6)? {
        1 => Some(10 + u128::from(u16::from_le_bytes(bytes.get(8..10)?.try_into().ok()?))),
        _ => Some(12 + u128::from(u32::from_le_bytes(bytes.get(8..12)?.try_into().ok()?))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of a file of version 2 with this header and no values.
    fn error_of(header: &str) -> String {
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(header.as_bytes());
        let decoded = Array::decode(&bytes, Accept::Floats, Path::new("a.npy"), "");
        decoded.err().unwrap().to_string()
    }

    /// Without the limits the first of them takes longer than anyone waits: four times as long for each bracket.
    #[test]
    fn headers_that_take_the_parser_long_are_refused() {
        for open in ["{", "{1:", "{'}':", "(", "["] {
            let error = error_of(&open.repeat(MOST_BRACKETS));
            assert!(error.contains("holds no array"), "{open}: {error}");
            let error = error_of(&open.repeat(4000));
            assert!(
                error.contains("are the most that is read"),
                "{open}: {error}"
            );
        }
        let error = error_of(&"9".repeat(1 << 20));
        assert!(error.contains("has 1048588 bytes"), "{error}");
    }
}
