//! The bytes of a journal: a header, then one record after the other.
//!
//! All numbers are little-endian. A header is
//!
//! ```text
//! "symplint journal 1\n" | length of the text, u64 | what the run is, as JSON | checksum
//! ```
//!
//! and a record
//!
//! ```text
//! key, 16 bytes | how often it was asked for before, u32 | count of numbers, u64 | numbers, f64 | checksum
//! ```
//!
//! A checksum is the first 8 bytes of the SHA-256 of all before it, from the beginning of the header or the record.

use std::io::{self, ErrorKind, Read};

use crate::key::Key;

/// How every journal begins.
pub const MAGIC: &[u8] = b"symplint journal 1\n";

/// Bytes before the count of numbers of a record.
pub const COUNT: u64 = 16 + 4;

/// Bytes before its numbers.
pub const PREFIX: u64 = COUNT + 8;

/// Bytes of a checksum.
pub const CHECKSUM: u64 = 8;

/// Descriptions of runs are shorter than this.
const LONGEST_TEXT: u64 = 1 << 24;

/// A call, and how often the same was asked for before.
pub type Call = (Key, u32);

/// The bytes of a header.
pub fn header(text: &str) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(text.as_bytes());
    with_checksum(bytes)
}

/// The bytes of a record.
pub fn record((key, before): Call, numbers: impl ExactSizeIterator<Item = f64>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(PREFIX as usize + 8 * numbers.len() + CHECKSUM as usize);
    bytes.extend(key);
    bytes.extend(before.to_le_bytes());
    bytes.extend((numbers.len() as u64).to_le_bytes());
    numbers.for_each(|x| bytes.extend(x.to_bits().to_le_bytes()));
    with_checksum(bytes)
}

fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = hmac_sha256::Hash::hash(&bytes);
    bytes.extend(&sum[..CHECKSUM as usize]);
    bytes
}

/// What the beginning of a file says.
pub enum Header {
    /// What the run is, and how many bytes say so.
    Whole(String, u64),
    /// It is not whole, or its bytes changed.
    Damaged,
    /// It is not a journal.
    Foreign,
}

/// Reads a header.
///
/// # Errors
/// Those of the operating system.
pub fn read_header(file: &mut impl Read) -> io::Result<Header> {
    let mut file = Hashing::new(file);
    let mut magic = Vec::new();
    file.up_to(MAGIC.len() as u64, &mut magic)?;
    if magic != MAGIC {
        return Ok(match MAGIC.starts_with(&magic) {
            true => Header::Damaged,
            false => Header::Foreign,
        });
    }
    let (mut length, mut text) = (Vec::new(), Vec::new());
    file.up_to(8, &mut length)?;
    let Ok(length) = <[u8; 8]>::try_from(&length[..]).map(u64::from_le_bytes) else {
        return Ok(Header::Damaged);
    };
    if length > LONGEST_TEXT {
        return Ok(Header::Foreign);
    }
    file.up_to(length, &mut text)?;
    let whole = file.ends_with_checksum()?;
    Ok(match String::from_utf8(text) {
        _ if !whole => Header::Damaged,
        Ok(text) => Header::Whole(text, MAGIC.len() as u64 + 8 + length + CHECKSUM),
        Err(_) => Header::Foreign,
    })
}

/// Bytes of a record of so many numbers.
pub fn size(count: u64) -> u64 {
    PREFIX + 8 * count + CHECKSUM
}

/// Reads a record of a file that has so many bytes left: the call and the count of its numbers, if it is whole.
///
/// # Errors
/// Those of the operating system.
pub fn read_record(file: &mut impl Read, left: u64) -> io::Result<Option<(Call, u64)>> {
    let mut file = Hashing::new(file);
    let mut prefix = Vec::new();
    file.up_to(PREFIX, &mut prefix)?;
    if prefix.len() as u64 != PREFIX {
        return Ok(None);
    }
    let mut key = [0; 16];
    key.copy_from_slice(&prefix[..16]);
    let before = u32::from_le_bytes(prefix[16..20].try_into().expect("four bytes"));
    let count = u64::from_le_bytes(prefix[20..].try_into().expect("eight bytes"));
    let bytes = count.checked_mul(8).filter(|bytes| *bytes <= left);
    let Some(bytes) = bytes else {
        return Ok(None);
    };
    file.pass(bytes)?;
    Ok(file.ends_with_checksum()?.then_some(((key, before), count)))
}

/// Reads bytes and hashes them.
struct Hashing<'a, R> {
    file: &'a mut R,
    hash: hmac_sha256::Hash,
}

impl<'a, R: Read> Hashing<'a, R> {
    fn new(file: &'a mut R) -> Self {
        Hashing {
            file,
            hash: hmac_sha256::Hash::new(),
        }
    }

    /// So many bytes, or as many as there are.
    fn up_to(&mut self, count: u64, bytes: &mut Vec<u8>) -> io::Result<()> {
        self.file.take(count).read_to_end(bytes)?;
        self.hash.update(&bytes);
        Ok(())
    }

    /// Passes so many bytes, or as many as there are.
    fn pass(&mut self, mut count: u64) -> io::Result<()> {
        let mut buffer = [0; 1 << 14];
        while count > 0 {
            let most = count.min(buffer.len() as u64) as usize;
            match self.file.read(&mut buffer[..most]) {
                Ok(0) => break,
                Ok(read) => {
                    self.hash.update(&buffer[..read]);
                    count -= read as u64;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Whether the checksum follows.
    fn ends_with_checksum(self) -> io::Result<bool> {
        let mut sum = Vec::new();
        self.file.take(CHECKSUM).read_to_end(&mut sum)?;
        Ok(sum == self.hash.finalize()[..CHECKSUM as usize])
    }
}
