//! Journals of evaluations, and rounds of calls.
//!
//! Any bytes are a file. Then the bytes say how a valid file is made and damaged: damage must not change a number that is
//! replayed. Checksums are no secret, so a file may have right ones and wrong sizes.

use std::fs;
use std::path::Path;

use arbitrary::{Result, Unstructured};
use serde_json::{Value, json};
use symplint::Ensemble;
use symplint_run::{Journal, JournalError, Request, read_round, write_round};

use crate::files::with_file;
use crate::numbers;

/// Opens the bytes as a journal and as a round, then what they make of a valid one.
pub fn journal(data: &[u8]) {
    with_file("journal", data, |path| {
        let _ = read_round(path, &run());
        open_and_note(path);
    });
    let mut u = Unstructured::new(data);
    let _ = damaged_journal(&mut u);
    let _ = damaged_round(&mut u);
    let _ = forged(&mut u);
}

/// The run that all files here are of.
fn run() -> Value {
    json!({ "map": "fuzz" })
}

/// Writes a journal of two calls.
pub(crate) fn journal_at(path: &Path) {
    let journal = Journal::open(path, &run()).expect("an empty file is a new journal");
    for samples in [2, 3] {
        let mut states = Ensemble::zeros(1, samples);
        let call = journal.call(0.5, &states.block());
        let noted = journal.note(call, &states.block());
        noted.expect("the file can be written");
    }
}

/// Whatever was in the file: if it is taken for a journal, it keeps what is noted.
fn open_and_note(path: &Path) {
    let mut states = Ensemble::zeros(1, 2);
    states.block().q.fill(0.25);
    let advance = |journal: &Journal| -> std::result::Result<Ensemble, JournalError> {
        let mut states = states.clone();
        journal.advance(0.5, &mut states.block(), |block| {
            block.q.fill(0.75);
            Ok::<(), JournalError>(())
        })?;
        Ok(states)
    };
    let Ok(journal) = Journal::open(path, &run()) else {
        return;
    };
    let first = advance(&journal).expect("a journal that was opened can be written");
    drop(journal);
    let journal = Journal::open(path, &run()).expect("a journal that was opened stays one");
    let again = advance(&journal).expect("a journal that was opened can be read");
    assert_eq!(journal.replayed(), 2, "the record was lost");
    assert_eq!(again.q().row(0), first.q().row(0));
}

fn damaged_journal(u: &mut Unstructured<'_>) -> Result<()> {
    let count = u.int_in_range(1..=4)?;
    let calls: Vec<(f64, Ensemble)> = (0..count)
        .map(|_| Ok((numbers::any(u)?, ensemble(u)?)))
        .collect::<Result<_>>()?;
    with_file("journal", &[], |path| {
        let journal = Journal::open(path, &run()).expect("an empty file is a new journal");
        for (h, states) in &calls {
            let mut states = states.clone();
            let call = journal.call(*h, &states.block());
            journal
                .note(call, &states.block())
                .expect("the file can be written");
        }
        drop(journal);
        damage(path, u)?;
        let Ok(journal) = Journal::open(path, &run()) else {
            return Ok(());
        };
        for (h, states) in &calls {
            let mut replayed = states.clone();
            let call = journal.call(*h, &replayed.block());
            let is_there = journal.replay(call, &mut replayed.block());
            if is_there.expect("the file can be read") {
                assert!(same(&replayed, states), "a damaged record was replayed");
            }
        }
        Ok(())
    })
}

fn damaged_round(u: &mut Unstructured<'_>) -> Result<()> {
    let count = u.int_in_range(0..=3)?;
    let requests: Vec<Request> = (0..count)
        .map(|_| {
            let call = (u.arbitrary()?, u.arbitrary()?);
            Ok(Request::new(call, numbers::any(u)?, ensemble(u)?))
        })
        .collect::<Result<_>>()?;
    with_file("calls", &[], |path| {
        write_round(path, &run(), &requests).expect("the file can be written");
        damage(path, u)?;
        let Ok(read) = read_round(path, &run()) else {
            return Ok(());
        };
        // Where whole records were cut off or repeated, checksums are right.
        for read in &read {
            let is_read = |written: &Request| {
                (read.call, read.h.to_bits()) == (written.call, written.h.to_bits())
                    && same(&read.states, &written.states)
            };
            assert!(requests.iter().any(is_read), "a damaged call was read");
        }
        Ok(())
    })
}

/// A round whose checksums are right, of any numbers.
fn forged(u: &mut Unstructured<'_>) -> Result<()> {
    let text = run().to_string();
    let mut bytes = b"symplint journal 1\n".to_vec();
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(text.as_bytes());
    append_checksum(&mut bytes, 0);
    for _ in 0..u.int_in_range(1..=3)? {
        let begin = bytes.len();
        bytes.extend([0; 20]);
        let count = u.int_in_range(0..=12)?;
        bytes.extend((count as u64).to_le_bytes());
        for _ in 0..count {
            let number = match u.arbitrary()? {
                true => f64::from(u.int_in_range(0..=8)?),
                false => numbers::any(u)?,
            };
            bytes.extend(number.to_le_bytes());
        }
        append_checksum(&mut bytes, begin);
    }
    with_file("calls", &bytes, |path| {
        let _ = read_round(path, &run());
        open_and_note(path);
    });
    Ok(())
}

fn append_checksum(bytes: &mut Vec<u8>, begin: usize) {
    let sum = hmac_sha256::Hash::hash(&bytes[begin..]);
    bytes.extend(&sum[..8]);
}

fn ensemble(u: &mut Unstructured<'_>) -> Result<Ensemble> {
    let (dof, samples) = (u.int_in_range(1..=3)?, u.int_in_range(1..=5)?);
    let mut states = Ensemble::zeros(dof, samples);
    let mut block = states.block();
    for i in 0..dof {
        for x in block.q.row_mut(i) {
            *x = numbers::any(u)?;
        }
    }
    Ok(states)
}

fn same(a: &Ensemble, b: &Ensemble) -> bool {
    let bits = |states: &Ensemble| -> Vec<u64> {
        [states.q(), states.p()]
            .iter()
            .flat_map(|rows| {
                (0..rows.count()).flat_map(|i| rows.row(i).iter().map(|x| x.to_bits()))
            })
            .collect()
    };
    (a.dof(), a.samples()) == (b.dof(), b.samples()) && bits(a) == bits(b)
}

/// Changes bytes of a file, cuts it off, or repeats a part of it.
fn damage(path: &Path, u: &mut Unstructured<'_>) -> Result<()> {
    let mut bytes = fs::read(path).expect("the file was written");
    for _ in 0..u.int_in_range(0..=3)? {
        let place = u.choose_index(bytes.len().max(1))?;
        match u.int_in_range(0..=3)? {
            0 => bytes.truncate(place),
            1 => bytes.extend_from_within(place..),
            2 => {
                bytes.extend(u.bytes(u.len().min(16))?);
            }
            _ => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= u.arbitrary::<u8>()?;
                }
            }
        }
    }
    fs::write(path, &bytes).expect("the file can be written");
    Ok(())
}
