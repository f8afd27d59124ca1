//! Runs that are killed, and continue.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use serde_json::Value;

use super::{Bench, ends, in_one_line, refused, said, symplint};

/// One more call of the program.
pub fn count(path: &str) {
    let mut file = OpenOptions::new()
        .append(true)
        .create(true)
        .open(path)
        .unwrap();
    file.write_all(b"call\n").unwrap();
}

pub fn calls(path: &Path) -> usize {
    fs::read_to_string(path).unwrap_or_default().lines().count()
}

pub fn report(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("report.json")).unwrap();
    let mut report: Value = serde_json::from_str(&text).unwrap();
    report.as_object_mut().unwrap().remove("provenance");
    report
}

fn resume(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = symplint(&["resume"]);
    command.arg(folder).args(arguments).output().unwrap()
}

pub const KEYS: &str = "workers = 2\nbatch = 32\n";

#[test]
fn a_run_that_is_killed_again_and_again_ends_with_the_same_report() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.path(name);
    let (whole, killed) = (path("whole"), path("killed"));
    let check = |out: &Path, counts: &Path| {
        let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=1500", "--out"]);
        command.arg(out).env("SYMPLINT_TEST_COUNT", counts);
        command
    };
    ends(0, &check(&whole, &path("calls")).output().unwrap());
    let needed = calls(&path("calls"));

    // After these numbers of calls in total.
    let kills = [1, 2, 5, needed / 3, needed / 2, needed - 2];
    for count in kills {
        let mut run = check(&killed, &path("more_calls")).spawn().unwrap();
        while calls(&path("more_calls")) < count && run.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        run.kill().unwrap();
        run.wait().unwrap();
    }
    ends(0, &resume(&killed, &["--quiet"]));
    assert_eq!(report(&killed), report(&whole));
    for file in ["points.csv", "config.toml", "figures/step_sizes.svg"] {
        let of = |folder: &Path| fs::read(folder.join(file)).unwrap();
        assert!(of(&killed) == of(&whole), "{file}");
    }
    // Two calls at a time were under way when a run was killed. They ended, and were not recorded.
    let made = calls(&path("more_calls"));
    assert!(
        made <= needed + 2 * kills.len(),
        "{made} calls, {needed} needed"
    );

    // All is known now: the program need not even be there.
    ends(0, &check(&killed, &path("no_calls")).output().unwrap());
    assert_eq!(calls(&path("no_calls")), 0);
    let text = fs::read_to_string(killed.join("report.json")).unwrap();
    let again: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        again["provenance"]["replayed"],
        again["evaluations"]["made"]
    );
}

#[test]
fn a_run_of_a_file_in_the_current_folder_goes_on() {
    let bench = Bench::new("leapfrog", KEYS);
    for words in [
        &["check", "run.toml", "--out", "run"][..],
        &["resume", "run"],
    ] {
        let mut command = symplint(words);
        command.current_dir(bench.folder.path()).arg("--quiet");
        if words[0] == "check" {
            command.args(["--set", "diagnostic.budget=300"]);
        }
        let output = command.output().unwrap();
        ends(0, &output);
    }
}

#[test]
fn what_is_no_stopped_run_is_refused() {
    let bench = Bench::new("leapfrog", KEYS);
    let folder = bench.folder.path().join("run");
    let arguments = [
        "--quiet",
        "--set",
        "diagnostic.budget=300",
        "--out",
        folder.to_str().unwrap(),
    ];
    assert_eq!(bench.check(&arguments).status.code(), Some(0));
    let no_run = resume(bench.folder.path(), &[]);
    refused(&no_run, "config.toml cannot be read");
    let other = [&arguments[..], &["--set", "system.batch=16"]].concat();
    refused(&bench.check(&other), "system.batch is 32 there and 16 here");
    let journal = folder.join("journal");
    let whole = fs::read(&journal).unwrap();
    fs::write(&journal, "notes of mine").unwrap();
    refused(&resume(&folder, &[]), "is not a journal of symplint");
    fs::write(&journal, whole).unwrap();
    let config = folder.join("config.toml");
    let text = fs::read_to_string(&config).unwrap();
    fs::write(&config, text.replace("batch = 32", "batch = 33")).unwrap();
    refused(&resume(&folder, &[]), "was changed after the run");
    fs::write(&config, "name = 1\n").unwrap();
    refused(&resume(&folder, &[]), "is not that of a run");
}

