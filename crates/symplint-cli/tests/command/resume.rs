//! Runs that are killed, and go on.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use serde_json::Value;

use super::{Bench, said};

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
    let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
    command
        .arg("resume")
        .arg(folder)
        .args(arguments)
        .output()
        .unwrap()
}

const KEYS: &str = "workers = 2\nbatch = 32\n";

#[test]
fn a_run_that_is_killed_again_and_again_ends_with_the_same_report() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let (whole, killed) = (path("whole"), path("killed"));
    let check = |out: &Path, counts: &Path| {
        let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=1500", "--out"]);
        command.arg(out).env("SYMPLINT_TEST_COUNT", counts);
        command
    };
    let output = check(&whole, &path("calls")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let needed = calls(&path("calls"));

    // After so many calls in all.
    let kills = [1, 2, 5, needed / 3, needed / 2, needed - 2];
    for count in kills {
        let mut run = check(&killed, &path("more_calls")).spawn().unwrap();
        while calls(&path("more_calls")) < count && run.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        run.kill().unwrap();
        run.wait().unwrap();
    }
    let output = resume(&killed, &["--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(report(&killed), report(&whole));
    for file in ["points.csv", "config.toml", "figures/step_sizes.svg"] {
        let of = |folder: &Path| fs::read(folder.join(file)).unwrap();
        assert!(of(&killed) == of(&whole), "{file}");
    }
    // Two calls at a time were under way when a run was killed. They ended, and nobody took note.
    let made = calls(&path("more_calls"));
    assert!(
        made <= needed + 2 * kills.len(),
        "{made} calls, {needed} needed"
    );

    // All is known now: the program need not even be there.
    let output = check(&killed, &path("no_calls")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
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
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command
            .current_dir(bench.folder.path())
            .args(words)
            .arg("--quiet");
        if words[0] == "check" {
            command.args(["--set", "diagnostic.budget=300"]);
        }
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
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
    let refused = |output: Output, words: &str| {
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(words), "{words}: {text}");
    };
    refused(
        resume(bench.folder.path(), &[]),
        "config.toml cannot be read",
    );
    let other = [&arguments[..], &["--set", "system.batch=16"]].concat();
    refused(bench.check(&other), "system.batch is 32 there and 16 here");
    let journal = folder.join("journal");
    let whole = fs::read(&journal).unwrap();
    fs::write(&journal, "notes of mine").unwrap();
    refused(resume(&folder, &[]), "is not a journal of symplint");
    fs::write(&journal, whole).unwrap();
    let config = folder.join("config.toml");
    let text = fs::read_to_string(&config).unwrap();
    fs::write(&config, text.replace("batch = 32", "batch = 33")).unwrap();
    refused(resume(&folder, &[]), "was changed after the run");
    fs::write(&config, "name = 1\n").unwrap();
    refused(resume(&folder, &[]), "is not that of a run");
}

#[test]
fn a_program_that_was_changed_is_named() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let script = |comment: &str| {
        fs::write(path("step.sh"), format!("cp \"$1\" \"$2\" # {comment}\n")).unwrap();
    };
    let text = "[system]\nname = \"command\"\ncommand = [\"sh\", \"step.sh\", \"{before}\", \"{after}\"]\n\
                q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n";
    fs::write(path("run.toml"), text).unwrap();
    let check = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command
            .arg("check")
            .arg(path("run.toml"))
            .arg("--quiet")
            .arg("--out")
            .arg(path("run"));
        command.args(arguments).output().unwrap()
    };
    script("as it was");
    // It moves nothing.
    assert_eq!(check(&[]).status.code(), Some(3));
    script("and as it is");
    let output = check(&[]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("program.step.sh"), "{text}");
    assert_eq!(check(&["--force"]).status.code(), Some(3));
}

#[cfg(unix)]
#[test]
fn a_limit_of_file_sizes_is_an_error_and_the_run_goes_on_without_it() {
    let bench = Bench::new("leapfrog", KEYS);
    let folder = bench.folder.path().join("run");
    let limited = |limit: &str| {
        let mut command = Command::new("sh");
        let script = format!("ulimit -f {limit}; exec \"$@\"");
        command
            .arg("-c")
            .arg(script)
            .arg("sh")
            .arg(env!("CARGO_BIN_EXE_symplint"));
        command
            .arg("check")
            .arg(bench.config())
            .arg("--quiet")
            .arg("--out")
            .arg(&folder);
        command.args(["--set", "diagnostic.budget=300"]);
        command
            .env("TMPDIR", bench.temporary.path())
            .output()
            .unwrap()
    };
    // Blocks of 512 bytes or of 1024: the configuration and a part of the journal fit.
    let output = limited("4");
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains("cannot write") && text.contains("journal"),
        "{text}"
    );
    let output = limited("unlimited");
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let text = fs::read_to_string(folder.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert!(report["provenance"]["replayed"].as_u64().unwrap() > 0);
}
