//! Bad input is refused with the place, the reason and the remedy.

use std::fs;

use tempfile::TempDir;

use super::{configuration, example, symplint, text};

/// Runs `check` and demands exit status 2 and every word of `expected` on standard error.
fn refused(configuration_text: &str, settings: &[&str], expected: &[&str]) {
    refused_by("check", configuration_text, settings, expected);
}

/// The same of a command.
fn refused_by(command: &str, configuration_text: &str, settings: &[&str], expected: &[&str]) {
    let (_folder, path) = configuration(configuration_text);
    let mut arguments = vec![command, path.to_str().unwrap()];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let output = symplint(&arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{settings:?}: {said}");
    assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
    // Messages are folded to the width of the terminal.
    let unfolded = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in expected {
        assert!(unfolded.contains(part), "{part:?} is not in: {unfolded}");
    }
    assert!(!said.contains("panicked"), "{said}");
}

const PENDULUM: &str = "[system]\nname = \"pendulum\"\n";

#[test]
fn bad_settings_are_refused_with_place_and_remedy() {
    refused(
        "[system]\nname = \"pendulm\"\n",
        &[],
        &["pendulm", "run.toml:2:8", "did you mean \"pendulum\""],
    );
    refused(
        "[system]\nname = \"pendulum\"\nq1 = 2\n",
        &[],
        &["\"q1\"", "run.toml:3:1", "q0"],
    );
    refused(
        "[sytem]\nname = \"pendulum\"\n",
        &[],
        &["[sytem]", "did you mean \"system\""],
    );
    refused("name = \"pendulum\"\n", &[], &["unknown section [name]"]);
    refused("", &[], &["system.name: missing", "harmonic-oscillator"]);
    refused("[system\n", &[], &["not valid TOML", "run.toml:1"]);
    refused(
        PENDULUM,
        &["loop.radius=-1"],
        &["loop.radius is -1", "above 0"],
    );
    refused(
        PENDULUM,
        &["loop.radius=\"\""],
        &["loop.radius is a string, not a number"],
    );
    refused(
        PENDULUM,
        &["loop.radius=[1.0, 2.0]"],
        &["2 numbers for 1 degrees of freedom"],
    );
    refused(
        PENDULUM,
        &["loop.radius={ q = -1.0 }"],
        &["loop.radius", "radius", "positive"],
    );
    refused(PENDULUM, &["loop.radius={ x = 1.0 }"], &["no key \"x\""]);
    refused(
        PENDULUM,
        &["diagnostic.step_sizes=auto"],
        &["needs a typical step size", "step_size = "],
    );
    refused(
        PENDULUM,
        &["diagnostic.step_sizes=none", "diagnostic.step_size=0.1"],
        &["together with step_size", "leave one"],
    );
    refused(
        PENDULUM,
        &["diagnostic.repeat=0"],
        &["diagnostic.repeat is 0", "1"],
    );
    refused(
        PENDULUM,
        &["diagnostic.samples=2"],
        &["diagnostic.samples is 2", "at least 3"],
    );
    refused(PENDULUM, &["diagnostic.samples=64.5"], &["whole number"]);
    refused(
        PENDULUM,
        &["diagnostic.samples=atuo"],
        &["samples is \"atuo\"", "write \"auto\" or a whole number"],
    );
    refused(
        PENDULUM,
        &["diagnostic.budget=199"],
        &["diagnostic.budget is 199", "at least 200"],
    );
    refused(
        PENDULUM,
        &["diagnostic.jacobian=maybe"],
        &["diagnostic.jacobian is a string", "true or false"],
    );
    // Under its former name.
    refused(
        PENDULUM,
        &["diagnostic.stages=false"],
        &["no key \"stages\"", "did you mean \"localise\""],
    );
    refused(
        PENDULUM,
        &["diagnostic.step_sizes=[0.5, '2^-1']"],
        &["step_sizes repeats 0.5", "once"],
    );
    refused(
        PENDULUM,
        &["diagnostic.step_sizes={from=0.1,to=0.5}"],
        &["goes from 0.1 to 0.5", "the larger one"],
    );
    refused(
        PENDULUM,
        &["diagnostic.sample_sweep={from=64,to=32,step_size=0.1}"],
        &["goes from 64 to 32"],
    );
    refused(
        PENDULUM,
        &[
            "integrator.name=verlet",
            "integrator.variant=position-first",
        ],
        &["another name for \"strang\"", "leave variant out"],
    );
    refused(
        PENDULUM,
        &["diagnostic.seed=-1"],
        &["diagnostic.seed is -1", "at least 0"],
    );
    refused(
        PENDULUM,
        &["diagnostic.step_sizes={from=1,to='2^-65'}"],
        &["step_sizes", "at most 64 halvings"],
    );
    refused(
        PENDULUM,
        &["diagnostic.step_sizes=[0.1, 0]"],
        &["is 0", "other than 0"],
    );
    refused(
        PENDULUM,
        &["diagnostic.step_sizes=[]"],
        &["step_sizes", "one step size or more"],
    );
    refused(
        PENDULUM,
        &["diagnostic.rule=spectral"],
        &["\"pseudospectral\""],
    );
    refused(
        PENDULUM,
        &["diagnostic.half_width=7"],
        &["diagnostic.half_width is 7", "at least 8"],
    );
    refused(
        PENDULUM,
        &["diagnostic.half_width=17"],
        &["diagnostic.half_width", "half_width is 17", "at most 16"],
    );
    refused(
        PENDULUM,
        &["diagnostic.rule=streaming", "diagnostic.samples=16"],
        &[
            "half width 10 spans 21 samples",
            "the loop has 16",
            "more samples",
        ],
    );
    refused(
        PENDULUM,
        &["integrator.name=strnag"],
        &["did you mean \"strang\""],
    );
    refused(
        PENDULUM,
        &["integrator.variant=first"],
        &["position-first", "momentum-first"],
    );
    refused(
        PENDULUM,
        &["loop.dofs=[1]"],
        &["degree of freedom 1 does not exist", "there are 1"],
    );
    refused(PENDULUM, &["loop"], &["--set KEY=VALUE"]);
    refused(PENDULUM, &["system.q0=1e300"], &["encloses no area"]);
    refused(PENDULUM, &["loop.radius=1e160"], &["overflows"]);
    refused(PENDULUM, &["diagnostic.samples=2^40"], &["at most"]);
    refused(PENDULUM, &["trace.samples=2^40"], &["at most"]);
    refused(PENDULUM, &["trace.steps=1e15"], &["at most"]);
    refused(PENDULUM, &["diagnostic.loops=1e9"], &["at most"]);
    let array = "[system]\nname = \"pendulum-array\"\n";
    refused(array, &["system.pendula=1e15"], &["at most"]);
    let spline = "[system]\nname = \"interpolated-pendulum\"\n";
    refused(spline, &["system.degree=6"], &["spline degree 6", "1 to 5"]);
    refused(
        spline,
        &["system.degree=2", "system.cells=24"],
        &["even", "odd number of cells"],
    );
    refused(spline, &["system.degree=3", "system.cells=2"], &["cells"]);
}

#[test]
fn rules_that_no_trace_can_use_are_refused() {
    for rule in ["piecewise", "streaming"] {
        let set = format!("diagnostic.rule={rule}");
        let named = format!("diagnostic.rule is \"{rule}\"");
        let expected = [
            named.as_str(),
            "a trace does not accept",
            "diagnostic.rule=pseudospectral",
        ];
        refused_by("trace", PENDULUM, &[&set], &expected);
    }
}

#[test]
fn a_snapshot_after_the_last_step_is_refused() {
    let settings = ["trace.steps=50", "trace.snapshots=[0, 80]"];
    let expected = ["trace.snapshots has step 80", "leave that snapshot out"];
    refused_by("trace", PENDULUM, &settings, &expected);
}

#[test]
fn integrators_that_do_not_fit_are_refused() {
    let double = "[system]\nname = \"double-pendulum\"\n";
    refused(
        double,
        &["integrator.name=strang"],
        &[
            "\"strang\" is for parts with exact flows",
            "not separable",
            "gauss6",
        ],
    );
    refused(
        double,
        &["integrator.name=boris"],
        &["for a charge in a magnetic field"],
    );
    let force = "[system]\nname = \"rotational-force\"\n";
    refused(
        force,
        &["integrator.name=rk4"],
        &["without a potential", "available: lie-trotter, strang"],
    );
    let map = "[system]\nname = \"standard-map\"\n";
    refused(
        map,
        &["integrator.name=strang"],
        &["does not accept an integrator", "name = \"none\""],
    );
    refused(
        map,
        &["integrator.tolerance=1e-3"],
        &["integrator.tolerance", "leave"],
    );
    refused(
        PENDULUM,
        &["integrator.name=none"],
        &["unknown integrator \"none\""],
    );
}

#[test]
fn bad_solvers_are_refused() {
    refused(
        PENDULUM,
        &["integrator.tolerance=1e-3"],
        &["\"strang\" is explicit"],
    );
    let gauss = "integrator.name=gauss4";
    refused(
        PENDULUM,
        &[gauss, "integrator.tolerance=-1"],
        &["not negative"],
    );
    refused(
        PENDULUM,
        &[gauss, "integrator.max_iterations=0"],
        &["at least 1"],
    );
    refused(
        PENDULUM,
        &[gauss, "integrator.iterations=0"],
        &["at least 1"],
    );
    refused(
        PENDULUM,
        &[gauss, "integrator.iterations=2", "integrator.tolerance=0.1"],
        &["cannot be combined with tolerance"],
    );
    refused(
        PENDULUM,
        &[gauss, "integrator.solver=newtn"],
        &["did you mean \"newton\""],
    );
    let array = "[system]\nname = \"pendulum-array\"\n";
    refused(
        array,
        &[gauss, "integrator.solver=newton"],
        &["4096 equations", "fixed-point"],
    );
    refused(
        PENDULUM,
        &[gauss, "integrator.max_iterations=1"],
        &[
            "did not converge in 1 iterations",
            "smaller step size",
            "max_iterations",
        ],
    );
    let plasma = "[system]\nname = \"pic-1d2v\"\n";
    for name in ["crank-nicolson", "discrete-gradient"] {
        let name = format!("integrator.name={name}");
        refused(
            plasma,
            &[&name, "integrator.solver=newton"],
            &["integrator.solver: ", "fixed-point", "leave the key out"],
        );
        refused(
            plasma,
            &[&name, "integrator.max_iterations=1"],
            &[
                "did not converge in 1 iterations",
                "a larger max_iterations",
            ],
        );
    }
    refused(
        PENDULUM,
        &["integrator.precision=half"],
        &["unknown value \"half\""],
    );
    refused(PENDULUM, &["integrator.damping=nan"], &["damping"]);
}

/// Solver keys of the file are ignored for an explicit method named by `--set`.
#[test]
fn another_integrator_leaves_the_solver_behind() {
    let (_folder, path) = configuration(&format!(
        "{PENDULUM}[integrator]\nname = \"gauss4\"\nsolver = \"newton\"\ntolerance = 1e-13\n"
    ));
    let path = path.to_str().unwrap();
    for name in ["gauss4", "strang"] {
        let set = format!("integrator.name={name}");
        let output = symplint(&["check", path, "--quiet", "--set", &set]);
        assert_ne!(output.status.code(), Some(2), "{}", text(&output.stderr));
    }
}

#[test]
fn bad_mechanics_are_refused() {
    let system = |name: &str| format!("[system]\nname = \"{name}\"\n");
    refused(
        &system("kepler"),
        &["system.softening=-1"],
        &["system.softening is -1"],
    );
    refused(
        &system("double-pendulum"),
        &["system.masses=[1.0, 0.0]"],
        &["system.masses", "above 0"],
    );
    refused(
        &system("double-pendulum"),
        &["system.lengths=-1"],
        &["system.lengths", "above 0"],
    );
    refused(
        &system("charged-particle"),
        &["system.omega=1e200"],
        &["omega"],
    );
    refused(
        &system("toda"),
        &["system.masses=0"],
        &["system.masses is 0"],
    );
    refused(
        &system("toda"),
        &["system.masses=1", "system.ends=periodic"],
        &["system.masses", "at least 2"],
    );
    refused(
        &system("fput"),
        &["system.ends=free"],
        &["unknown value \"free\""],
    );
    refused(
        &system("henon-map"),
        &["system.contraction=0"],
        &["above 0"],
    );
    refused(
        &system("standard-map"),
        &["system.strength=nan"],
        &["strength"],
    );
}

#[test]
fn bad_plasmas_are_refused() {
    let line = "[system]\nname = \"pic-1d\"\n";
    refused(
        line,
        &["system.cells=0"],
        &["system.cells is 0", "at least 1"],
    );
    refused(line, &["system.degree=6"], &["degree", "5"]);
    refused(
        line,
        &["system.family=lagrange", "system.degree=4"],
        &["degree", "3"],
    );
    refused(
        line,
        &["system.family=spline"],
        &["did you mean \"b-spline\""],
    );
    refused(line, &["system.particles=0"], &["particles is 0"]);
    refused(line, &["system.length=-1"], &["above 0"]);
    refused(line, &["system.weights=[1.0, nan]"], &["weights is NaN"]);
    refused(line, &["system.weights=[1.0, 0.0]"], &["system.weights"]);
    refused(line, &["system.weights=[]"], &["system.weights"]);
    for other in ["system.particles=2", "system.density=2.0"] {
        refused(
            line,
            &["system.weights=[1.0, 2.0]", other],
            &["leave out either weights"],
        );
    }
    refused(line, &["system.density=1e308"], &["system.density", "inf"]);
    refused(
        line,
        &["system.initial=landua"],
        &["did you mean \"landau\""],
    );
    refused(
        line,
        &["system.initial=landau", "system.amplitude=2"],
        &["system.amplitude"],
    );
    refused(
        "[system]\nname = \"two-cell\"\nlength = 0\n",
        &[],
        &["above 0"],
    );
}

#[test]
fn grids_without_centred_differences_are_refused() {
    for cells in [1, 2] {
        refused(
            "[system]\nname = \"pic-es1\"\n",
            &[&format!("system.cells={cells}")],
            &["system.cells", "no particle feels a force", "at least 3"],
        );
    }
}

/// They would be recorded as if they described the state.
#[test]
fn keys_of_another_initial_state_are_refused() {
    let rows = |count: usize| "0.25,0.5\n".repeat(count);
    for (system, dof, keys) in [
        (
            "pic-es1",
            4,
            &[
                "thermal_velocity = 1.0",
                "velocities = \"text\"",
                "beam_velocity = 3.0",
                "amplitude = 0.5",
                "mode = 1",
                "seed = 42",
            ][..],
        ),
        ("pic-1d2v", 24, &["amplitude = 0.5", "seed = 42"]),
        ("pendulum-array", 1024, &["seed = 42"]),
        ("toda", 32, &["mode = 1", "amplitude = 1.0"]),
    ] {
        let state = TempDir::new().unwrap();
        let path = state.path().join("state.csv");
        fs::write(&path, rows(dof)).unwrap();
        let system = format!("[system]\nname = \"{system}\"\n");
        let file = format!("initial = {{ file = '{}' }}\n", path.display());
        for key in keys {
            let name = key.split(' ').next().unwrap();
            let place = format!("system.{name}: applies to initial = ");
            let expected = [place.as_str(), "run.toml:4:", "leave the key out"];
            refused(&format!("{system}{file}{key}\n"), &[], &expected);
            // If the file is named by --set, keys of the other state are left behind.
            let (_folder, run) = configuration(&format!("{system}{key}\n"));
            let set = format!("system.{}", file.trim());
            let out = state.path().join(format!("out-{name}"));
            let output = symplint(&[
                "loop",
                run.to_str().unwrap(),
                "--samples",
                "8",
                "--set",
                &set,
                "--out",
                out.to_str().unwrap(),
            ]);
            assert!(output.status.success(), "{}", text(&output.stderr));
        }
    }
    refused(
        "[system]\nname = \"pic-1d\"\ninitial = \"landau\"\nbeam_velocity = 3.0\n",
        &[],
        &["system.beam_velocity: applies to initial = \"two-stream\" only"],
    );
}

#[test]
fn bad_state_files_are_refused() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        format!("system.initial={{ file = '{}' }}", path.display())
    };
    /// A NumPy 1.0 file of doubles in C order.
    fn npy(shape: &str, values: &[f64]) -> Vec<u8> {
        let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        while (10 + header.len() + 1) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }
    let array = "[system]\nname = \"pendulum-array\"\npendula = 3\n";
    let good = file("good.npy", &npy("(2, 3)", &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]));
    let (_run, path) = configuration(array);
    let output = symplint(&["check", path.to_str().unwrap(), "--quiet", "--set", &good]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));

    // By the program's own names of columns, too.
    for header in ["q,p", "x,v", "q0,p0", "q_0,p_0"] {
        let rows = format!("{header}\n0.1,0.4\n0.2,0.5\n0.3,0.6\n");
        let named = file("named.csv", rows.as_bytes());
        let arguments = ["check", path.to_str().unwrap(), "--quiet", "--set", &named];
        let output = symplint(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }

    let shape = file("shape.npy", &npy("(3, 2)", &[0.0; 6]));
    refused(array, &[&shape], &["[3, 2]", "(2, dof)"]);
    let long = file("long.npy", &npy("(2, 4)", &[0.0; 8]));
    refused(
        array,
        &[&long],
        &["has 4 degrees of freedom, but the system has 3"],
    );
    let nan = file(
        "nan.npy",
        &npy("(2, 3)", &[0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0]),
    );
    refused(array, &[&nan], &["NaN", "p[1] is"]);
    let cut = file("cut.npy", &npy("(2, 3)", &[0.0; 5]));
    refused(array, &[&cut], &["cut.npy"]);
    let noise = file("noise.npy", b"not an array");
    refused(array, &[&noise], &["noise.npy", "numpy.save"]);
    let columns = file("columns.csv", b"0.1,0.2,0.3\n");
    refused(array, &[&columns], &["3 columns", "two columns"]);
    let words = file("words.csv", b"0.1,0.2\nx,0.2\n0.1,0.2\n");
    refused(array, &[&words], &["row 2"]);
    let huge = file("huge.npy", &npy("(2, 9223372036854775808)", &[0.0; 4]));
    refused(array, &[&huge], &["huge.npy"]);
    let mistyped = file("mistyped.csv", b"O.1,O.2\n0.1,0.2\n0.1,0.2\n0.1,0.2\n");
    refused(array, &[&mistyped], &["row 1"]);
    for name in ["O1,O2", "q.0,p.0", "x1e,v1e"] {
        let rows = format!("{name}\n0.1,0.2\n0.1,0.2\n0.1,0.2\n");
        let mistyped = file("mistyped.csv", rows.as_bytes());
        refused(array, &[&mistyped], &["row 1"]);
    }
    let mut long = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
    long.extend([b' '; 100]);
    let long = file("header.npy", &long);
    refused(
        array,
        &[&long],
        &["header.npy", "promises 4294967307 bytes"],
    );
    let kind = file("state.txt", b"0.1 0.2\n");
    refused(array, &[&kind], &["state.txt", "not a .npy or .csv file"]);
    refused(
        array,
        &["system.initial={file='/nowhere/state.npy'}"],
        &["cannot open", "relative"],
    );
    refused(array, &["system.initial=random"], &["uniform"]);
}

