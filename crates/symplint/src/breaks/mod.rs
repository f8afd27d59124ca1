//! Breaks: jumps of an advanced loop.
//!
//! Samples alone cannot tell a jump from a steep but smooth stretch. If a map can be evaluated at any s,
//! every cell in which samples look discontinuous (`residual`) is followed (`follow`) by bisection
//! (`bracket`) until no double lies between: what is still a jump there is a break. If samples are all that is
//! known, all cells that look so are searched for (`search`). Jumps too small to break a loop bound its digits
//! (`little`).

mod bracket;
mod follow;
mod limits;
mod little;
mod residual;
mod search;

pub(crate) use bracket::{
    Bracket, End, Progress, displace, flickers, interleaved, is_between_levels, keeps_its_levels,
    lands_on_a_level, lasting, scatter, stands_out,
};
pub(crate) use limits::{
    CONFIRMING_STATES, DISTANCES_FROM_ZONE, INTERMEDIATE_ZONE_STATES, REACH_OF_CONFIRMATION,
    STATES_AROUND_ZONE, STATES_OF_LOOKS,
};
pub(crate) use little::little_jumps;
pub(crate) use residual::{
    Coordinate, GROUP, REACH, Residuals, Suspect, Window, most_outstanding, rounding,
};
pub(crate) use search::{Jump, Roughness, find_jumps};

use serde::{Deserialize, Serialize};

use residual::may_jump;

use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use crate::signal::{UNIT_ROUNDOFF, largest, unwrap_row, wraps};
use crate::state::scratch::with_buffer;
use crate::state::{Coordinates, Ensemble, in_parallel};

/// A point at which an advanced loop is discontinuous, in the degree of freedom that led to it, or that jumps most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Break {
    /// Where: the loop parameter in [0, 1).
    pub s: f64,
    /// How far from there it may be, along the loop: what the rounding of states makes of it, and the zone in which rounding
    /// decides where a solver inside the map stops.
    #[serde(default)]
    pub uncertainty: f64,
    /// Degree of freedom.
    pub dof: usize,
    /// q(s⁺) − q(s⁻) there.
    pub jump_q: f64,
    /// p(s⁺) − p(s⁻) there.
    pub jump_p: f64,
    /// The substep of the map that breaks the loop, 0 for the first; `None` where the map is one whole
    /// or it is not known.
    pub substep: Option<usize>,
}

/// Calibrated on the truth set: of 2,370 breaks the true errors are at most 0.6 times this part of the roundings that a
/// state may be off in all.
const POSITION_ERROR_IN_ROUNDINGS: f64 = 0.05;

/// How far the rounding of a state, this part of the loop, moves a break whose jump is this part of the size of the loop:
/// a threshold is met to a rounding of what is compared with it, and if a solver causes the break, this changes by
/// no more than the jump along the loop. If no solver causes the break, positions are compared, and `jump` is 1.
pub(crate) fn uncertainty_of_position(rounding: f64, jump: f64) -> f64 {
    (POSITION_ERROR_IN_ROUNDINGS * rounding / jump.min(1.0)).min(1.0)
}

impl Break {
    /// Whether it is more than rounding, where q and p of its degree of freedom have these ranges on the loop.
    pub(crate) fn is_substantial(&self, [range_q, range_p]: [f64; 2]) -> bool {
        self.jump_q.abs() > limits::MIN_RELATIVE_JUMP * range_q
            || self.jump_p.abs() > limits::MIN_RELATIVE_JUMP * range_p
    }
}

/// Looks for a break of the loop that `map` makes of `phase_loop` in one step of size `h`.
///
/// `advanced` holds the advanced samples. The most suspicious degrees of freedom are
/// followed; the first break found is returned. `None` means that the samples show no jump, or that
/// what looked like one is continuous when evaluated more closely.
///
/// # Errors
/// Those of the map where it is evaluated between the samples; if map, loop and samples differ in their degrees
/// of freedom.
pub fn find_break(
    map: &dyn TimeAdvance,
    phase_loop: &dyn Loop,
    h: f64,
    advanced: &Ensemble,
) -> Result<Option<Break>, Error> {
    let count = EvaluationCount::unlimited();
    let evaluator = Evaluator::new(map, &count)?;
    match find_break_with(&evaluator, phase_loop, h, advanced)? {
        SearchResult::Found(found) => Ok(Some(found)),
        SearchResult::Clean | SearchResult::Unaffordable => Ok(None),
    }
}

/// The result of a search for a break.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SearchResult {
    /// The samples show no jump, or what looked like one is continuous.
    Clean,
    /// A break.
    Found(Break),
    /// A cell looks discontinuous, and the budget does not allow to follow it.
    Unaffordable,
}

/// The same with the evaluations counted by `evaluator`, in the coordinates of its map.
pub(crate) fn find_break_with(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    advanced: &Ensemble,
) -> Result<SearchResult, Error> {
    let dof = phase_loop.dof();
    evaluator.check_dof(dof)?;
    Error::check_length("rows of the advanced samples", dof, advanced.dof())?;
    let rows = rows_that_may_jump(advanced, evaluator.coordinates());
    find_break_in(evaluator, phase_loop, h, advanced, &rows)
}

