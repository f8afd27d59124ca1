//! What the system cannot do for a call, which is no failure of the map: the run ends, and goes on later.

use std::fs;
use std::process::Command;

use serde_json::Value;

use super::resume::{KEYS, report};
use super::{Bench, in_one_line, said};
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

#[test]
#[cfg(target_os = "linux")]
fn a_call_that_cannot_be_made_is_no_failure_of_the_map() {
    let bench = Bench::new("leapfrog", "batch = 1000\n");
    for (limit, reason) in [
        ("-f 1", "before.npz: File too large"),
        ("-n 7", "open files (os error 24); end other processes"),
        ("-n 10", "open files (os error 24); end other processes"),
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
        let text = in_one_line(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(reason), "{text}");
        assert!(text.contains("says nothing of the map"), "{text}");
        // Nor does a library print what it could not write.
        assert!(!text.contains("ZipWriter"), "{text}");
        assert!(bench.left_behind().is_empty());
    }
}

#[test]
#[cfg(unix)]
fn what_fails_for_another_reason_than_the_map_stops_the_run_which_goes_on_later() {
    for (behaviour, keep, reason) in [
        ("grow", None, "files may not grow"),
        ("remove", None, "before.npz was removed or changed"),
        ("remove", Some("kept"), "before.npz was removed or changed"),
    ] {
        let bench = Bench::new(behaviour, KEYS);
        let path = |name: &str| bench.folder.path().join(name);
        let check = |out: &str, keep: Option<&str>| {
            let mut command = bench.command(&["--quiet", "--set", "diagnostic.budget=1500"]);
            command.arg("--out").arg(path(out));
            command.args(keep.map(|keep| format!("--keep={}", path(keep).display())));
            command
        };
        let stopped = check("stopped", keep).output().unwrap();
        let text = in_one_line(&stopped);
        assert_eq!(stopped.status.code(), Some(2), "{behaviour}: {text}");
        assert!(text.contains(reason), "{behaviour}: {text}");
        assert!(!path("stopped").join("report.json").exists());
        for out in ["stopped", "whole"] {
            let mut command = check(out, keep.filter(|_| out == "stopped"));
            let output = command.env("SYMPLINT_TEST_WELL", "").output().unwrap();
            let text = said(&output);
            assert_eq!(output.status.code(), Some(0), "{behaviour}: {text}");
        }
        // The configurations have `keep`, or not.
        let [stopped, whole] = ["stopped", "whole"].map(|out| report(&path(out)));
        assert_eq!(stopped["evidence"], whole["evidence"], "{behaviour}");
        assert_eq!(stopped["verdict"], whole["verdict"], "{behaviour}");
    }
}
