//! Diagnoses of maps of a few operations, some of which jump, fail, remember, or return what is not a number.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use arbitrary::{Result, Unstructured};
use symplint::diagnosis::{SampleCount, SampleSweep};
use symplint::rules::{Closure, Cutoffs, Piecewise, Streaming};
use symplint::{Circle, Coordinates, Diagnostic, FourierLoop, Loop, PerSample, Rule};

use crate::numbers;
use crate::verdicts::{judge_and_write, read_again};

/// Evaluations at most: a diagnosis takes some milliseconds.
const MAX_EVALUATIONS: usize = 3000;

/// Diagnoses a map that the bytes describe. It is not evaluated more often than the budget says, and the report leads to
/// the same verdict.
pub fn check(data: &[u8]) {
    let _ = diagnose(&mut Unstructured::new(data));
}

fn diagnose(u: &mut Unstructured<'_>) -> Result<()> {
    let dof = u.int_in_range(1..=2)?;
    let diagnostic = diagnostic(u)?;
    let Some(phase_loop) = phase_loop(u, dof)? else {
        return Ok(());
    };
    let coordinates = coordinates(u, dof)?;
    let count = u.int_in_range(1..=5)?;
    let operations: Vec<Operation> = (0..count)
        .map(|_| Operation::of(u, dof))
        .collect::<Result<_>>()?;
    let (evaluations, memory) = (AtomicUsize::new(0), AtomicU64::new(0));
    let map = PerSample::new(dof, |h, q: &mut [f64], p: &mut [f64]| {
        evaluations.fetch_add(1, Ordering::Relaxed);
        (operations.iter()).try_for_each(|operation| operation.apply(h, q, p, &memory))
    });
    let map = (map.with_coordinates(coordinates)).expect("they are of its degrees of freedom");
    let diagnosis = diagnostic.run(&map, &*phase_loop);
    let made = evaluations.into_inner();
    let budget = diagnostic.budget.unwrap_or(usize::MAX);
    assert!(made <= budget, "{made} evaluations of {budget}");
    match diagnosis {
        Ok(diagnosis) => {
            let diagnosis = judge_and_write(diagnosis.evidence);
            let evidence = read_again(&diagnosis.evidence).unwrap_or_else(|error| {
                panic!("{error}\n{:#?}", diagnosis.evidence);
            });
            assert_eq!(evidence, diagnosis.evidence);
        }
        Err(error) => drop(error.to_string()),
    }
    Ok(())
}

/// One substep: a change of one coordinate by a function of another.
struct Operation {
    function: Function,
    /// Which coordinate is read and which is changed; positions first.
    from: usize,
    to: usize,
    factor: f64,
    /// Whether the change is proportional to h.
    of_step: bool,
    replaces: bool,
}

#[derive(Clone, Copy)]
enum Function {
    Identity,
    Sine,
    Floor,
    Sign,
    Inverse,
    Root,
    Cube,
    Exponential,
    Single,
    /// Not a number where the coordinate is larger than 1.
    NotANumber,
    /// Fails where the coordinate is larger than 1.
    Failure,
    /// How often it was called.
    Memory,
}

impl Operation {
    fn of(u: &mut Unstructured<'_>, dof: usize) -> Result<Self> {
        let kicks = u.ratio(3, 4)?;
        let i = u.choose_index(dof)?;
        let (from, to) = match (kicks, u.arbitrary()?) {
            (true, true) => (i, i + dof),
            (true, false) => (i + dof, i),
            _ => (u.choose_index(2 * dof)?, u.choose_index(2 * dof)?),
        };
        Ok(Operation {
            function: Function::of(u)?,
            from,
            to,
            factor: numbers::rarely_any(u)?,
            of_step: u.ratio(7, 8)?,
            replaces: u.ratio(1, 16)?,
        })
    }

    fn apply(
        &self,
        h: f64,
        q: &mut [f64],
        p: &mut [f64],
        memory: &AtomicU64,
    ) -> std::result::Result<(), &'static str> {
        let dof = q.len();
        let x = match self.from < dof {
            true => q[self.from],
            false => p[self.from - dof],
        };
        let value = match self.function {
            Function::Identity => x,
            Function::Sine => x.sin(),
            Function::Floor => x.floor(),
            Function::Sign => x.signum(),
            Function::Inverse => 1.0 / x,
            Function::Root => x.sqrt(),
            Function::Cube => x * x * x,
            Function::Exponential => x.exp(),
            Function::Single => f64::from(x as f32) - x,
            Function::NotANumber if x > 1.0 => f64::NAN,
            Function::Failure if x > 1.0 => return Err("the coordinate is larger than 1"),
            Function::NotANumber | Function::Failure => x,
            Function::Memory => memory.fetch_add(1, Ordering::Relaxed) as f64,
        };
        let change = match self.of_step {
            true => h * self.factor * value,
            false => self.factor * value,
        };
        let target = match self.to < dof {
            true => &mut q[self.to],
            false => &mut p[self.to - dof],
        };
        *target = match self.replaces {
            true => change,
            false => *target + change,
        };
        Ok(())
    }
}