/// The same in these rows of each degree of freedom.
pub(crate) fn find_break_in(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    advanced: &Ensemble,
    rows: &[[bool; 2]],
) -> Result<SearchResult, Error> {
    let suspects = suspects(advanced, evaluator.coordinates(), rows);
    let samples = advanced.samples();
    follow_up(evaluator, phase_loop, h, &suspects, samples, Some(advanced))
}

/// Whether q and p of each degree of freedom may jump. Rows that cannot have no [`suspects`] and no [`little_jumps`].
pub(crate) fn rows_that_may_jump(ensemble: &Ensemble, coordinates: &Coordinates) -> Vec<[bool; 2]> {
    let of_dof = |dof: usize| dof_may_jump(ensemble, coordinates, dof);
    in_parallel(0..ensemble.dof(), 2 * ensemble.samples(), of_dof)
}

/// [`rows_that_may_jump`] for one degree of freedom.
pub(crate) fn dof_may_jump(
    ensemble: &Ensemble,
    coordinates: &Coordinates,
    dof: usize,
) -> [bool; 2] {
    let of_row = |row: &[f64], period: f64| {
        wraps(row, period) || may_jump(row, rounding(UNIT_ROUNDOFF * largest(row)))
    };
    [
        of_row(ensemble.q().row(dof), coordinates.period(dof)),
        of_row(ensemble.p().row(dof), coordinates.momentum_period(dof)),
    ]
}

/// The first break among `suspects`: these are cells between `samples` samples, which may be `known`.
///
/// # Errors
/// Those of the map where it is evaluated between the samples.
pub(crate) fn follow_up(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    suspects: &[Suspect],
    samples: usize,
    known: Option<&Ensemble>,
) -> Result<SearchResult, Error> {
    for suspect in suspects {
        if evaluator.count().left() < limits::MAX_EVALUATIONS_OF_SUSPECT {
            return Ok(SearchResult::Unaffordable);
        }
        let found = follow::follow(evaluator, phase_loop, h, suspect, samples, known)?;
        if found != SearchResult::Clean {
            return Ok(found);
        }
    }
    Ok(SearchResult::Clean)
}

/// The most suspicious cells of samples in memory, those that stand out most first.
fn suspects(
    ensemble: &Ensemble,
    coordinates: &Coordinates,
    may_jump: &[[bool; 2]],
) -> Vec<Suspect> {
    if ensemble.samples() < GROUP {
        return Vec::new();
    }
    let of_dof = |dof: usize| {
        let (q, p) = (ensemble.q().row(dof), ensemble.p().row(dof));
        let rows = [
            (Coordinate::Q, q, coordinates.period(dof)),
            (Coordinate::P, p, coordinates.momentum_period(dof)),
        ];
        let rows = rows.into_iter().zip(may_jump[dof]);
        rows.filter(|(_, may_jump)| *may_jump)
            .filter_map(|((coordinate, row, period), _)| suspect(dof, coordinate, row, period))
            .collect::<Vec<_>>()
    };
    let dofs: Vec<usize> = (0..ensemble.dof())
        .filter(|&dof| may_jump[dof] != [false; 2])
        .collect();
    let of_dofs = in_parallel(dofs, 2 * ensemble.samples(), of_dof);
    let mut found: Vec<Suspect> = of_dofs.into_iter().flatten().collect();
    most_outstanding(&mut found);
    found
}

fn suspect(dof: usize, coordinate: Coordinate, row: &[f64], period: f64) -> Option<Suspect> {
    if wraps(row, period) {
        return with_buffer(row.len(), |unwrapped| {
            unwrapped.copy_from_slice(row);
            let gain = unwrap_row(unwrapped, period) as f64 * period;
            suspect_of(dof, coordinate, unwrapped, gain)
        });
    }
    suspect_of(dof, coordinate, row, 0.0)
}

