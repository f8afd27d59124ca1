//! Loops that another code advanced, given by their samples.
//!
//! A map can be evaluated between the samples, data cannot. So where the samples are smooth the
//! pseudospectral rule with an error estimate from every second sample is used, and where they jump
//! (`find_jumps`) a finite-difference rule that leaves the jumps out (`pieces`); its
//! error covers that the position of a break within its cell is not known. Rows that are not equally spaced, as some were lost,
//! are interpolated in the arc length of the loop before the step (`arc_length`). No cut-off is compared with the size of
//! a coordinate: a shift of the origin
//! changes nothing.

mod arc_length;
mod compare;
mod increments;
mod order;
mod pieces;

use crate::breaks::{Break, rounding};
use crate::error::Error;
use crate::evidence::{
    ClosedBreaks, Evidence, JumpingCells, LoopBreak, LoopEvidence, LoopKind, LoopPicture, Origin,
    StepEvidence, Survey,
};
use crate::rules::RuleKind;
use crate::signal::{Extent, nearest};
use crate::state::{Coordinates, Ensemble, coordinate, each_in_parallel, period};
use compare::{InitialLoop, LoopComparison};

/// All samples of a loop at one time, as another code stored them.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The states, in the order of the loop. Equally spaced rows, sample k at s = k/N_s, give the most digits.
    pub states: Ensemble,
    /// Relative rounding error of the stored values, as a part of the largest: 2^-53 of double precision,
    /// 2^-24 of single precision, 5e-7 of seven decimal digits.
    pub unit_roundoff: f64,
    /// The size of the step that made the states, if that is known. Not zero.
    pub step_size: Option<f64>,
}

impl Snapshot {
    /// Relative rounding error of a double.
    pub const DOUBLE: f64 = f64::EPSILON / 2.0;

    /// Relative rounding error of a single precision number.
    pub const SINGLE: f64 = f32::EPSILON as f64 / 2.0;

    /// States in double precision before any step, or after one of unknown size.
    pub fn new(states: Ensemble) -> Self {
        Snapshot {
            states,
            unit_roundoff: Self::DOUBLE,
            step_size: None,
        }
    }

    /// The same after a step of size `h`.
    pub fn after_step(mut self, h: f64) -> Self {
        self.step_size = Some(h);
        self
    }

    /// The same without the last row.
    fn without_last(&self) -> Self {
        let mut states = self.states.clone();
        let samples = states.samples() - 1;
        Snapshot {
            states: states.block().copy_of(0..samples),
            ..self.clone()
        }
    }

    /// The same with another relative rounding error.
    pub fn with_unit_roundoff(mut self, unit_roundoff: f64) -> Self {
        self.unit_roundoff = unit_roundoff;
        self
    }
}

/// Compares a loop before a step with the same loop after one or several steps of different sizes, each
/// taken from `before`.
///
/// Rows may be spaced unequally, and some may be missing, the same before and after. A last row that repeats the first one is
/// left out. If the samples are smooth, the rule is pseudospectral, or piecewise if they are not equally spaced. If they jump,
/// it is [`RuleKind::JumpDetecting`]: the
/// advanced integral is then the absolutely continuous part.
///
/// # Errors
/// If the loops differ in samples or degrees of freedom, a state is not finite, there are fewer than 3
/// samples or no loop after the step, a step size is zero, not finite or stated twice, or the loop before
/// the step encloses no area.
pub fn measure_snapshots(
    before: &Snapshot,
    after: &[Snapshot],
    coordinates: &Coordinates,
) -> Result<Evidence, Error> {
    check(before, after, coordinates)?;
    let repeats = closes(before, coordinates);
    let shortened: Vec<Snapshot> = match repeats {
        true => (std::iter::once(before)
            .chain(after)
            .map(Snapshot::without_last))
        .collect(),
        false => Vec::new(),
    };
    let (before, after) = match shortened.split_first() {
        Some((before, after)) => (before, after),
        None => (before, after),
    };
    let initial = InitialLoop::new(before, coordinates)?;
    // All of them, so that the error is that of the first snapshot on any number of threads.
    let compared = each_in_parallel(after, |snapshot| initial.compare(snapshot));
    let compared: Vec<LoopComparison> = compared.into_iter().collect::<Result<_, Error>>()?;
    let samples = before.states.samples();
    let mut given = LoopEvidence::new(0, LoopKind::Given);
    given.rule = RuleKind::Pseudospectral;
    given.samples = samples;
    given.repeated_row = repeats.then_some(samples);
    given.widest_gap = initial.widest_gap();
    given.broken_before = initial.broken;
    given.wrap_before = initial.wrapped;
    let all = std::iter::once(before).chain(after);
    given.shuffled = all
        .filter_map(|snapshot| order::shuffled(&snapshot.states, coordinates))
        .reduce(f64::max);
    given.steps = (compared.iter())
        .map(|step| evidence(step, samples))
        .collect();
    let stated = std::iter::once(before)
        .chain(after)
        .map(|snapshot| snapshot.unit_roundoff);
    let largest = stated.reduce(f64::max);
    let survey = Survey {
        stated_roundoff: largest.filter(|&stated| stated > Snapshot::DOUBLE),
        ..Survey::default()
    };
    let size = |snapshot: &&Snapshot| snapshot.step_size.unwrap_or(0.0).abs();
    let largest = (after.iter()).reduce(|a, b| if size(&b) > size(&a) { b } else { a });
    Ok(Evidence {
        origin: Origin::Samples,
        survey,
        picture: largest.map(|largest| {
            let (before, after) = (&before.states, &largest.states);
            LoopPicture::of(largest.step_size, before, after, coordinates)
        }),
        breaks: compared.iter().flat_map(breaks_at).collect(),
        loops: vec![given],
        ..Evidence::default()
    })
}

