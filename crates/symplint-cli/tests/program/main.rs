//! The program as its users run it: exit statuses, files, messages.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

mod budget;
mod command_line;
mod judge;
mod occupied_folders;
mod provenance;
mod refusals;
mod run_folder;

fn symplint(arguments: &[&str]) -> Output {
    Command::cargo_bin("symplint")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn example(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    root.join(name).to_str().unwrap().to_owned()
}

/// A configuration in its own folder.
fn configuration(text: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.toml");
    fs::write(&path, text).unwrap();
    (folder, path)
}

fn report(arguments: &[&str]) -> Value {
    let output = symplint(&[arguments, &["--json"]].concat());
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("nothing but JSON on standard output")
}

#[test]
fn the_first_command_of_the_readme() {
    let output = symplint(&["check", &example("pendulum.toml")]);
    assert_eq!(output.status.code(), Some(0));
    let said = text(&output.stdout);
    assert!(said.contains("SYMPLECTIC to 14"), "{said}");
    assert!(said.lines().count() < 28, "a screen holds it:\n{said}");
    assert!(!said.contains('\u{1b}'), "no colours in a pipe");
}

#[test]
fn an_integrator_that_is_not_symplectic() {
    for (variant, order) in [("midpoint", 3.0), ("heun", 4.0)] {
        let set = format!("integrator.variant={variant}");
        let arguments = [
            "check",
            &example("pendulum.toml"),
            "--set",
            "integrator.name=rk2",
            "--set",
            &set,
        ];
        assert_eq!(symplint(&arguments).status.code(), Some(1));
        let report = report(&arguments);
        assert_eq!(report["verdict"]["kind"], "not-symplectic");
        assert_eq!(report["verdict"]["order"], order);
        assert_eq!(report["verdict"]["digits"], Value::Null);
        assert_eq!(report["config"]["integrator"]["variant"], variant);
    }
}

#[test]
fn the_streaming_rule_has_the_verdicts_of_the_others() {
    for (integrator, status) in [("strang", 0), ("rk2", 1)] {
        let set = format!("integrator.name={integrator}");
        let example = example("pendulum-array.toml");
        let mut arguments = vec!["check", &example, "--set", &set];
        for setting in [
            "system.pendula=16",
            "diagnostic.rule=streaming",
            "diagnostic.half_width=9",
        ] {
            arguments.extend(["--set", setting]);
        }
        assert_eq!(symplint(&arguments).status.code(), Some(status));
        let report = report(&arguments);
        assert_eq!(report["config"]["diagnostic"]["half_width"], 9);
        for point in report["points"].as_array().unwrap() {
            assert_eq!(point["rule"], "streaming");
            // The first 10 samples are advanced twice; 32 tell the rounding of the map at the first step of a loop.
            let samples = point["samples"].as_u64().unwrap();
            let further = point["evaluations"].as_u64().unwrap() - samples;
            assert!([10, 42].contains(&further), "{further}");
        }
    }
    let (_folder, path) = configuration("[system]\nname = \"absolute-value\"\n");
    let arguments = [
        "check",
        path.to_str().unwrap(),
        "--set",
        "diagnostic.rule=streaming",
    ];
    assert_eq!(symplint(&arguments).status.code(), Some(1));
    assert_eq!(report(&arguments)["verdict"]["kind"], "broken-loops");
}

#[test]
fn the_report_has_the_fields_of_its_schema() {
    let report = report(&["check", &example("pendulum.toml")]);
    assert_eq!(report["schema"], "symplint/report/3");
    let point = &report["points"][0];
    for field in [
        "sweep",
        "loop",
        "step_size",
        "samples",
        "rule",
        "initial",
        "final",
        "signed_defect",
        "defect",
        "quadrature_error",
        "roundoff",
        "omitted_cells",
        "jumps",
        "chord",
        "closed_defect",
        "regularity",
        "evaluations",
    ] {
        assert!(point.get(field).is_some(), "{field} is missing: {point}");
    }
    assert_eq!(point["sweep"], "step-size");
    assert_eq!(point["jumps"], Value::Null);
    assert!((point["initial"].as_f64().unwrap() - std::f64::consts::PI).abs() < 1e-14);
    for field in ["config", "evaluations", "fits", "evidence", "provenance"] {
        assert!(report.get(field).is_some(), "{field}");
    }
    for field in [
        "kind",
        "digits",
        "order",
        "summary",
        "findings",
        "sentences",
        "cause",
        "advice",
    ] {
        assert!(report["verdict"].get(field).is_some(), "{field}");
    }
}

#[test]
fn broken_loops_and_undecided_have_their_own_status() {
    let (_folder, path) = configuration("[system]\nname = \"absolute-value\"\n");
    let path = path.to_str().unwrap();
    let output = symplint(&["check", path, "--quiet"]);
    assert_eq!(
        (output.status.code(), text(&output.stdout).trim()),
        (
            Some(1),
            "DISCONTINUOUS (broken loops): ∮p·dq is conserved once breaks are closed"
        )
    );
    // Runge and Kutta's method at small steps: a larger one shows its defect.
    let output = symplint(&[
        "check",
        &example("pendulum.toml"),
        "--quiet",
        "--set",
        "diagnostic.step_sizes=[1e-6]",
        "--set",
        "integrator.name=rk4",
    ]);
    assert_eq!(
        (output.status.code(), text(&output.stdout).trim()),
        (Some(3), "INCONCLUSIVE")
    );
}

#[test]
fn a_map_without_a_step_size_has_no_column_of_them() {
    let (folder, path) = configuration(
        "[system]\nname = \"standard-map\"\n[diagnostic]\nstep_sizes = \"none\"\nrepeat = 2\n",
    );
    let (path, out) = (path.to_str().unwrap(), folder.path().join("run"));
    let output = symplint(&["check", path, "--out", out.to_str().unwrap()]);
    let said = text(&output.stdout);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{said}{}",
        text(&output.stderr)
    );
    assert!(said.contains("by the map (pseudospectral rule)"), "{said}");
    assert!(
        !said.contains("step size") && !said.contains("h ="),
        "{said}"
    );
    assert!(out.join("figures/loop.svg").exists());
    assert!(!out.join("figures/step_sizes.svg").exists());
    let found = report(&["check", out.join("config.toml").to_str().unwrap()]);
    assert_eq!(found["points"][0]["step_size"], Value::Null);
    assert_eq!(found["config"]["diagnostic"]["step_sizes"], "none");
    assert_eq!(found["evidence"]["jacobian"]["step_size"], Value::Null);
}

