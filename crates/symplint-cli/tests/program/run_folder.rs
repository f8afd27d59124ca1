//! What `--out` leaves behind, and what it leaves out.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use super::provenance::results;
use super::{configuration, report, symplint, text};

/// Kepler's problem from a state at rest or not, and a circle in the plane of its first degree of freedom.
fn kepler(q0: &str, p0: &str, variant: &str, diagnostic: &str) -> String {
    format!(
        r#"
[system]
name = "kepler"
q0 = {q0}
p0 = {p0}

[integrator]
name = "strang"
variant = "{variant}"

[loop]
dofs = [0]

[diagnostic]
rule = "pseudospectral"
samples = 64
loops = 1
{diagnostic}
"#
    )
}

#[test]
fn the_loop_is_drawn_from_samples_that_were_measured() {
    // No sample but those measured: the force is singular at the centre, which the circle meets between two of its samples.
    let (folder, path) = configuration(&kepler(
        "0.0",
        "[0.0, 1.0]",
        "momentum-first",
        "step_sizes = [1e-10]\nlocalise = false",
    ));
    let (path, out) = (path.to_str().unwrap(), folder.path().join("run"));
    let samples = folder.path().join("samples.csv");
    let output = samples.to_str().unwrap();
    symplint(&["loop", path, "--samples", "128", "--output", output]);
    let samples = fs::read_to_string(&samples).unwrap();
    let position = samples.lines().nth(1 + 13).unwrap().split(',').next();
    let through = format!("system.q0=[-{}, 0.0]", position.unwrap());
    let arguments = ["check", path, "--json", "--set", &through];
    let without = symplint(&arguments);
    let with = symplint(&[&arguments[..], &["--out", out.to_str().unwrap()]].concat());
    let said = text(&with.stderr);
    assert_ne!(without.status.code(), Some(2), "{}", text(&without.stderr));
    assert_eq!(with.status.code(), without.status.code(), "{said}");
    assert_eq!(results(&with.stdout), results(&without.stdout));
    assert!(out.join("figures/loop.svg").exists(), "{said}");
}

#[test]
fn a_loop_of_which_no_sample_is_kept_is_not_drawn() {
    let folder = TempDir::new().unwrap();
    let (_run, path) = configuration("[system]\nname = \"pendulum-array\"\npendula = 64\n");
    for (rule, drawn) in [("pseudospectral", true), ("streaming", false)] {
        let out = folder.path().join(rule);
        let mut arguments = vec!["check", path.to_str().unwrap(), "--out"];
        let rule = format!("diagnostic.rule={rule}");
        arguments.extend([out.to_str().unwrap(), "--set", &rule]);
        for setting in [
            "diagnostic.samples=33",
            "diagnostic.loops=1",
            "diagnostic.step_sizes=[0.5]",
        ] {
            arguments.extend(["--set", setting]);
        }
        let output = symplint(&arguments);
        let said = text(&output.stderr);
        assert_ne!(output.status.code(), Some(2), "{said}");
        assert_eq!(out.join("figures/loop.svg").exists(), drawn, "{rule}");
        assert_eq!(said.contains("stayed in memory"), !drawn, "{said}");
    }
}

#[test]
fn a_resolved_configuration_finds_its_state_file() {
    let (folder, _) = configuration("");
    let file = folder.path().join("few.toml");
    let system = "name = \"pendulum-array\"\npendula = 2\ninitial = { file = \"state.csv\" }";
    fs::write(&file, format!("[system]\n{system}\n")).unwrap();
    fs::write(folder.path().join("state.csv"), "0.1,0.2\n0.3,0.4\n").unwrap();
    // By a relative path of the configuration, too: its folder is that of the run then.
    for (from, given) in [
        (Path::new("/"), file.as_path()),
        (folder.path(), Path::new("few.toml")),
    ] {
        let output = assert_cmd::Command::cargo_bin("symplint")
            .unwrap()
            .current_dir(from)
            .arg("check")
            .arg(given)
            .arg("--out")
            .arg(folder.path().join("run"))
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let resolved = folder.path().join("run/config.toml");
        let again = report(&["check", resolved.to_str().unwrap()]);
        let first = fs::read_to_string(folder.path().join("run/report.json")).unwrap();
        let first: Value = serde_json::from_str(&first).unwrap();
        assert_eq!(again["points"], first["points"]);
    }
}

/// Default snapshots come to step 80.
#[test]
fn a_short_trace_drops_the_default_snapshots_that_it_does_not_reach() {
    let (folder, path) = configuration("[system]\nname = \"pendulum\"\n");
    let out = folder.path().join("run");
    let short = ["--set", "trace.steps=50", "--set", "trace.samples=64"];
    let arguments = [
        &[
            "trace",
            path.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ],
        &short[..],
    ];
    let output = symplint(&arguments.concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(out.join("loop_40.csv").exists());
    assert!(!out.join("loop_80.csv").exists());
    // The resolved configuration runs again.
    let again = report(&["trace", out.join("config.toml").to_str().unwrap()]);
    assert_eq!(again["points"].as_array().unwrap().len(), 51);
}

#[test]
fn a_run_that_fails_leaves_the_points_until_then() {
    // A step of ¼ takes the state at s = 0 so near to the centre that the loop integral overflows; one of ½ takes it beyond.
    let (folder, path) = configuration(&kepler(
        "[-0.125, 1e-90]",
        "[0.0, 0.0]",
        "position-first",
        "step_sizes = [0.5, 0.25]",
    ));
    let out = folder.path().join("run");
    let (path, into) = (path.to_str().unwrap(), out.to_str().unwrap());
    let arguments = ["check", path, "--out", into];
    // An earlier run came to its end: its report must not stay next to the points of this one.
    let shorter = ["--set", "diagnostic.step_sizes=[0.5]"];
    let arguments = [&arguments[..], &["--force"]].concat();
    let output = symplint(&[&arguments[..], &shorter].concat());
    assert_ne!(output.status.code(), Some(2), "{}", text(&output.stderr));
    let whole = fs::read_to_string(out.join("points.csv")).unwrap();
    assert!(out.join("report.json").exists());
    // One that is refused before it measures anything leaves them alone.
    let streaming = ["diagnostic.rule=streaming", "diagnostic.samples=16"];
    let refused = ["--set", streaming[0], "--set", streaming[1]];
    let output = symplint(&[&arguments[..], &refused].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(!text(&output.stderr).contains("the points measured before"));
    assert!(out.join("report.json").exists());
    assert_eq!(fs::read_to_string(out.join("points.csv")).unwrap(), whole);

    let output = symplint(&arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("the points measured before are in"), "{said}");
    assert_eq!(fs::read_to_string(out.join("points.csv")).unwrap(), whole);
    assert_eq!(whole.lines().count(), 2, "{whole}");
    let resolved = fs::read_to_string(out.join("config.toml")).unwrap();
    assert!(resolved.contains("step_sizes = [0.5, 0.25]"), "{resolved}");
    assert!(!out.join("report.json").exists());
}
