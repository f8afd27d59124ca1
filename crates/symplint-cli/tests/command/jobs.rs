//! Runs whose calls are made by jobs: in any order, some at a time, and some again.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::resume::{calls, report};
use super::{Bench, ends, in_one_line, refused, said, symplint};

const KEYS: &str = "workers = 1\nbatch = 16\n";

/// Parts of a round.
const PARTS: usize = 8;

/// All calls of a run at its bad step size fail.
const BAD: [&str; 2] = ["--set", "diagnostic.step_sizes=[0.125]"];

/// A run by jobs.
struct Jobs {
    bench: Bench,
    run: PathBuf,
    /// The calls of the program.
    counts: PathBuf,
}

impl Jobs {
    fn new(behaviour: &str) -> Self {
        let bench = Bench::new(behaviour, KEYS);
        let [run, counts] = ["jobs", "calls_of_jobs"].map(|name| bench.path(name));
        Jobs { bench, run, counts }
    }

    fn plan(&self, more: &[&str]) -> Output {
        let mut plan = symplint(&["plan", "--quiet", "--set", "diagnostic.budget=300"]);
        plan.arg(self.bench.config()).arg("--out").arg(&self.run);
        plan.args(more).output().unwrap()
    }

    fn command(&self, words: &[&str]) -> Command {
        let mut command = symplint(&[words, &["--quiet"]].concat());
        command.arg(&self.run);
        command.env("SYMPLINT_TEST_COUNT", &self.counts);
        command
    }

    fn advance(&self, part: &str) -> Output {
        let mut command = self.command(&["advance", "--part", part]);
        command.output().unwrap()
    }

    fn collect(&self) -> Output {
        self.command(&["collect"]).output().unwrap()
    }

    /// Makes rounds to the end, without the jobs that are lost; returns how many rounds there were, and the output of the last
    /// `collect`.
    fn to_the_end(&self, is_lost: impl Fn(usize, usize) -> bool) -> (usize, Output) {
        for round in 0..100 {
            // An order that looks random.
            let mut order: Vec<usize> = (1..=PARTS).collect();
            order.sort_by_key(|k| (k + 31 * round).wrapping_mul(0x9E37_79B9_7F4A_7C15));
            // Two jobs at a time.
            for pair in order.chunks(2) {
                std::thread::scope(|scope| {
                    for &k in pair.iter().filter(|&&k| !is_lost(round, k)) {
                        scope.spawn(move || self.advance(&format!("{k}/{PARTS}")));
                    }
                });
            }
            let collected = self.collect();
            if collected.status.code() != Some(4) {
                return (round + 1, collected);
            }
        }
        panic!("the rounds do not end");
    }

    /// The same run without jobs.
    fn whole(&self, more: &[&str]) -> (PathBuf, usize) {
        let (out, counts) = (self.bench.path("whole"), self.bench.path("calls"));
        let mut check = (self.bench).command(&["--quiet", "--set", "diagnostic.budget=300"]);
        check.args(more).arg("--out").arg(&out);
        let output = check.env("SYMPLINT_TEST_COUNT", &counts).output().unwrap();
        assert_ne!(output.status.code(), Some(2), "{}", said(&output));
        (out, calls(&counts))
    }

    fn lock(&self) -> File {
        File::open(self.run.join(".lock")).unwrap()
    }
}

#[test]
fn parts_in_any_order_and_lost_ones_give_the_same_report() {
    let jobs = Jobs::new("euler");
    let settings = ["diagnostic.budget=500", "diagnostic.localise=false"];
    let settings = settings.map(|setting| ["--set", setting]).concat();
    let (whole, needed) = jobs.whole(&settings);
    ends(4, &jobs.plan(&settings));
    // Part 3 is lost in every second round.
    let (rounds, last) = jobs.to_the_end(|round, k| round % 2 == 1 && k == 3);
    ends(1, &last);
    assert_eq!(report(&jobs.run), report(&whole));
    assert_eq!(calls(&jobs.counts), needed);
    assert!(rounds < 25, "{rounds} rounds");
    assert!(!jobs.run.join("round").exists());
    for file in ["points.csv", "config.toml", "figures/step_sizes.svg"] {
        let of = |folder: &Path| fs::read(folder.join(file)).unwrap();
        assert!(of(&jobs.run) == of(&whole), "{file}");
    }
}

