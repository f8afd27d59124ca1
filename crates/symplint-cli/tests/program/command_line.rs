//! Options, help, and the loops that options describe.

use std::fs;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use super::{configuration, example, report, symplint, text};

#[test]
fn unknown_options_that_are_settings_are_told_how_to_set_them() {
    for (arguments, words) in [
        (
            ["check", "pendulum", "--step-size=0.1"],
            "--set diagnostic.step_size=VALUE",
        ),
        (
            ["check", "pendulum", "--integrator=rk2"],
            "--set integrator.name=VALUE",
        ),
        (["trace", "pendulum", "--q0=2"], "--set system.q0=VALUE"),
        (
            ["trace", "pendulum", "--steps=2"],
            "--set trace.steps=VALUE",
        ),
        (
            ["check", "pendulum", "--seed=2"],
            "--set diagnostic.seed=VALUE",
        ),
        (["check", "pendulum", "--quiett"], "'--quiet'"),
    ] {
        let output = symplint(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2));
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    // `judge` has no settings.
    let said = symplint(&["judge", "report.json", "--budget=100"]).stderr;
    assert!(!text(&said).contains("--set"), "{}", text(&said));
}

#[test]
fn the_program_says_its_name_and_version() {
    let said = text(&symplint(&["--version"]).stdout);
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(said, format!("symplint {version}\n"));
    for arguments in [&["--help"][..], &["check", "--help"]] {
        let said = text(&symplint(arguments).stdout);
        assert!(said.contains("Usage: symplint "), "{said}");
        assert!(!said.contains("symplint-cli"), "{said}");
    }
}

/// The long options that the help of a command offers.
fn offered(command: &str) -> Vec<String> {
    let help = text(&symplint(&[command, "--help"]).stdout);
    (help.lines())
        .filter_map(|line| {
            let line = line.trim_start();
            let line = line.strip_prefix("-").map_or(line, |rest| {
                rest.split_once(", --").map_or(line, |(_, long)| {
                    // "o, --output <FILE>"
                    &line[line.len() - long.len() - 2..]
                })
            });
            let name = line.strip_prefix("--")?;
            Some(name.split([' ', '\n']).next()?.to_owned())
        })
        .collect()
}

#[test]
fn help_offers_what_a_command_accepts() {
    assert_eq!(offered("init"), ["all", "help"]);
    assert_eq!(offered("list"), ["help"]);
    let measure = offered("measure");
    for option in [
        "h", "period", "weight", "out", "force", "json", "quiet", "threads",
    ] {
        assert!(
            measure.iter().any(|one| one == option),
            "{option}: {measure:?}"
        );
    }
    assert!(!measure.iter().any(|one| one == "set"), "{measure:?}");
    for command in [
        &["list", "systems"][..],
        &["init", "pendulum"],
        &["measure", "a", "b"],
    ] {
        let output = symplint(&[command, &["--set", "loop.radius=2"]].concat());
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains("unexpected argument '--set'"));
    }
}

#[test]
fn more_threads_than_processors_are_not_started() {
    let example = example("pendulum.toml");
    let budget = ["--set", "diagnostic.budget=1000"];
    for count in ["5000", "1000000"] {
        let arguments = ["check", &example, "--json", "--threads", count];
        let output = symplint(&[&arguments[..], &budget].concat());
        let said = text(&output.stderr);
        let note = format!("note: --threads {count} exceeds the number of processors");
        assert!(said.contains(&note), "{said}");
        assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
    }
}

#[test]
fn numbers_are_read_as_in_configurations() {
    let folder = TempDir::new().unwrap();
    let samples = |number: &str, name: &str| {
        let file = folder.path().join(name);
        let arguments = ["loop", "--dof", "1", "--samples", number, "--json", "-o"];
        let output = symplint(&[&arguments[..], &[file.to_str().unwrap()]].concat());
        let written: Value = serde_json::from_slice(&output.stdout).unwrap();
        written["samples"].clone()
    };
    assert_eq!(samples("2^14", "a.npz"), 16384);
    assert_eq!(samples("1e4", "b.npz"), 10000);
    assert_eq!(samples("16384", "c.npz"), 16384);
    let example = example("pendulum.toml");
    let report = report(&["check", &example, "--steps", "2^2", "--threads", "2^1"]);
    assert_eq!(report["config"]["diagnostic"]["steps"], 4);
    for arguments in [
        ["check", &example, "--steps", "many"],
        ["check", &example, "--steps", "0.5"],
        ["check", &example, "--threads", "-1"],
    ] {
        let output = symplint(&arguments);
        assert_eq!(output.status.code(), Some(2));
        let said = text(&output.stderr);
        assert!(said.contains(&arguments[2][2..]), "{said}");
    }
}

