//! Loops that another code advanced: all that is known of them is their samples.
//!
//! A map can be evaluated between the samples, data cannot. So where the samples are smooth the
//! pseudospectral rule with its nested error estimate is used, and where they jump ([`find_jumps`](crate::breaks::find_jumps))
//! a finite-difference rule that leaves the jumps out ([`pieces`]) and owns up to not knowing where in
//! its cell a break lies. No cut-off is compared with the size of a coordinate: a shift of the origin
//! changes nothing.

mod compare;
mod conclude;
mod increments;
mod pieces;

use rayon::prelude::*;

use crate::diagnosis::{BreakAt, Diagnosis, Point, Sweep};
use crate::error::Error;
use crate::state::Coordinates;
use crate::state::Ensemble;
use compare::{Compared, Initial};

/// All samples of a loop at one time, as another code stored them.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The states; sample k belongs to s = k/N_s.
    pub states: Ensemble,
    /// Relative rounding error of the stored values, as a part of the largest: 2^-53 of double precision,
    /// 2^-24 of single precision, 5e-7 of seven decimal digits.
    pub unit_roundoff: f64,
    /// The size of the step that made the states, where that is known. Not zero.
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

    /// The same with another relative rounding error.
    pub fn with_unit_roundoff(mut self, unit_roundoff: f64) -> Self {
        self.unit_roundoff = unit_roundoff;
        self
    }
}

/// Compares a loop before a step with the same loop after one or several steps of different sizes, each
/// taken from `before`, and judges.
///
/// In the result, a point has the rule `pseudospectral` where the samples are smooth. Where they
/// jump it has `jump-detecting`: `advanced` is then the absolutely continuous part,
/// `omitted_cells` the cells that jump, `jumps` those of them that stay jumps from every fourth to
/// every sample, and `chord` what straight chords across the breaks add. `step_size` is NaN (in reports
/// `null`) where it is not known. A `quadrature_error` of `None` says that the samples are too few
/// to know the integral.
///
/// A jump in data is evidence, not proof: a flank much steeper than the distance of two samples looks the
/// same. Momenta are multiplied by the weights of `coordinates`, positions unwrapped by its periods.
///
/// # Errors
/// If the loops differ in samples or degrees of freedom, a state is not finite, there are fewer than 3
/// samples or no loop after the step, a step size is zero, not finite or stated twice, or the loop before
/// the step encloses no area.
///
/// ```
/// use symplint::{Circle, Coordinates, Ensemble, Snapshot, VerdictKind, measure};
///
/// // Another code's step: here a shear, which is symplectic.
/// let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
/// let before = Ensemble::sample(&circle, 256)?;
/// let mut after = before.clone();
/// for k in 0..after.samples() {
///     let p = after.p().row(0)[k];
///     after.block().q.row_mut(0)[k] += 0.5 * p * p;
/// }
///
/// let after = Snapshot::new(after).after_step(0.5);
/// let diagnosis = measure(&Snapshot::new(before), &[after], &Coordinates::plain(1))?;
/// assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
/// # Ok::<(), symplint::Error>(())
/// ```
pub fn measure(
    before: &Snapshot,
    after: &[Snapshot],
    coordinates: &Coordinates,
) -> Result<Diagnosis, Error> {
    check(before, after, coordinates)?;
    let initial = Initial::new(before, coordinates)?;
    // All of them, so that the error is that of the first snapshot on any number of threads.
    let compared: Vec<Result<Compared, Error>> = (after.par_iter())
        .map(|snapshot| initial.compare(snapshot))
        .collect();
    let compared: Vec<Compared> = compared.into_iter().collect::<Result<_, Error>>()?;
    let samples = before.states.samples();
    let points = compared
        .iter()
        .map(|step| point(&initial, step, samples))
        .collect();
    let (verdict, fits) = conclude::conclude(&initial, &compared, samples);
    Ok(Diagnosis {
        localisation: None,
        verdict,
        points,
        fits,
        breaks: compared.iter().flat_map(breaks_at).collect(),
        long_time: None,
        jacobian: None,
    })
}

fn breaks_at(step: &Compared) -> impl Iterator<Item = BreakAt> + '_ {
    step.breaks.iter().map(|&found| BreakAt {
        loop_index: 0,
        // Not a number where nobody said it: null in reports.
        step_size: step.step_size.unwrap_or(f64::NAN),
        found,
    })
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

fn point(initial: &Initial<'_>, step: &Compared, samples: usize) -> Point {
    let defect = &step.defect;
    Point {
        sweep: Sweep::StepSize,
        loop_index: 0,
        step_size: step.step_size.unwrap_or(f64::NAN),
        samples,
        rule: step.rule,
        initial: initial.integral.value,
        advanced: step.integral.value,
        signed_defect: defect.signed,
        defect: defect.magnitude(),
        quadrature_error: defect.quadrature_error,
        roundoff: defect.roundoff,
        omitted_cells: step.integral.omitted.as_ref().map(Vec::len),
        jumps: step.broken.map(|broken| broken.confirmed),
        chord: step.broken.map(|broken| broken.chord),
        closed_defect: step.broken.map(|broken| broken.closed_defect.signed.abs()),
        regularity: step.integral.regularity,
        evaluations: samples,
    }
}
