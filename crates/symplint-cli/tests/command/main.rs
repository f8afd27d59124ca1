//! `[system] name = "command"`: programs as maps, good ones and bad ones.
//!
//! The program is this test program itself: the test `program` advances the states of a file when it is called by the
//! names of two files, a step size and a behaviour, which are filters without a meaning to the test harness.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use symplint_files::LoopFile;
use tempfile::TempDir;

mod changed_files;
mod jobs;
mod lacks;
mod resume;
#[cfg(unix)]
mod signals;

/// The step size at which bad programs are bad.
const BAD: f64 = 0.125;

#[test]
#[ignore = "it is the program that the other tests call"]
fn program() {
    let words: Vec<String> = std::env::args().collect();
    let Some(at) = words.iter().position(|word| word == "advance") else {
        return;
    };
    let (before, after) = (PathBuf::from(&words[at + 1]), PathBuf::from(&words[at + 2]));
    let h: f64 = words[at + 3].parse().unwrap();
    let behaviour = words[at + 4].as_str();
    let mut file = LoopFile::read_states(&before).unwrap();
    assert_eq!(file.step_size, Some(h));
    let mut states = file.states.block();
    for k in 0..states.len() {
        let (q, p) = (&mut states.q.row_mut(0)[k], &mut states.p.row_mut(0)[k]);
        match behaviour {
            "euler" => (*q, *p) = (*q + h * *p, *p - h * q.sin()),
            _ => {
                *q += 0.5 * h * *p;
                *p -= h * q.sin();
                *q += 0.5 * h * *p;
            }
        }
    }
    file.path = after.clone();
    let write = |file: &LoopFile| file.write().map(|_| ()).unwrap();
    if let Ok(path) = std::env::var("SYMPLINT_TEST_COUNT") {
        resume::count(&path);
    }
    if behaviour == "fails" {
        eprintln!("cannot open restart.dat");
        std::process::exit(3);
    }
    if h != BAD || std::env::var("SYMPLINT_TEST_WELL").is_ok() {
        return write(&file);
    }
    match behaviour {
        "crash" => {
            eprintln!("the matrix is singular");
            std::process::exit(3);
        }
        "hang" | "leave" => {
            // With its own process, which has to end with it.
            let mut sleep = Command::new("sleep").arg("1000").spawn().unwrap();
            if let Ok(path) = std::env::var("SYMPLINT_TEST_PIDS") {
                let pids = format!("{} {}", std::process::id(), sleep.id());
                fs::write(format!("{path}.new"), pids).unwrap();
                fs::rename(format!("{path}.new"), path).unwrap();
            }
            match behaviour {
                "hang" => drop(sleep.wait()),
                _ => write(&file),
            }
        }
        "half" => {
            write(&file);
            let bytes = fs::read(&after).unwrap();
            fs::write(&after, &bytes[..bytes.len() / 2]).unwrap();
        }
        "nothing" => {}
        "fifo" => drop(Command::new("mkfifo").arg(&after).status().unwrap()),
        "killed" => {
            // As the system does if memory runs out.
            if let Ok(path) = std::env::var("SYMPLINT_TEST_ONCE")
                && fs::File::create_new(path).is_err()
            {
                return write(&file);
            }
            let pid = std::process::id().to_string();
            let _ = Command::new("kill").args(["-KILL", &pid]).status();
            std::thread::sleep(Duration::from_secs(60));
        }
        "remove" => {
            // As somebody who tidies up.
            fs::remove_dir_all(before.parent().unwrap().parent().unwrap()).unwrap();
            std::process::exit(1);
        }
        "nan" => {
            let last = file.states.samples() - 1;
            file.states.block().p.row_mut(0)[last] = f64::NAN;
            write(&file);
        }
        "count" | "dof" => {
            let shape = match behaviour {
                "count" => (1, file.states.samples() + 1),
                _ => (2, file.states.samples()),
            };
            file.states = symplint::Ensemble::zeros(shape.0, shape.1);
            // One value for one degree of freedom is one for all.
            write(&file);
        }
        _ => write(&file),
    }
}

/// A folder for a configuration, and one for temporary files.
struct Bench {
    folder: TempDir,
    temporary: TempDir,
}

