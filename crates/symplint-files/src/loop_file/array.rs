//! Arrays in NumPy's format.

use std::path::Path;

use super::LoopFileError;

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
pub enum NumberKind {
    /// Floating-point numbers: what a step computes.
    Floats,
    /// Integers, too: people write h = 1.
    Numbers,
}

impl Array {
    /// Decodes the bytes of an `.npy` file; `array` is its name in an archive, or empty.
    pub fn decode(
        bytes: &[u8],
        kind: NumberKind,
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
        let Header {
            descr,
            fortran_order,
            shape,
            start,
        } = Header::read(bytes).map_err(broken)?;
        let (width, number): (usize, fn(&[u8]) -> f64) = match (descr, kind) {
            ("<f8", _) => (8, |of| f64::from_le_bytes(word(of))),
            (">f8", _) => (8, |of| f64::from_be_bytes(word(of))),
            ("<f4", _) => (4, |of| f32::from_le_bytes(word(of)).into()),
            (">f4", _) => (4, |of| f32::from_be_bytes(word(of)).into()),
            ("<i8", NumberKind::Numbers) => (8, |of| i64::from_le_bytes(word(of)) as f64),
            (">i8", NumberKind::Numbers) => (8, |of| i64::from_be_bytes(word(of)) as f64),
            ("<i4", NumberKind::Numbers) => (4, |of| i32::from_le_bytes(word(of)).into()),
            (">i4", NumberKind::Numbers) => (4, |of| i32::from_be_bytes(word(of)).into()),
            _ => {
                return Err(LoopFileError::Type {
                    path: path.to_owned(),
                    array: array.to_owned(),
                    descr: descr.to_owned(),
                });
            }
        };
        // With an axis of length zero there are no values, and the other axes can claim any length: nothing is
        // read. Callers that need values refuse the shape.
        let count = match shape.contains(&0) {
            true => 0,
            false => (shape.iter()).fold(1, |count: u128, &axis| count.saturating_mul(axis.into())),
        };
        let promised = count.saturating_mul(width as u128);
        if promised > (bytes.len() - start) as u128 {
            return Err(cut_short(promised.saturating_add(start as u128)));
        }
        let shape: Vec<usize> = shape.into_iter().map(|axis| axis as usize).collect();
        let stored = (bytes[start..].chunks_exact(width))
            .take(count as usize)
            .map(number);
        let values = match shape[..] {
            [rows, columns] if fortran_order && count > 0 => {
                let stored: Vec<f64> = stored.collect();
                (0..rows)
                    .flat_map(|row| (0..columns).map(move |column| column * rows + row))
                    .map(|index| stored[index])
                    .collect()
            }
            _ => stored.collect(),
        };
        Ok(Array {
            shape,
            values,
            single: descr.ends_with("f4"),
        })
    }

    /// The bytes of an `.npy` file in double precision.
    pub fn encode(&self) -> Vec<u8> {
        let axes: String = self.shape.iter().map(|axis| format!("{axis},")).collect();
        let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({axes}), }}");
        // Values start at a multiple of 64 bytes; the last byte of the header ends a line.
        let size = (10 + header.len() + 1).next_multiple_of(64);
        header.extend(std::iter::repeat_n(' ', size - 11 - header.len()));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(self.values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }
}

/// The bytes of one number.
fn word<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.try_into().expect("a chunk has the width of its type")
}

/// What stands before the values: a Python dictionary with three entries
/// (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).
struct Header<'a> {
    /// The type of the numbers as numpy names it: `<f8`.
    descr: &'a str,
    fortran_order: bool,
    shape: Vec<u64>,
    /// Bytes before the first value.
    start: usize,
}

