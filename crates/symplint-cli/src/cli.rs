//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use symplint_config::parse_number;

/// Tests whether a time-advance map is symplectic.
///
/// symplint advances closed loops of states by one step of the map, and compares the Poincaré loop integral ∮ p·dq before and
/// after the step, for several step sizes, loops and numbers of samples.
#[derive(Parser)]
#[command(name = "symplint", version, max_term_width = 100, after_help = AFTER)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER: &str = "Examples:
  symplint init pendulum > pendulum.toml          a commented configuration to start from
  symplint check pendulum.toml                    is it symplectic?
  symplint check pendulum.toml --set integrator.name=rk2 --out run
  symplint loop --dof 3 --radius 0.5              initial states for another code
  symplint measure loop.npz after.npz             compare them with the states after its step
  symplint reproduce fig2                         a figure of the paper

Exit status of `check`, `measure`, `judge` and `resume`: 0 symplectic; 1 not symplectic, or loops broken; 2 bad usage, bad input or a \
failed run; 3 undecided; 130 interrupted.";

const EXIT_STATUS: &str = "Exit status: 0 symplectic; 1 not symplectic, or loops broken; 2 bad usage, bad input or a \
failed run; 3 undecided; 130 interrupted.";

const JOBS: &str = "Example:
  symplint plan run.toml --out run                  a round of calls
  symplint advance run --part 1/8                   the first of eight parts; also make 2/8 to 8/8
  symplint collect run                              the next round, or the verdict

Exit status of `plan` and `collect`: 4 if there is a round of calls to make; otherwise as `check`. Exit status of `advance`: 0 all \
calls of the part were made; 2 some calls failed, or the part could not be started; 130 interrupted.";