#[test]
fn a_run_folder_holds_everything() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("deep/run");
    let sweep = "diagnostic.sample_sweep={from=8,to=64,step_size=0.5}";
    let output = symplint(&[
        "check",
        &example("pendulum.toml"),
        "--set",
        sweep,
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0));
    for name in [
        "report.json",
        "points.csv",
        "config.toml",
        "figures/step_sizes.svg",
        "figures/step_sizes.png",
        "figures/samples.svg",
        "figures/loop.png",
    ] {
        assert!(
            fs::metadata(out.join(name)).is_ok_and(|data| data.len() > 100),
            "{name}"
        );
    }
    let points = fs::read_to_string(out.join("points.csv")).unwrap();
    assert!(
        points.starts_with("sweep,loop,step_size,samples,rule,initial,final,"),
        "{points}"
    );
    assert_eq!(
        points
            .lines()
            .filter(|line| line.starts_with("samples,0,0.5,"))
            .count(),
        4
    );
    // The resolved configuration runs again, and gives the same bits.
    let resolved = out.join("config.toml");
    let again = report(&["check", resolved.to_str().unwrap()]);
    let first: Value =
        serde_json::from_str(&fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(again["points"], first["points"]);
    // The table has the points of the report, in their order.
    let listed = first["points"].as_array().unwrap();
    assert_eq!(points.lines().count(), listed.len() + 1);
    for (line, point) in points.lines().skip(1).zip(listed) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(point["sweep"], fields[0]);
        assert_eq!(point["loop"].to_string(), fields[1]);
        let of_report = point["final"].as_f64().unwrap();
        // The reader of JSON here rounds the last bit at will.
        let of_table: f64 = fields[6].parse().unwrap();
        assert!((of_report - of_table).abs() < 1e-15 * of_table.abs());
    }
}

