//! The bytes of a journal: a header, then one record after the other.
//!
//! All numbers are little-endian. A header is
//!
//! ```text
//! "symplint journal 1\n" | length of the text, u64 | the run, as JSON | checksum
//! ```
//!
//! and a record
//!
//! ```text
//! key, 16 bytes | number of equal calls before, u32 | count of numbers, u64 | numbers, f64 | checksum
//! ```
//!
//! A checksum is the first 8 bytes of the SHA-256 of all bytes before it, from the beginning of the header or the record. A reader
//! stops at the first record that is incomplete or has another checksum.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use serde_json::Value;
use symplint::Block;

use super::JournalError;
use crate::difference::difference;

/// How every journal begins.
const MAGIC: &[u8] = b"symplint journal 1\n";

/// Bytes of a record before its numbers.
pub const PREFIX: usize = 16 + 4 + 8;

/// Bytes of a checksum.
const CHECKSUM: usize = 8;

/// The beginning of the SHA-256 of a step size and states: two calls that differ have the same with a probability of
/// 2^-128.
pub type Key = [u8; 16];

/// A call of a map: its key, and the number of equal calls before it.
pub type Call = (Key, u32);

/// The key of a call with these states.
pub fn key(h: f64, block: &Block<'_>) -> Key {
    let mut hash = hmac_sha256::Hash::new();
    hash.update(h.to_bits().to_le_bytes());
    for size in [block.dof(), block.len()] {
        hash.update((size as u64).to_le_bytes());
    }
    for x in numbers(block) {
        hash.update(x.to_bits().to_le_bytes());
    }
    let mut key = [0; 16];
    key.copy_from_slice(&hash.finalize()[..16]);
    key
}

/// The positions and then the momenta of a block, by degree of freedom.
pub fn numbers(block: &Block<'_>) -> Vec<f64> {
    let rows = |i: usize| match i < block.dof() {
        true => block.q.row(i),
        false => block.p.row(i - block.dof()),
    };
    let all = (0..2 * block.dof()).flat_map(|i| rows(i).iter().copied());
    all.collect()
}

/// Writes numbers into a block, in the order of [`numbers`].
pub fn fill(block: &mut Block<'_>, numbers: &[f64]) {
    let (dof, samples) = (block.dof(), block.len());
    for (i, row) in numbers.chunks_exact(samples).enumerate() {
        match i < dof {
            true => block.q.row_mut(i).copy_from_slice(row),
            false => block.p.row_mut(i - dof).copy_from_slice(row),
        }
    }
}

/// The bytes of a header.
pub fn header(run: &Value) -> Vec<u8> {
    let text = run.to_string();
    let mut bytes = MAGIC.to_vec();
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(text.as_bytes());
    with_checksum(bytes)
}

/// The bytes of a record.
pub fn record((key, before): Call, numbers: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(PREFIX + 8 * numbers.len() + CHECKSUM);
    bytes.extend(key);
    bytes.extend(before.to_le_bytes());
    bytes.extend((numbers.len() as u64).to_le_bytes());
    numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    with_checksum(bytes)
}

fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = checksum(&bytes);
    bytes.extend(sum);
    bytes
}

fn checksum(bytes: &[u8]) -> [u8; CHECKSUM] {
    let sum = hmac_sha256::Hash::hash(bytes);
    *sum.first_chunk()
        .expect("a SHA-256 is longer than a checksum")
}

/// A record of a file.
pub struct Record {
    /// Its call.
    pub call: Call,
    /// Its numbers.
    pub numbers: Vec<f64>,
}

/// A journal that is read from its beginning. Memory and time are at most a multiple of the length of the file.
pub struct Reader<R> {
    file: BufReader<R>,
    length: u64,
    /// The end of the last complete record.
    pub end: u64,
}

impl<R: Read> Reader<R> {
    /// Reads the header of a file of this length: the run that it is of, if the file is a journal.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn new(file: R, length: u64) -> io::Result<Option<(Self, Value)>> {
        let file = BufReader::with_capacity(1 << 16, file);
        let end = 0;
        let mut reader = Reader { file, length, end };
        let of_text = |prefix: &[u8]| {
            let length = prefix.strip_prefix(MAGIC)?;
            Some(u64::from_le_bytes(length.try_into().ok()?))
        };
        let bytes = reader.checked(MAGIC.len() + 8, of_text)?;
        let run = bytes.and_then(|bytes| serde_json::from_slice(&bytes[MAGIC.len() + 8..]).ok());
        Ok(run.map(|run| (reader, run)))
    }

    /// The next record; nothing at the end, and at the first record that is damaged.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn next(&mut self) -> io::Result<Option<Record>> {
        let eight = |bytes: &[u8]| <[u8; 8]>::try_from(bytes).expect("eight bytes");
        let of_numbers = |prefix: &[u8]| u64::from_le_bytes(eight(&prefix[20..])).checked_mul(8);
        let Some(bytes) = self.checked(PREFIX, of_numbers)? else {
            return Ok(None);
        };
        let (prefix, numbers) = bytes.split_at(PREFIX);
        let key = *prefix.first_chunk().expect("sixteen bytes");
        let before = u32::from_le_bytes(prefix[16..20].try_into().expect("four bytes"));
        let numbers = numbers.chunks_exact(8);
        Ok(Some(Record {
            call: (key, before),
            numbers: numbers.map(|x| f64::from_le_bytes(eight(x))).collect(),
        }))
    }

    /// Reads a prefix, as many bytes after it as `rest` finds in it, and their checksum. Returns nothing if the file ends before,
    /// or the checksum is another one.
    fn checked(
        &mut self,
        prefix: usize,
        rest: impl Fn(&[u8]) -> Option<u64>,
    ) -> io::Result<Option<Vec<u8>>> {
        let file = &mut self.file;
        let mut bytes = Vec::new();
        file.take(prefix as u64).read_to_end(&mut bytes)?;
        let there = (bytes.len() == prefix).then(|| rest(&bytes)).flatten();
        let most = (self.length - self.end).saturating_sub((prefix + CHECKSUM) as u64);
        let Some(count) = there.filter(|count| *count <= most) else {
            return Ok(None);
        };
        file.take(count + CHECKSUM as u64).read_to_end(&mut bytes)?;
        let sum = bytes.split_off(bytes.len().saturating_sub(CHECKSUM));
        if bytes.len() as u64 != prefix as u64 + count || sum != checksum(&bytes) {
            return Ok(None);
        }
        self.end += (bytes.len() + CHECKSUM) as u64;
        Ok(Some(bytes))
    }
}

/// The records in a file of the run that `run` describes, also while another process writes it.
///
/// # Errors
/// If the file cannot be read, or is not a journal of this run.
pub fn records(path: &Path, run: &Value) -> Result<Vec<Record>, JournalError> {
    let error = |error: io::Error| JournalError::of_file("read", path, &error);
    let file = File::open(path).map_err(error)?;
    let length = file.metadata().map_err(error)?.len();
    let reader = Reader::new(file, length).map_err(error)?;
    let path = path.to_owned();
    let Some((mut reader, there)) = reader else {
        return Err(JournalError::NotAJournal { path });
    };
    if let Some(difference) = difference("", &there, run) {
        return Err(JournalError::OtherRun { path, difference });
    }
    let mut records = Vec::new();
    while let Some(record) =
        (reader.next()).map_err(|e| JournalError::of_file("read", &path, &e))?
    {
        records.push(record);
    }
    Ok(records)
}
