//! What the file of a journal holds, also where bytes of it changed or it was cut off.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};

use crate::record::{CHECKSUM, COUNT, Call, Header, PREFIX, read_header, read_record, size};

/// The sizes of all records are multiples of this, so where no byte was lost the next one begins a multiple of it further on.
const STEP: u64 = 4;

/// Bytes that are hashed in vain at most, beside a multiple of the length of the file: what is no record may state any
/// length, and a file that was made for that would be read without end.
const HASHED_IN_VAIN: u64 = 1 << 24;

/// What a file holds.
pub enum Contents {
    /// Nothing, or the beginning of the header that is expected: it was cut off when it was written, and nothing follows.
    Nothing,
    /// Something else than a journal.
    Foreign,
    /// A journal that cannot be read from a byte on.
    Damaged { at: u64 },
    Records {
        run: String,
        /// Where the last whole record ends.
        end: u64,
        /// Where the numbers of each call begin, and how many there are.
        found: HashMap<Call, (u64, u64)>,
    },
}

/// Reads a file that begins with `expected` if it is of this run. Memory and time are at most a multiple of its length.
///
/// # Errors
/// Those of the operating system.
pub fn scan(file: &mut File, expected: &[u8]) -> io::Result<Contents> {
    let length = file.metadata()?.len();
    file.rewind()?;
    if length < expected.len() as u64 {
        let mut bytes = Vec::new();
        file.take(length).read_to_end(&mut bytes)?;
        if expected.starts_with(&bytes) {
            return Ok(Contents::Nothing);
        }
        file.rewind()?;
    }
    let mut file = BufReader::with_capacity(1 << 16, file);
    match read_header(&mut file)? {
        Header::Whole(run, end) => records(file, run, end, length),
        Header::Damaged => Ok(Contents::Damaged { at: 0 }),
        Header::Foreign => Ok(Contents::Foreign),
    }
}

/// The records from `end` on. After one that is not whole the next is looked for at every place where one may begin.
fn records(
    file: BufReader<&mut File>,
    run: String,
    mut end: u64,
    length: u64,
) -> io::Result<Contents> {
    let mut bytes = Bytes {
        file,
        position: end,
        length,
        in_vain: HASHED_IN_VAIN.saturating_add(length.saturating_mul(4)),
    };
    let (mut found, mut at) = (HashMap::new(), end);
    while at < length {
        match bytes.record_at(at)? {
            Some((call, count)) => {
                found.insert(call, (at + PREFIX, count));
                at += size(count);
                end = at;
            }
            None if bytes.in_vain == 0 => return Ok(Contents::Damaged { at: end }),
            None => at += STEP,
        }
    }
    Ok(Contents::Records { run, end, found })
}

/// The bytes of a file, in which records are looked for.
struct Bytes<'a> {
    file: BufReader<&'a mut File>,
    position: u64,
    length: u64,
    /// How many may still be hashed for nothing.
    in_vain: u64,
}

impl Bytes<'_> {
    /// The record at a place, if there is a whole one.
    fn record_at(&mut self, at: u64) -> io::Result<Option<(Call, u64)>> {
        let Some(count) = self.count_at(at)? else {
            return Ok(None);
        };
        self.go_to(at)?;
        let found = read_record(&mut self.file, self.length - at)?;
        self.position += size(count);
        if found.is_none() {
            self.in_vain = self.in_vain.saturating_sub(size(count));
        }
        Ok(found)
    }

    /// How many numbers a record at a place would have, if it is one that ends within the file. Every call has numbers: zeros
    /// stand where a disk wrote nothing.
    fn count_at(&mut self, at: u64) -> io::Result<Option<u64>> {
        let Some(most) = (self.length - at).checked_sub(PREFIX + CHECKSUM) else {
            return Ok(None);
        };
        self.go_to(at + COUNT)?;
        let mut count = [0; 8];
        self.file.read_exact(&mut count)?;
        self.position += count.len() as u64;
        let count = u64::from_le_bytes(count);
        Ok((1..=most / 8).contains(&count).then_some(count))
    }

    /// Within what is read already, mostly.
    fn go_to(&mut self, position: u64) -> io::Result<()> {
        // No file is longer than an i64 counts.
        let offset = position as i64 - self.position as i64;
        self.file.seek_relative(offset)?;
        self.position = position;
        Ok(())
    }
}
