//! The rules that integrate equispaced samples: pseudospectral and finite differences.

use multiversion::multiversion;

use super::{
    Defect, LoopAfterStep, LoopIntegral, LoopIntegrator, Rule, RuleKind, Samples, Subject,
};
use crate::breaks::{Break, SearchResult, dof_may_jump, find_break_in, little_jumps};
use crate::error::Error;
use crate::signal::Extent;
use crate::state::{Coordinates, Ensemble};

/// A rule that [`LoopIntegral::in_coordinates`] serves.
pub(super) struct SampledRule(pub Rule);

impl LoopIntegrator for SampledRule {
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
    ) -> Result<LoopAfterStep, Error> {
        let after = samples.kept();
        let coordinates = subject.coordinates();
        // Search and integrate each row while it is in the cache.
        let look = |dof| dof_may_jump(after, coordinates, dof);
        let (mut integral, rows) =
            LoopIntegral::in_coordinates_with(after, &self.0, coordinates, look)?;
        let Jumps { found, little } = jumps(subject, h, after, &rows)?;
        integral.quadrature_error = match (&found, self.0) {
            (SearchResult::Unaffordable, _) => None,
            // The rule took a jump for a part of the loop: its error is not known.
            (SearchResult::Found(found), Rule::FiniteDifference(_))
                if retains(&integral, found, after.samples()) =>
            {
                None
            }
            (SearchResult::Clean, Rule::FiniteDifference(_)) => {
                cross_checked(subject, after, &integral)?
            }
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
    found: SearchResult,
) -> Result<LoopAfterStep, Error> {
    Ok(LoopAfterStep {
        defect: Defect::between(initial, &integral)?,
        regularity: integral.regularity,
        integral,
        breaks: match found {
            SearchResult::Found(found) => vec![found],
            SearchResult::Clean | SearchResult::Unaffordable => Vec::new(),
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
    let other = SampledRule(Rule::Pseudospectral).before(subject, Samples::Kept(after))?;
    let distance = (other.value - integral.value).abs();
    let errors = integral.quadrature_error.zip(other.quadrature_error);
    Ok(errors.map(|(own, of_other)| own.max(distance + of_other)))
}

/// What advanced samples lead to.
pub(super) struct Jumps {
    /// A break of more than rounding.
    pub found: SearchResult,
    /// What jumps contribute at most that are less than that.
    pub little: f64,
}

/// Looks for a break in the [rows that may jump](crate::breaks::rows_that_may_jump) of advanced samples.
pub(super) fn jumps(
    subject: &Subject<'_>,
    h: f64,
    after: &Ensemble,
    rows: &[[bool; 2]],
) -> Result<Jumps, Error> {
    let (evaluator, phase_loop) = (subject.evaluator, subject.phase_loop);
    let found = match find_break_in(evaluator, phase_loop, h, after, rows)? {
        SearchResult::Found(found) if !found.is_substantial(ranges_of(after, found.dof)) => {
            SearchResult::Clean
        }
        found => found,
    };
    let little = match found {
        SearchResult::Clean => little_jumps(after, subject.coordinates(), &[], rows),
        SearchResult::Found(_) | SearchResult::Unaffordable => 0.0,
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
    const MAX_DISTANCE_TO_SAMPLE: f64 = 1e-6;
    let position = found.s * samples as f64;
    integral.omitted.as_ref().is_none_or(|omitted| {
        !omitted.iter().any(|cell| {
            let from = cell.cell as f64;
            cell.dof == found.dof
                && (from - MAX_DISTANCE_TO_SAMPLE..=from + 1.0 + MAX_DISTANCE_TO_SAMPLE)
                    .contains(&position)
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
        furthest_step(row, period) / spacing
    };
    (0..ensemble.dof()).map(furthest).fold(0.0, f64::max)
}

/// The largest distance of neighbouring samples, round the loop; that of nearest images if there is a period.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn furthest_step(row: &[f64], period: f64) -> f64 {
    /// Enough lanes that none waits for the one before.
    const LANES: usize = 16;
    let period = if period > 0.0 { period } else { f64::INFINITY };
    let distance = |a: f64, b: f64| {
        let direct = (b - a).abs();
        let round = (direct - period).abs();
        if round < direct { round } else { direct }
    };
    let (groups, rest) = row[..row.len() - 1].as_chunks::<LANES>();
    let (next_groups, next_rest) = row[1..].as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    for (group, next) in groups.iter().zip(next_groups) {
        for lane in 0..LANES {
            let step = distance(group[lane], next[lane]);
            lanes[lane] = if step > lanes[lane] {
                step
            } else {
                lanes[lane]
            };
        }
    }
    let closing = distance(row[row.len() - 1], row[0]);
    let rest = rest.iter().zip(next_rest).map(|(&a, &b)| distance(a, b));
    rest.chain(lanes).fold(closing, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, Evaluator, PerSample, TimeAdvance};
    use crate::rules::Cutoffs;

    const FINITE_DIFFERENCES: Rule = Rule::FiniteDifference(Cutoffs {
        q: crate::rules::Cutoff::Absolute(1e3),
        p: crate::rules::Cutoff::Absolute(1e3),
    });

    /// One step of size 0.5, from a circle of radius 1, on a budget that this many evaluations more are left of.
    fn step(map: &dyn TimeAdvance, rule: Rule, samples: usize, left: usize) -> LoopAfterStep {
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let count = EvaluationCount::new(samples + left);
        let evaluator = Evaluator::new(map, &count).unwrap();
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &circle,
        };
        let mut states = Ensemble::sample(&circle, samples).unwrap();
        let rule = SampledRule(rule);
        let initial = rule.before(&subject, Samples::Kept(&states)).unwrap();
        evaluator.advance(&mut states, 0.5).unwrap();
        rule.after(&subject, 0.5, Samples::Kept(&states), &initial)
            .unwrap()
    }

    /// A kick by a force that jumps by twice this at q = 0.3.
    fn kick(jump: f64) -> impl TimeAdvance {
        PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * (q[0] + jump * (q[0] - 0.3).signum());
            q[0] += h * p[0];
        })
    }

    #[test]
    fn an_error_is_known_where_the_rule_left_the_jump_out() {
        // Of 4096 cells one with a jump of 1/2 has a slope of 2048.
        let map = kick(0.5);
        let omitted = step(&map, FINITE_DIFFERENCES, 4096, 1000);
        assert_eq!(omitted.breaks.len(), 1);
        assert!(omitted.integral.quadrature_error.is_some());
        let retained = step(&map, Rule::FiniteDifference(Cutoffs::none()), 4096, 1000);
        assert_eq!(retained.breaks.len(), 1);
        assert_eq!(retained.integral.quadrature_error, None);
    }

    #[test]
    fn an_error_is_not_known_where_a_jump_is_too_dear_to_follow() {
        for rule in [Rule::Pseudospectral, FINITE_DIFFERENCES] {
            let step = step(&kick(0.5), rule, 4096, 10);
            assert!(step.breaks.is_empty());
            assert_eq!(step.integral.quadrature_error, None);
        }
    }

    #[test]
    fn jumps_too_small_for_a_break_widen_the_error() {
        let size = 2e-12;
        let [without, with] =
            [0.0, size].map(|jump| step(&kick(jump), Rule::Pseudospectral, 4096, 1000));
        assert!(with.breaks.is_empty());
        let wider =
            with.integral.quadrature_error.unwrap() - without.integral.quadrature_error.unwrap();
        // Positions jump by h² times twice the size, twice, where momenta are near 0.95 and below.
        assert!((0.1 * size..10.0 * size).contains(&wider), "{wider:e}");
    }

    #[test]
    fn finite_differences_of_a_smooth_loop_are_compared_with_the_pseudospectral_rule() {
        // The largest slopes of a circle are 2π times its radius: a part of it is left out.
        let cutoffs = Cutoffs::relative(6.0);
        let step = step(&kick(0.0), Rule::FiniteDifference(cutoffs), 4096, 1000);
        let error = step.integral.quadrature_error.unwrap();
        let exact = std::f64::consts::PI;
        let missing = (step.integral.value.abs() - exact).abs();
        assert!(missing > 0.1 && error >= missing, "{missing} {error}");
        assert!(error < 2.0 * missing, "{missing} {error}");
    }

    #[test]
    fn ranges_are_those_of_the_degree_of_freedom() {
        let circle = Circle::new(vec![5.0, -1e3], vec![0.0, 7.0], 2.0).unwrap();
        // Samples meet the ends of all ranges.
        let circle = circle.with_phases(crate::loops::Phases::Equal);
        let states = Ensemble::sample(&circle, 64).unwrap();
        for dof in 0..2 {
            for range in ranges_of(&states, dof) {
                assert!((range - 4.0).abs() < 1e-12, "{range}");
            }
        }
    }

    #[test]
    fn a_break_is_in_the_integral_unless_its_cell_was_left_out() {
        let integral = |cells: Option<&[usize]>| LoopIntegral {
            value: 1.0,
            contributions: vec![0.5, 0.5],
            quadrature_error: Some(0.0),
            roundoff: 0.0,
            scale: 1.0,
            omitted: cells.map(|cells| {
                let cell = |&cell| crate::rules::OmittedCell { dof: 1, cell };
                cells.iter().map(cell).collect()
            }),
            regularity: None,
        };
        let found = |s: f64, dof: usize| Break {
            s,
            uncertainty: 0.0,
            dof,
            jump_q: 1.0,
            jump_p: 0.0,
            substep: None,
        };
        assert!(retains(&integral(None), &found(0.5, 1), 64));
        let cells = integral(Some(&[3, 32]));
        for (s, dof, retained) in [
            (0.51, 1, false),
            (0.51, 0, true),
            (3.5 / 64.0, 1, false),
            (4.5 / 64.0, 1, true),
            // On a sample, in the cell on either side.
            (0.5, 1, false),
            (33.0 / 64.0, 1, false),
            (31.9 / 64.0, 1, true),
        ] {
            assert_eq!(retains(&cells, &found(s, dof), 64), retained, "{s} {dof}");
        }
    }

    #[test]
    fn neighbours_are_compared_with_grid_cells_and_half_periods() {
        let states = |q: [f64; 4]| {
            let mut states = Ensemble::zeros(1, 4);
            states.block().q.row_mut(0).copy_from_slice(&q);
            states
        };
        let plain = Coordinates::plain(1);
        let far = states([0.0, 1.0, 3.0, 2.0]);
        assert_eq!(cells_apart(&far, &plain), 0.0);
        let grid = plain.clone().with_grid_spacing(0.5).unwrap();
        assert_eq!(cells_apart(&far, &grid), 4.0);
        // From 3 to 0 is one with a period of 4.
        let periodic = |c: Coordinates| c.with_periods(vec![4.0]).unwrap();
        let long: Vec<f64> = (0..50).map(|k| (f64::from(k) * 0.3).sin()).collect();
        let expected = long.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let expected = expected.fold((long[49] - long[0]).abs(), f64::max);
        assert_eq!(furthest_step(&long, 0.0), expected);
        let wrapped = states([3.0, 0.0, 0.5, 3.5]);
        assert_eq!(cells_apart(&wrapped, &periodic(plain)), 0.5);
        assert_eq!(cells_apart(&wrapped, &periodic(grid.clone())), 2.0);
    }
}