#[test]
fn places_that_cannot_be_written_are_refused_before_the_run() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for (out, says) in [
        (file.join("run"), "cannot write"),
        (file, "is a file, not a folder"),
    ] {
        let pendulum = example("pendulum.toml");
        let output = symplint(&["check", &pendulum, "--out", out.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(says));
        assert!(output.stdout.is_empty());
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_no_panic() {
    let full = fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let program = assert_cmd::cargo::cargo_bin("symplint");
    let output = std::process::Command::new(program)
        .args(["list", "systems"])
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("standard output"));
}

#[test]
fn bad_usage_has_status_2() {
    for arguments in [
        &["check"][..],
        &["chekc", "x.toml"],
        &["check", "nowhere.toml"],
        &["check", "x.toml", "--threads", "0"],
        &["reproduce", "fig99"],
        &["reproduce", "fig1", "fig2", "--set", "steps=3"],
        &["reproduce", "fig1", "--set", "stesp=3"],
        &["init", "pendullum"],
        &["list", "everything"],
    ] {
        let output = symplint(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty());
    }
}

#[test]
#[cfg(target_os = "linux")]
fn the_status_is_that_of_the_error_where_it_cannot_be_said() {
    let full = fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let program = assert_cmd::cargo::cargo_bin("symplint");
    let status = std::process::Command::new(program)
        .args(["judge", "nowhere.json"])
        .stderr(full)
        .status();
    assert_eq!(status.unwrap().code(), Some(2));
}

#[test]
#[cfg(unix)]
fn what_is_no_regular_file_is_not_waited_for() {
    let folder = TempDir::new().unwrap();
    for name in ["loop.npz", "loop.csv", "loop_q.npy", "report.json"] {
        let fifo = folder.path().join(name);
        let made = std::process::Command::new("mkfifo").arg(&fifo).status();
        assert!(made.unwrap().success());
        let fifo = fifo.to_str().unwrap();
        let output = match name {
            "report.json" => symplint(&["judge", fifo]),
            _ => symplint(&["measure", fifo, fifo]),
        };
        assert_eq!(output.status.code(), Some(2), "{name}");
        let said = text(&output.stderr);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains("not a regular file"), "{said}");
    }
}
