//! The command line.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Tells whether a time-advance map is symplectic.
///
/// A closed loop of initial states is sent through one step of the map, and the Poincaré loop integral
/// ∮ p·dq is compared before and after, while the step size and the number of samples vary.
#[derive(Parser)]
#[command(version, max_term_width = 100, after_help = AFTER)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Options of every command that measures.
    #[command(flatten)]
    pub common: Common,
}

const AFTER: &str = "Examples:
  symplint init pendulum > pendulum.toml          a commented configuration to start from
  symplint check pendulum.toml                    is it symplectic?
  symplint check pendulum.toml --set integrator.name=rk2 --out run
  symplint loop pendulum.toml -o before.npz       initial states for another code
  symplint measure before.npz after.npz           what its step did to them
  symplint reproduce fig2                         a figure of the paper

Exit status of `check` and `measure`: 0 symplectic, 1 not symplectic or loops broken, 2 bad usage, bad input or a \
failed run, 3 undecided.";

/// What to do.
#[derive(Subcommand)]
pub enum Command {
    /// Full diagnosis of a configuration: sweeps, verdict, figures.
    ///
    /// Sweeps the step size (and, if asked for, the number of samples), tries further random loops at the
    /// largest step size, and gives a verdict. With --out DIR everything measured is written there.
    Check {
        /// The configuration; `symplint init SYSTEM` prints one to start from.
        config: PathBuf,
        /// Take N steps of the largest size, too, and see whether the defect adds up or returns
        #[arg(long, value_name = "N")]
        steps: Option<usize>,
    },
    /// Write the samples of a configured loop, for another code to advance.
    ///
    /// Row k of the arrays q and p, of shape (samples, dof), is the state at s = k/samples. Advance every row
    /// by one step, store the arrays in the same way, and give both files to `symplint measure`.
    Loop {
        /// The configuration; its integrator is not used.
        config: PathBuf,
        /// Samples of the loop; diagnostic.samples if left out, or 256 where that is "auto"
        #[arg(long, value_name = "N")]
        samples: Option<usize>,
        /// File to write, `loop.npz` if left out (in DIR, if --out names one): .npz holds q and p, and
        /// period and weight where there are any; .npy is a pair, loop_q.npy and loop_p.npy; .csv has
        /// columns q_0, q_1, …, p_0, p_1, …
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Defect and verdict of a loop that another code advanced.
    ///
    /// Compares the file before the step with one or more files after it, each advanced from BEFORE by one
    /// step. Files are as `symplint loop` writes them; an .npz file may also hold `h`, `period` (for each
    /// position, 0 if it is not periodic) and `weight` (canonical momentum = weight × p). What is said here
    /// goes before what the files say. Samples alone cannot prove that a loop is broken, but show it.
    Measure {
        /// The loop before the step: .npz, .npy (loop_q.npy stands for the pair with loop_p.npy) or .csv.
        before: PathBuf,
        /// The loop after one step; several files for several step sizes.
        #[arg(required = true)]
        after: Vec<PathBuf>,
        /// Step sizes of the files after the step, in their order; without any, no order is fitted
        #[arg(
            long = "h",
            value_name = "H",
            value_delimiter = ',',
            allow_hyphen_values = true
        )]
        h: Vec<String>,
        /// Period of the positions, 0 for none: one number, or one for each degree of freedom
        #[arg(long, value_name = "L", value_delimiter = ',')]
        period: Vec<String>,
        /// Weight of the momenta: one number, or one for each degree of freedom
        #[arg(
            long,
            value_name = "W",
            value_delimiter = ',',
            allow_hyphen_values = true
        )]
        weight: Vec<String>,
    },
    /// Loop integral and energy against time.
    ///
    /// Takes trace.steps steps of size trace.step_size and follows the loop integral, and the
    /// energy of the orbit that starts at the centre of the loop. By the pseudospectral rule, or finite
    /// differences; the others are refused.
    Trace {
        /// The configuration; `symplint init SYSTEM` prints one to start from.
        config: PathBuf,
    },
    /// The paper: its figures and closed forms, with the claims they bear out.
    ///
    /// Writes figures (SVG, PNG), data (CSV) and the judged claims into one folder, `symplint-paper`
    /// unless --out names another. --set changes the settings of a single item.
    Reproduce {
        /// Which items; all if none is named. `symplint list figures` shows them.
        ids: Vec<String>,
        /// Only show the items with their cost.
        #[arg(long)]
        list: bool,
    },
    /// What there is to choose from.
    ///
    /// Measures nothing, and refuses --set, --out, --json and --quiet.
    List {
        /// Of what.
        what: What,
    },
    /// Print a commented starter configuration.
    ///
    /// Measures nothing, and refuses --set, --out, --json and --quiet.
    Init {
        /// The system; `symplint list systems` shows them.
        system: String,
    },
}

/// What can be listed.
#[derive(Clone, Copy, ValueEnum)]
pub enum What {
    /// Hamiltonians.
    Systems,
    /// Time-advance maps.
    Integrators,
    /// Rules for the loop integral.
    Rules,
    /// Items of `reproduce`.
    Figures,
}

/// Options of every command that measures.
#[derive(Args)]
pub struct Common {
    /// Change a key of the configuration, such as integrator.name=rk2 (repeatable)
    #[arg(long, value_name = "KEY=VALUE", global = true)]
    pub set: Vec<String>,
    /// Run folder: report.json, points.csv, figures/, config.toml as resolved
    #[arg(long, value_name = "DIR", global = true)]
    pub out: Option<PathBuf>,
    /// Print the report as JSON on standard output, and nothing else there
    #[arg(long, global = true)]
    pub json: bool,
    /// Number of threads; all cores if left out. Results do not depend on it
    #[arg(long, value_name = "N", global = true)]
    pub threads: Option<NonZeroUsize>,
    /// No progress bars and no tables; only the verdict
    #[arg(long, global = true)]
    pub quiet: bool,
}
