//! Measuring and judging in one call.

use super::{Fit, Verdict, judge};
use crate::diagnosis::{Diagnostic, Event};
use crate::error::Error;
use crate::evidence::{Evidence, LoopPicture, Point};
use crate::loops::Loop;
use crate::map::TimeAdvance;
use crate::snapshots::{Snapshot, measure_snapshots};
use crate::state::Coordinates;

/// A verdict with all the evidence that led to it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Everything that was measured.
    pub evidence: Evidence,
    /// Your loop before and after the largest step, from samples that were measured. `None` if no samples stayed in memory, and
    /// for evidence from a file.
    pub picture: Option<LoopPicture>,
}

impl Diagnosis {
    /// The diagnosis that follows from some evidence.
    pub fn of(mut evidence: Evidence) -> Self {
        Diagnosis {
            verdict: judge(&evidence),
            picture: evidence.picture.take(),
            evidence,
        }
    }

    /// All measured points, flat: see [`Evidence::points`].
    pub fn points(&self) -> Vec<Point> {
        self.evidence.points()
    }

    /// Power laws fitted to the defects of the loops.
    pub fn fits(&self) -> &[Fit] {
        &self.verdict.fits
    }
}

impl Diagnostic {
    /// Measures and judges, on the threads of the current Rayon pool: [`Diagnostic::measure`], then
    /// [`judge`].
    ///
    /// # Errors
    /// Those of [`Diagnostic::measure`].
    pub fn run(&self, map: &dyn TimeAdvance, phase_loop: &dyn Loop) -> Result<Diagnosis, Error> {
        self.run_watched(map, phase_loop, &|_| {})
    }

    /// The same; `watch` gets each point when it is measured.
    ///
    /// # Errors
    /// Those of [`Diagnostic::measure`].
    pub fn run_watched(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        watch: &dyn Fn(Event<'_>),
    ) -> Result<Diagnosis, Error> {
        Ok(Diagnosis::of(self.measure(map, phase_loop, watch)?))
    }
}

/// Compares a loop before a step with the same loop after one or several steps of different sizes, each
/// taken from `before`, and judges: [`measure_snapshots`], then [`judge`].
///
/// A jump in data is evidence, not proof: a slope much steeper than the distance of two samples looks the
/// same. Momenta are multiplied by the weights of `coordinates`, positions unwrapped by its periods.
///
/// # Errors
/// Those of [`measure_snapshots`].
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
    Ok(Diagnosis::of(measure_snapshots(
        before,
        after,
        coordinates,
    )?))
}
