//! Closing in on a suspected jump, one state at a time.

use super::bracket::{
    Bracket, End, Progress, displace, flickers, interleaved, is_between_levels, keeps_its_levels,
    lands_on_a_level, lasting, stands_out,
};
use super::limits::{
    AROUND_A_ZONE, BETWEEN, CONFIRMING, DISTANCES_AROUND, LOOKS, ROUNDINGS, SAMPLES_OF_SIZE,
};
use super::residual::{Coordinate, Suspect};
use super::{Break, Search, uncertainty_of_position};
use crate::error::Error;
use crate::loops::Loop;
use crate::map::{Evaluator, states_at};
use crate::signal::{Barycentric, Extent, UNIT_ROUNDOFF, nearest};
use crate::state::Ensemble;

/// A point of the advanced loop in one degree of freedom.
#[derive(Clone, Copy)]
struct Point {
    s: f64,
    /// The coordinate that looks discontinuous, unwrapped and counted so that the jump is upwards.
    value: f64,
    q: f64,
    p: f64,
}

impl Point {
    /// Those of the samples of an ensemble in the suspected degree of freedom.
    fn of(suspect: &Suspect, states: &Ensemble, sample: usize, s: f64) -> Self {
        let q = states.q().row(suspect.dof)[sample];
        let p = states.p().row(suspect.dof)[sample];
        let value = match suspect.coordinate {
            Coordinate::Q => q,
            Coordinate::P => p,
        };
        Point { s, value, q, p }
    }
}

/// Evaluates the map on ever shorter stretches round a suspected jump.
///
/// The six samples around it are taken from `known`, if they are in memory. Finds a break if the two sides are
/// still apart when no double lies between. There is no break if the sides meet (the loop is steep but continuous there), if the
/// jump does not stand out of the noise and of the slope times the rounding of states, or if more states next to it have other
/// values than those of its two sides. If it stands out, its ends must land on its levels when they are displaced.
pub(super) fn follow(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    suspect: &Suspect,
    samples: usize,
    known: Option<&Ensemble>,
) -> Result<Search, Error> {
    let dof = suspect.dof;
    let period = match suspect.coordinate {
        Coordinate::Q => evaluator.coordinates().period(dof),
        Coordinate::P => evaluator.coordinates().momentum_period(dof),
    };
    let image = |s: &[f64]| -> Result<Vec<Point>, Error> {
        let on_loop: Vec<f64> = s.iter().map(|s| s.rem_euclid(1.0)).collect();
        let states = evaluator.image(phase_loop, h, &on_loop)?;
        let points = s.iter().enumerate();
        Ok((points.map(|(k, &s)| Point::of(suspect, &states, k, s))).collect())
    };
    // A cell at the beginning of the loop has neighbours at its end.
    let first = match suspect.cell {
        cell if cell < 2 => cell + samples - 2,
        cell => cell - 2,
    };
    let at = |k: usize| k as f64 / samples as f64;
    let around = first..first + 6;
    let around = match known {
        Some(states) => around
            .map(|k| Point::of(suspect, states, k % samples, at(k)))
            .collect(),
        None => image(&around.map(at).collect::<Vec<f64>>())?,
    };
    let mut sides = Sides::new(around, period);
    let [low, high] = [sides.left[0], sides.right[0]];
    let (expected, _) = sides.step_and_smooth(0.5 * (low.s + high.s));
    let mut bracket = Bracket::new([low.s, high.s], expected);
    while !bracket.is_narrow() {
        let middle = bracket.middle();
        let (step, smooth) = sides.step_and_smooth(middle);
        let mut point = image(&[middle])?[0];
        point.value = sides.count(point.value);
        let end = match point.value < smooth + 0.5 * step {
            true => End::Low,
            false => End::High,
        };
        sides.add(end, point);
        if bracket.halve(end, step) == Progress::Continuous {
            return Ok(Search::Clean);
        }
    }
    let ends = [sides.left[0], sides.right[0]];
    let jump = nearest(ends[1].value - ends[0].value, period);
    let jump_q = nearest(ends[1].q - ends[0].q, evaluator.coordinates().period(dof));
    let jump_p = nearest(
        ends[1].p - ends[0].p,
        evaluator.coordinates().momentum_period(dof),
    );
    let dofs = evaluator.dof();
    let is_rounding = evaluator.grain().is_some_and(|grain| {
        !grain.is_exceeded(dof, jump_q) && !grain.is_exceeded(dofs + dof, jump_p)
    });
    if is_rounding || bracket.is_little(jump) || !suspect.stands_out(jump.abs()) {
        return Ok(Search::Clean);
    }
    let found = Break {
        s: bracket.high.rem_euclid(1.0),
        uncertainty: bracket.high - bracket.low + uncertainty(phase_loop, dof, [jump_q, jump_p])?,
        dof,
        jump_q,
        jump_p,
        substep: None,
    };
    // Values on one side, from its end outwards.
    let beside = |end: End, s: &[f64]| -> Result<Vec<f64>, Error> {
        let origin = ends[end as usize].value;
        let points = image(s)?.into_iter();
        let from_end = |point: Point| origin + nearest(sides.sign * point.value - origin, period);
        Ok(points.map(from_end).collect())
    };
    // Whether both ends, displaced, stay on the levels of the jump.
    let are_steady = |close: &[Vec<f64>; 2]| -> Result<bool, Error> {
        let on_loop = ends.map(|point| point.s.rem_euclid(1.0));
        let mut states = states_at(phase_loop, &on_loop);
        for end in [End::Low, End::High] {
            displace(&mut states.block(), end as usize, 1 + end as usize);
        }
        evaluator.advance(&mut states, h)?;
        let lasting = lasting(jump, [&close[0], &close[1]]);
        let is_steady = |end: End| {
            let point = Point::of(suspect, &states, end as usize, on_loop[end as usize]);
            let moved = sides.sign * point.value - ends[end as usize].value;
            lands_on_a_level(jump, lasting, nearest(moved, period))
        };
        Ok(is_steady(End::Low) && is_steady(End::High))
    };
    let mut close = ends.map(|point| vec![point.value]);
    let look = |close: &mut [Vec<f64>; 2], states: usize| -> Result<(), Error> {
        for (side, end) in close.iter_mut().zip([End::Low, End::High]) {
            let s: Vec<f64> = bracket.beside(end).take(states).skip(side.len()).collect();
            side.extend(beside(end, &s)?);
        }
        Ok(())
    };
    for states in LOOKS {
        look(&mut close, states)?;
        if stands_out(jump, [&close[0], &close[1]]) {
            look(&mut close, CONFIRMING)?;
            if !are_steady(&close)? {
                return Ok(Search::Clean);
            }
            if keeps_its_levels(jump, [&close[0], &close[1]]) {
                return Ok(Search::Found(found));
            }
            break;
        }
    }
    if !flickers(jump, [&close[0], &close[1]]) {
        return Ok(Search::Clean);
    }
    for distance in DISTANCES_AROUND {
        if evaluator.count().left() < 2 * (AROUND_A_ZONE - 1 + BETWEEN) {
            return Ok(Search::Unaffordable);
        }
        let mut around = ends.map(|point| vec![point.value]);
        for (side, end) in around.iter_mut().zip([End::Low, End::High]) {
            let s: Vec<f64> = bracket.around(end, distance).skip(1).collect();
            side.extend(beside(end, &s)?);
        }
        if is_between_levels(jump, [&around[0], &around[1]]) {
            for (side, end) in around.iter_mut().zip([End::Low, End::High]) {
                let between = beside(end, &bracket.between(end, distance).collect::<Vec<f64>>())?;
                *side = interleaved(side, &between);
            }
            if is_between_levels(jump, [&around[0], &around[1]]) {
                return Ok(Search::Found(found));
            }
        }
    }
    Ok(Search::Clean)
}