/// The commands.
#[derive(Subcommand)]
pub enum Command {
    /// Test a map that a configuration describes, and give a verdict.
    ///
    /// Tests your loop at each step size, and then random loops and the Jacobian at the largest step size. If the configuration
    /// has a `sample_sweep`, it also varies the number of samples. --out DIR writes the report and its figures to DIR.
    #[command(after_help = EXIT_STATUS)]
    Check(CheckArgs),
    /// Write the samples of a loop, for another code to advance.
    ///
    /// Row k of the arrays q and p, of shape (samples, dof), is the state at s = k/samples. Advance every row
    /// by one step, store the arrays in the same way, and give both files to `symplint measure`.
    ///
    /// The loop comes from a configuration or, without one, from --dof, --q0, --p0, --radius and so on.
    #[command(after_help = LOOP_EXAMPLES)]
    Loop(LoopArgs),
    /// Compare a loop before and after a step of another code.
    ///
    /// Each AFTER file has the states of BEFORE after one step. `symplint loop` writes the formats. An .npz file may also have
    /// `h`, `period` (of each position, 0 if it is not periodic), `momentum_period` and `weight` (canonical momentum = weight × p).
    /// For non-canonical coordinates, it has `z` instead of `q` and `p`, and the values `theta` of the one-form at these states.
    /// Options replace values in the files. Samples alone cannot prove that a loop is broken, but they are evidence for it.
    #[command(after_help = EXIT_STATUS)]
    Measure(MeasureArgs),
    /// Compute the verdict again from the measurements in a report.
    ///
    /// The verdict depends only on the key `evidence` of a report, which `check` and `measure` write with --out or --json. The map
    /// is not called.
    #[command(after_help = EXIT_STATUS)]
    Judge(JudgeArgs),
    /// Continue a run of `check` that was stopped.
    ///
    /// With --out DIR, `check` stores each call of a program (system.name = "command") in DIR/journal as soon as the call
    /// ends. The same command, or this one, continues the run and does not repeat these calls. The report equals the report of a
    /// run without an interruption. Runs of other systems start again from the beginning.
    #[command(after_help = EXIT_STATUS)]
    Resume(ResumeArgs),
    /// Write the next calls of a program as files, for the jobs of a scheduler.
    ///
    /// Writes a round of calls to DIR/round: the calls that `check` would make next. Each job makes a part of them by
    /// `symplint advance DIR --part K/N`, in any order and on any machine that sees DIR. `symplint collect DIR` then reads the
    /// results. It writes the next round or, at the end, the files of `check --out DIR`.
    #[command(after_help = JOBS)]
    Plan(PlanArgs),
    /// Make a part of a round of calls.
    ///
    /// Part K of N has every N-th call. A job that was stopped can be started again, and does not repeat its finished calls. If a
    /// call fails, the error names it, and the job continues with the next call.
    #[command(after_help = JOBS)]
    Advance(AdvanceArgs),
    /// Read the results of a round, and plan the next round or give the verdict.
    ///
    /// The next round repeats calls without a result. A call that failed twice counts as a failure of the map.
    #[command(after_help = JOBS)]
    Collect(ResumeArgs),
    /// Follow the loop integral and the energy in time.
    ///
    /// Takes trace.steps steps of size trace.step_size. The energy belongs to the orbit that starts at the centre of the loop.
    /// The rule is pseudospectral or finite-difference. Other rules are errors.
    Trace(TraceArgs),
    /// Reproduce the figures of the paper, and test its claims.
    ///
    /// Writes figures (SVG, PDF, PNG), data (CSV) and a list of claims with their results to one folder. --set changes the settings
    /// of a single item.
    Reproduce(ReproduceArgs),
    /// List systems, integrators, rules or figures.
    List {
        /// What to list.
        what: ListTopic,
    },
    /// Print a commented starter configuration.
    Init {
        /// The system; `symplint list systems` shows them all.
        system: String,
        /// Print every key
        #[arg(long)]
        all: bool,
    },
    /// Print a completion script for a shell.
    #[command(after_help = COMPLETIONS)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages: symplint.1, and a page for each command.
    #[command(after_help = MAN)]
    Man {
        /// The folder to write to; it is created if it does not exist
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
}

const COMPLETIONS: &str = "Examples:
  symplint completions bash > ~/.local/share/bash-completion/completions/symplint
  symplint completions zsh > ~/.zfunc/_symplint     with ~/.zfunc in $fpath
  symplint completions fish > ~/.config/fish/completions/symplint.fish";

const MAN: &str = "Example:
  symplint man ~/.local/share/man/man1";

impl Command {
    /// The number of threads, if it is given.
    pub fn threads(&self) -> Option<usize> {
        match self {
            Command::Check(arguments) => arguments.run.shown.threads,
            Command::Loop(arguments) => arguments.threads,
            Command::Measure(arguments) => arguments.run.shown.threads,
            Command::Trace(arguments) => arguments.run.shown.threads,
            Command::Reproduce(arguments) => arguments.threads,
            Command::Resume(arguments) | Command::Collect(arguments) => arguments.shown.threads,
            Command::Plan(arguments) => arguments.shown.threads,
            Command::Advance(_)
            | Command::Judge(_)
            | Command::List { .. }
            | Command::Init { .. }
            | Command::Completions { .. }
            | Command::Man { .. } => None,
        }
    }
}

/// What can be listed.
#[derive(Clone, Copy, ValueEnum)]
pub enum ListTopic {
    /// Hamiltonians and maps.
    Systems,
    /// Time-advance maps.
    Integrators,
    /// Rules for the loop integral.
    Rules,
    /// Items of `reproduce`.
    Figures,
}

/// Arguments of `check`.
#[derive(Args)]
pub struct CheckArgs {
    /// The configuration, - for standard input, or the name of a system; `symplint init SYSTEM` prints one to start from
    pub config: PathBuf,
    /// Also take N steps of the largest size, to test whether the defect accumulates
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    pub steps: Option<usize>,
    /// Keep the files of all calls of a program in a new folder, by default symplint-calls
    #[arg(long, value_name = "DIR", num_args = 0..=1, require_equals = true, default_missing_value = "symplint-calls")]
    pub keep: Option<PathBuf>,
    /// Changes of the configuration.
    #[command(flatten)]
    pub settings: Settings,
    /// Output and threads.
    #[command(flatten)]
    pub run: Run,
}

/// Arguments of `judge`.
#[derive(Args)]
pub struct JudgeArgs {
    /// The report: report.json, the run folder that holds it, or - for standard input
    #[arg(value_name = "REPORT")]
    pub report: PathBuf,
    /// Print the verdict as JSON
    #[arg(long)]
    pub json: bool,
    /// Print only the headline of the verdict
    #[arg(short, long)]
    pub quiet: bool,
    /// Print every row of the table and every finding
    #[arg(long)]
    pub all: bool,
}

/// Arguments of `plan`.
#[derive(Args)]
pub struct PlanArgs {
    /// The configuration of a program (system.name = "command")
    pub config: PathBuf,
    /// The run folder
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Replace the run of another configuration in DIR
    #[arg(long)]
    pub force: bool,
    /// Changes of the configuration.
    #[command(flatten)]
    pub settings: Settings,
    /// Output and threads.
    #[command(flatten)]
    pub shown: OutputArgs,
}

/// Arguments of `advance`.
#[derive(Args)]
pub struct AdvanceArgs {
    /// The folder that `plan --out` named
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Make part K of N
    #[arg(long, value_name = "K/N", value_parser = part)]
    pub part: (usize, usize),
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Parses a part of several: `3/8`.
fn part(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/');
    let numbers = numbers.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((k, n)) if (1..=n).contains(&k) => Ok((k, n)),
        _ => Err("give K/N with 1 ≤ K ≤ N, as in 3/8".into()),
    }
}

/// Arguments of `resume` and `collect`.
#[derive(Args)]
pub struct ResumeArgs {
    /// The folder that --out named
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Output and threads.
    #[command(flatten)]
    pub shown: OutputArgs,
}

/// Arguments of `trace`.
#[derive(Args)]
pub struct TraceArgs {
    /// The configuration, - for standard input, or the name of a system; `symplint init SYSTEM` prints one to start from
    pub config: PathBuf,
    /// Changes of the configuration.
    #[command(flatten)]
    pub settings: Settings,
    /// Output and threads.
    #[command(flatten)]
    pub run: Run,
}

/// Arguments of `measure`.
#[derive(Args)]
pub struct MeasureArgs {
    /// The loop before the step: .npz, .npy (loop_q.npy stands for the pair with loop_p.npy), .csv, .raw or .txt
    pub before: PathBuf,
    /// The loop after one step; several files for several step sizes
    #[arg(required = true)]
    pub after: Vec<PathBuf>,
    /// Step sizes of the files after the step, in their order; without any, no order is fitted
    #[arg(long = "h", value_name = "H", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub step_sizes: Vec<f64>,
    /// Period of the positions, 0 if not periodic: one number, or one for each degree of freedom
    #[arg(long, value_name = "L", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub period: Vec<f64>,
    /// Period of the momenta, 0 if not periodic: one number, or one for each degree of freedom
    #[arg(long, value_name = "L", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub momentum_period: Vec<f64>,
    /// Weight of the momenta: one number, or one for each degree of freedom
    #[arg(long, value_name = "W", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub weight: Vec<f64>,
    /// Output and threads.
    #[command(flatten)]
    pub run: Run,
}

/// Arguments of `reproduce`.
#[derive(Args)]
pub struct ReproduceArgs {
    /// Names of the items; all if none is given. `symplint list figures` shows them
    pub ids: Vec<String>,
    /// Only list the items and their cost
    #[arg(long, conflicts_with_all = ["ids", "set", "out", "force", "json", "quiet"])]
    pub list: bool,
    /// Change a setting of one item, such as strang=momentum-first of fig7 (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Folder for figures, data and claims
    #[arg(long, value_name = "DIR", default_value = "symplint-paper")]
    pub out: PathBuf,
    /// Replace another run in DIR; files that symplint did not write are never replaced
    #[arg(long)]
    pub force: bool,
    /// Print the claims as JSON on standard output, and nothing else
    #[arg(long)]
    pub json: bool,
    /// No progress bar; print only the numbers of claims that hold and fail
    #[arg(short, long)]
    pub quiet: bool,
    /// Number of threads; all cores by default. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = at_least_one, allow_negative_numbers = true)]
    pub threads: Option<usize>,
}

const LOOP_EXAMPLES: &str = "Examples:
  symplint loop pendulum.toml -o before.npz
  symplint loop --dof 3 --radius 0.5 --samples 2^10 -o before.npz
  symplint loop --q0 1,2,3 --p0 0 --shape fourier --seed 7 -o before.csv
  symplint loop --dof 2 --center pi --radius 0.1 --period 2*pi,0 -o before.npz";

/// Arguments of `loop`.
#[derive(Args)]
pub struct LoopArgs {
    /// The configuration of the loop; its integrator is not used
    pub config: Option<PathBuf>,
    /// Samples of the loop. The default is diagnostic.samples, or 256 if that is "auto"
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    pub samples: Option<usize>,
    /// File to write: .npz has q and p, and periods and weights if they are set; .npy is a pair of files, loop_q.npy and
    /// loop_p.npy; .csv has columns q_0, q_1, …, p_0, p_1, …; .raw and .txt have one line `symplint h dof samples`, and then all
    /// samples of q_0, of q_1, …, of p_0, of p_1, … as doubles or decimals
    #[arg(long, short, value_name = "FILE", default_value = "loop.npz")]
    pub output: PathBuf,
    /// Folder of the file
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace another loop in that file; a file that is not a loop is never replaced
    #[arg(long)]
    pub force: bool,
    /// Changes of the configuration.
    #[command(flatten)]
    pub settings: Settings,
    /// Print the names of the files as JSON on standard output, and nothing else
    #[arg(long)]
    pub json: bool,
    /// Print the file and its size, without the next command
    #[arg(short, long)]
    pub quiet: bool,
    /// Number of threads; all cores by default. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = at_least_one, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// The loop without a configuration.
    #[command(flatten)]
    pub shape: LoopShape,
}

/// A loop without a configuration.
#[derive(Args)]
#[command(next_help_heading = "Loop without a configuration")]
pub struct LoopShape {
    /// Degrees of freedom; not needed if another option has one number for each
    #[arg(long, value_name = "D", value_parser = at_least_one, allow_negative_numbers = true)]
    pub dof: Option<usize>,
    /// Centre of the loop, positions: one number, or one for each degree of freedom [default: 0]
    #[arg(long, value_name = "Q", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub q0: Vec<f64>,
    /// Centre of the loop, momenta: one number, or one for each degree of freedom [default: 0]
    #[arg(long, value_name = "P", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub p0: Vec<f64>,
    /// Centre of the loop, instead of --q0 and --p0: one number for all positions and momenta, or all positions and then
    /// all momenta
    #[arg(
        long,
        visible_alias = "centre",
        value_name = "C",
        value_delimiter = ',',
        value_parser = number,
        allow_hyphen_values = true,
        conflicts_with_all = ["q0", "p0"]
    )]
    pub center: Vec<f64>,
    /// Radius of the loop, the same in all positions and momenta [default: 1]
    #[arg(long, value_name = "R", value_parser = number, allow_hyphen_values = true)]
    pub radius: Option<f64>,
    /// Shape of the loop [default: circle]
    #[arg(long)]
    pub shape: Option<Shape>,
    /// Phases of the circles of the degrees of freedom [default: staggered]
    #[arg(long)]
    pub phases: Option<Phases>,
    /// Seed of random phases and of fourier loops [default: 1]
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    pub seed: Option<usize>,
    /// Period of the positions, 0 if not periodic: one number, or one for each degree of freedom
    #[arg(long, value_name = "L", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub period: Vec<f64>,
    /// Weight of the momenta, canonical momentum = weight × p: one number, or one for each degree of freedom
    #[arg(long, value_name = "W", value_delimiter = ',', value_parser = number, allow_hyphen_values = true)]
    pub weight: Vec<f64>,
}

