//! `[diagnostic]`: what `check` measures.

use symplint::Diagnostic;
use symplint::diagnosis::{MOST_LOOPS, SampleCount, SampleSweep};
use symplint::rules::{Closure, Cutoff, Cutoffs, Piecewise, Streaming};

use super::document::{Node, Value};
use super::error::ConfigError;
use super::rules::{RULES, RuleSettings};
use super::section::{Accept, Key, MOST_WHOLE, Section, read_number};

/// The keys of `[diagnostic]`.
pub const KEYS: &[Key] = &[
    Key::new(
        "rule",
        "\"auto\"",
        "\"auto\", \"pseudospectral\", \"finite-difference\", \"piecewise\" or \"streaming\"",
    ),
    Key::new(
        "step_sizes",
        "{ from = \"2^-1\", to = \"2^-10\" }",
        "halved from … to …, or a list, or \"auto\"; the largest matters most to the verdict; \"none\" for a map that is no step in time",
    ),
    Key::optional(
        "step_size",
        "0.1",
        "a typical h, for step_sizes = \"auto\": from it the largest is found that tests something",
    ),
    Key::new(
        "repeat",
        "1",
        "the map is composed with itself this number of times",
    ),
    Key::new(
        "samples",
        "\"auto\"",
        "samples of the loop: \"auto\", or a number from 3",
    ),
    Key::new(
        "budget",
        "\"auto\"",
        "most evaluations, states advanced by one step: \"auto\", or a number from 200",
    ),
    Key::new(
        "tolerance",
        "1e-12",
        "tolerance of the piecewise rule, relative to the size of the loop",
    ),
    Key::new(
        "closure",
        "\"substeps\"",
        "how the piecewise rule closes breaks: in the substep that causes them, or by \"chords\"",
    ),
    Key::new(
        "half_width",
        "10",
        "m of the streaming rule, 8 to 16: differences of order 2m use m samples on either side",
    ),
    Key::optional(
        "sample_sweep",
        "{ from = \"2^6\", to = \"2^15\", step_size = 0.1 }",
        "numbers of samples, doubled from … to …; without that sweep if left out",
    ),
    Key::new(
        "cutoff_q",
        "1000.0",
        "λ_q: the finite-difference rule omits cells where |dq/ds| > λ_q max|q|",
    ),
    Key::new("cutoff_p", "1000.0", "λ_p: the same for p"),
    Key::optional(
        "cutoff_q_absolute",
        "100.0",
        "τ_q: omits cells where |dq/ds| > τ_q, in place of cutoff_q",
    ),
    Key::optional("cutoff_p_absolute", "100.0", "τ_p: the same for p"),
    Key::new(
        "loops",
        "8",
        "number of loops; those after the first are random, and use the largest step size",
    ),
    Key::new("seed", "1", "seed of the random loops"),
    Key::new(
        "project",
        "true",
        "whether random loops keep to the constraint manifold of systems that have one",
    ),
    Key::new(
        "steps",
        "0",
        "number of steps of the largest size, to see whether a defect accumulates; 0 for none",
    ),
    Key::new(
        "jacobian",
        "true",
        "whether the Jacobian of one step is also checked",
    ),
    Key::new(
        "properties",
        "true",
        "whether volume, time reversal and other properties are also tested",
    ),
    Key::optional(
        "reversal",
        "[1.0, -1.0]",
        "signs of q, then of p, that reverse time; without them, those of all p change",
    ),
    Key::new(
        "symmetric",
        "false",
        "whether a step of size -h is tested to undo one of size h; the map must take negative step sizes",
    ),
    Key::new(
        "localise",
        "true",
        "whether a defect is traced to a substep of the map and to a part of the loop",
    ),
];

const FROM_TO: [Key; 2] = [
    Key::optional("from", "\"2^-1\"", "largest step size"),
    Key::optional("to", "\"2^-10\"", "smallest step size"),
];

