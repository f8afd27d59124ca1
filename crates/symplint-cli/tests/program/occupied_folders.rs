//! Folders of `--out` and files of `--output` that hold something else are not written to.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::{configuration, example, symplint, text};

/// The message without line breaks, which fit it to the terminal.
fn refused(arguments: &[&str]) -> String {
    let output = symplint(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `check` of a pendulum with few points; exit status 0 is demanded.
fn check(configuration: &Path, out: &Path, more: &[&str]) {
    let output = symplint(&[&arguments(configuration, out)[..], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

fn arguments<'a>(configuration: &'a Path, out: &'a Path) -> Vec<&'a str> {
    let mut arguments = vec!["check", configuration.to_str().unwrap(), "--quiet"];
    arguments.extend(["--out", out.to_str().unwrap()]);
    arguments
}

const FEW: &str =
    "# Mine.\n[system]\nname = \"pendulum\"\n[diagnostic]\nstep_sizes = [0.5]\nloops = 1\n";

/// `check config.toml --out .` must not replace the user's own file.
#[test]
fn a_folder_with_files_of_others_is_never_written_to() {
    let (folder, path) = configuration(FEW);
    let own = folder.path().join("config.toml");
    fs::rename(&path, &own).unwrap();
    for force in [&[][..], &["--force"]] {
        let said = refused(&[&arguments(&own, folder.path())[..], force].concat());
        for words in [
            "not a run folder",
            "did not write config.toml",
            "--force does not",
        ] {
            assert!(said.contains(words), "{said}");
        }
    }
    assert_eq!(fs::read_to_string(&own).unwrap(), FEW);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);

    // The same where no name is one of symplint's.
    fs::rename(&own, folder.path().join("notes.txt")).unwrap();
    let pendulum = example("pendulum.toml");
    let said = refused(&[
        "trace",
        &pendulum,
        "--force",
        "--out",
        folder.path().to_str().unwrap(),
    ]);
    assert!(said.contains("did not write notes.txt"), "{said}");
}

#[test]
fn the_run_of_another_configuration_is_replaced_by_force_only() {
    let (folder, path) = configuration(FEW);
    let out = folder.path().join("run");
    let sweep = "diagnostic.sample_sweep={from=8,to=16,step_size=0.5}";
    check(&path, &out, &["--set", sweep]);
    assert!(out.join("figures/samples.svg").exists());
    let report = || fs::read_to_string(out.join("report.json")).unwrap();
    let first = report();

    let said = refused(&arguments(&path, &out));
    assert!(said.contains("it has diagnostic.sample_sweep"), "{said}");
    assert!(said.contains("--force"), "{said}");
    assert_eq!(report(), first);

    check(&path, &out, &["--force"]);
    // Nothing of the first run remains.
    assert!(!out.join("figures/samples.svg").exists());
    assert!(!out.join("figures/samples.png").exists());
    let second = report();
    assert_ne!(second, first);

    let said = refused(&[&arguments(&path, &out)[..], &["--set", "loop.radius=0.5"]].concat());
    assert!(
        said.contains("loop.radius is 1.0 there and 0.5 here"),
        "{said}"
    );
    // The same configuration, with a number written in another way.
    check(&path, &out, &["--set", "loop.radius=2^0", "--threads", "1"]);
    assert!(report().contains("\"radius\": \"2^0\""));
    // Its own resolved configuration.
    check(&out.join("config.toml"), &out, &[]);
}

#[test]
fn commands_do_not_share_a_folder() {
    let (folder, path) = configuration(FEW);
    let out = folder.path().join("run");
    check(&path, &out, &[]);
    let mut trace = vec!["trace", path.to_str().unwrap(), "--set", "trace.steps=4"];
    trace.extend(["--set", "trace.samples=64", "--out", out.to_str().unwrap()]);
    let said = refused(&trace);
    assert!(said.contains("of `symplint check`"), "{said}");
    trace.push("--force");
    assert_eq!(symplint(&trace).status.code(), Some(0));
    assert!(out.join("loop_0.csv").exists());
    assert!(!out.join("figures/step_sizes.svg").exists());
    let said = refused(&arguments(&path, &out));
    assert!(said.contains("of `symplint trace`"), "{said}");
    // Of the loops in the folder, the trace wrote the first.
    let own = out.join("loop_7.csv");
    fs::write(&own, "Mine.").unwrap();
    check(&path, &out, &["--force"]);
    assert!(!out.join("loop_0.csv").exists());
    assert!(!out.join("figures/energy.svg").exists());
    assert_eq!(fs::read_to_string(&own).unwrap(), "Mine.");

    let out = out.to_str().unwrap();
    let reproduce = ["reproduce", "formulas", "--out", out];
    let said = refused(&reproduce);
    assert!(said.contains("of `symplint check`"), "{said}");
    let forced = symplint(&[&reproduce[..], &["--force"]].concat());
    assert_eq!(forced.status.code(), Some(0), "{}", text(&forced.stderr));
    // Its own run again.
    assert_eq!(symplint(&reproduce).status.code(), Some(0));
}

#[test]
fn a_run_folder_that_was_edited_is_never_written_to() {
    let (folder, path) = configuration(FEW);
    type Edit = fn(String) -> String;
    let edits: [(&str, Edit); 3] = [
        ("config.toml", |text| text + "# A note.\n"),
        ("config.toml", |text| {
            text.replace("radius = 1.0", "radius = 2.0")
        }),
        ("report.json", |_| "{}".into()),
    ];
    for (number, (name, edit)) in edits.into_iter().enumerate() {
        let out = folder.path().join(number.to_string());
        check(&path, &out, &[]);
        let file = out.join(name);
        let edited = edit(fs::read_to_string(&file).unwrap());
        fs::write(&file, &edited).unwrap();
        // The configuration of the folder itself is refused, too.
        for configuration in [&path, &out.join("config.toml")] {
            let said = refused(&[&arguments(configuration, &out)[..], &["--force"]].concat());
            assert!(said.contains(name), "{said}");
        }
        assert_eq!(fs::read_to_string(&file).unwrap(), edited);
    }
}

#[test]
fn a_run_that_failed_at_once_leaves_a_folder_that_can_be_used() {
    let (folder, path) = configuration(FEW);
    let out = folder.path().join("run");
    let streaming = ["diagnostic.rule=streaming", "diagnostic.samples=16"];
    let streaming = ["--set", streaming[0], "--set", streaming[1]];
    refused(&[&arguments(&path, &out)[..], &streaming].concat());
    check(&path, &out, &[]);

    let paper = folder.path().join("paper");
    let paper = paper.to_str().unwrap();
    refused(&["reproduce", "fig8", "--set", "until=1e300", "--out", paper]);
    let few = ["--set", "steps=8", "--set", "samples=64", "--out", paper];
    let output = symplint(&[&["reproduce", "fig2"], &few[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

/// Its claims are one table, so an item less would lose claims.
#[test]
fn reproduce_adds_items_and_drops_none() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    fn with_out<'a>(ids: &[&'a str], out: &'a str) -> Vec<&'a str> {
        [&["reproduce"], ids, &["--out", out]].concat()
    }
    let run = |ids: &[&str]| {
        let output = symplint(&with_out(ids, out));
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    };
    run(&["formulas"]);
    run(&["formulas", "appendix-a"]);
    let said = refused(&with_out(&["formulas"], out));
    assert!(
        said.contains("it has appendix-a, and this run does not"),
        "{said}"
    );
    run(&["formulas", "--force"]);
    let few = ["fig2", "--set", "samples=64", "--set"];
    run(&[&few[..], &["steps=8", "--force"]].concat());
    let said = refused(&with_out(&[&few[..], &["steps=9"]].concat(), out));
    assert!(said.contains("fig2.steps is 8 there and 9 here"), "{said}");
}

#[test]
fn a_loop_file_is_replaced_by_the_same_loop_or_by_force() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for name in ["loop.npz", "loop.npy", "loop.csv"] {
        let path = file(name);
        let write = |more: &[&'static str]| {
            let mut arguments = vec!["loop", "--dof", "2", "--weight", "2", "-o", &path];
            arguments.extend(more);
            arguments
                .iter()
                .map(|text| (*text).to_owned())
                .collect::<Vec<_>>()
        };
        let run = |more: &[&'static str]| {
            let arguments = write(more);
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            symplint(&arguments)
        };
        assert_eq!(run(&[]).status.code(), Some(0));
        assert_eq!(
            run(&[]).status.code(),
            Some(0),
            "{name}: the same loop again"
        );
        for other in [&["--radius", "0.5"][..], &["--samples", "64"]] {
            let output = run(other);
            assert_eq!(output.status.code(), Some(2), "{name} {other:?}");
            let said = text(&output.stderr);
            assert!(
                said.contains("holds another loop") && said.contains("--force"),
                "{said}"
            );
            assert_eq!(run(&[]).status.code(), Some(0), "{name} is as it was");
        }
        assert_eq!(run(&["--radius", "0.5", "--force"]).status.code(), Some(0));
        assert_eq!(run(&[]).status.code(), Some(2), "{name} is replaced");
    }
    let notes = file("notes.csv");
    fs::write(&notes, "some,notes\n").unwrap();
    let said = refused(&["loop", "--dof", "1", "-o", &notes, "--force"]);
    assert!(said.contains("not a loop that symplint wrote"), "{said}");
    assert_eq!(fs::read_to_string(&notes).unwrap(), "some,notes\n");
}
