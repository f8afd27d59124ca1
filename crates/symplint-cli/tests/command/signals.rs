//! Signals end programs and remove their files, and nothing else.

use super::*;

/// Waits until `done`, or fails.
fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(60), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Whether a process runs; one that ended and is not waited for yet does not.
fn runs(pid: &str) -> bool {
    let output = Command::new("ps").args(["-o", "stat=", "-p", pid]).output();
    let state = String::from_utf8(output.unwrap().stdout).unwrap();
    !state.trim().is_empty() && !state.starts_with('Z')
}

fn send(signal: &str, pid: &str) {
    let status = Command::new("kill").args([signal, pid]).status().unwrap();
    assert!(status.success(), "kill {signal} {pid}");
}

/// A check whose program hangs, once it does; with the numbers of the program and of the process that it started.
fn hanging(bench: &Bench) -> (Child, Vec<String>) {
    hanging_with(bench, &[], Stdio::piped())
}

fn hanging_with(
    bench: &Bench,
    arguments: &[&str],
    error: impl Into<Stdio>,
) -> (Child, Vec<String>) {
    let pids = bench.folder.path().join("pids");
    let mut command = bench.command(&["--set", "diagnostic.step_sizes=[0.125]"]);
    command.args(arguments).env("SYMPLINT_TEST_PIDS", &pids);
    let child = command.stdout(Stdio::null()).stderr(error).spawn();
    let child = child.unwrap();
    wait_until("the program is called", || pids.exists());
    let pids = fs::read_to_string(pids).unwrap();
    (child, pids.split(' ').map(str::to_owned).collect())
}

/// Whether this process ignores a signal, as one under nohup does: its children do, too.
fn is_ignored(number: u32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (number - 1) & 1 == 1)
}

