//! Journals that were cut off, that are of another run, and calls that are made more than once.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use symplint::{Circle, Ensemble, StepFailure};
use symplint_run::{Journal, JournalError, Request, read_round, records, write_round};

fn run() -> Value {
    json!({ "map": "pendulum", "version": "1", "config": { "seed": 1 } })
}

/// Three samples of a circle of this radius.
fn states(radius: f64) -> Ensemble {
    Ensemble::sample(
        &Circle::new(vec![0.3, 0.1], vec![0.5, 0.2], radius).unwrap(),
        3,
    )
    .unwrap()
}

/// All numbers of the states.
fn numbers(states: &Ensemble) -> Vec<f64> {
    let rows = (0..2).flat_map(|i| [states.q().row(i), states.p().row(i)]);
    rows.flatten().copied().collect()
}

/// Advances states through the journal by a map that adds `shift`, and says whether it was called.
fn advance(journal: &Journal, states: &mut Ensemble, h: f64, shift: f64) -> bool {
    let mut called = false;
    let map = |block: &mut symplint::Block<'_>| {
        called = true;
        for i in 0..2 {
            block.q.row_mut(i).iter_mut().for_each(|q| *q += shift);
        }
        Ok::<(), JournalError>(())
    };
    journal.advance(h, &mut states.block(), map).unwrap();
    called
}

/// A journal of four calls, the last of them that of the first states once more.
fn write(path: &Path) -> Vec<Ensemble> {
    let journal = Journal::open(path, &run()).unwrap();
    let calls = [(1.0, 0.5), (2.0, 0.5), (1.0, 0.25), (1.0, 0.5)];
    (calls.iter().enumerate())
        .map(|(k, &(radius, h))| {
            let mut states = states(radius);
            assert!(advance(&journal, &mut states, h, k as f64 + 1.0));
            states
        })
        .collect()
}

/// How many of the calls are replayed, with the states of [`write`].
fn replayed(path: &Path, expected: &[Ensemble]) -> usize {
    let journal = Journal::open(path, &run()).unwrap();
    let calls = [(1.0, 0.5), (2.0, 0.5), (1.0, 0.25), (1.0, 0.5)];
    let mut replayed = 0;
    for (k, (&(radius, h), expected)) in calls.iter().zip(expected).enumerate() {
        let mut states = states(radius);
        replayed += usize::from(!advance(&journal, &mut states, h, k as f64 + 1.0));
        assert_eq!(numbers(&states), numbers(expected));
    }
    assert_eq!(journal.replayed(), 3 * replayed);
    replayed
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("journal");
    (folder, path)
}

#[test]
fn every_call_is_replayed_the_second_of_two_alike_as_such() {
    let (_folder, path) = folder();
    let expected = write(&path);
    assert_ne!(numbers(&expected[0]), numbers(&expected[3]));
    assert_eq!(replayed(&path, &expected), 4);
}

#[test]
fn a_journal_that_was_cut_off_anywhere_goes_on() {
    let (_folder, path) = folder();
    let expected = write(&path);
    let whole = fs::read(&path).unwrap();
    let record = 16 + 4 + 8 + 8 * 12 + 8;
    let header = whole.len() - 4 * record;
    for length in 0..=whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        assert_eq!(
            replayed(&path, &expected),
            length.saturating_sub(header) / record
        );
        assert_eq!(
            fs::read(&path).unwrap(),
            whole,
            "cut off after {length} bytes"
        );
    }
}

#[test]
fn a_damaged_record_and_those_after_it_are_made_again() {
    let (_folder, path) = folder();
    let expected = write(&path);
    let whole = fs::read(&path).unwrap();
    let record = 16 + 4 + 8 + 8 * 12 + 8;
    let header = whole.len() - 4 * record;
    for at in header..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x40;
        fs::write(&path, &damaged).unwrap();
        let number = (at - header) / record;
        assert_eq!(replayed(&path, &expected), number, "byte {at}");
        assert_eq!(fs::read(&path).unwrap(), whole, "byte {at}");
    }
}

#[test]
fn a_damaged_header_is_refused_and_nothing_is_changed() {
    let (_folder, path) = folder();
    let expected = write(&path);
    let whole = fs::read(&path).unwrap();
    let header = whole.len() - 4 * (16 + 4 + 8 + 8 * 12 + 8);
    for at in 0..header {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x40;
        fs::write(&path, &damaged).unwrap();
        let error = Journal::open(&path, &run()).map(|_| ()).unwrap_err();
        assert!(
            matches!(error, JournalError::NotAJournal { .. }),
            "byte {at}: {error}"
        );
        assert!(fs::read(&path).unwrap() == damaged, "byte {at}");
    }
    fs::write(&path, &whole).unwrap();
    assert_eq!(replayed(&path, &expected), 4);
}

#[test]
fn a_journal_is_begun_anew_only_if_no_process_writes_to_it() {
    let (_folder, path) = folder();
    let expected = write(&path);
    let other = json!({ "map": "another" });
    let journal = Journal::open(&path, &run()).unwrap();
    let refused = Journal::replace(&path, &other).map(|_| ());
    assert!(matches!(refused, Err(JournalError::InUse { .. })));
    drop(journal);
    assert_eq!(replayed(&path, &expected), 4);
    drop(Journal::replace(&path, &other).unwrap());
    drop(Journal::open(&path, &other).unwrap());
    assert_eq!(records(&path, &other).unwrap().len(), 0);
}