#[test]
fn keys_of_the_diagnosis_are_followed_and_recorded() {
    let example = example("pendulum.toml");
    let run = |setting: &str| {
        let few = ["--set", "diagnostic.step_sizes=[0.5]", "--set", setting];
        let set = ["--set", "integrator.name=rk2"];
        report(&[&["check", &example], &few[..], &set].concat())
    };
    let mentions = |report: &Value, word: &str| {
        let evidence = report["verdict"]["sentences"].as_array().unwrap();
        evidence
            .iter()
            .any(|line| line.as_str().unwrap().contains(word))
    };
    let with = run("diagnostic.budget=2^20");
    assert_eq!(with["config"]["diagnostic"]["budget"], "2^20");
    assert_eq!(with["config"]["diagnostic"]["jacobian"], true);
    assert_eq!(with["config"]["diagnostic"]["localise"], true);
    assert!(
        mentions(&with, "Jacobian") && mentions(&with, "sectors"),
        "{with}"
    );
    let without = run("diagnostic.jacobian=false");
    assert!(!mentions(&without, "Jacobian"), "{without}");
    let without = run("diagnostic.localise=false");
    assert!(!mentions(&without, "sectors"), "{without}");
}

#[test]
fn the_longest_sweep_that_is_not_refused() {
    let settings = [
        "diagnostic.step_sizes={from=1,to='2^-64'}",
        "diagnostic.loops=1",
    ];
    let example = example("pendulum.toml");
    let mut arguments = vec!["check", &example];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let report = report(&arguments);
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 65);
    assert_eq!(points[64]["step_size"], 2f64.powi(-64));
}

#[test]
fn a_trace_follows_loop_and_energy() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = [
        "trace",
        &example("pendulum.toml"),
        "--set",
        "system.q0=pi",
        "--set",
        "trace.steps=50",
        "--set",
        "trace.samples=256",
        "--set",
        "trace.snapshots=[0, 50]",
        "--out",
        out,
    ];
    assert_eq!(symplint(&arguments).status.code(), Some(0));
    for name in [
        "report.json",
        "points.csv",
        "loop_50.csv",
        "figures/loops.svg",
        "figures/energy.png",
    ] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    let report = report(&arguments);
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 51);
    assert!((points[50]["time"].as_f64().unwrap() - 5.0).abs() < 1e-12);
    assert!(
        points
            .iter()
            .all(|point| point["defect"].as_f64().unwrap() < 1e-13)
    );
    assert!(
        points
            .iter()
            .all(|point| point["energy_error"].as_f64().unwrap().abs() < 1e-2)
    );
    let samples = fs::read_to_string(folder.path().join("loop_50.csv")).unwrap();
    assert_eq!(
        (samples.lines().count(), samples.lines().next()),
        (257, Some("s,q_0,p_0"))
    );
}

