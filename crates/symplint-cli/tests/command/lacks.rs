//! Calls that the system cannot serve, which is not a failure of the map: the run ends, and continues later.

use std::fs;
use std::process::Command;

use serde_json::Value;

use super::resume::{KEYS, report};
use super::{Bench, ends, refused, said};

#[cfg(unix)]
#[test]
fn a_limit_of_file_sizes_is_an_error_and_the_run_goes_on_without_it() {
    let bench = Bench::new("leapfrog", KEYS);
    let folder = bench.folder.path().join("run");
    let limited = |limit: &str| {
        let mut command = Command::new("sh");
        let script = format!("ulimit -f {limit}; exec \"$@\"");
        command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_symplint")]);
        command.args(["check", "--quiet", "--set", "diagnostic.budget=300"]);
        command.arg(bench.config()).arg("--out").arg(&folder);
        let command = command.env("TMPDIR", bench.temporary.path());
        command.output().unwrap()
    };
    // Blocks of 512 bytes or of 1024: the configuration and a part of the journal fit.
    let output = limited("4");
    refused(&output, "cannot write");
    refused(&output, "journal");
    let output = limited("unlimited");
    ends(0, &output);
    let text = fs::read_to_string(folder.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert!(report["provenance"]["replayed"].as_u64().unwrap() > 0);
}

#[test]
#[cfg(target_os = "linux")]
fn a_call_that_cannot_be_made_is_no_failure_of_the_map() {
    let bench = Bench::new("leapfrog", "batch = 1000\n");
    for (limit, reason) in [
        ("-f 1", "before.npz: File too large"),
        ("-n 7", "open files (os error 24); check system.command"),
        ("-n 10", "open files (os error 24); check system.command"),
    ] {
        let output = Command::new("sh")
            .args(["-c", &format!("ulimit {limit}; exec \"$@\""), "sh"])
            .arg(env!("CARGO_BIN_EXE_symplint"))
            .arg("check")
            .arg(bench.config())
            .args(["--set", "diagnostic.budget=300"])
            .env("TMPDIR", bench.temporary.path())
            .output()
            .unwrap();
        refused(&output, reason);
        refused(&output, "says nothing of the map");
        // Nor does a library print what it could not write.
        assert!(!said(&output).contains("ZipWriter"));
        assert!(bench.left_behind().is_empty());
    }
}

#[test]
#[cfg(unix)]
fn a_run_whose_files_are_removed_stops_and_resumes() {
    let bench = Bench::new("remove", KEYS);
    let path = |name: &str| bench.path(name);
    let check = |out: &str| {
        let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=1500", "--out"]);
        command.arg(path(out));
        command
    };
    let stopped = check("stopped").output().unwrap();
    // The first call notices it, or another one beside it.
    refused(&stopped, "was removed meanwhile");
    assert!(!path("stopped").join("report.json").exists());
    for out in ["stopped", "whole"] {
        let output = check(out).env("SYMPLINT_TEST_WELL", "").output().unwrap();
        ends(0, &output);
    }
    assert_eq!(report(&path("stopped")), report(&path("whole")));
}