/// Shapes of loops.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Shape {
    /// q = q0 + r sin 2πs, p = p0 + r cos 2πs in every degree of freedom
    Circle,
    /// Random Fourier modes 1 to 3
    Fourier,
}

/// Phases of circles.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Phases {
    /// Multiples of the golden ratio
    Staggered,
    /// The same phase for all: the loop of the paper
    Equal,
    /// Random phases
    Random,
}

/// Changes of a configuration.
#[derive(Args)]
pub struct Settings {
    /// Change a key of the configuration, such as integrator.name=rk2 (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Output and threads of a run.
#[derive(Args)]
pub struct Run {
    /// Folder for the results: the report, points.csv, figures, and config.toml with all defaults. It must be new or empty, or
    /// have a run of the same configuration
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace another run in DIR; files that symplint did not write are never replaced
    #[arg(long, requires = "out")]
    pub force: bool,
    /// The rest.
    #[command(flatten)]
    pub shown: OutputArgs,
}

/// Output on the terminal, and the number of threads.
#[derive(Args, Clone)]
pub struct OutputArgs {
    /// Print the report as JSON on standard output, and nothing else
    #[arg(long)]
    pub json: bool,
    /// No progress bar; print only the headline of the verdict, or the last lines of a trace
    #[arg(short, long)]
    pub quiet: bool,
    /// Print every row of the table and every finding
    #[arg(long)]
    pub all: bool,
    /// Number of threads; all cores by default. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = at_least_one, allow_negative_numbers = true)]
    pub threads: Option<usize>,
}

/// A number, as in a configuration.
fn number(text: &str) -> Result<f64, String> {
    (parse_number(text).filter(|value| value.is_finite()))
        .ok_or_else(|| "give a finite number such as 0.1, 2^-3 or 2*pi".to_owned())
}

/// A whole number, as in a configuration.
fn whole(text: &str) -> Result<usize, String> {
    /// Doubles represent every whole number up to this one.
    const MAX_WHOLE_NUMBER: f64 = (1_u64 << 53) as f64;
    (parse_number(text)
        .filter(|value| value.fract() == 0.0 && (0.0..=MAX_WHOLE_NUMBER).contains(value)))
    .map(|value| value as usize)
    .ok_or_else(|| "give a whole number such as 1000, 1e3 or 2^10".to_owned())
}

/// A whole number above 0.
fn at_least_one(text: &str) -> Result<usize, String> {
    match whole(text)? {
        0 => Err("give a whole number of at least 1".to_owned()),
        number => Ok(number),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn whole_numbers_are_written_as_in_configurations() {
        assert_eq!(whole("16384"), Ok(16384));
        assert_eq!(whole("2^14"), Ok(16384));
        assert_eq!(whole("1e4"), Ok(10000));
        assert_eq!(whole("0"), Ok(0));
        assert_eq!(at_least_one("2^0"), Ok(1));
        for text in ["", "x", "0.5", "-1", "nan", "inf", "2^64", "1e400"] {
            assert!(whole(text).is_err(), "{text}");
        }
        assert!(at_least_one("0").is_err());
        assert_eq!(number("-pi/2"), Ok(-std::f64::consts::FRAC_PI_2));
        for text in ["nan", "inf", "1e400", "1 2", "0x10"] {
            assert!(number(text).is_err(), "{text}");
        }
    }
}
