//! The rules that integrate equispaced samples: pseudospectral and finite differences.

use super::{Advanced, Defect, LoopIntegral, LoopIntegrator, Rule, RuleKind, Samples, Subject};
use crate::breaks::{Break, Search, find_break_with, little_jumps};
use crate::error::Error;
use crate::signal::Extent;
use crate::state::{Coordinates, Ensemble};

/// A rule that [`LoopIntegral::in_coordinates`] serves.
pub(super) struct Sampled(pub Rule);

impl LoopIntegrator for Sampled {
    fn kind(&self) -> RuleKind {
        self.0.kind()
    }

    fn before(&self, subject: &Subject<'_>, samples: Samples<'_>) -> Result<LoopIntegral, Error> {
        LoopIntegral::in_coordinates(samples.kept(), &self.0, subject.coordinates())
    }

    fn after(
        &self,
        subject: &Subject<'_>,
        h: f64,
        samples: Samples<'_>,
        initial: &LoopIntegral,
    ) -> Result<Advanced, Error> {
        let after = samples.kept();
        let Jumps { found, little } = jumps(subject, h, after)?;
        let mut integral = self.before(subject, samples)?;
        integral.quadrature_error = match (&found, self.0) {
            (Search::Unaffordable, _) => None,
            // The rule took a jump for a part of the loop: its error is not known.
            (Search::Found(found), Rule::FiniteDifference(_))
                if retains(&integral, found, after.samples()) =>
            {
                None
            }
            (Search::Clean, Rule::FiniteDifference(_)) => cross_checked(subject, after, &integral)?,
            _ => integral.quadrature_error,
        };
        integral.quadrature_error = integral.quadrature_error.map(|error| error + little);
        advanced(subject, after, initial, integral, found)
    }
}

fn advanced(
    subject: &Subject<'_>,
    after: &Ensemble,
    initial: &LoopIntegral,
    integral: LoopIntegral,
    found: Search,
) -> Result<Advanced, Error> {
    Ok(Advanced {
        defect: Defect::between(initial, &integral)?,
        regularity: integral.regularity,
        integral,
        breaks: match found {
            Search::Found(found) => vec![found],
            Search::Clean | Search::Unaffordable => Vec::new(),
        },
        closed: None,
        samples: after.samples(),
        cells_apart: cells_apart(after, subject.coordinates()),
    })
}

/// The quadrature error of a finite-difference integral of a loop without breaks, not less than its
/// distance from the pseudospectral one: cut-offs can leave out steep but smooth cells.
fn cross_checked(
    subject: &Subject<'_>,
    after: &Ensemble,
    integral: &LoopIntegral,
) -> Result<Option<f64>, Error> {
    let other = Sampled(Rule::Pseudospectral).before(subject, Samples::Kept(after))?;
    let distance = (other.value - integral.value).abs();
    let errors = integral.quadrature_error.zip(other.quadrature_error);
    Ok(errors.map(|(own, of_other)| own.max(distance + of_other)))
}

/// What advanced samples lead to.
pub(super) struct Jumps {
    /// A break of more than rounding.
    pub found: Search,
    /// What jumps contribute at most that are less than that.
    pub little: f64,
}

/// Looks for a break where advanced samples show one.
pub(super) fn jumps(subject: &Subject<'_>, h: f64, after: &Ensemble) -> Result<Jumps, Error> {
    let found = match find_break_with(subject.evaluator, subject.phase_loop, h, after)? {
        Search::Found(found) if !found.is_substantial(ranges_of(after, found.dof)) => Search::Clean,
        found => found,
    };
    let little = match found {
        Search::Clean => little_jumps(after, subject.coordinates(), &[]),
        Search::Found(_) | Search::Unaffordable => 0.0,
    };
    Ok(Jumps { found, little })
}

/// The ranges of q and p of a degree of freedom.
pub(super) fn ranges_of(ensemble: &Ensemble, dof: usize) -> [f64; 2] {
    [ensemble.q(), ensemble.p()].map(|rows| Extent::of(rows.row(dof)).length())
}

/// Whether the cell of a break is among those that make up the integral.
fn retains(integral: &LoopIntegral, found: &Break, samples: usize) -> bool {
    /// A break this near to a sample, in cells, may be in the cell on either side.
    const EDGE: f64 = 1e-6;
    let position = found.s * samples as f64;
    integral.omitted.as_ref().is_none_or(|omitted| {
        !omitted.iter().any(|cell| {
            let from = cell.cell as f64;
            cell.dof == found.dof && (from - EDGE..=from + 1.0 + EDGE).contains(&position)
        })
    })
}

/// Grid cells between neighbouring samples at most, or half periods, if they are more; 0 where there is
/// neither. Positions that are half a period apart could be unwrapped either way.
pub(crate) fn cells_apart(ensemble: &Ensemble, coordinates: &Coordinates) -> f64 {
    let furthest = |dof: usize| {
        let (row, period) = (ensemble.q().row(dof), coordinates.period(dof));
        let spacing = match (coordinates.grid_spacing(), 0.5 * period) {
            (0.0, 0.0) => return 0.0,
            (0.0, other) | (other, 0.0) => other,
            (grid, half) => grid.min(half),
        };
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
        steps.fold(closing, f64::max) / spacing
    };
    (0..ensemble.dof()).map(furthest).fold(0.0, f64::max)
}