/// How far along the loop the rounding of states may move a break with these jumps of q and p.
fn uncertainty(phase_loop: &dyn Loop, dof: usize, jumps: [f64; 2]) -> Result<f64, Error> {
    let states = Ensemble::sample(phase_loop, SAMPLES_OF_SIZE)?;
    let rows = [states.q().row(dof), states.p().row(dof)];
    let (mut rounding, mut largest) = (ROUNDINGS * UNIT_ROUNDOFF, 0.0f64);
    for (row, jump) in rows.into_iter().zip(jumps) {
        let extent = Extent::of(row);
        if extent.length() > 0.0 {
            let part = extent.magnitude() / extent.length();
            rounding = rounding.max(ROUNDINGS * UNIT_ROUNDOFF * part);
            largest = largest.max(2.0 * jump.abs() / extent.length());
        }
    }
    Ok(uncertainty_of_position(rounding, largest))
}

/// The three points nearest to a jump on each side of it, the nearest first.
struct Sides {
    left: [Point; 3],
    right: [Point; 3],
    period: f64,
    /// 1 where the coordinate jumps upwards, else −1.
    sign: f64,
}

impl Sides {
    /// From six neighbours.
    fn new(mut points: Vec<Point>, period: f64) -> Self {
        for k in 1..points.len() {
            let last = points[k - 1].value;
            points[k].value = last + nearest(points[k].value - last, period);
        }
        let mut sides = Sides {
            left: [points[2], points[1], points[0]],
            right: [points[3], points[4], points[5]],
            period,
            sign: 1.0,
        };
        let middle = points[2].s + 0.5 * (points[3].s - points[2].s);
        if sides.step_and_smooth(middle).0 < 0.0 {
            sides.sign = -1.0;
            for point in sides.left.iter_mut().chain(&mut sides.right) {
                point.value = -point.value;
            }
        }
        sides
    }

    /// A value of the coordinate as the points count it.
    fn count(&self, value: f64) -> f64 {
        let near = self.left[0].value;
        near + nearest(self.sign * value - near, self.period)
    }

    /// Adds a point between the two sides.
    fn add(&mut self, end: End, point: Point) {
        let side = match end {
            End::Low => &mut self.left,
            End::High => &mut self.right,
        };
        *side = [point, side[0], side[1]];
    }

    /// The polynomial of degree 4 with a step in the gap that goes through all six points: the step, and the value
    /// that the polynomial takes at `s`.
    fn step_and_smooth(&self, s: f64) -> (f64, f64) {
        let points = || self.left.iter().chain(&self.right);
        let polynomial = Barycentric::at(points().map(|point| point.s - s).collect());
        let origin = self.left[0].value;
        let mut values: Vec<f64> = points().map(|point| point.value - origin).collect();
        // The highest divided difference of the values is that of the step alone.
        let unit = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let step = polynomial.divided_difference(&values) / polynomial.divided_difference(&unit);
        values[3..].iter_mut().for_each(|value| *value -= step);
        (step, origin + polynomial.evaluate(&values, 0.0))
    }
}