/// Columns q_0, …, p_0, … of the loop that options describe.
fn table(options: &[&str]) -> Vec<Vec<f64>> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("loop.csv");
    let output = symplint(&[&["loop", "-o", file.to_str().unwrap()], options].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = fs::read_to_string(&file).unwrap();
    (table.lines().skip(1))
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().unwrap())
                .collect()
        })
        .collect()
}

/// q = q0 + r sin 2πs and p = p0 + r cos 2πs at s = 0, ¼, ½, ¾.
#[test]
fn a_loop_without_a_configuration() {
    let close = |states: &[Vec<f64>], expected: &[[f64; 4]]| {
        for (state, expected) in states.iter().zip(expected) {
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-15;
            assert!(state.iter().zip(expected).all(near), "{states:?}");
        }
    };
    let quarter = ["--samples", "4", "--radius", "0.5"];
    let around = |q: [f64; 2], p: [f64; 2]| {
        [[0.0, 0.5], [0.5, 0.0], [0.0, -0.5], [-0.5, 0.0]]
            .map(|[dq, dp]| [q[0] + dq, q[1] + dq, p[0] + dp, p[1] + dp])
    };
    let at = |options: &[&str]| table(&[&quarter[..], options].concat());
    let in_phase = |options: &[&str]| at(&[options, &["--phases", "equal"]].concat());
    close(&in_phase(&["--dof", "2"]), &around([0.0; 2], [0.0; 2]));
    close(
        &in_phase(&["--dof", "2", "--center", "-2^-1"]),
        &around([-0.5; 2], [-0.5; 2]),
    );
    let expected = around([1.0, 2.0], [3.0, 3.0]);
    close(&in_phase(&["--q0", "1,2", "--p0", "3"]), &expected);
    close(&in_phase(&["--centre", "1,2,3,3"]), &expected);
    // By default, the second degree of freedom is ahead by the golden ratio.
    let staggered = at(&["--dof", "2"]);
    assert_eq!(staggered, at(&["--dof", "2", "--phases", "staggered"]));
    let ahead = std::f64::consts::TAU * 0.618_033_988_749_894_9;
    let first = [0.0, 0.5 * ahead.sin(), 0.5, 0.5 * ahead.cos()];
    close(&staggered[..1], &[first]);
    // Different phases, and the same for the same seed.
    let random = |seed| at(&["--dof", "2", "--phases", "random", "--seed", seed]);
    assert_ne!(random("1"), random("2"));
    assert_eq!(random("2"), random("2"));
    let fourier = |seed| at(&["--dof", "2", "--shape", "fourier", "--seed", seed]);
    assert_ne!(fourier("1"), fourier("2"));
    assert_ne!(fourier("1"), random("1"));
}

/// A configuration and options that describe one loop give the same loop; periods and weights go into the file.
#[test]
fn options_and_configuration_describe_the_same_loop() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (by_file, by_options) = (file("a.npz"), file("b.npz"));
    let example = example("pendulum.toml");
    symplint(&["loop", &example, "-o", &by_file]);
    symplint(&["loop", "--q0", "2", "--p0", "0.5", "-o", &by_options]);
    assert_eq!(fs::read(&by_file).unwrap(), fs::read(&by_options).unwrap());

    let mut arguments = vec!["loop", "--dof", "2", "--json", "-o"];
    let periodic = file("c.npz");
    arguments.extend([&periodic, "--period", "2*pi,0", "--weight", "2"]);
    let written: Value = serde_json::from_slice(&symplint(&arguments).stdout).unwrap();
    assert_eq!(written["dof"], 2);
    assert_eq!(written["period"][1], 0.0);
    assert_eq!(written["weight"], serde_json::json!([2.0, 2.0]));
    assert_eq!(
        symplint(&["measure", &periodic, &periodic]).status.code(),
        Some(3)
    );
}