impl<'a> Header<'a> {
    /// Reads the header; the bytes hold the whole of it.
    fn read(bytes: &'a [u8]) -> Result<Self, String> {
        let size = header_size(bytes).ok_or("it does not start as numpy's files do")? as usize;
        let fields = if bytes[6] == 1 { 10 } else { 12 };
        let text = str::from_utf8(&bytes[fields..size]).map_err(|error| error.to_string())?;
        let missing = |name: &str| format!("its header has no valid entry '{name}'");
        let dictionary = (text.trim())
            .strip_prefix('{')
            .and_then(|text| text.strip_suffix('}'))
            .ok_or("its header is not a dictionary")?;
        let entries = entries(dictionary);
        let entry = |name: &str| {
            (entries.iter())
                .filter_map(|entry| entry.split_once(':'))
                .find(|(key, _)| key.trim().trim_matches(['\'', '"']) == name)
                .map(|(_, value)| value.trim())
        };
        let axes = |value: &str| {
            (value.strip_prefix('(')?.strip_suffix(')')?.split(','))
                .map(str::trim)
                .filter(|axis| !axis.is_empty())
                .map(|axis| axis.parse().ok())
                .collect()
        };
        Ok(Header {
            descr: entry("descr")
                .ok_or_else(|| missing("descr"))?
                .trim_matches(['\'', '"']),
            fortran_order: match entry("fortran_order") {
                Some("True") => true,
                Some("False") => false,
                _ => return Err(missing("fortran_order")),
            },
            shape: (entry("shape").and_then(axes)).ok_or_else(|| missing("shape"))?,
            start: size,
        })
    }
}

/// Entries of a dictionary: what stands between its commas, if these are neither in brackets nor in quotes.
fn entries(dictionary: &str) -> Vec<&str> {
    let (mut depth, mut quote) = (0_usize, None);
    dictionary
        .split(|character| {
            match (quote, character) {
                (Some(open), _) if open == character => quote = None,
                (Some(_), _) => {}
                (None, '\'' | '"') => quote = Some(character),
                (None, '(' | '[' | '{') => depth += 1,
                (None, ')' | ']' | '}') => depth = depth.saturating_sub(1),
                _ => {}
            }
            quote.is_none() && depth == 0 && character == ','
        })
        .collect()
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

    /// A file of version 2 with this header and these values.
    fn file(header: &str, values: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values);
        bytes
    }

    fn decode(header: &str, values: &[u8]) -> Result<Array, String> {
        Array::decode(
            &file(header, values),
            NumberKind::Numbers,
            Path::new("a.npy"),
            "",
        )
        .map_err(|error| error.to_string())
    }

    /// Headers as numpy 1.26 and 2.3 write them, Python 2's spacing among them.
    #[test]
    fn headers_of_numpy_are_read() {
        let values: Vec<u8> = [1_i32, 2, 3, 4, 5, 6].map(i32::to_be_bytes).concat();
        let header = "{'descr': '>i4', 'fortran_order': True, 'shape': (2, 3), }      \n";
        let array = decode(header, &values).unwrap();
        assert_eq!(array.shape, [2, 3]);
        assert_eq!(array.values, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
        let header = "{\"shape\":(6,),\"fortran_order\":False,\"descr\":\">i4\"}";
        assert_eq!(decode(header, &values).unwrap().shape, [6]);
        let header =
            "{'descr': [('a', '<f8'), ('b, c', '<i4')], 'fortran_order': False, 'shape': (1,), }";
        let error = decode(header, &[0; 12]).err().unwrap();
        assert!(error.contains("[('a', '<f8'), ('b, c', '<i4')]"), "{error}");
        let scalar = decode(
            "{'descr': '<i8', 'fortran_order': False, 'shape': (), }",
            &[7, 0, 0, 0, 0, 0, 0, 0],
        );
        assert_eq!(scalar.unwrap().values, [7.0]);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let array = Array {
            shape: vec![2, 3],
            values: vec![0.5, -1.0, 2.0, f64::MAX, 0.0, 1e-300],
            single: false,
        };
        let bytes = array.encode();
        assert_eq!(header_size(&bytes).unwrap() % 64, 0);
        let read = Array::decode(&bytes, NumberKind::Floats, Path::new("a.npy"), "").unwrap();
        assert_eq!((read.shape, read.values), (array.shape, array.values));
    }

    #[test]
    fn headers_that_are_no_dictionary_are_refused() {
        for (header, reason) in [
            ("", "not a dictionary"),
            (&"{1:".repeat(4000), "not a dictionary"),
            (&format!("{{{}}}", "[".repeat(1 << 20)), "'descr'"),
            ("{'descr': '<f8', 'shape': (1,)}", "'fortran_order'"),
            (
                "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}",
                "'shape'",
            ),
            (
                "{'descr': '<f8', 'fortran_order': False, 'shape': 3}",
                "'shape'",
            ),
        ] {
            let error = decode(header, &[0; 8]).err().unwrap();
            assert!(error.contains(reason), "{error}");
        }
        let huge = "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 99999999999)}";
        assert!(
            decode(huge, &[0; 8])
                .err()
                .unwrap()
                .contains("79999999998400000000097")
        );
    }
}