/// Of a row that gains `gain` round the loop.
fn suspect_of(dof: usize, coordinate: Coordinate, row: &[f64], gain: f64) -> Option<Suspect> {
    let (residuals, groups) = Residuals::of(row, gain);
    let magnitude = largest(row) + gain.abs();
    residuals.suspect(dof, coordinate, [row.len(), groups], magnitude)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::PerSample;

    /// A kick by the gradient of a potential whose slope jumps, bends or is steep at q = 0.3.
    fn kick(force: impl Fn(f64) -> f64 + Send + Sync) -> impl TimeAdvance {
        PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] += h * force(q[0] - 0.3);
            q[0] += h * p[0];
        })
    }

    fn search(map: &dyn TimeAdvance, samples: usize) -> Option<Break> {
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let mut ensemble = Ensemble::sample(&circle, samples).unwrap();
        ensemble.advance(map, 0.5).unwrap();
        find_break(map, &circle, 0.5, &ensemble).unwrap()
    }

    #[test]
    fn a_jump_is_found_to_round_off() {
        let expected = 0.3f64.asin() / std::f64::consts::TAU;
        for samples in [32, 48, 64, 257, 4096] {
            let found = search(&kick(|x| -x.signum()), samples).expect("the force jumps");
            let other = 0.5 - expected;
            let distance = (found.s - expected).abs().min((found.s - other).abs());
            assert!(distance < 1e-13, "{samples} samples: s = {}", found.s);
            assert!((found.jump_p.abs() - 1.0).abs() < 1e-9);
            assert!((found.jump_q.abs() - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn a_small_jump_in_a_large_slope_is_found() {
        let map = kick(|x| 3.0 * x - 1e-6 * x.signum());
        let found = search(&map, 4096).expect("the force jumps by 2e-6");
        assert!((found.jump_p.abs() - 1e-6).abs() < 1e-9);
    }

    #[test]
    fn a_kink_is_no_break() {
        for samples in [64, 1024, 16384] {
            assert_eq!(search(&kick(|x| -x.abs()), samples), None);
        }
    }

    #[test]
    fn a_steep_force_is_no_break() {
        for width in [1e-2, 1e-4, 1e-6, 1e-8] {
            let map = kick(move |x| -x / x.hypot(width));
            assert_eq!(search(&map, 512), None, "width {width}");
        }
    }

    #[test]
    fn single_precision_is_no_break() {
        let map = kick(|x| f64::from((x as f32).sin()));
        for samples in [64, 512, 4096, 65536] {
            assert_eq!(search(&map, samples), None, "{samples} samples");
        }
    }

    #[test]
    fn a_smooth_map_is_no_break() {
        let map = kick(|x| -x.sin());
        for samples in [16, 64, 1024, 65536] {
            assert_eq!(search(&map, samples), None, "{samples} samples");
        }
    }

    #[test]
    fn a_break_is_substantial_in_either_coordinate() {
        let found = |jump_q, jump_p| Break {
            s: 0.5,
            uncertainty: 0.0,
            dof: 0,
            jump_q,
            jump_p,
            substep: None,
        };
        let ranges = [1e3, 1e-3];
        assert!(!found(0.9e-8, -0.9e-14).is_substantial(ranges));
        assert!(found(-1.1e-8, 0.0).is_substantial(ranges));
        assert!(found(0.0, 1.1e-14).is_substantial(ranges));
    }

    #[test]
    fn fewer_samples_than_a_group_show_nothing() {
        let map = kick(|x| -x.signum());
        assert_eq!(search(&map, GROUP - 1), None);
        assert!(search(&map, GROUP).is_some());
    }

    #[test]
    fn a_position_that_winds_does_not_jump_where_the_row_ends() {
        for n in [64, 1000] {
            let row: Vec<f64> = (0..n)
                .map(|k| k as f64 / n as f64)
                .map(|s| (3.0 + 2.0 * s + 0.1 * (std::f64::consts::TAU * s).sin()).rem_euclid(1.0))
                .collect();
            let found = suspect(0, Coordinate::Q, &row, 1.0);
            assert!(found.is_none(), "{n}: {found:?}");
        }
    }

    #[test]
    fn one_rounding_of_large_values_is_no_jump() {
        let row: Vec<f64> = (0..64).map(|k| 1e6 + 1e-10 * f64::from(k > 30)).collect();
        assert!(suspect(0, Coordinate::P, &row, 0.0).is_none());
        let row: Vec<f64> = (0..64).map(|k| 1e6 + 1e-8 * f64::from(k > 30)).collect();
        assert!(suspect(0, Coordinate::P, &row, 0.0).is_some());
    }

    /// The result of a search for a map that is known to return this number of binary digits.
    fn search_of_rounded(map: &dyn TimeAdvance, circle: &dyn Loop) -> Option<Break> {
        let mut states = Ensemble::sample(circle, 256).unwrap();
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count).unwrap();
        evaluator.advance(&mut states, 0.5).unwrap();
        evaluator.learn_grain(circle, 256, |c, k| crate::state::coordinate(&states, c)[k]);
        assert!(evaluator.grain().is_some());
        match find_break_with(&evaluator, circle, 0.5, &states).unwrap() {
            SearchResult::Found(found) => Some(found),
            SearchResult::Clean => None,
            SearchResult::Unaffordable => panic!("without a limit"),
        }
    }

    #[test]
    fn in_single_precision_a_jump_of_one_coordinate_breaks_the_loop() {
        let single = |x: f64| f64::from(x as f32);
        let circle = Circle::new(vec![0.0, 1e5], vec![0.0, 0.0], 1.0).unwrap();
        // Which coordinate of the second degree of freedom jumps.
        for jumps in [[0.0, 0.0], [0.0, 0.3], [0.3, 0.0]] {
            let map = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
                let (side_q, side_p) = ((p[1] - 0.3).signum(), (q[1] - 1e5 - 0.3).signum());
                q[1] += h * (p[1] + jumps[0] * side_q);
                p[1] -= h * (q[1] - 1e5 - jumps[0] * h * side_q + jumps[1] * side_p);
                for x in q.iter_mut().chain(p) {
                    *x = single(*x);
                }
            });
            let found = search_of_rounded(&map, &circle);
            assert_eq!(found.is_some(), jumps != [0.0; 2], "{jumps:?}: {found:?}");
        }
    }
}
