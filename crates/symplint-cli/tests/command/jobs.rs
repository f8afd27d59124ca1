//! Runs whose calls are made by jobs: in any order, some at a time, and some again.

use std::path::Path;
use std::process::{Command, Output};

use super::resume::{calls, report};
use super::{Bench, in_one_line, said};

const KEYS: &str = "workers = 1\nbatch = 16\n";

/// Parts of a round.
const PARTS: usize = 8;

fn symplint(words: &[&str], folder: &Path, counts: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
    command.arg(words[0]).arg(folder).args(&words[1..]);
    command.env("SYMPLINT_TEST_COUNT", counts).output().unwrap()
}

/// Numbers that look random: the order of parts.
fn shuffled(count: usize, seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (1..=count).collect();
    order.sort_by_key(|&k| (k as u64 + 31 * seed).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    order
}

/// Makes rounds to the end by jobs, of which `job` may leave out some; returns how many rounds there were, and what `collect` said
/// last.
fn by_jobs(
    bench: &Bench,
    (folder, counts): (&Path, &Path),
    settings: &[&str],
    job: impl Fn(usize, usize) -> bool,
) -> (usize, Output) {
    let mut plan = Command::new(env!("CARGO_BIN_EXE_symplint"));
    plan.arg("plan").arg(bench.config()).args(settings);
    let planned = plan.arg("--out").arg(folder).output().unwrap();
    assert_eq!(planned.status.code(), Some(4), "{}", said(&planned));
    for round in 0..100 {
        let order = shuffled(PARTS, round as u64);
        // Two jobs at a time.
        for pair in order.chunks(2) {
            std::thread::scope(|scope| {
                for &k in pair.iter().filter(|&&k| job(round, k)) {
                    let part = format!("{k}/{PARTS}");
                    scope.spawn(move || {
                        symplint(&["advance", "--quiet", "--part", &part], folder, counts)
                    });
                }
            });
        }
        let collected = symplint(&["collect", "--quiet"], folder, counts);
        if collected.status.code() != Some(4) {
            return (round + 1, collected);
        }
    }
    panic!("there is no end of rounds");
}

#[test]
fn parts_in_any_order_and_lost_ones_give_the_same_report() {
    let bench = Bench::new("euler", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let settings = [
        "--set",
        "diagnostic.budget=500",
        "--set",
        "diagnostic.localise=false",
    ];
    let mut check = bench.command(&settings);
    check
        .arg("--quiet")
        .env("SYMPLINT_TEST_COUNT", path("calls"));
    let whole = check.arg("--out").arg(path("whole")).output().unwrap();
    // Part 3 is lost in every second round.
    let lost = |round: usize, k: usize| round.is_multiple_of(2) || k != 3;
    let of_jobs = (&*path("jobs"), &*path("calls_of_jobs"));
    let (rounds, last) = by_jobs(&bench, of_jobs, &settings, lost);
    assert_eq!(last.status.code(), whole.status.code(), "{}", said(&last));
    assert_eq!(report(&path("jobs")), report(&path("whole")));
    assert_eq!(calls(&path("calls_of_jobs")), calls(&path("calls")));
    assert!(rounds < 25, "{rounds} rounds");
    assert!(!path("jobs").join("round").exists());
    for file in ["points.csv", "config.toml", "figures/step_sizes.svg"] {
        let of = |folder: &str| std::fs::read(path(folder).join(file)).unwrap();
        assert!(of("jobs") == of("whole"), "{file}");
    }
}

#[test]
fn a_call_that_fails_twice_is_a_failure_of_the_map() {
    // It fails at one of the step sizes.
    let bench = Bench::new("crash", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let settings = ["--set", "diagnostic.budget=300"];
    let mut check = bench.command(&settings);
    let whole = check
        .arg("--quiet")
        .arg("--out")
        .arg(path("whole"))
        .output()
        .unwrap();
    assert_eq!(whole.status.code(), Some(0), "{}", said(&whole));
    let of_jobs = (&*path("jobs"), &*path("calls"));
    let (_, last) = by_jobs(&bench, of_jobs, &settings, |_, _| true);
    assert_eq!(last.status.code(), Some(0), "{}", said(&last));
    let (of_jobs, of_check) = (report(&path("jobs")), report(&path("whole")));
    assert_eq!(of_jobs["points"], of_check["points"]);
    let omissions = of_jobs["evidence"]["omissions"].to_string();
    assert!(omissions.contains("the matrix is singular"), "{omissions}");
    // Taken in once more, the run has ended, and no call is asked for again.
    let again = symplint(&["collect", "--quiet"], &path("jobs"), &path("calls"));
    assert_eq!(said(&again), said(&last));
    assert_eq!(again.status.code(), Some(0));
    assert!(!path("jobs").join("round").exists());
    assert_eq!(report(&path("jobs")), of_jobs);
}

#[test]
fn a_job_names_what_failed_and_makes_the_rest() {
    let bench = Bench::new("crash", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let settings = "diagnostic.step_sizes=[0.5, 0.125]";
    let mut plan = Command::new(env!("CARGO_BIN_EXE_symplint"));
    plan.arg("plan")
        .arg(bench.config())
        .arg("--out")
        .arg(path("run"));
    plan.args(["--set", settings, "--set", "diagnostic.budget=200"])
        .output()
        .unwrap();
    for _ in 0..20 {
        let made = symplint(&["advance", "--part", "1/1"], &path("run"), &path("calls"));
        if made.status.code() == Some(2) {
            let text = said(&made);
            assert!(text.contains("h = 0.125 failed"), "{text}");
            assert!(text.contains("the matrix is singular"), "{text}");
            return;
        }
        assert_eq!(made.status.code(), Some(0), "{}", said(&made));
        let collected = symplint(&["collect", "--quiet"], &path("run"), &path("calls"));
        assert_eq!(collected.status.code(), Some(4), "{}", said(&collected));
    }
    panic!("no call failed");
}

#[test]
fn what_cannot_be_planned_or_made_is_refused() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let refused = |output: Output, words: &str| {
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(words), "{words}: {text}");
    };
    let plan = |config: &Path, settings: &[&str]| {
        let mut plan = Command::new(env!("CARGO_BIN_EXE_symplint"));
        plan.arg("plan").arg(config).args(settings).arg("--out");
        plan.arg(path("run")).output().unwrap()
    };
    let pendulum = path("pendulum.toml");
    std::fs::write(&pendulum, "[system]\nname = \"pendulum\"\n").unwrap();
    refused(plan(&pendulum, &[]), "only calls of programs");
    let auto = ["--set", "loop.radius=\"auto\""];
    refused(plan(&bench.config(), &auto), "give radii as numbers");
    std::fs::remove_dir_all(path("run")).ok();

    let counts = path("calls");
    let advance = |part: &str| symplint(&["advance", "--part", part], &path("run"), &counts);
    refused(advance("1/2"), "config.toml cannot be read");
    let planned = plan(&bench.config(), &["--set", "diagnostic.budget=200"]);
    assert_eq!(planned.status.code(), Some(4), "{}", said(&planned));
    for part in ["0/2", "3/2", "1", "a/b", "1/0"] {
        refused(advance(part), "give K/N");
    }
    // A job is under way.
    let round = path("run").join("round");
    let text = std::fs::read(round.join("calls")).unwrap();
    assert_eq!(advance("1/2").status.code(), Some(0));
    let part = std::fs::File::open(round.join("part-1-of-2")).unwrap();
    part.lock().unwrap();
    let collect = || symplint(&["collect"], &path("run"), &counts);
    refused(collect(), "another run writes to it");
    drop(part);
    // A file that was cut off.
    std::fs::write(round.join("calls"), &text[..text.len() - 9]).unwrap();
    refused(advance("2/2"), "is damaged");
    refused(advance("2/2"), "symplint collect DIR");
    std::fs::remove_file(round.join("calls")).unwrap();
    refused(advance("2/2"), "has no round of calls");
    assert_eq!(collect().status.code(), Some(4));
    assert_eq!(advance("2/2").status.code(), Some(0));
}

/// A scheduler: runs the jobs of an array at the same time, and waits for them.
const SBATCH: &str = r#"#!/bin/sh
echo 17
for word in "$@"; do
    case $word in
        --array=1-*) jobs=${word#--array=1-} ;;
        --wrap=*) script=${word#--wrap=} ;;
    esac
done
k=1
while [ "$k" -le "$jobs" ]; do
    SLURM_ARRAY_TASK_ID=$k sh -c "$script" &
    k=$((k + 1))
done
wait
"#;

/// Runs the script for SLURM with a scheduler.
#[cfg(unix)]
fn rounds(bench: &Bench, sbatch: &str) -> Output {
    use std::os::unix::fs::PermissionsExt;

    let path = |name: &str| bench.folder.path().join(name);
    std::fs::create_dir(path("bin")).unwrap();
    let file = path("bin").join("sbatch");
    std::fs::write(&file, sbatch).unwrap();
    std::fs::set_permissions(&file, PermissionsExt::from_mode(0o755)).unwrap();
    let text = std::fs::read_to_string(bench.config()).unwrap() + "budget = 300\n";
    std::fs::write(bench.config(), text).unwrap();
    let symplint = Path::new(env!("CARGO_BIN_EXE_symplint")).parent().unwrap();
    let own = std::env::var("PATH").unwrap();
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/slurm/rounds.sh"
    );
    let places = format!("{}:{}:{own}", path("bin").display(), symplint.display());
    Command::new("sh")
        .arg(script)
        .arg(bench.config())
        .arg(path("run"))
        .arg("3")
        .env("PATH", places)
        .output()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn the_script_for_slurm_makes_all_rounds() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let output = rounds(&bench, SBATCH);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let whole = bench.check(&["--quiet", "--out", path("whole").to_str().unwrap()]);
    assert_eq!(whole.status.code(), Some(0), "{}", said(&whole));
    assert_eq!(report(&path("run")), report(&path("whole")));
}

#[cfg(unix)]
#[test]
fn the_script_for_slurm_ends_where_jobs_are_refused_or_never_run() {
    for (sbatch, words) in [
        ("#!/bin/sh\nexit 1\n", "sbatch takes no jobs"),
        ("#!/bin/sh\necho 17\nexit 1\n", "two rounds made no call"),
    ] {
        let bench = Bench::new("leapfrog", KEYS);
        let output = rounds(&bench, sbatch);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(words), "{}", said(&output));
    }
    // A call that fails is no end.
    let output = rounds(&Bench::new("crash", KEYS), SBATCH);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

/// Plans a run of the bench, of few evaluations.
fn plan(bench: &Bench, out: &Path, more: &[&str]) -> Output {
    let mut plan = Command::new(env!("CARGO_BIN_EXE_symplint"));
    plan.arg("plan").arg(bench.config()).arg("--out").arg(out);
    plan.args(["--quiet", "--set", "diagnostic.budget=300"]);
    plan.args(more).output().unwrap()
}

#[test]
fn a_run_that_is_planned_anew_forgets_the_parts_of_the_old_one() {
    let bench = Bench::new("crash", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let run = path("run");
    let bad = ["--set", "diagnostic.step_sizes=[0.125]"];
    assert_eq!(plan(&bench, &run, &bad).status.code(), Some(4));
    let advance = |part: &str| symplint(&["advance", "--part", part], &run, &path("calls"));
    assert_eq!(advance("1/1").status.code(), Some(2));
    let part = run.join("round").join("part-1-of-1");
    assert!(part.exists() && part.with_extension("failed").exists());

    let good = ["--force", "--set", "diagnostic.step_sizes=[0.5]"];
    // While the job is under way nothing is replaced.
    let file = std::fs::File::open(&part).unwrap();
    file.lock().unwrap();
    let refused = plan(&bench, &run, &good);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    drop(file);
    assert_eq!(plan(&bench, &run, &bad).status.code(), Some(4));

    assert_eq!(plan(&bench, &run, &good).status.code(), Some(4));
    assert!(!part.exists() && !part.with_extension("failed").exists());
    assert_eq!(advance("1/1").status.code(), Some(0));
    let collected = symplint(&["collect", "--quiet"], &run, &path("calls"));
    assert_ne!(collected.status.code(), Some(2), "{}", said(&collected));
}

#[test]
fn a_call_that_fails_in_two_jobs_of_a_round_failed_once() {
    let bench = Bench::new("crash", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let run = path("run");
    let bad = ["--set", "diagnostic.step_sizes=[0.125]"];
    assert_eq!(plan(&bench, &run, &bad).status.code(), Some(4));
    for part in ["1/1", "1/2", "2/2"] {
        symplint(
            &["advance", "--quiet", "--part", part],
            &run,
            &path("calls"),
        );
    }
    let collected = symplint(&["collect", "--quiet"], &run, &path("calls"));
    assert_eq!(collected.status.code(), Some(4), "{}", said(&collected));
    let failed = std::fs::read_to_string(run.join("failed.json")).unwrap();
    let failed: serde_json::Value = serde_json::from_str(&failed).unwrap();
    let failed = failed.as_array().unwrap();
    assert!(!failed.is_empty());
    assert!(failed.iter().all(|call| call["times"] == 1), "{failed:?}");
}

#[test]
fn a_job_that_is_started_again_and_stops_early_forgets_no_failure() {
    let bench = Bench::new("crash", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let run = path("run");
    let bad = ["--set", "diagnostic.step_sizes=[0.125]"];
    assert_eq!(plan(&bench, &run, &bad).status.code(), Some(4));
    let advance = |temporary: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command.arg("advance").arg(&run).args(["--part", "1/1"]);
        command.env("TMPDIR", temporary).output().unwrap()
    };
    let failed = || std::fs::read(run.join("round/part-1-of-1.failed")).unwrap();
    assert_eq!(advance(bench.temporary.path()).status.code(), Some(2));
    let first = failed();
    let stopped = advance(&path("not there"));
    assert_eq!(stopped.status.code(), Some(2));
    assert!(
        in_one_line(&stopped).contains("cannot write"),
        "{}",
        said(&stopped)
    );
    assert_eq!(failed(), first);
}

#[test]
fn failures_that_were_taken_in_once_do_not_count_again() {
    let bench = Bench::new("crash", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let run = path("run");
    let bad = ["--set", "diagnostic.step_sizes=[0.125]"];
    assert_eq!(plan(&bench, &run, &bad).status.code(), Some(4));
    let advance = || {
        symplint(
            &["advance", "--quiet", "--part", "1/1"],
            &run,
            &path("calls"),
        )
    };
    let collect = || symplint(&["collect", "--quiet"], &run, &path("calls"));
    let part = run.join("round").join("part-1-of-1.failed");
    advance();
    let failed = std::fs::read(&part).unwrap();
    assert_eq!(collect().status.code(), Some(4));
    let once = std::fs::read(run.join("failed.json")).unwrap();
    // As if `collect` had been killed before it removed the list of the part.
    std::fs::write(&part, &failed).unwrap();
    let output = collect();
    assert_eq!(output.status.code(), Some(4), "{}", said(&output));
    assert!(std::fs::read(run.join("failed.json")).unwrap() == once);
    // A list that was cut off is named, with what to do about it.
    std::fs::write(run.join("failed.json"), &once[..once.len() / 2]).unwrap();
    let text = in_one_line(&collect());
    assert!(
        text.contains("failed.json") && text.contains("remove it"),
        "{text}"
    );
    assert!(!text.contains("report.json"), "{text}");
    std::fs::write(run.join("failed.json"), &once).unwrap();
    advance();
    collect();
    let twice = std::fs::read_to_string(run.join("failed.json")).unwrap_or_default();
    assert!(!twice.contains("\"times\":1"), "{twice}");
}

#[test]
fn a_call_is_made_once_however_a_round_is_cut_into_parts() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let (run, counts) = (path("run"), path("calls"));
    let json = plan(&bench, &run, &["--json"]);
    assert_eq!(json.status.code(), Some(4), "{}", said(&json));
    assert!(json.stdout.is_empty(), "{}", said(&json));
    #[cfg(target_os = "linux")]
    {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let mut collect = Command::new(env!("CARGO_BIN_EXE_symplint"));
        collect.arg("collect").arg(&run).arg("--json");
        let status = collect.stderr(full.unwrap()).status().unwrap();
        assert_eq!(status.code(), Some(4));
    }
    let advance = |part: &str| {
        let output = symplint(&["advance", "--quiet", "--part", part], &run, &counts);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        calls(&counts)
    };
    let mut was_cut = false;
    let ended = loop {
        let half = advance("1/2");
        let all = advance("1/1");
        assert_eq!(advance("2/3"), all);
        was_cut |= half < all;
        // Planned again, the run has what the jobs made.
        let output = plan(&bench, &run, &[]);
        assert!(!run.join("round").join("part-1-of-1").exists());
        if output.status.code() != Some(4) {
            break output;
        }
    };
    assert_eq!(ended.status.code(), Some(0), "{}", said(&ended));
    assert!(was_cut);
    let mut check = bench.command(&["--quiet", "--set", "diagnostic.budget=300", "--out"]);
    check
        .arg(path("whole"))
        .env("SYMPLINT_TEST_COUNT", path("needed"));
    assert_eq!(check.status().unwrap().code(), Some(0));
    assert_eq!(calls(&counts), calls(&path("needed")));
}

#[test]
fn a_run_that_goes_on_without_jobs_takes_in_theirs_and_waits_for_none() {
    let bench = Bench::new("leapfrog", KEYS);
    let path = |name: &str| bench.folder.path().join(name);
    let run = path("run");
    assert_eq!(plan(&bench, &run, &[]).status.code(), Some(4));
    let advance = || symplint(&["advance", "--part", "1/1"], &run, &path("calls"));
    assert_eq!(advance().status.code(), Some(0));
    let made = calls(&path("calls"));
    let resume = || symplint(&["resume", "--quiet"], &run, &path("more_calls"));
    let part = std::fs::File::open(run.join("round/part-1-of-1")).unwrap();
    part.lock().unwrap();
    let refused = resume();
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(in_one_line(&refused).contains("another run writes to it"));
    drop(part);
    let output = resume();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(!run.join("round").exists());
    let whole = path("whole");
    let mut check = bench.command(&["--quiet", "--set", "diagnostic.budget=300", "--out"]);
    check.arg(&whole).env("SYMPLINT_TEST_COUNT", path("needed"));
    assert_eq!(check.status().unwrap().code(), Some(0));
    assert_eq!(made + calls(&path("more_calls")), calls(&path("needed")));
    assert_eq!(report(&run), report(&whole));
    let late = advance();
    assert!(
        in_one_line(&late).contains("has no round"),
        "{}",
        said(&late)
    );
}
