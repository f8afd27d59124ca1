//! `[diagnostic]`: what `check` measures.

use symplint::{
    Closure, Cutoff, Cutoffs, Diagnostic, Piecewise, Rule, RuleChoice, SampleCount, SampleSweep,
    Streaming,
};

use super::document::{Node, Value};
use super::error::ConfigError;
use super::section::{Accept, Key, Section, read_number};

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
        "halving from … to …, or a list; the verdict leans on the largest",
    ),
    Key::new(
        "samples",
        "\"auto\"",
        "samples of the loop: \"auto\", or a number from 3",
    ),
    Key::new(
        "tolerance",
        "1e-11",
        "of the piecewise rule, relative to the size of the loop",
    ),
    Key::new(
        "closure",
        "\"substeps\"",
        "how the piecewise rule closes breaks: where a substep breaks them, or by \"chords\"",
    ),
    Key::new(
        "half_width",
        "8",
        "m of the streaming rule: its differences of order 2m see m samples on either side, 8 to 16",
    ),
    Key::optional(
        "sample_sweep",
        "{ from = \"2^6\", to = \"2^15\", step_size = 0.1 }",
        "doubling from … to …; no sweep if left out",
    ),
    Key::new(
        "cutoff_q",
        "1000.0",
        "λ_q: finite differences leave out cells where |dq/ds| > λ_q max|q|",
    ),
    Key::new("cutoff_p", "1000.0", "λ_p: the same for p"),
    Key::optional(
        "cutoff_q_absolute",
        "100.0",
        "τ_q: cut-off on |dq/ds| itself, in place of cutoff_q",
    ),
    Key::optional("cutoff_p_absolute", "100.0", "τ_p: the same for p"),
    Key::new(
        "loops",
        "8",
        "loops in all; those after the first are random and tried at the largest step size",
    ),
    Key::new("seed", "1", "of the random loops"),
    Key::new(
        "steps",
        "0",
        "so many steps of the largest size, to see whether a defect adds up; 0 for none",
    ),
    Key::new(
        "stages",
        "true",
        "whether a defect is traced to a substep of the map and to a part of the loop",
    ),
];

const FROM_TO: [Key; 2] = [
    Key::optional("from", "\"2^-1\"", "the first"),
    Key::optional("to", "\"2^-10\"", "the last"),
];

const SAMPLE_SWEEP: [Key; 3] = [
    Key::new("from", "\"2^6\"", "fewest samples"),
    Key::new("to", "\"2^15\"", "most samples"),
    Key::new("step_size", "0.1", "h"),
];

/// Halvings or doublings in one sweep at most.
const LONGEST: usize = 64;

/// Samples of one loop at most: their ensemble must fit into memory many times over.
pub const MOST_SAMPLES: u64 = 1 << 28;

/// Steps of one run at most.
const MOST_STEPS: u64 = 100_000_000;

/// Loops at most: each is a run of its own.
const MOST_LOOPS: u64 = 10_000;

/// Reads `[diagnostic]`.
pub fn read(node: Option<&Node>) -> Result<(Diagnostic, Section), ConfigError> {
    let section = Section::new("diagnostic", node, KEYS.to_vec())?;
    let cutoffs = cutoffs(&section)?;
    let rules = [
        "auto",
        "pseudospectral",
        "finite-difference",
        Piecewise::NAME,
        Streaming::NAME,
    ];
    let rule = match section.choice("rule", &rules)? {
        "auto" => RuleChoice::Auto,
        "pseudospectral" => RuleChoice::Fixed(Rule::Pseudospectral),
        "finite-difference" => RuleChoice::Fixed(Rule::FiniteDifference(cutoffs)),
        Piecewise::NAME => RuleChoice::Piecewise,
        _ => RuleChoice::Streaming,
    };
    let piecewise = Piecewise {
        tolerance: section.number("tolerance", Accept::Positive)?,
        closure: match section.choice("closure", &["substeps", "chords"])? {
            "chords" => Closure::Chords,
            _ => Closure::Substeps,
        },
        ..Piecewise::default()
    };
    let diagnostic = Diagnostic {
        rule,
        piecewise,
        streaming: streaming(&section)?,
        samples: samples(&section)?,
        step_sizes: step_sizes(&section)?,
        sample_sweep: sample_sweep(&section)?,
        loops: section.whole_between("loops", 1, MOST_LOOPS)? as usize,
        seed: section.whole("seed", 0)?,
        jacobian: true,
        stages: section.flag("stages")?,
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

fn samples(section: &Section) -> Result<SampleCount, ConfigError> {
    match section.node("samples")?.map(|node| node.value) {
        Some(Value::Text(text)) if text == "auto" => Ok(SampleCount::Auto),
        _ => {
            let count = section.whole_between("samples", 3, MOST_SAMPLES)?;
            Ok(SampleCount::Fixed(count as usize))
        }
    }
}

fn step_sizes(section: &Section) -> Result<Vec<f64>, ConfigError> {
    let node = section.node("step_sizes")?.expect("it has a default");
    let path = "diagnostic.step_sizes";
    match &node.value {
        Value::List(list) if list.is_empty() => {
            Err(section.error("step_sizes", "empty", "give one step size or more"))
        }
        Value::List(list) => (list.iter())
            .map(|item| read_number(path, item, Accept::Positive))
            .collect(),
        Value::Table(_) => {
            let range = section
                .subsection("step_sizes", &FROM_TO)?
                .expect("it is a table");
            let from = range.number("from", Accept::Positive)?;
            let to = range.number("to", Accept::Positive)?;
            // Halves of `from` down to `to`, with room for rounding at the end; one more than there may be, to
            // tell.
            let sizes: Vec<f64> = (0..=LONGEST + 1)
                .map(|m| from * 0.5f64.powi(m as i32))
                .take_while(|&h| h >= to * (1.0 - 1e-9))
                .collect();
            if sizes.is_empty() || sizes.len() > LONGEST + 1 {
                return Err(section.error(
                    "step_sizes",
                    format!("from {from} by halves to {to} is no sweep"),
                    format!("let `from` be the larger one, with at most {LONGEST} halvings"),
                ));
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
        return Err(section.error(
            "sample_sweep",
            format!("from {from} by doubling to {to} is no sweep"),
            "let `to` be the larger one, and `from` at most 2^28",
        ));
    }
    let step_size = range.number("step_size", Accept::Positive)?;
    section.adopt("sample_sweep", range);
    Ok(Some(SampleSweep { counts, step_size }))
}