#[test]
fn a_call_that_fails_is_not_noted() {
    let (_folder, path) = folder();
    let fails = |_: &mut symplint::Block<'_>| {
        Err(StepFailure {
            sample: 1,
            reason: "no".into(),
        })
    };
    let journal = Journal::open(&path, &run()).unwrap();
    let failure = journal
        .advance(0.5, &mut states(1.0).block(), fails)
        .unwrap_err();
    assert_eq!((failure.sample, &*failure.reason), (1, "no"));
    assert!(journal.failure().is_none());
    drop(journal);
    let journal = Journal::open(&path, &run()).unwrap();
    assert!(advance(&journal, &mut states(1.0), 0.5, 1.0));
}

#[test]
fn other_runs_and_other_files_are_refused() {
    let (_folder, path) = folder();
    let expected = write(&path);
    let open = |run: &Value| Journal::open(&path, run).map(|_| ()).unwrap_err();
    let mut other = run();
    other["config"]["seed"] = json!(2);
    let error = open(&other);
    assert!(matches!(error, JournalError::OtherRun { .. }));
    assert!(
        error
            .to_string()
            .contains("config.seed is 1 there and 2 here"),
        "{error}"
    );
    let journal = Journal::open(&path, &run()).unwrap();
    assert!(matches!(open(&run()), JournalError::InUse { .. }));
    drop(journal);
    assert_eq!(replayed(&path, &expected), 4);
    for foreign in [
        "something else",
        "symplint journal 9\n",
        "symplint journal 1\nfar too long a text",
        &"symplint journal 9\n".repeat(20),
    ] {
        fs::write(&path, foreign).unwrap();
        assert!(
            matches!(open(&run()), JournalError::NotAJournal { .. }),
            "{foreign}"
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), foreign);
    }
    let error = Journal::open(Path::new("/no/such/folder/journal"), &run()).map(|_| ());
    assert!(matches!(error, Err(JournalError::File { .. })));
}

#[test]
fn a_journal_without_calls_is_of_no_run() {
    let (_folder, path) = folder();
    drop(Journal::open(&path, &json!({ "map": "other" })).unwrap());
    let expected = write(&path);
    assert_eq!(replayed(&path, &expected), 4);
    // With calls it is of theirs.
    let error = Journal::open(&path, &json!({ "map": "other" })).err();
    assert!(matches!(error, Some(JournalError::OtherRun { .. })));
    assert_eq!(replayed(&path, &expected), 4);
}

#[test]
fn a_journal_takes_in_the_calls_of_others() {
    let (folder, path) = folder();
    let other = folder.path().join("other");
    let expected = write(&other);
    {
        let journal = Journal::open(&path, &run()).unwrap();
        // One that both have.
        assert!(advance(&journal, &mut states(1.0), 0.5, 1.0));
        let part = records(&other, &run()).unwrap();
        assert_eq!(journal.merge(&part), Ok(3));
        assert_eq!(journal.merge(&part), Ok(0));
    }
    assert_eq!(replayed(&path, &expected), 4);
}

#[test]
fn records_are_seen_while_a_run_writes_them() {
    let (_folder, path) = folder();
    assert!(records(&path, &run()).is_err());
    let journal = Journal::open(&path, &run()).unwrap();
    for count in 0..2 {
        assert_eq!(records(&path, &run()).unwrap().len(), count);
        advance(&journal, &mut states(1.0), 0.5 + count as f64, 1.0);
    }
    // The end of a record that is being written is not there yet.
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 3]).unwrap();
    assert_eq!(records(&path, &run()).unwrap().len(), 1);
    assert_eq!(fs::read(&path).unwrap().len(), bytes.len() - 3);
    let refused = records(&path, &json!({ "map": "another" })).map(|_| ());
    assert!(matches!(refused, Err(JournalError::OtherRun { .. })));
    fs::write(&path, "notes of mine").unwrap();
    assert!(records(&path, &run()).is_err());
}

#[test]
fn a_round_is_read_as_it_was_written() {
    let (folder, path) = folder();
    let journal = Journal::open(&path, &run()).unwrap();
    let requests: Vec<Request> = (1..=5)
        .map(|k| {
            let mut states = states(f64::from(k));
            let h = 1.0 / f64::from(k);
            let call = journal.call(h, &states.block());
            Request::new(call, h, states)
        })
        .collect();
    let path = folder.path().join("calls");
    write_round(&path, &run(), &requests).unwrap();
    let read = read_round(&path, &run()).unwrap();
    assert_eq!(read.len(), 5);
    for (read, written) in read.iter().zip(&requests) {
        assert_eq!((read.call, read.h), (written.call, written.h));
        assert_eq!(numbers(&read.states), numbers(&written.states));
    }
    let refused = read_round(&path, &json!({ "map": "another" })).map(|_| ());
    assert!(
        matches!(refused, Err(JournalError::OtherRun { .. })),
        "{refused:?}"
    );
    // A file that was cut off has the calls before.
    let whole = fs::read(&path).unwrap();
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        match read_round(&path, &run()) {
            Err(JournalError::NotAJournal { .. }) => {}
            Ok(read) => assert!(read.len() < 5, "{length}"),
            Err(error) => panic!("{error}"),
        }
    }
}