#[test]
fn a_call_that_fails_twice_is_a_failure_of_the_map() {
    // It fails at one of the step sizes.
    let jobs = Jobs::new("crash");
    let (whole, _) = jobs.whole(&[]);
    ends(4, &jobs.plan(&[]));
    let (_, last) = jobs.to_the_end(|_, _| false);
    ends(0, &last);
    let (of_jobs, of_check) = (report(&jobs.run), report(&whole));
    assert_eq!(of_jobs["points"], of_check["points"]);
    let omissions = of_jobs["evidence"]["omissions"].to_string();
    assert!(omissions.contains("the matrix is singular"), "{omissions}");
    // Collected once more, the run has ended, and no call is asked for again.
    let again = jobs.collect();
    ends(0, &again);
    assert_eq!(said(&again), said(&last));
    assert!(!jobs.run.join("round").exists());
    assert_eq!(report(&jobs.run), of_jobs);
}

#[test]
fn a_job_names_the_calls_that_failed() {
    let jobs = Jobs::new("crash");
    ends(4, &jobs.plan(&BAD));
    refused(&jobs.advance("1/1"), "h = 0.125 failed");
    refused(&jobs.advance("1/1"), "the matrix is singular");
}

#[test]
fn a_run_that_cannot_be_planned_or_advanced_is_refused() {
    let jobs = Jobs::new("leapfrog");
    let pendulum = jobs.bench.path("pendulum.toml");
    fs::write(&pendulum, "[system]\nname = \"pendulum\"\n").unwrap();
    let mut plan = symplint(&["plan"]);
    plan.arg(pendulum).arg("--out").arg(&jobs.run);
    refused(&plan.output().unwrap(), "only calls of programs");
    let auto = ["--set", "loop.radius=\"auto\""];
    refused(&jobs.plan(&auto), "give radii as numbers");
    fs::remove_dir_all(&jobs.run).ok();

    refused(&jobs.advance("1/2"), "config.toml cannot be read");
    ends(4, &jobs.plan(&[]));
    for part in ["0/2", "3/2", "1", "a/b", "1/0"] {
        refused(&jobs.advance(part), "give K/N");
    }
    // A job is under way.
    ends(0, &jobs.advance("1/2"));
    let (job, round) = (jobs.lock(), jobs.run.join("round").join("calls"));
    job.lock_shared().unwrap();
    refused(&jobs.collect(), "another run writes to it");
    ends(0, &jobs.advance("1/2"));
    drop(job);
    // Nor does a job begin while a run is under way.
    let run = jobs.lock();
    run.lock().unwrap();
    refused(&jobs.advance("2/2"), "another run writes to it");
    drop(run);
    fs::write(&round, "symplint").unwrap();
    refused(&jobs.advance("2/2"), "its beginning is damaged");
    fs::remove_file(round).unwrap();
    refused(&jobs.advance("2/2"), "has no round of calls");
    ends(4, &jobs.collect());
    ends(0, &jobs.advance("2/2"));
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
fn rounds(jobs: &Jobs, sbatch: &str) -> Output {
    use std::os::unix::fs::PermissionsExt;

    let bin = jobs.bench.path("bin");
    fs::create_dir(&bin).unwrap();
    fs::write(bin.join("sbatch"), sbatch).unwrap();
    fs::set_permissions(bin.join("sbatch"), PermissionsExt::from_mode(0o755)).unwrap();
    let text = fs::read_to_string(jobs.bench.config()).unwrap() + "budget = 300\n";
    fs::write(jobs.bench.config(), text).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_symplint")).parent().unwrap();
    let own = std::env::var("PATH").unwrap();
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/slurm/rounds.sh"
    );
    let places = format!("{}:{}:{own}", bin.display(), program.display());
    let mut command = Command::new("sh");
    command.arg(script).arg(jobs.bench.config()).arg(&jobs.run);
    command.arg("3").env("PATH", places).output().unwrap()
}

#[cfg(unix)]
#[test]
fn the_script_for_slurm_makes_all_rounds() {
    let jobs = Jobs::new("leapfrog");
    ends(0, &rounds(&jobs, SBATCH));
    assert_eq!(report(&jobs.run), report(&jobs.whole(&[]).0));
}

#[cfg(unix)]
#[test]
fn the_script_for_slurm_ends_if_jobs_are_refused_or_never_run() {
    for (sbatch, words) in [
        ("#!/bin/sh\nexit 1\n", "sbatch takes no jobs"),
        ("#!/bin/sh\necho 17\nexit 1\n", "two rounds made no call"),
    ] {
        refused(&rounds(&Jobs::new("leapfrog"), sbatch), words);
    }
    // A call that fails does not end the script.
    ends(0, &rounds(&Jobs::new("crash"), SBATCH));
}