const SAMPLE_SWEEP: [Key; 3] = [
    Key::new("from", "\"2^6\"", "fewest samples"),
    Key::new("to", "\"2^15\"", "most samples"),
    Key::new("step_size", "0.1", "h"),
];

/// Halvings of the step size at most: from 1 they reach far below round-off.
const LONGEST: usize = 64;

/// Samples of one loop at most. An ensemble of them takes 4 GiB for each degree of freedom.
pub const MOST_SAMPLES: u64 = 1 << 28;

/// The map is composed with itself at most this number of times.
const MOST_REPEATS: u64 = 1_000_000;

/// Steps of a long-time run at most.
const MOST_STEPS: u64 = 100_000_000;

/// The smallest budget that is accepted: one loop and the checks of the map take nearly as many evaluations.
const LEAST_BUDGET: u64 = 200;

/// Reads `[diagnostic]`.
pub fn read(node: Option<&Node>) -> Result<(Diagnostic, Section), ConfigError> {
    let section = Section::new("diagnostic", node, KEYS.to_vec())?;
    let cutoffs = cutoffs(&section)?;
    let piecewise = Piecewise {
        tolerance: section.number("tolerance", Accept::Positive)?,
        closure: match section.choice("closure", &["substeps", "chords"])? {
            "chords" => Closure::Chords,
            _ => Closure::Substeps,
        },
        ..Piecewise::default()
    };
    let streaming = streaming(&section)?;
    let names: Vec<&str> = RULES.iter().map(|info| info.name).collect();
    let named = section.choice("rule", &names)?;
    let info = (RULES.iter().find(|info| info.name == named)).expect("the name is one of them");
    let settings = RuleSettings {
        cutoffs,
        piecewise,
        streaming,
    };
    let budget = section.whole_or_auto("budget", LEAST_BUDGET, MOST_WHOLE)?;
    let diagnostic = Diagnostic {
        rule: (info.make)(&settings),
        piecewise,
        streaming,
        samples: match section.whole_or_auto("samples", 3, MOST_SAMPLES)? {
            None => SampleCount::Auto,
            Some(count) => SampleCount::Fixed(count as usize),
        },
        typical_step: section.optional_number("step_size", Accept::Positive)?,
        has_step_size: !is_none(&section)?,
        step_sizes: step_sizes(&section)?,
        repeat: section.whole_between("repeat", 1, MOST_REPEATS)? as usize,
        sample_sweep: sample_sweep(&section)?,
        loops: section.whole_between("loops", 1, MOST_LOOPS as u64)? as usize,
        seed: section.whole("seed", 0)?,
        project: section.flag("project")?,
        jacobian: section.flag("jacobian")?,
        properties: section.flag("properties")?,
        reversal: section.optional_numbers("reversal", Accept::Finite)?,
        symmetric: section.flag("symmetric")?,
        localise: section.flag("localise")?,
        budget: budget.map(|budget| budget as usize),
        long_time: section.whole_between("steps", 0, MOST_STEPS)? as usize,
    };
    Ok((diagnostic, section))
}

fn cutoffs(section: &Section) -> Result<Cutoffs, ConfigError> {
    let cutoff = |relative: &str, absolute: &str| {
        let lambda = section.number(relative, Accept::Positive)?;
        let tau = section.optional_number(absolute, Accept::Positive)?;
        Ok(tau.map_or(Cutoff::Relative(lambda), Cutoff::Absolute))
    };
    Ok(Cutoffs {
        q: cutoff("cutoff_q", "cutoff_q_absolute")?,
        p: cutoff("cutoff_p", "cutoff_p_absolute")?,
    })
}

fn streaming(section: &Section) -> Result<Streaming, ConfigError> {
    let most = Streaming::WIDEST as u64;
    let half_width = section.whole_between("half_width", Streaming::NARROWEST as u64, most)?;
    Ok(Streaming {
        half_width: half_width as usize,
    })
}

