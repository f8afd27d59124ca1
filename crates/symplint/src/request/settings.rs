//! The table of settings.

use super::{MAX_WHOLE_NUMBER, NumberRange, Refusal, Setting, Value};
use crate::diagnosis::{Diagnostic, MAX_LOOPS, MIN_BUDGET, SampleCount, SampleSweep};
use crate::rules::{Closure, Cutoff, Cutoffs, Rule, RuleKind, Streaming};

/// Halvings of the step size at most: from 1 they reach far below round-off.
const MAX_HALVINGS: usize = 64;

/// Samples of one loop at most. An ensemble of them takes 4 GiB for each degree of freedom.
pub const MAX_SAMPLES: u64 = 1 << 28;

/// The map is composed with itself at most this number of times.
const MAX_REPEATS: u64 = 1_000_000;

/// Steps of a long-time run at most.
const MAX_STEPS: u64 = 100_000_000;

/// Order of a method at most: composition and extrapolation reach a few tens.
const MAX_ORDER: u64 = 100;

/// Every setting of a diagnosis. They are read in this order.
pub const SETTINGS: &[Setting] = &[
    with_default(
        "rule",
        "\"auto\"",
        "\"auto\", \"pseudospectral\", \"finite-difference\", \"piecewise\" or \"streaming\"",
        |of, value| rule(value).map(|rule| of.rule = rule),
    ),
    optional(
        "step_size",
        "0.1",
        "a typical step size, instead of step_sizes: symplint finds a large step size from it, and also tests its halves",
        typical_step,
    ),
    Setting {
        keys: &["from", "to"],
        ..with_default(
            "step_sizes",
            "{ from = \"2^-1\", to = \"2^-10\" }",
            "halved from … to …, or a list; random loops use the largest; \"auto\" needs step_size; \"none\" for a map without a step size",
            step_sizes,
        )
    },
    with_default(
        "repeat",
        "1",
        "the map is composed with itself this number of times",
        |of, value| (value.whole(1, MAX_REPEATS)).map(|count| of.repeat = count as usize),
    ),
    with_default(
        "samples",
        "\"auto\"",
        "samples of the loop: \"auto\", or a number from 3",
        |of, value| {
            let count = value.whole_or_auto(3, MAX_SAMPLES)?;
            let fixed = |count| SampleCount::Fixed(count as usize);
            of.samples = count.map_or(SampleCount::Auto, fixed);
            Ok(())
        },
    ),
    with_default(
        "budget",
        "\"auto\"",
        "largest number of evaluations (states advanced by one step): \"auto\", or a number from 200",
        |of, value| {
            let budget = value.whole_or_auto(MIN_BUDGET as u64, MAX_WHOLE_NUMBER)?;
            of.budget = budget.map(|budget| budget as usize);
            Ok(())
        },
    ),
    with_default(
        "tolerance",
        "1e-12",
        "tolerance of the piecewise rule, relative to the size of the loop",
        |of, value| {
            (value.number(NumberRange::Positive)).map(|relative| of.piecewise.tolerance = relative)
        },
    ),
    with_default(
        "closure",
        "\"substeps\"",
        "how the piecewise rule closes breaks: in the substep that causes them, or by \"chords\"",
        |of, value| closure(value).map(|closure| of.piecewise.closure = closure),
    ),
    with_default(
        "half_width",
        "10",
        "m of the streaming rule, 8 to 16: its differences of order 2m use m samples on either side",
        |of, value| {
            let (least, most) = (
                Streaming::MIN_HALF_WIDTH as u64,
                Streaming::MAX_HALF_WIDTH as u64,
            );
            (value.whole(least, most)).map(|width| of.streaming.half_width = width as usize)
        },
    ),
    Setting {
        keys: &["from", "to", "step_size"],
        ..optional(
            "sample_sweep",
            "{ from = \"2^6\", to = \"2^15\", step_size = 0.1 }",
            "also vary the number of samples, doubled from … to …, at this step size",
            |of, value| sample_sweep(value).map(|sweep| of.sample_sweep = Some(sweep)),
        )
    },
    with_default(
        "cutoff_q",
        "1000.0",
        "λ_q: the finite-difference rule omits cells with |dq/ds| > λ_q max|q|",
        |of, value| cutoff(of, value, Cutoff::Relative, |of| &mut of.q),
    ),
    with_default("cutoff_p", "1000.0", "λ_p: the same for p", |of, value| {
        cutoff(of, value, Cutoff::Relative, |of| &mut of.p)
    }),
    optional(
        "cutoff_q_absolute",
        "100.0",
        "τ_q: the rule omits cells with |dq/ds| > τ_q, instead of cutoff_q",
        |of, value| cutoff(of, value, Cutoff::Absolute, |of| &mut of.q),
    ),
    optional(
        "cutoff_p_absolute",
        "100.0",
        "τ_p: the same for p",
        |of, value| cutoff(of, value, Cutoff::Absolute, |of| &mut of.p),
    ),
    with_default(
        "loops",
        "8",
        "number of loops; all after the first are random, and use the largest step size",
        |of, value| (value.whole(1, MAX_LOOPS as u64)).map(|count| of.loops = count as usize),
    ),
    with_default("seed", "1", "seed of the random loops", |of, value| {
        value.whole(0, u64::MAX).map(|seed| of.seed = seed)
    }),
    with_default(
        "project",
        "true",
        "whether random loops stay on the constraint manifold of systems that have one",
        |of, value| value.flag().map(|flag| of.project = flag),
    ),
    with_default(
        "steps",
        "0",
        "the loop is also followed for this number of steps of the largest size, to test whether a defect accumulates",
        |of, value| (value.whole(0, MAX_STEPS)).map(|count| of.long_time = count as usize),
    ),
    optional(
        "order",
        "2",
        "order of the method, if you know it: the report then names a defect that this order does not explain",
        |of, value| (value.whole(1, MAX_ORDER)).map(|order| of.order = Some(order as usize)),
    ),
    with_default(
        "jacobian",
        "true",
        "whether the Jacobian of one step is also tested; if not, it is tested at one point, \
         and only if a loop integral changes",
        |of, value| value.flag().map(|flag| of.jacobian = flag),
    ),
    with_default(
        "properties",
        "true",
        "whether volume, time reversal and other properties are also tested",
        |of, value| value.flag().map(|flag| of.properties = flag),
    ),
    optional(
        "reversal",
        "[1.0, -1.0]",
        "signs of q, then of p, that reverse time; by default, the signs of all p change",
        |of, value| {
            let signs = value.list(|sign| sign.number(NumberRange::Finite))?;
            of.reversal = Some(signs);
            Ok(())
        },
    ),
    with_default(
        "symmetric",
        "false",
        "whether to test that a step of size -h undoes a step of size h; the map must accept negative step sizes",
        |of, value| value.flag().map(|flag| of.symmetric = flag),
    ),
    with_default(
        "localise",
        "true",
        "whether a defect is traced to a substep of the map and to a part of the loop",
        |of, value| value.flag().map(|flag| of.localise = flag),
    ),
];