/// All files of a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => files.extend(contents(&path)),
            false => files.push((path.clone(), fs::read(path).unwrap())),
        }
    }
    files.sort();
    files
}

#[test]
fn a_command_that_is_refused_changes_nothing() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let check = |word: &str, q0: &str, more: &[&str]| {
        let text = format!(
            "[system]\nname = \"command\"\n\
             command = [\"sh\", \"-c\", 'cp \"$0\" \"$1\"', \"{{before}}\", \"{{after}}\", \"{word}\"]\n\
             q0 = [{q0}]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n"
        );
        fs::write(path("run.toml"), text).unwrap();
        let mut command = symplint(&["check"]);
        command.arg(path("run.toml")).args(more);
        command.arg("--out").arg(path("run")).output().unwrap()
    };
    // It moves nothing.
    assert_eq!(check("1", "0.0", &[]).status.code(), Some(3));
    let before = contents(&path("run"));
    for (word, q0, key) in [
        ("1.0", "0.0", "system.command"),
        ("1", "-0.0", "system.q0"),
        ("1", "0.5", "system.q0"),
    ] {
        let output = check(word, q0, &[]);
        let text = in_one_line(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(&format!("{key} is [")), "{text}");
        assert!(text.contains("here"), "{text}");
        assert!(contents(&path("run")) == before, "{word} {q0}");
    }
    // A journal of another version is refused as late as can be.
    let journal = path("run").join("journal");
    let whole = fs::read(&journal).unwrap();
    fs::write(&journal, "notes of mine").unwrap();
    let damaged = contents(&path("run"));
    ends(2, &check("1", "0", &["--set", "system.workers=1"]));
    assert!(contents(&path("run")) == damaged);
    fs::write(&journal, whole).unwrap();
    ends(3, &resume(&path("run"), &[]));
    // The same number in other digits.
    ends(3, &check("1", "0", &[]));
}

#[test]
fn a_run_that_goes_on_is_not_replaced_by_force() {
    let bench = Bench::new("leapfrog", KEYS);
    let folder = bench.folder.path().join("run");
    let check = |more: &[&str]| {
        let mut command = bench.command(&["--quiet", "--out"]);
        command.arg(&folder).args(more).output().unwrap()
    };
    let few = ["--set", "diagnostic.budget=300"];
    assert_eq!(check(&few).status.code(), Some(0));
    let lock = fs::File::options().write(true).open(folder.join(".lock"));
    let lock = lock.unwrap();
    lock.lock().unwrap();
    let before = contents(&folder);
    // Nor by a run that has no journal itself.
    let pendulum = bench.folder.path().join("pendulum.toml");
    let text = "[system]\nname = \"pendulum\"\n[diagnostic]\nbudget = 300\n";
    fs::write(&pendulum, text).unwrap();
    let of_pendulum = || {
        let mut command = symplint(&["check", "--quiet", "--force"]);
        command
            .arg(&pendulum)
            .arg("--out")
            .arg(&folder)
            .output()
            .unwrap()
    };
    let of_other = || check(&["--force", "--set", "diagnostic.budget=400"]);
    for output in [check(&["--force"]), of_other(), of_pendulum()] {
        refused(&output, "another run writes to it");
    }
    assert!(contents(&folder) == before);
    drop(lock);
    assert_eq!(of_other().status.code(), Some(0));
    // It leaves nothing of a run that had one.
    fs::create_dir(folder.join("round")).unwrap();
    for file in ["round/calls", "round/part-1-of-1", "failed.json"] {
        fs::write(folder.join(file), "").unwrap();
    }
    ends(0, &of_pendulum());
    for file in ["round", "failed.json", "journal"] {
        assert!(!folder.join(file).exists(), "{file}");
    }
    // Beside no journal it is another file.
    fs::write(folder.join("failed.json"), "mine").unwrap();
    ends(0, &of_pendulum());
    assert!(folder.join("failed.json").exists());
}

#[test]
fn how_a_run_goes_is_no_other_run() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.path(name);
    let check = |settings: &[&str], counts: &str| {
        let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=300", "--out"]);
        command.arg(path("run")).args(settings);
        let output = command.env("SYMPLINT_TEST_COUNT", path(counts)).output();
        let output = output.unwrap();
        ends(0, &output);
    };
    check(&[], "calls");
    let keep = format!("system.keep={:?}", path("kept"));
    let others = ["system.workers=1", "system.timeout=50", &keep];
    check(&others.map(|other| ["--set", other]).concat(), "more_calls");
    assert_eq!(calls(&path("more_calls")), 0);
    ends(0, &resume(&path("run"), &["--quiet"]));
}