#[test]
fn bad_options_of_a_loop_are_refused() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let example = example("pendulum.toml");
    for (options, says) in [
        (&[][..], "give --dof"),
        (&["--center", "0"], "give --dof"),
        (&["--set", "loop.radius=2"], "no configuration is given"),
        (&["--dof", "0"], "at least 1"),
        (&["--dof", "1e12"], "too large"),
        (
            &["--dof", "2^24", "--samples", "2^24"],
            "fewer samples or degrees of freedom",
        ),
        (&["--dof", "1", "--samples", "2^45"], "fewer samples"),
        (&["--dof", "1", "--samples", "2"], "3 or more"),
        (&["--dof", "1", "--samples", "-4"], "whole number"),
        (&["--dof", "1", "--radius", "nan"], "finite number"),
        (&["--dof", "1", "--radius", "-1"], "positive"),
        (&["--dof", "1", "--seed", "0.5"], "whole number"),
        (&["--dof", "3", "--q0", "1,2"], "2 numbers for 3 degrees"),
        (&["--q0", "1,2", "--p0", "1,2,3"], "2 numbers for 3 degrees"),
        (
            &["--dof", "2", "--center", "1,2"],
            "the positions and then the momenta",
        ),
        (
            &["--dof", "2", "--center", "1", "--q0", "1"],
            "cannot be used with",
        ),
        (&["--dof", "2", "--period", "-1"], "period[0]"),
        (&["--dof", "2", "--weight", "1,0"], "weight[1]"),
        (&["--dof", "2", "--shape", "square"], "circle, fourier"),
        (
            &["--dof", "2", "--shape", "fourier", "--phases", "equal"],
            "circles only",
        ),
        (&["--dof", "1", "-o", "loop.dat"], "loop.dat"),
        (&[example.as_str(), "--radius", "2"], "--set loop.radius"),
        (&[example.as_str(), "--dof", "1"], "leave --dof out"),
    ] {
        let output = symplint(&[&["loop", "--out", out], options].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {said}");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(says), "{options:?}: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn integrators_go_by_other_names() {
    let example = example("pendulum.toml");
    for (name, resolved) in [
        ("verlet", ("strang", Some("momentum-first"))),
        ("velocity-verlet", ("strang", Some("momentum-first"))),
        ("leapfrog", ("strang", Some("momentum-first"))),
        ("kick-drift-kick", ("strang", Some("momentum-first"))),
        ("drift-kick-drift", ("strang", Some("position-first"))),
        ("symplectic-euler", ("lie-trotter", None)),
    ] {
        let set = format!("integrator.name={name}");
        let few = [
            "--set",
            "diagnostic.step_sizes=[0.5]",
            "--set",
            "diagnostic.loops=1",
        ];
        let arguments = [&["check", &example, "--set", &set], &few[..]].concat();
        let integrator = &report(&arguments)["config"]["integrator"];
        assert_eq!(integrator["name"], resolved.0);
        assert_eq!(integrator["variant"].as_str(), resolved.1);
        let listed = text(&symplint(&["list", "integrators"]).stdout);
        // One entry is one line where standard output is not a terminal.
        let line = listed.lines().find(|line| line.starts_with(resolved.0));
        assert!(line.unwrap().contains(name), "{listed}");
    }
    // A variant of the file belongs to the integrator of the file.
    let (_folder, path) = configuration(
        "[system]\nname = \"pendulum\"\n[integrator]\nname = \"strang\"\nvariant = \"position-first\"\n",
    );
    let arguments = [
        "check",
        path.to_str().unwrap(),
        "--set",
        "integrator.name=verlet",
    ];
    assert_eq!(
        report(&arguments)["config"]["integrator"]["variant"],
        "momentum-first"
    );
}

/// Widths of the lines that a command prints for a terminal of some width.
fn widths(columns: &str, arguments: &[&str]) -> Vec<(usize, String)> {
    let output = Command::cargo_bin("symplint")
        .unwrap()
        .env("COLUMNS", columns)
        .args(arguments)
        .output()
        .unwrap();
    let said = text(&output.stdout);
    (said.lines())
        .map(|line| (line.chars().count(), line.to_owned()))
        .collect()
}

#[test]
fn output_wraps_to_the_terminal() {
    let absolute = example("absolute-value.toml");
    let pendulum = example("pendulum.toml");
    let sweep = "diagnostic.sample_sweep={from='2^8',to='2^9',step_size=0.1}";
    let thirds = "diagnostic.step_sizes=[0.3333333333333333, 0.1]";
    let finite = "diagnostic.rule=finite-difference";
    for arguments in [
        &["check", &absolute][..],
        &["check", &absolute, "--set", finite, "--set", thirds],
        &[
            "check",
            &pendulum,
            "--set",
            "integrator.name=rk2",
            "--set",
            sweep,
        ],
        &["trace", &pendulum, "--set", "trace.steps=80"],
        &["list", "integrators"],
        &["list", "systems"],
        &["list", "rules"],
        &["list", "figures"],
    ] {
        for (width, line) in widths("80", arguments) {
            assert!(width <= 80, "{arguments:?}: {width} characters: {line}");
        }
    }
    // Findings have a hanging indent.
    let lines = widths("60", &["check", &pendulum]);
    let first = lines
        .iter()
        .position(|(_, line)| line.starts_with("  Jacobian  "))
        .unwrap();
    assert!(lines[first + 1].1.starts_with(&" ".repeat(14)), "{lines:?}");
    assert!(
        lines[first..].iter().all(|(width, _)| *width <= 60),
        "{lines:?}"
    );
}

/// For `grep` and the like. Tables fit in 80 characters all the same.
#[test]
fn sentences_stay_whole_in_a_pipe() {
    let said = text(&symplint(&["check", &example("absolute-value.toml")]).stdout);
    let is_sentence = |line: &&str| line.starts_with("  Breaks") || line.starts_with("The map");
    assert!(
        said.lines()
            .filter(is_sentence)
            .any(|line| line.chars().count() > 100)
    );
    let below = (said.lines()).skip_while(|line| !line.starts_with("  Relative change"));
    let table = below.take_while(|line| !line.is_empty());
    assert!(
        table.into_iter().all(|line| line.chars().count() <= 80),
        "{said}"
    );
}

#[test]
fn a_system_stands_for_its_configuration_and_a_dash_for_standard_input() {
    let by_name = report(&["check", "henon-heiles", "--set", "diagnostic.budget=500"]);
    assert_eq!(by_name["config"]["system"]["name"], "henon-heiles");
    let input = "[system]\nname = \"henon-heiles\"\n\n[diagnostic]\nbudget = 500\n";
    let mut command = Command::cargo_bin("symplint").unwrap();
    let output = command.args(["check", "-", "--json"]).write_stdin(input);
    let found: Value = serde_json::from_slice(&output.output().unwrap().stdout).unwrap();
    assert_eq!(found["evidence"], by_name["evidence"]);
    let output = symplint(&["check", "henon-heils"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("did you mean \"henon-heiles\""));
}

#[test]
fn short_options_write_a_folder_with_a_page() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("run");
    let settings = [
        "--set",
        "integrator.name=rk2",
        "--set",
        "diagnostic.budget=500",
    ];
    let output = symplint(
        &[
            &["check", "pendulum", "-q", "-o", out.to_str().unwrap()],
            &settings[..],
        ]
        .concat(),
    );
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stdout).lines().count(), 1);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<header class=\"not-symplectic\">") && page.contains("<svg"));
    assert!(page.len() < 500_000);
}