impl Function {
    fn of(u: &mut Unstructured<'_>) -> Result<Self> {
        Ok(*u.choose(&[
            Function::Identity,
            Function::Sine,
            Function::Identity,
            Function::Sine,
            Function::Floor,
            Function::Sign,
            Function::Inverse,
            Function::Root,
            Function::Cube,
            Function::Exponential,
            Function::Single,
            Function::NotANumber,
            Function::Failure,
            Function::Memory,
        ])?)
    }
}

fn diagnostic(u: &mut Unstructured<'_>) -> Result<Diagnostic> {
    let piecewise = Piecewise {
        tolerance: match u.arbitrary()? {
            true => 1e-12,
            false => numbers::any(u)?,
        },
        closure: *u.choose(&[Closure::Substeps, Closure::Chords])?,
        pieces: u.int_in_range(0..=9)?,
        most_evaluations: u.int_in_range(0..=2 * MAX_EVALUATIONS)?,
    };
    let streaming = Streaming {
        half_width: u.int_in_range(0..=18)?,
    };
    let rule = match u.int_in_range(0..=5)? {
        0 => Rule::Pseudospectral,
        1 => Rule::FiniteDifference(Cutoffs::relative(numbers::any(u)?)),
        2 => Rule::Piecewise(piecewise),
        3 => Rule::Streaming(streaming),
        _ => Rule::Auto,
    };
    let steps = u.int_in_range(0..=3)?;
    let step_sizes = (0..steps)
        .map(|_| numbers::rarely_any(u))
        .collect::<Result<_>>()?;
    let typical_step = match u.ratio(1, 4)? {
        true => Some(numbers::rarely_any(u)?),
        false => None,
    };
    let sample_sweep = match u.ratio(1, 8)? {
        true => Some(SampleSweep {
            counts: vec![u.int_in_range(0..=64)?, 64],
            step_size: numbers::rarely_any(u)?,
        }),
        false => None,
    };
    Ok(Diagnostic {
        rule,
        piecewise,
        streaming,
        samples: match u.arbitrary()? {
            true => SampleCount::Auto,
            false => SampleCount::Fixed(u.int_in_range(0..=300)?),
        },
        step_sizes,
        typical_step,
        sample_sweep,
        loops: u.int_in_range(0..=3)?,
        seed: u.arbitrary()?,
        project: u.arbitrary()?,
        long_time: match u.ratio(1, 4)? {
            true => u.int_in_range(0..=50)?,
            false => 0,
        },
        localise: u.arbitrary()?,
        jacobian: u.arbitrary()?,
        properties: u.arbitrary()?,
        reversal: match u.ratio(1, 8)? {
            true => Some(numbers::several(u, 6)?),
            false => None,
        },
        symmetric: u.arbitrary()?,
        budget: Some(u.int_in_range(0..=MAX_EVALUATIONS)?),
        has_step_size: !u.ratio(1, 8)?,
        repeat: match u.ratio(1, 8)? {
            true => u.int_in_range(0..=3)?,
            false => 1,
        },
        order: match u.ratio(1, 8)? {
            true => Some(u.int_in_range(0..=9)?),
            false => None,
        },
    })
}

fn phase_loop(u: &mut Unstructured<'_>, dof: usize) -> Result<Option<Box<dyn Loop>>> {
    let several = |u: &mut Unstructured<'_>| -> Result<Vec<f64>> {
        (0..dof).map(|_| numbers::rarely_any(u)).collect()
    };
    let (q, p) = (several(u)?, several(u)?);
    let radius: Vec<f64> = several(u)?.into_iter().map(f64::abs).collect();
    let circle = |q, p| Circle::with_radii(q, p, radius.clone(), radius.clone());
    Ok(match u.arbitrary()? {
        true => (circle(q, p).ok()).map(|circle| Box::new(circle) as Box<dyn Loop>),
        false => (FourierLoop::random(q, p, &radius, &radius, u.arbitrary()?).ok())
            .map(|random| Box::new(random) as Box<dyn Loop>),
    })
}

fn coordinates(u: &mut Unstructured<'_>, dof: usize) -> Result<Coordinates> {
    let plain = Coordinates::plain(dof);
    if u.ratio(2, 3)? {
        return Ok(plain);
    }
    let periods = (0..dof)
        .map(|_| Ok(numbers::rarely_any(u)?.abs()))
        .collect::<Result<Vec<f64>>>()?;
    let with = match u.arbitrary()? {
        true => plain.clone().with_periods(periods),
        false => plain.clone().with_momentum_periods(periods),
    };
    Ok(with.unwrap_or(plain))
}