/// Reads a value into a diagnostic.
type Setter = fn(&mut Diagnostic, &Value) -> Result<(), Refusal>;

const fn with_default(
    name: &'static str,
    value: &'static str,
    help: &'static str,
    set: Setter,
) -> Setting {
    Setting {
        name,
        value,
        is_optional: false,
        keys: &[],
        help,
        set,
    }
}

const fn optional(
    name: &'static str,
    example: &'static str,
    help: &'static str,
    set: Setter,
) -> Setting {
    Setting {
        is_optional: true,
        ..with_default(name, example, help, set)
    }
}

fn rule(value: &Value) -> Result<Rule, Refusal> {
    let name = value.text()?;
    Rule::named(name).ok_or_else(|| {
        let known: Vec<String> = (RuleKind::CHOICES.iter())
            .map(|kind| format!("\"{kind}\""))
            .collect();
        let remedy = format!("give one of {}", known.join(", "));
        Refusal::new(format!("is \"{name}\""), remedy)
    })
}

fn closure(value: &Value) -> Result<Closure, Refusal> {
    match value.text()? {
        "substeps" => Ok(Closure::Substeps),
        "chords" => Ok(Closure::Chords),
        other => Err(Refusal::new(
            format!("is \"{other}\""),
            "give \"substeps\" or \"chords\"",
        )),
    }
}