#[test]
fn a_run_that_is_planned_anew_forgets_the_parts_of_the_old_one() {
    let jobs = Jobs::new("crash");
    ends(4, &jobs.plan(&BAD));
    ends(2, &jobs.advance("1/1"));
    let part = jobs.run.join("round").join("part-1-of-1");
    assert!(part.exists() && part.with_extension("failed").exists());
    let good = ["--force", "--set", "diagnostic.step_sizes=[0.5]"];
    // While a job is under way nothing is replaced.
    let job = jobs.lock();
    job.lock_shared().unwrap();
    ends(2, &jobs.plan(&good));
    drop(job);
    ends(4, &jobs.plan(&BAD));
    ends(4, &jobs.plan(&good));
    assert!(!part.exists() && !part.with_extension("failed").exists());
    ends(0, &jobs.advance("1/1"));
    assert_ne!(jobs.collect().status.code(), Some(2));
}

#[test]
fn a_call_counts_as_failed_once_a_round() {
    let jobs = Jobs::new("crash");
    ends(4, &jobs.plan(&BAD));
    let part = jobs.run.join("round").join("part-1-of-1.failed");
    let list = jobs.run.join("failed.json");
    for job in ["1/1", "1/2", "2/2"] {
        ends(2, &jobs.advance(job));
    }
    let failed = fs::read(&part).unwrap();
    // A job that is started again and stops early forgets no failure.
    let mut stopped = jobs.command(&["advance", "--part", "1/1"]);
    stopped.env("TMPDIR", jobs.bench.path("not there"));
    refused(&stopped.output().unwrap(), "cannot write");
    assert_eq!(fs::read(&part).unwrap(), failed);

    ends(4, &jobs.collect());
    let once = fs::read_to_string(&list).unwrap();
    assert!(once.contains("\"times\":1") && !once.contains("\"times\":2"));
    // As if `collect` had been killed before it removed the list of the part.
    fs::write(&part, &failed).unwrap();
    ends(4, &jobs.collect());
    assert_eq!(fs::read_to_string(&list).unwrap(), once);
    // A list that was cut off is named, with the remedy.
    fs::write(&list, &once[..once.len() / 2]).unwrap();
    let collected = jobs.collect();
    refused(&collected, "failed.json");
    refused(&collected, "remove it");
    fs::write(&list, &once).unwrap();
    ends(2, &jobs.advance("1/1"));
    jobs.collect();
    let twice = fs::read_to_string(&list).unwrap_or_default();
    assert!(!twice.contains("\"times\":1"), "{twice}");
}

#[test]
fn a_call_is_made_once_however_a_round_is_cut_into_parts() {
    let jobs = Jobs::new("leapfrog");
    let json = jobs.plan(&["--json"]);
    ends(4, &json);
    assert!(json.stdout.is_empty(), "{}", said(&json));
    #[cfg(target_os = "linux")]
    {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let mut collect = jobs.command(&["collect", "--json"]);
        assert_eq!(collect.stderr(full).status().unwrap().code(), Some(4));
    }
    let advance = |part: &str| {
        ends(0, &jobs.advance(part));
        calls(&jobs.counts)
    };
    let mut was_cut = false;
    let ended = loop {
        let (half, all) = (advance("1/2"), advance("1/1"));
        assert_eq!(advance("2/3"), all);
        was_cut |= half < all;
        // Planned again, the run has what the jobs made.
        let output = jobs.plan(&[]);
        assert!(!jobs.run.join("round").join("part-1-of-1").exists());
        if output.status.code() != Some(4) {
            break output;
        }
    };
    ends(0, &ended);
    assert!(was_cut);
    assert_eq!(calls(&jobs.counts), jobs.whole(&[]).1);
}

#[test]
fn a_run_that_resumes_without_jobs_has_their_results_and_waits_for_none() {
    let jobs = Jobs::new("leapfrog");
    ends(4, &jobs.plan(&[]));
    ends(0, &jobs.advance("1/1"));
    let resume = || jobs.command(&["resume"]).output().unwrap();
    let job = jobs.lock();
    job.lock_shared().unwrap();
    refused(&resume(), "another run writes to it");
    drop(job);
    ends(0, &resume());
    assert!(!jobs.run.join("round").exists());
    let (whole, needed) = jobs.whole(&[]);
    assert_eq!(calls(&jobs.counts), needed);
    assert_eq!(report(&jobs.run), report(&whole));
    let late = jobs.advance("1/1");
    assert!(in_one_line(&late).contains("has no round"));
}
