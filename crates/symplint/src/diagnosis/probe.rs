//! One loop with a rule and a number of samples, ready to be advanced by any step size.

use crate::breaks::{Break, find_break};
use crate::coordinates::Coordinates;
use crate::defect::Defect;
use crate::ensemble::Ensemble;
use crate::error::Error;
use crate::integral::{LoopIntegral, Rule};
use crate::loops::Loop;
use crate::map::TimeAdvance;

/// What is under test: a map and a loop to send through it.
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    pub map: &'a dyn TimeAdvance,
    pub phase_loop: &'a dyn Loop,
    pub coordinates: &'a Coordinates,
}

/// A subject with its initial loop integral.
pub(super) struct Probe<'a> {
    /// 0 is the given loop, the others are random.
    pub index: usize,
    pub subject: Subject<'a>,
    pub rule: Rule,
    pub samples: usize,
    pub initial: LoopIntegral,
}

/// What one step did to the loop.
pub(super) struct Measured {
    pub integral: LoopIntegral,
    pub defect: Defect,
    pub found: Option<Break>,
}

/// Below this quadrature error the Fourier series of the loop ends well before the samples do: it
/// has no jumps, and none are looked for.
const RESOLVED: f64 = 1e-12;

impl<'a> Probe<'a> {
    pub fn new(
        index: usize,
        subject: Subject<'a>,
        rule: Rule,
        samples: usize,
    ) -> Result<Self, Error> {
        let ensemble = Ensemble::sample(subject.phase_loop, samples)?;
        let initial = LoopIntegral::in_coordinates(&ensemble, &rule, subject.coordinates)?;
        Ok(Probe {
            index,
            subject,
            rule,
            samples,
            initial,
        })
    }

    /// The same with another number of samples.
    pub fn with_samples(&self, samples: usize) -> Result<Self, Error> {
        Probe::new(self.index, self.subject, self.rule, samples)
    }

    /// Whether the cell of a break is among those that make up the integral.
    fn retains(&self, integral: &LoopIntegral, found: &Break) -> bool {
        let position = found.s * self.samples as f64;
        integral.omitted.as_ref().is_none_or(|omitted| {
            // A break at a sample may be in the cell on either side.
            !omitted.iter().any(|cell| {
                let from = cell.cell as f64;
                cell.dof == found.dof && (from - 1e-6..=from + 1.0 + 1e-6).contains(&position)
            })
        })
    }

    /// Advances the loop by one step and compares the loop integrals.
    pub fn measure(&self, h: f64) -> Result<Measured, Error> {
        let Subject {
            map,
            phase_loop,
            coordinates,
        } = self.subject;
        let mut ensemble = Ensemble::sample(phase_loop, self.samples)?;
        ensemble.advance(map, h)?;
        let mut integral = LoopIntegral::in_coordinates(&ensemble, &self.rule, coordinates)?;
        let mut defect = Defect::between(&self.initial, &integral)?;
        let resolved = matches!(self.rule, Rule::Pseudospectral)
            && defect
                .quadrature_error
                .is_some_and(|error| error < RESOLVED);
        let found = if resolved {
            None
        } else {
            find_break(map, phase_loop, h, &ensemble, coordinates)?
        };
        if found.is_some_and(|found| self.retains(&integral, &found)) {
            // The rule took a jump for a part of the loop: nobody knows how far off that is.
            integral.quadrature_error = None;
            defect = Defect::between(&self.initial, &integral)?;
        }
        Ok(Measured {
            integral,
            defect,
            found,
        })
    }
}

/// How far one step moves the loop, relative to the loop's size: the largest ratio over all
/// coordinates, from a few samples.
pub(super) fn displacement(
    map: &dyn TimeAdvance,
    phase_loop: &dyn Loop,
    h: f64,
) -> Result<f64, Error> {
    const SAMPLES: usize = 32;
    let before = Ensemble::sample(phase_loop, SAMPLES)?;
    let mut after = before.clone();
    after.advance(map, h)?;
    let mut largest: f64 = 0.0;
    for (before, after) in [(before.q(), after.q()), (before.p(), after.p())] {
        for i in 0..before.count() {
            let (a, b) = (before.row(i), after.row(i));
            let low = a.iter().copied().fold(f64::INFINITY, f64::min);
            let high = a.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let moved = a
                .iter()
                .zip(b)
                .map(|(a, b)| (b - a).abs())
                .fold(0.0, f64::max);
            if high > low {
                largest = largest.max(2.0 * moved / (high - low));
            }
        }
    }
    Ok(largest)
}