/// Sets one cut-off, if the rule has any.
fn cutoff(
    diagnostic: &mut Diagnostic,
    value: &Value,
    kind: fn(f64) -> Cutoff,
    of: fn(&mut Cutoffs) -> &mut Cutoff,
) -> Result<(), Refusal> {
    let cutoff = kind(value.number(NumberRange::Positive)?);
    if let Rule::FiniteDifference(cutoffs) = &mut diagnostic.rule {
        *of(cutoffs) = cutoff;
    }
    Ok(())
}

fn typical_step(diagnostic: &mut Diagnostic, value: &Value) -> Result<(), Refusal> {
    diagnostic.typical_step = Some(value.number(NumberRange::NotZero)?);
    diagnostic.step_sizes = Vec::new();
    Ok(())
}

fn step_sizes(diagnostic: &mut Diagnostic, value: &Value) -> Result<(), Refusal> {
    let is_typical = diagnostic.typical_step.is_some();
    if matches!(value, Value::Text(text) if text == "auto") {
        return match is_typical {
            true => Ok(()),
            false => Err(Refusal::new(
                "is \"auto\", which needs a typical step size to begin with",
                "give `step_size = …`, the h that you compute with",
            )),
        };
    }
    if is_typical {
        return Err(Refusal::new(
            "is given together with step_size, a typical one from which step sizes are found",
            "leave one of the two out",
        ));
    }
    let one = |item: &Value| item.number(NumberRange::NotZero);
    diagnostic.step_sizes = match value {
        Value::Text(text) if text == "none" => {
            diagnostic.has_step_size = false;
            // The argument h of a map without a step size.
            vec![1.0]
        }
        Value::List(_) => value.list(one)?,
        Value::Table(_) => halved(value)?,
        _ => vec![one(value)?],
    };
    let sizes = &diagnostic.step_sizes;
    if sizes.is_empty() {
        let remedy = "give one step size or more";
        return Err(Refusal::new("is an empty list", remedy));
    }
    if let Some(k) = (0..sizes.len()).find(|&k| sizes[..k].contains(&sizes[k])) {
        let message = format!("repeats {}", sizes[k]);
        return Err(Refusal {
            part: Some(super::ValuePart::Item(k)),
            ..Refusal::new(message, "give each step size once")
        });
    }
    Ok(())
}

/// Step sizes halved from the value of `from` down to `to`, which may be rounded.
fn halved(value: &Value) -> Result<Vec<f64>, Refusal> {
    let one = |name| {
        let missing = || Refusal::new(format!("has no `{name}`"), "write { from = …, to = … }");
        let size = value.key(name, |item| item.number(NumberRange::Positive))?;
        size.ok_or_else(missing)
    };
    let (from, to) = (one("from")?, one("to")?);
    // One step size more than allowed shows that there are too many.
    let sizes: Vec<f64> = (0..=MAX_HALVINGS + 1)
        .map(|m| from * 0.5f64.powi(m as i32))
        .take_while(|&h| h >= to * (1.0 - 1e-9))
        .collect();
    if sizes.is_empty() {
        return Err(Refusal::new(
            format!("goes from {from} to {to}"),
            "step sizes are halved: let `from` be the larger one",
        ));
    }
    if sizes.len() > MAX_HALVINGS + 1 {
        return Err(Refusal::new(
            format!("from {from} to {to} takes more than {MAX_HALVINGS} halvings"),
            format!("give a range of at most {MAX_HALVINGS} halvings"),
        ));
    }
    Ok(sizes)
}