#[test]
fn every_system_has_a_starter_that_runs() {
    let listed = text(&symplint(&["list", "systems"]).stdout);
    // A name begins a line; what is said of it is indented.
    let names = listed.lines().filter(|line| !line.starts_with(' '));
    let names: Vec<&str> = names
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(names.len() >= 17, "{listed}");
    for name in names {
        let short = text(&symplint(&["init", name]).stdout);
        assert!(short.lines().count() <= 40, "{short}");
        let starter = text(&symplint(&["init", name, "--all"]).stdout);
        // The short one has some of these lines.
        let keys = |of: &str| -> Vec<String> {
            let keys = of
                .lines()
                .filter(|line| line.contains(" = ") && !line.starts_with([' ', '#']));
            keys.map(str::to_owned).collect()
        };
        assert!(
            keys(&short).iter().all(|key| keys(&starter).contains(key)),
            "{short}"
        );
        assert!(starter.contains("# "), "it is commented:\n{starter}");
        let longest = starter.lines().map(|line| line.chars().count()).max();
        assert!(longest <= Some(80), "{starter}");
        let (_folder, path) = configuration(&starter);
        // Few pendula, so that it is quick, and a program that is there; every other key as the starter has it.
        let pendula = match name {
            "pendulum-array" => vec!["--set", "system.pendula=16"],
            "command" => vec![
                "--set",
                "system.command=[\"cp\", \"{before}\", \"{after}\"]",
            ],
            _ => vec![],
        };
        let output =
            symplint(&[&["check", path.to_str().unwrap(), "--quiet"], &pendula[..]].concat());
        let broken = matches!(
            name,
            "absolute-value" | "two-cell" | "rotational-force" | "pic-es1"
        );
        // A copy of the states is a step that moves nothing, which decides nothing.
        let expected = match name {
            "command" => 3,
            _ => i32::from(broken),
        };
        assert_eq!(
            output.status.code(),
            Some(expected),
            "{name}: {}",
            text(&output.stderr)
        );
    }
}

/// The verdict on an example with settings: exit status and headline.
fn verdict(name: &str, settings: &[&str]) -> (i32, String) {
    let path = example(name);
    let mut arguments = vec!["check", &path, "--quiet"];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let output = symplint(&arguments);
    let said = text(&output.stdout).trim().to_owned();
    (output.status.code().unwrap(), said)
}

/// The verdicts that the comments of the examples name.
#[test]
fn examples_of_mechanics_have_their_verdicts() {
    let of_order = |order: usize| {
        let law = ["", "h", "h²", "h³", "h⁴", "h⁵", "h⁶", "h⁷"][order];
        (
            1,
            format!("NOT SYMPLECTIC: ∮p·dq changes in proportion to {law}"),
        )
    };
    let symplectic = |name: &str, settings: &[&str]| {
        let (status, said) = verdict(name, settings);
        assert_eq!(status, 0, "{name} {settings:?}: {said}");
        assert!(
            said.starts_with("SYMPLECTIC to 1"),
            "{name} {settings:?}: {said}"
        );
    };
    let adaptive = "integrator.name=adaptive-strang";
    symplectic("kepler.toml", &[]);
    symplectic("kepler.toml", &["integrator.name=gauss6"]);
    symplectic(
        "kepler.toml",
        &["system.q0=[0.5,0]", "system.softening=0.1"],
    );
    assert_eq!(verdict("kepler.toml", &[adaptive]), of_order(1));
    let (status, _) = verdict("kepler.toml", &["integrator.name=dop853"]);
    assert_eq!(status, 1);

    let averaged = "integrator.name=averaged-vector-field";
    symplectic("double-pendulum.toml", &[]);
    symplectic("double-pendulum.toml", &["integrator.solver=newton"]);
    for (setting, order) in [
        ("integrator.name=trapezoidal", 3),
        (averaged, 3),
        ("integrator.name=rk4", 5),
    ] {
        assert_eq!(
            verdict("double-pendulum.toml", &[setting]),
            of_order(order),
            "{setting}"
        );
    }
    let loose = verdict("double-pendulum.toml", &["integrator.tolerance=1e-6"]);
    assert_eq!(loose, (1, "DISCONTINUOUS (broken loops)".to_owned()));
    let (status, said) = verdict("double-pendulum.toml", &["integrator.iterations=3"]);
    assert_eq!(status, 1);
    assert!(said.starts_with("NOT SYMPLECTIC"), "{said}");

    assert_eq!(verdict("charged-particle.toml", &[]), of_order(3));
    symplectic("charged-particle.toml", &["system.gradient=0"]);
    let electric = ["system.gradient=0", "system.omega=0.8"];
    assert_eq!(verdict("charged-particle.toml", &electric), of_order(3));
    symplectic(
        "charged-particle.toml",
        &["integrator.name=implicit-midpoint"],
    );

    assert_eq!(verdict("rotational-force.toml", &[]), of_order(1));
    symplectic("rotational-force.toml", &["system.strength=0"]);

    symplectic("fput.toml", &[]);
    // Its terms of order 5 and 6 are as large as each other at these step sizes.
    let without_order = (1, "NOT SYMPLECTIC: ∮p·dq changes".to_owned());
    assert_eq!(
        verdict("fput.toml", &["integrator.name=rk4"]),
        without_order
    );
    symplectic("toda.toml", &[]);
    symplectic("toda.toml", &["integrator.name=gauss4"]);
    assert_eq!(verdict("toda.toml", &[averaged]), of_order(3));
}

