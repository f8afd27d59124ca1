//! One loop with a rule and a number of samples, ready to be advanced by any step size.

use crate::breaks::{Break, find_break};
use crate::coordinates::Coordinates;
use crate::defect::Defect;
use crate::ensemble::Ensemble;
use crate::error::Error;
use crate::integral::{LoopIntegral, Rule, unwrap_row};
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
    /// Grid cells from one sample to the next at most.
    pub cells_apart: f64,
}

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

    /// The quadrature error of a finite-difference integral of a loop without breaks, not less than its
    /// distance from the pseudospectral one: cut-offs can leave out steep but smooth cells.
    fn cross_checked(
        &self,
        ensemble: &Ensemble,
        integral: &LoopIntegral,
    ) -> Result<Option<f64>, Error> {
        let rule = Rule::Pseudospectral;
        let other = LoopIntegral::in_coordinates(ensemble, &rule, self.subject.coordinates)?;
        let distance = (other.value - integral.value).abs();
        let errors = integral.quadrature_error.zip(other.quadrature_error);
        Ok(errors.map(|(own, of_other)| own.max(distance + of_other)))
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
        let found = find_break(map, phase_loop, h, &ensemble, coordinates)?;
        if let Rule::FiniteDifference(_) = self.rule {
            integral.quadrature_error = match found {
                // The rule took a jump for a part of the loop: nobody knows how far off that is.
                Some(found) if self.retains(&integral, &found) => None,
                Some(_) => integral.quadrature_error,
                None => self.cross_checked(&ensemble, &integral)?,
            };
            defect = Defect::between(&self.initial, &integral)?;
        }
        Ok(Measured {
            integral,
            defect,
            found,
            cells_apart: cells_apart(&ensemble, coordinates),
        })
    }
}

/// Grid cells between neighbouring samples at most; 0 where there is no grid.
fn cells_apart(ensemble: &Ensemble, coordinates: &Coordinates) -> f64 {
    let spacing = coordinates.grid_spacing();
    if spacing == 0.0 {
        return 0.0;
    }
    let furthest = |dof: usize| {
        let (row, period) = (ensemble.q().row(dof), coordinates.period(dof));
        let distance = |a: f64, b: f64| {
            let direct = (b - a).abs();
            if period > 0.0 {
                direct.min((direct - period).abs())
            } else {
                direct
            }
        };
        let closing = distance(row[row.len() - 1], row[0]);
        let steps = row.windows(2).map(|pair| distance(pair[0], pair[1]));
        steps.fold(closing, f64::max)
    };
    let largest = (0..ensemble.dof()).map(furthest).fold(0.0, f64::max);
    largest / spacing
}

/// How much one step deforms the loop, relative to its size: the largest motion of a coordinate against
/// the mean motion, over half the coordinate's range on the loop, from a few samples.
///
/// A translation deforms nothing, and no defect can come of it.
pub(super) fn deformation(
    map: &dyn TimeAdvance,
    phase_loop: &dyn Loop,
    h: f64,
) -> Result<f64, Error> {
    const SAMPLES: usize = 32;
    let before = Ensemble::sample(phase_loop, SAMPLES)?;
    let mut after = before.clone();
    after.advance(map, h)?;
    let coordinates = map.coordinates();
    let mut largest: f64 = 0.0;
    for i in 0..before.dof() {
        let (q, p) = (before.q().row(i), before.p().row(i));
        let of_q = motion(q, after.q().row(i), coordinates.period(i));
        let of_p = motion(p, after.p().row(i), 0.0);
        largest = largest.max(of_q).max(of_p);
    }
    Ok(largest)
}

/// Largest distance between the motions of two samples, over the range of the coordinate; motions are
/// counted modulo `period`, if there is one.
pub(crate) fn motion(before: &[f64], after: &[f64], period: f64) -> f64 {
    let range = |values: &[f64]| {
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
                (l.min(v), h.max(v))
            });
        high - low
    };
    let mut motions: Vec<f64> = before.iter().zip(after).map(|(a, b)| b - a).collect();
    unwrap_row(&mut motions, period);
    let size = range(before);
    if size > 0.0 {
        range(&motions) / size
    } else {
        0.0
    }
}