/// Whether the map has no step size.
fn is_none(section: &Section) -> Result<bool, ConfigError> {
    let node = section.node("step_sizes")?.expect("it has a default");
    Ok(matches!(&node.value, Value::Text(text) if text == "none"))
}

fn step_sizes(section: &Section) -> Result<Vec<f64>, ConfigError> {
    let node = section.node("step_sizes")?.expect("it has a default");
    let path = "diagnostic.step_sizes";
    match &node.value {
        Value::Text(text) if text == "auto" => match section.written_place("step_size") {
            Some(_) => Ok(Vec::new()),
            None => Err(section.error(
                "step_sizes",
                "\"auto\" needs a typical step size to begin with",
                "add `step_size = …` to [diagnostic], the h that you compute with",
            )),
        },
        Value::Text(text) if text == "none" => match section.written_place("step_size") {
            // What a map without a step size is called with.
            None => Ok(vec![1.0]),
            Some(_) => Err(section.error(
                "step_size",
                "a typical step size is given, and step_sizes is \"none\"",
                "leave one of the two out",
            )),
        },
        Value::List(list) if list.is_empty() => Err(section.error(
            "step_sizes",
            "the list is empty",
            "give one step size or more",
        )),
        Value::List(list) => {
            let mut sizes: Vec<f64> = Vec::new();
            for item in list {
                let size = read_number(path, item, Accept::Positive)?;
                if sizes.contains(&size) {
                    let text = format!("{path} has {size} twice");
                    return Err(ConfigError::new(text, "give each step size once")
                        .at(&item.place, "repeated"));
                }
                sizes.push(size);
            }
            Ok(sizes)
        }
        Value::Table(_) => {
            let range = section
                .subsection("step_sizes", &FROM_TO)?
                .expect("it is a table");
            let from = range.number("from", Accept::Positive)?;
            let to = range.number("to", Accept::Positive)?;
            // Down to `to`, which may be rounded. One step size more than allowed shows that there are too many.
            let sizes: Vec<f64> = (0..=LONGEST + 1)
                .map(|m| from * 0.5f64.powi(m as i32))
                .take_while(|&h| h >= to * (1.0 - 1e-9))
                .collect();
            if sizes.is_empty() {
                let message = format!("`from` is {from}, smaller than `to`, which is {to}");
                let help = "step sizes are halved: let `from` be the larger one";
                return Err(section.error("step_sizes", message, help));
            }
            if sizes.len() > LONGEST + 1 {
                let message = format!("from {from} to {to} takes more than {LONGEST} halvings");
                let help = format!("give a range of at most {LONGEST} halvings");
                return Err(section.error("step_sizes", message, help));
            }
            Ok(sizes)
        }
        _ => Ok(vec![read_number(path, &node, Accept::Positive)?]),
    }
}

fn sample_sweep(section: &Section) -> Result<Option<SampleSweep>, ConfigError> {
    let Some(range) = section.subsection("sample_sweep", &SAMPLE_SWEEP)? else {
        return Ok(None);
    };
    let from = range.whole("from", 3)?;
    let to = range.whole("to", 3)?;
    let counts: Vec<usize> = std::iter::successors(Some(from), |&count| count.checked_mul(2))
        .take_while(|&count| count <= to.min(MOST_SAMPLES))
        .map(|count| count as usize)
        .collect();
    if counts.is_empty() {
        let (message, help) = if from > MOST_SAMPLES {
            (
                format!("`from` is {from}, which is too large"),
                "give at most 2^28",
            )
        } else {
            (
                format!("`from` is {from}, larger than `to`, which is {to}"),
                "numbers of samples are doubled: let `to` be the larger one",
            )
        };
        return Err(section.error("sample_sweep", message, help));
    }
    let step_size = range.number("step_size", Accept::Positive)?;
    section.adopt("sample_sweep", range);
    Ok(Some(SampleSweep { counts, step_size }))
}