#[test]
fn examples_of_given_maps_have_their_verdicts() {
    let of_first_order = (
        1,
        "NOT SYMPLECTIC: ∮p·dq changes in proportion to h".to_owned(),
    );
    assert_eq!(verdict("henon-map.toml", &[]).0, 0);
    let contracted = verdict("henon-map.toml", &["system.contraction=0.9"]);
    assert_eq!(contracted, of_first_order);
    assert_eq!(verdict("standard-map.toml", &[]).0, 0);
    let damped = verdict("standard-map.toml", &["integrator.damping=0.1"]);
    assert_eq!(damped, of_first_order);
    let (status, said) = verdict("standard-map.toml", &["integrator.precision=single"]);
    assert_eq!(status, 0);
    let digits: f64 = said.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((6.5..9.0).contains(&digits), "{said}");
}

/// A map without an energy is traced without one.
#[test]
fn a_trace_without_an_energy() {
    let folder = TempDir::new().unwrap();
    let arguments = [
        "trace",
        &example("standard-map.toml"),
        "--set",
        "trace.steps=4",
        "--set",
        "trace.samples=256",
        "--set",
        "trace.snapshots=[4]",
        "--out",
        folder.path().to_str().unwrap(),
    ];
    let output = symplint(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(!text(&output.stdout).contains("largest energy error"));
    assert!(folder.path().join("figures/loops.svg").exists());
    assert!(!folder.path().join("figures/energy.svg").exists());
    let report = report(&arguments);
    assert_eq!(report["points"][4]["energy"], Value::Null);
}

#[test]
fn everything_can_be_listed() {
    for (what, some) in [
        ("integrators", "yoshida8"),
        ("rules", "pseudospectral"),
        ("rules", "streaming"),
        ("figures", "fig5"),
    ] {
        let output = symplint(&["list", what]);
        assert_eq!(output.status.code(), Some(0));
        assert!(text(&output.stdout).contains(some));
    }
}

#[test]
fn items_of_the_paper_with_settings() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = symplint(&[
        "reproduce",
        "fig2",
        "--set",
        "steps=80",
        "--set",
        "samples=512",
        "--out",
        out,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let claims: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("claims.json")).unwrap())
            .unwrap();
    assert_eq!(claims[0]["item"], "fig2");
    assert_eq!(claims[0]["judgement"], "holds");
    for name in [
        "claims.md",
        "fig2_stable.csv",
        "figures/fig2.svg",
        "figures/fig2.png",
    ] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

/// The claims that `reproduce` judged, and claims.md.
fn claims_of(arguments: &[&str]) -> (Vec<Value>, String) {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = symplint(&[&["reproduce"], arguments, &["--out", out]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let read = |name| fs::read_to_string(folder.path().join(name)).unwrap();
    let claims = serde_json::from_str(&read("claims.json")).unwrap();
    (claims, read("claims.md"))
}

#[test]
fn claims_are_left_open_where_the_settings_cannot_carry_them() {
    for arguments in [
        &["fig6", "--set", "to=64", "--set", "scaling_to=2^13"][..],
        &["fig7", "--set", "samples=64"],
        &["fig7", "--set", "particles=1", "--set", "samples=512"],
        &[
            "fig6",
            "--set",
            "particles=1",
            "--set",
            "to=256",
            "--set",
            "scaling_to=2^13",
        ],
        &["fig8", "--set", "until=1", "--set", "particles=50"],
    ] {
        let (claims, _) = claims_of(arguments);
        assert!(!claims.is_empty());
        for claim in claims {
            assert_eq!(claim["judgement"], "unresolved", "{arguments:?}: {claim}");
        }
    }
}

#[test]
fn checks_beyond_the_paper_are_no_claims_of_it() {
    let (claims, table) = claims_of(&[
        "physics",
        "--set",
        "cold_particles=100",
        "--set",
        "landau_particles=100",
        "--set",
        "beam_particles=100",
    ]);
    assert_eq!(claims.len(), 3);
    assert!(claims.iter().all(|claim| claim["origin"] == "beyond"));
    assert!(table.starts_with("# Checks beyond the paper"), "{table}");
}

#[test]
fn runs_without_end_are_refused() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = symplint(&["reproduce", "fig8", "--set", "until=1e300", "--out", out]);
    assert_eq!(output.status.code(), Some(2));
    let error = text(&output.stderr);
    for expected in ["fig8.until", "too many", "at most"] {
        assert!(error.contains(expected), "{expected}: {error}");
    }
    for item in ["near-symplectic", "census"] {
        let folder = TempDir::new().unwrap();
        let out = folder.path().to_str().unwrap();
        let output = symplint(&["reproduce", item, "--set", "time=1e300", "--out", out]);
        assert_eq!(output.status.code(), Some(2));
        let error = text(&output.stderr);
        assert!(error.contains(&format!("{item}.time")), "{error}");
    }
    for item in ["fig4", "fig5", "fig7", "fig9"] {
        let folder = TempDir::new().unwrap();
        let out = folder.path().to_str().unwrap();
        let output = symplint(&["reproduce", item, "--set", "halvings=41", "--out", out]);
        assert_eq!(output.status.code(), Some(2));
        let error = text(&output.stderr);
        for expected in [&format!("{item}.halvings"), "41 is too many", "at most 40"] {
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }
    // The key to blame is the one that was set, and numbers stay readable.
    let output = symplint(&[
        "reproduce",
        "fig8",
        "--set",
        "step_size=1e-300",
        "--out",
        out,
    ]);
    let error = text(&output.stderr);
    assert!(error.contains("fig8.step_size"), "{error}");
    assert!(!error.contains("00000"), "{error}");
}

#[test]
fn odd_plasmas_run() {
    let (folder, path) = configuration("[system]\nname = \"pic-1d\"\n");
    // One particle, one cell, fewer cells than the spline's width, a particle at L and far outside.
    fs::write(
        folder.path().join("state.csv"),
        "x,v\n50.0,1.0\n-12345.6,-2.0\n",
    )
    .unwrap();
    for settings in [
        &["system.particles=1"][..],
        &["system.cells=1"],
        &["system.cells=2", "system.length=1"],
        &["system.initial={ file = 'state.csv' }"],
        &["system.filter=4", "system.weights=[10.0, 40.0]"],
    ] {
        let mut arguments = vec!["check", path.to_str().unwrap(), "--quiet"];
        for setting in settings {
            arguments.extend(["--set", setting]);
        }
        let output = symplint(&arguments);
        // A particle alone on one cell feels nothing: a shear, and symplectic as any.
        assert_eq!(
            output.status.code(),
            Some(0),
            "{settings:?}: {}",
            text(&output.stderr)
        );
    }
}