#[test]
fn nothing_is_left_behind_after_a_signal() {
    for (signal, number) in [("-INT", 2), ("-TERM", 15), ("-HUP", 1)] {
        if is_ignored(number) {
            continue;
        }
        let bench = Bench::new("hang", "workers = 1");
        let (child, pids) = hanging(&bench);
        assert!(!bench.left_behind().is_empty());
        send(signal, &child.id().to_string());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{signal}");
        let note = in_one_line(&output);
        assert!(
            note.contains("stopped; nothing is kept"),
            "{signal}: {note}"
        );
        assert!(bench.left_behind().is_empty(), "{signal}");
        wait_until("the program ends", || !pids.iter().any(|pid| runs(pid)));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_signal_ends_it_where_nothing_can_be_said() {
    let bench = Bench::new("hang", "workers = 1");
    let out = bench.folder.path().join("run");
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let (mut child, _) = hanging_with(&bench, &["--out", out.to_str().unwrap()], full);
    send("-TERM", &child.id().to_string());
    wait_until("the run ends", || child.try_wait().unwrap().is_some());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(bench.left_behind().is_empty());
}

#[test]
#[cfg(unix)]
fn a_run_without_calls_names_the_points_that_it_keeps() {
    if is_ignored(15) {
        return;
    }
    let folder = tempfile::TempDir::new().unwrap();
    let out = folder.path().join("run");
    let child = Command::new(env!("CARGO_BIN_EXE_symplint"))
        .args(["check", "henon-heiles", "--threads", "1", "--out"])
        .arg(&out)
        // Long enough to be stopped.
        .args(["--set", "diagnostic.budget=1000000000"])
        .args(["--set", "diagnostic.samples=2^20"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_until("it runs", || out.join("points.csv").exists());
    send("-TERM", &child.id().to_string());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let note = in_one_line(&output);
    assert!(note.contains("points measured so far are in"), "{note}");
    assert!(note.contains("run/points.csv"), "{note}");
}

#[test]
fn a_job_that_is_stopped_says_how_to_go_on() {
    let bench = Bench::new("hang", "workers = 1");
    let path = |name: &str| bench.folder.path().join(name);
    let symplint = |command: &str| {
        let mut symplint = Command::new(env!("CARGO_BIN_EXE_symplint"));
        symplint.arg(command).env("TMPDIR", bench.temporary.path());
        symplint
    };
    let mut plan = symplint("plan");
    plan.arg(bench.config()).arg("--out").arg(path("run"));
    plan.args(["--set", "diagnostic.step_sizes=[0.125]"]);
    assert_eq!(plan.output().unwrap().status.code(), Some(4));
    let job = symplint("advance")
        .arg(path("run"))
        .args(["--part", "1/1"])
        .env("SYMPLINT_TEST_PIDS", path("pids"))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_until("the program is called", || path("pids").exists());
    send("-TERM", &job.id().to_string());
    let output = job.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let text = in_one_line(&output);
    assert!(text.contains("symplint advance"), "{text}");
    assert!(text.contains("--part 1/1` continues"), "{text}");
}

#[test]
fn a_signal_that_was_ignored_at_the_start_is_ignored() {
    let bench = Bench::new("hang", "workers = 1");
    let pids = bench.folder.path().join("pids");
    // As nohup does, which would also write to a file.
    let child = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_symplint"))
        .arg("check")
        .arg(bench.config())
        .args(["--set", "diagnostic.step_sizes=[0.125]"])
        .env("TMPDIR", bench.temporary.path())
        .env("SYMPLINT_TEST_PIDS", &pids)
        .stdout(Stdio::null())
        .spawn();
    let mut child = child.unwrap();
    wait_until("the program is called", || pids.exists());
    send("-HUP", &child.id().to_string());
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(child.try_wait().unwrap(), None);
    send("-TERM", &child.id().to_string());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

#[test]
fn programs_are_waited_for_where_the_signal_of_their_end_was_ignored() {
    let bench = Bench::new("verlet", "batch = 1000");
    let output = Command::new("bash")
        .args(["-c", "trap '' CHLD; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_symplint"))
        .arg("check")
        .arg(bench.config())
        .args(["--quiet", "--set", "diagnostic.budget=300"])
        .env("TMPDIR", bench.temporary.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

#[test]
fn what_a_program_leaves_behind_in_the_background_is_ended() {
    let bench = Bench::new("leave", "workers = 1");
    let pids = bench.folder.path().join("pids");
    let mut command = bench.command(&[
        "--set",
        "diagnostic.step_sizes=[0.125]",
        "--set",
        "diagnostic.budget=200",
    ]);
    let output = command.env("SYMPLINT_TEST_PIDS", &pids).output().unwrap();
    assert_ne!(output.status.code(), Some(2), "{}", said(&output));
    let pids = fs::read_to_string(pids).unwrap();
    wait_until("it ends", || !pids.split(' ').any(runs));
    assert!(bench.left_behind().is_empty());
}

#[test]
fn the_next_run_removes_what_a_killed_one_left_and_nothing_of_one_that_runs() {
    let bench = Bench::new("hang", "workers = 1");
    let (killed, orphans) = hanging(&bench);
    send("-KILL", &killed.id().to_string());
    killed.wait_with_output().unwrap();
    orphans.iter().for_each(|pid| send("-KILL", pid));
    let stale = bench.left_behind();
    assert_eq!(stale.len(), 1);
    fs::remove_file(bench.folder.path().join("pids")).unwrap();
    let (running, _) = hanging(&bench);
    let left = bench.left_behind();
    assert_eq!(left.len(), 1);
    assert_ne!(left, stale);
    // A third run leaves the folder of the second alone.
    let output = bench.check(&[
        "--set",
        "diagnostic.step_sizes=[0.5]",
        "--set",
        "diagnostic.budget=200",
    ]);
    assert_ne!(output.status.code(), Some(2), "{}", said(&output));
    assert_eq!(bench.left_behind(), left);
    send("-TERM", &running.id().to_string());
    running.wait_with_output().unwrap();
    assert!(bench.left_behind().is_empty());
}