/// Whether the last row repeats the first one, or is a period away: as of parameters from 0 to 1, both included. Rows next to these
/// are not as near, or rounding to few digits may have made them the same.
fn closes(snapshot: &Snapshot, coordinates: &Coordinates) -> bool {
    /// Neighbours are this many times the rounding of a row apart at least. Conventional.
    const MIN_DISTANCE_IN_ROUNDINGS: f64 = 8.0;
    let states = &snapshot.states;
    let (dof, last) = (states.dof(), states.samples() - 1);
    let stored = snapshot.unit_roundoff.max(Snapshot::DOUBLE);
    let differ = |a: usize, b: usize, roundings: f64| {
        (0..2 * dof).any(|c| {
            let row = coordinate(states, c);
            let rounding = rounding(stored * Extent::of(row).magnitude());
            nearest(row[b] - row[a], period(coordinates, c)).abs() > roundings * rounding
        })
    };
    last >= 3
        && !differ(0, last, 1.0)
        && differ(0, 1, MIN_DISTANCE_IN_ROUNDINGS)
        && differ(last - 1, last, MIN_DISTANCE_IN_ROUNDINGS)
}

fn breaks_at(step: &LoopComparison) -> impl Iterator<Item = LoopBreak> + '_ {
    step.breaks.iter().map(|&found| LoopBreak {
        loop_index: 0,
        step_size: step.step_size,
        found,
    })
}

fn evidence(step: &LoopComparison, samples: usize) -> StepEvidence {
    let size = |found: &Break| found.jump_q.abs() + found.jump_p.abs();
    StepEvidence {
        reach_of_jumps: 0.0,
        step_size: step.step_size,
        samples,
        rule: step.rule,
        initial: step.initial,
        advanced: step.integral.value,
        defect: step.defect,
        jump: (step.breaks.iter().copied()).reduce(|a, b| if size(&b) > size(&a) { b } else { a }),
        closing: step.broken.map(|broken| ClosedBreaks {
            breaks: broken.confirmed,
            chord: broken.chord,
            closed: broken.closed_defect,
            bend: 0.0,
            straight: true,
        }),
        jumping: step.broken.map(|broken| JumpingCells {
            cells: broken.cells,
            confirmed: broken.confirmed,
            largest: step.largest_jump,
        }),
        flickering: 0,
        wrap: step.wrapped,
        omitted_cells: step.integral.omitted.as_ref().map(Vec::len),
        cells_apart: 0.0,
        regularity: step.integral.regularity,
        has_feature: false,
        motion: step.motion,
        evaluations: samples,
    }
}

fn check(before: &Snapshot, after: &[Snapshot], coordinates: &Coordinates) -> Result<(), Error> {
    let states = &before.states;
    Error::check_length("coordinates", states.dof(), coordinates.dof())?;
    if states.samples() < 3 {
        return Err(Error::TooFewSamples {
            samples: states.samples(),
        });
    }
    if after.is_empty() {
        return Err(Error::OutOfRange {
            what: "number of loops after the step",
            value: 0.0,
            remedy: "give one or more",
        });
    }
    for snapshot in std::iter::once(before).chain(after) {
        if !(0.0..0.1).contains(&snapshot.unit_roundoff) {
            return Err(Error::OutOfRange {
                what: "relative rounding error of the values",
                value: snapshot.unit_roundoff,
                remedy: "give a number from 0 to 0.1, such as 2^-53 for double precision",
            });
        }
        snapshot.states.check_finite(snapshot.step_size)?;
    }
    let mut seen: Vec<f64> = Vec::new();
    for (index, snapshot) in after.iter().enumerate() {
        let of_after = &snapshot.states;
        if (of_after.samples(), of_after.dof()) != (states.samples(), states.dof()) {
            return Err(Error::ShapesDiffer {
                index,
                before: (states.samples(), states.dof()),
                after: (of_after.samples(), of_after.dof()),
            });
        }
        let Some(h) = snapshot.step_size else {
            continue;
        };
        if !h.is_finite() || h == 0.0 {
            return Err(Error::OutOfRange {
                what: "step size",
                value: h,
                remedy: "give finite step sizes that are not zero",
            });
        }
        if seen.contains(&h) {
            return Err(Error::RepeatedStep { step_size: h });
        }
        seen.push(h);
    }
    Ok(())
}