#[test]
fn shells_get_completions_and_man_gets_pages() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = symplint(&["completions", shell]);
        assert_eq!(output.status.code(), Some(0));
        let script = text(&output.stdout);
        for word in ["reproduce", "measure"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let folder = TempDir::new().unwrap();
    let pages = folder.path().join("man1");
    let output = symplint(&["man", pages.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for (name, word) in [
        ("symplint.1", "Poincaré"),
        ("symplint-check.1", "Also take N steps"),
        ("symplint-init.1", "configuration"),
    ] {
        let page = fs::read_to_string(pages.join(name)).unwrap();
        assert!(
            page.contains(".TH symplint") && page.contains(word),
            "{name}: {page}"
        );
    }
}

#[test]
fn all_errors_of_a_configuration_are_printed() {
    let (_folder, path) = configuration(
        "[system]\nname = \"pendulum\"\nmass = 2\n\n[diagnostic]\nloops = \"many\"\nbudget = 1\n",
    );
    let output = symplint(&["check", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert_eq!(said.matches("error: ").count(), 3, "{said}");
    for line in ["run.toml:3:1", "run.toml:6:9", "run.toml:7:10"] {
        assert!(said.contains(line), "{line}: {said}");
    }
}

#[test]
fn a_quiet_reproduction_prints_numbers_only() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let item = [
        "reproduce",
        "fig2",
        "--set",
        "steps=80",
        "--set",
        "samples=512",
    ];
    let output = symplint(&[&item[..], &["--out", out, "--quiet"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.contains("hold: "), "{said}");
}