impl Bench {
    fn new(behaviour: &str, keys: &str) -> Self {
        let bench = Bench {
            folder: TempDir::new().unwrap(),
            temporary: TempDir::new().unwrap(),
        };
        let program = std::env::current_exe().unwrap();
        let text = format!(
            "[system]\nname = \"command\"\n\
             command = [{program:?}, \"program\", \"--exact\", \"--ignored\", \"--nocapture\", \
             \"advance\", \"{{before}}\", \"{{after}}\", \"{{h}}\", \"{behaviour}\"]\n\
             q0 = [1.0]\np0 = [0.5]\n{keys}\n\
             [diagnostic]\nstep_sizes = {{ from = \"2^-1\", to = \"2^-5\" }}\n"
        );
        fs::write(bench.config(), text).unwrap();
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn config(&self) -> PathBuf {
        self.path("run.toml")
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = symplint(&["check"]);
        command.arg(self.config()).args(arguments);
        command.env("TMPDIR", self.temporary.path());
        command
    }

    fn check(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn report(&self, arguments: &[&str]) -> Value {
        let output = self.check(&[arguments, &["--json"]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {said}"))
    }

    fn left_behind(&self) -> Vec<PathBuf> {
        (fs::read_dir(self.temporary.path()).unwrap())
            .map(|entry| entry.unwrap().path())
            .collect()
    }
}

/// The program with these arguments.
fn symplint(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
    command.args(arguments);
    command
}

/// Demands an exit status.
fn ends(status: i32, output: &Output) {
    assert_eq!(output.status.code(), Some(status), "{}", said(output));
}

/// Demands an error with these words.
fn refused(output: &Output, words: &str) {
    ends(2, output);
    let text = in_one_line(output);
    assert!(text.contains(words), "{words}: {text}");
}

/// Its message without the line breaks that fit it to the terminal.
fn in_one_line(output: &Output) -> String {
    let text = said(output);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr]
        .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
        .concat()
}

#[test]
fn programs_have_the_verdicts_of_their_methods() {
    let bench = Bench::new("verlet", "batch = 100");
    let report = bench.report(&["--set", "diagnostic.budget=3000"]);
    assert_eq!(report["verdict"]["kind"], "symplectic", "{report}");
    let bench = Bench::new("euler", "");
    let report = bench.report(&["--set", "diagnostic.budget=3000"]);
    assert_eq!(report["verdict"]["kind"], "not-symplectic");
    assert_eq!(report["verdict"]["order"], 2.0);
    assert!(bench.left_behind().is_empty());
}

#[test]
fn the_default_budget_is_that_of_codes_of_others() {
    let report = Bench::new("verlet", "batch = 4096").report(&[]);
    assert_eq!(report["evidence"]["evaluations"]["budget"], 20_000);
}

#[test]
fn files_of_any_format_give_the_same_evidence() {
    let of = |format: &str| {
        let keys = format!("batch = 1000\nformat = \"{format}\"");
        let bench = Bench::new("euler", &keys);
        bench.report(&["--set", "diagnostic.budget=600"])["evidence"].clone()
    };
    let npz = of("npz");
    assert_eq!(of("raw"), npz);
    assert_eq!(of("text"), npz);
}

#[test]
fn neither_workers_nor_batches_nor_threads_change_a_bit() {
    let budget = ["--set", "diagnostic.budget=600"];
    let of = |keys: &str, threads: &str| {
        let bench = Bench::new("euler", keys);
        bench.report(&[&budget[..], &["--threads", threads]].concat())["evidence"].clone()
    };
    let one = of("workers = 1\nbatch = 1000", "1");
    assert_eq!(of("workers = 3\nbatch = 7", "2"), one);
}

#[test]
fn one_bad_step_size_is_named_and_the_others_are_measured() {
    for (behaviour, reasons) in [
        (
            "crash",
            &["ended with exit status: 3", "the matrix is singular"][..],
        ),
        ("hang", &["did not end within 2 s", "system.timeout"]),
        ("killed", &["ended with signal: 9"]),
        ("half", &["cannot be used", "{after}"]),
        ("nothing", &["did not write {after}"]),
        ("fifo", &["{after}, which is not a regular file"]),
        ("nan", &["p[0] = NaN"]),
        (
            "count",
            &["samples of 1 degrees of freedom where {before} has"],
        ),
        (
            "dof",
            &["samples of 2 degrees of freedom where {before} has"],
        ),
    ] {
        let bench = Bench::new(behaviour, "timeout = 2.0\nbatch = 1000");
        let output = bench.check(&["--set", "diagnostic.budget=1000"]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(0), "{behaviour}: {text}");
        assert!(
            text.contains("The step size h = 0.125 was left out"),
            "{text}"
        );
        for reason in reasons {
            // Paragraphs are wrapped.
            let text: Vec<&str> = text.split_whitespace().collect();
            assert!(text.join(" ").contains(reason), "{behaviour}: {text:?}");
        }
        assert!(bench.left_behind().is_empty(), "{behaviour}");
    }
}

#[test]
fn a_small_budget_hides_no_failure_of_a_program() {
    let bench = Bench::new("fails", "batch = 1000");
    for budget in [200, 500] {
        let output = bench.check(&["--set", &format!("diagnostic.budget={budget}")]);
        refused(&output, "cannot open restart.dat");
        assert!(!in_one_line(&output).contains("raise the budget"));
    }
}

#[test]
fn a_program_that_something_killed_is_started_once_more() {
    let bench = Bench::new("killed", "workers = 1\nbatch = 1000");
    let mut check = bench.command(&["--set", "diagnostic.budget=1000"]);
    let once = bench.folder.path().join("once");
    let output = check.env("SYMPLINT_TEST_ONCE", &once).output().unwrap();
    ends(0, &output);
    assert!(once.exists());
    assert!(!said(&output).contains("left out"), "{}", said(&output));
}

#[test]
fn a_program_that_never_works_is_an_error_with_its_words() {
    for (command, words) in [
        (
            "[\"no-such-program\", \"{before}\", \"{after}\"]",
            "cannot run `no-such-program`: no such file; check system.command",
        ),
        (
            "[\"sh\", \"-c\", \"echo sorry; exit 7\", \"{before}\", \"{after}\"]",
            "sorry",
        ),
        ("[\"true\", \"{before}\"]", "no argument contains {after}"),
        ("[]", "the list is empty"),
        ("\"true\"", "a list of strings"),
    ] {
        let bench = Bench::new("verlet", "");
        let output = bench.check(&["--set", &format!("system.command={command}")]);
        refused(&output, words);
        assert!(bench.left_behind().is_empty());
    }
}

#[test]
fn states_come_from_files() {
    let bench = Bench::new("verlet", "");
    let mut states = symplint::Ensemble::zeros(1, 1);
    states.block().q.row_mut(0)[0] = 0.75;
    let file = LoopFile {
        path: bench.folder.path().join("state.npz"),
        states,
        unit_roundoff: symplint::Snapshot::DOUBLE,
        step_size: None,
        period: None,
        momentum_period: None,
        weight: None,
    };
    file.write().unwrap();
    let set = "system.q0={ file = \"state.npz\" }";
    let loop_file = bench.folder.path().join("loop.csv");
    let run = |arguments: &[&str]| {
        let mut command = symplint(&["loop"]);
        said(
            &command
                .arg(bench.config())
                .args(arguments)
                .output()
                .unwrap(),
        )
    };
    let text = run(&[
        "--set",
        set,
        "-o",
        loop_file.to_str().unwrap(),
        "--samples",
        "4",
    ]);
    let written = LoopFile::read(&loop_file).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert_eq!(written.states.q().row(0)[0], 0.75);
    assert_eq!(written.states.p().row(0)[0], 1.5);
    let text = run(&["--set", "system.p0=[1.0, 2.0]"]);
    assert!(text.contains("2 momenta for 1 positions"), "{text}");
    let text = run(&["--set", "system.q0={ file = \"other.npz\" }"]);
    assert!(text.contains("cannot read"), "{text}");
}

#[test]
fn files_are_kept_where_that_is_asked_for() {
    let bench = Bench::new("verlet", "");
    let kept = bench.folder.path().join("calls");
    let keep = format!("--keep={}", kept.display());
    let budget = ["--set", "diagnostic.budget=200"];
    let arguments = [&budget[..], &[&keep]].concat();
    let output = bench.check(&arguments);
    assert_ne!(output.status.code(), Some(2), "{}", said(&output));
    let first = kept.join("call-000001");
    for name in ["before.npz", "after.npz", "error.txt", "output.txt"] {
        assert!(first.join(name).exists(), "{name}");
    }
    let output = bench.check(&arguments);
    assert!(said(&output).contains("is not empty"), "{}", said(&output));
}

/// What `loop`, the program and `measure` find is what `check` finds.
#[test]
fn files_advanced_by_a_program_measure_as_check_does() {
    let bench = Bench::new("euler", "batch = 1000");
    let fixed = [
        "--set",
        "diagnostic.samples=128",
        "--set",
        "diagnostic.step_sizes=[0.25]",
    ];
    let checked = bench.report(&[&fixed[..], &["--set", "diagnostic.loops=1"]].concat());
    let checked = &checked["points"][0];
    let path = |name: &str| bench.path(name);
    let symplint = |arguments: &[&str]| symplint(arguments).output().unwrap();
    let (before, after) = (path("before.npz"), path("after.npz"));
    let [before, after] = [&before, &after].map(|path| path.to_str().unwrap());
    let config = bench.config();
    symplint(&[
        "loop",
        config.to_str().unwrap(),
        "--samples",
        "128",
        "-o",
        before,
    ]);
    // As the program is called by check, which adds h.
    let mut file = LoopFile::read(Path::new(before)).unwrap();
    file.step_size = Some(0.25);
    file.path = path("with_h.npz");
    file.write().unwrap();
    let advanced = Command::new(std::env::current_exe().unwrap())
        .args(["program", "--exact", "--ignored", "--nocapture", "advance"])
        .args([file.path.to_str().unwrap(), after, "0.25", "euler"])
        .output()
        .unwrap();
    assert!(advanced.status.success(), "{}", said(&advanced));
    let measured = symplint(&["measure", before, after, "--json"]);
    let measured: Value = serde_json::from_slice(&measured.stdout).unwrap();
    for quantity in ["step_size", "initial", "final", "signed_defect", "samples"] {
        assert_eq!(
            measured["points"][0][quantity], checked[quantity],
            "{quantity}"
        );
    }
    assert!(checked["signed_defect"].as_f64().unwrap() > 0.01);
}

#[test]
#[cfg(target_os = "linux")]
fn a_verdict_is_given_where_standard_error_cannot_be_written() {
    let bench = Bench::new("verlet", "batch = 1000");
    let out = bench.folder.path().join("run");
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = bench.command(&["--set", "diagnostic.budget=300", "--out"]);
    let output = command.arg(out).stderr(full).output().unwrap();
    ends(0, &output);
}