#[test]
fn a_run_that_keeps_its_files_goes_on() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.path(name);
    let keep = path("kept");
    let check = |out: &str| {
        let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=300"]);
        // Relative to the configuration, also when the run is resumed.
        command.args(["--set", "system.keep=kept"]);
        command.arg("--out").arg(path(out)).output().unwrap()
    };
    let kept = || fs::read_dir(&keep).unwrap().count();
    ends(0, &check("run"));
    let (needed, whole) = (kept(), report(&path("run")));
    // Half of the journal is lost.
    let journal = path("run").join("journal");
    let bytes = fs::read(&journal).unwrap();
    fs::write(&journal, &bytes[..bytes.len() / 2]).unwrap();
    ends(0, &resume(&path("run"), &["--quiet"]));
    assert!(kept() > needed);
    assert_eq!(report(&path("run")), whole);
    ends(0, &check("run"));
    // Another run.
    refused(&check("other"), "is not empty");
}

#[test]
fn radii_that_the_map_suggests_are_looked_for_once() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.path(name);
    let check = |counts: &str, more: &[&str]| {
        let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=300"]);
        command
            .args(["--set", "loop.radius=auto", "--out"])
            .arg(path("run"));
        command.args(more).env("SYMPLINT_TEST_COUNT", path(counts));
        command.output().unwrap()
    };
    ends(0, &check("calls", &[]));
    let whole = report(&path("run"));
    assert!(whole["evaluations"]["by_check"]["radii"].as_u64().unwrap() > 0);
    ends(0, &check("no_calls", &[]));
    // Another run is refused before its first call.
    ends(2, &check("no_calls", &["--set", "system.q0=[0.25]"]));
    assert_eq!(calls(&path("no_calls")), 0);
    ends(0, &resume(&path("run"), &["--quiet"]));
    assert_eq!(report(&path("run")), whole);
}

#[test]
fn what_a_run_left_that_was_killed_at_once_is_no_file_of_others() {
    let bench = Bench::new("leapfrog", KEYS);
    let folder = bench.folder.path().join("run");
    fs::create_dir_all(folder.join("figures")).unwrap();
    for name in [".config.toml.part", ".lock"] {
        fs::write(folder.join(name), "# sympl").unwrap();
    }
    let arguments = ["--quiet", "--set", "diagnostic.budget=300", "--out"];
    let check = || bench.command(&arguments).arg(&folder).output().unwrap();
    assert_eq!(check().status.code(), Some(0), "{}", said(&check()));
    fs::write(folder.join(".report.json.part"), "{").unwrap();
    assert_eq!(check().status.code(), Some(0));
    let other = bench.folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join(".notes.part"), "").unwrap();
    let refused = bench.command(&arguments).arg(&other).output().unwrap();
    assert!(in_one_line(&refused).contains("did not write .notes.part"));
}

#[test]
fn of_two_runs_that_begin_at_once_in_a_folder_one_is_refused() {
    let bench = Bench::new("leapfrog", KEYS);
    for attempt in 0..6 {
        let folder = bench.folder.path().join(format!("run{attempt}"));
        let check = |batch: usize| {
            let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=200"]);
            command.args(["--set", &format!("system.batch={batch}"), "--out"]);
            let stdio = || std::process::Stdio::piped();
            command.arg(&folder).stdout(stdio()).stderr(stdio());
            command.spawn().unwrap()
        };
        let runs = [30, 40].map(|batch| (batch, check(batch)));
        let ended = runs.map(|(batch, run)| (batch, run.wait_with_output().unwrap()));
        let (refused, others): (Vec<_>, Vec<_>) =
            (ended.iter()).partition(|(_, output)| output.status.code() == Some(2));
        let [(_, refused), (batch, _)] = [refused, others].map(|runs| {
            assert_eq!(runs.len(), 1, "{}{}", said(&ended[0].1), said(&ended[1].1));
            runs[0]
        });
        assert_eq!(
            report(&folder)["config"]["system"]["batch"],
            *batch,
            "{}",
            said(refused)
        );
        let output = resume(&folder, &["--quiet"]);
        assert_ne!(output.status.code(), Some(2), "{}", said(&output));
    }
}