fn sample_sweep(value: &Value) -> Result<SampleSweep, Refusal> {
    let whole = |name, default| {
        let count = value.key(name, |item| item.whole(3, MAX_SAMPLES))?;
        Ok::<u64, Refusal>(count.unwrap_or(default))
    };
    let (from, to) = (whole("from", 1 << 6)?, whole("to", 1 << 15)?);
    let counts: Vec<usize> = std::iter::successors(Some(from), |&count| Some(2 * count))
        .take_while(|&count| count <= to)
        .map(|count| count as usize)
        .collect();
    if counts.is_empty() {
        return Err(Refusal::new(
            format!("goes from {from} to {to}"),
            "numbers of samples are doubled: let `to` be the larger one",
        ));
    }
    let step_size = value.key("step_size", |item| item.number(NumberRange::Positive))?;
    Ok(SampleSweep {
        counts,
        step_size: step_size.unwrap_or(0.1),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn read(name: &str, value: Value) -> Result<Diagnostic, String> {
        let settings = BTreeMap::from([(name.to_owned(), value)]);
        Diagnostic::from_settings(&settings).map_err(|error| error.to_string())
    }

    #[test]
    fn names_are_distinct_and_the_rule_names_all_choices() {
        for (k, setting) in SETTINGS.iter().enumerate() {
            assert!(SETTINGS[..k].iter().all(|other| other.name != setting.name));
        }
        for kind in RuleKind::CHOICES {
            assert!(SETTINGS[0].help.contains(&format!("\"{kind}\"")), "{kind}");
            assert_eq!(Rule::named(kind.name()).map(|rule| rule.kind()), Some(kind));
        }
    }

    #[test]
    fn step_sizes_are_halved_listed_or_searched_for() {
        let table = |from: f64, to: f64| {
            let key = |name: &str, value| (name.to_owned(), Value::Number(value));
            Value::Table(BTreeMap::from([key("from", from), key("to", to)]))
        };
        let found = read("step_sizes", table(1.0, 0.3)).unwrap();
        assert_eq!(found.step_sizes, [1.0, 0.5]);
        assert_eq!(
            read("step_sizes", table(0.1, 0.2)).unwrap_err(),
            "step_sizes goes from 0.1 to 0.2; step sizes are halved: let `from` be the larger one"
        );
        let found = read("step_size", Value::Number(0.1)).unwrap();
        assert_eq!((found.step_sizes, found.typical_step), (vec![], Some(0.1)));
        assert!(read("step_sizes", Value::Text("auto".into())).is_err());
        let found = read("step_sizes", Value::Text("none".into())).unwrap();
        assert!(!found.has_step_size);
        let twice = Value::List(vec![Value::Number(0.5); 2]);
        assert_eq!(
            read("step_sizes", twice).unwrap_err(),
            "step_sizes[1] repeats 0.5; give each step size once"
        );
    }

    #[test]
    fn settings_of_a_rule_reach_the_rule_that_is_named() {
        let text = r#"{"rule": "piecewise", "tolerance": 1e-9, "cutoff_q": 7}"#;
        let settings = serde_json::from_str(text).unwrap();
        let found = Diagnostic::from_settings(&settings).unwrap();
        assert!(matches!(found.rule, Rule::Piecewise(rule) if rule.tolerance == 1e-9));
        let text = r#"{"rule": "finite-difference", "cutoff_q": 7, "cutoff_p_absolute": 5}"#;
        let settings = serde_json::from_str(text).unwrap();
        let found = Diagnostic::from_settings(&settings).unwrap();
        let cutoffs = Cutoffs {
            q: Cutoff::Relative(7.0),
            p: Cutoff::Absolute(5.0),
        };
        assert_eq!(found.rule, Rule::FiniteDifference(cutoffs));
    }

    #[test]
    fn unknown_names_are_refused() {
        let error = read("sampels", Value::Whole(4)).unwrap_err();
        assert!(error.starts_with("unknown setting \"sampels\"; available: rule, "));
    }
}
