//! The verdict again, from a report.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::{example, symplint, text};

/// Writes the report of an example, judges it, and compares.
fn judged_alike(name: &str, settings: &[&str]) {
    let path = example(name);
    let mut arguments = vec!["check", &path, "--json"];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let run = symplint(&arguments);
    let folder = TempDir::new().unwrap();
    let report = folder.path().join("report.json");
    fs::write(&report, &run.stdout).unwrap();
    // A run folder stands for the report in it.
    for of in [report.to_str().unwrap(), folder.path().to_str().unwrap()] {
        let judged = symplint(&["judge", of, "--json"]);
        assert_eq!(
            judged.status.code(),
            run.status.code(),
            "{name}: {}",
            text(&judged.stderr)
        );
        let verdict: Value = serde_json::from_slice(&judged.stdout).unwrap();
        let of_run: Value = serde_json::from_slice(&run.stdout).unwrap();
        assert_eq!(verdict, of_run["verdict"], "{name}");
    }
}

#[test]
fn every_example_is_judged_alike_from_its_report() {
    let examples = fs::read_dir(example("")).unwrap();
    let mut names: Vec<String> = examples
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    names.sort();
    assert!(names.len() >= 17);
    for name in names {
        // The evidence is of the same kind whatever it costs.
        judged_alike(&name, &["diagnostic.budget=20000"]);
    }
    judged_alike("pendulum.toml", &["integrator.name=rk2"]);
}

#[test]
fn what_is_no_report_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("other.json");
    for (content, words) in [("", "not JSON"), ("{}", "not a report"), ("[", "not JSON")] {
        fs::write(&path, content).unwrap();
        let output = symplint(&["judge", path.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2));
        let message = text(&output.stderr);
        assert!(message.contains(words), "{content}: {message}");
    }
    let output = symplint(&["judge", "no-such-file.json"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("cannot read"));
}
