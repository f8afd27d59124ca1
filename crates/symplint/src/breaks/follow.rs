//! Closing in on a suspected jump, one state at a time.

use super::bracket::{
    Bracket, End, Progress, displace, flickers, interleaved, is_between_levels, keeps_its_levels,
    lands_on_a_level, lasting, stands_out,
};
use super::limits::{
    CONFIRMING_STATES, DISTANCES_FROM_ZONE, INTERMEDIATE_ZONE_STATES, MAX_ROUNDINGS_OF_RESIDUAL,
    SAMPLES_OF_SIZE, STATES_AROUND_ZONE, STATES_OF_LOOKS,
};
use super::residual::{Coordinate, Suspect};
use super::{Break, SearchResult, uncertainty_of_position};
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
/// still apart when no double lies between. It is not a break if the sides meet (the loop is steep but continuous there), if the
/// jump does not stand out of the noise and of the slope times the rounding of states, or if more states next to it have other
/// values than those of its two sides. If it stands out, its ends must land on its levels when they are displaced.
pub(super) fn follow(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    suspect: &Suspect,
    samples: usize,
    known: Option<&Ensemble>,
) -> Result<SearchResult, Error> {
    let stretch = Stretch {
        evaluator,
        phase_loop,
        h,
        suspect,
        period: match suspect.coordinate {
            Coordinate::Q => evaluator.coordinates().period(suspect.dof),
            Coordinate::P => evaluator.coordinates().momentum_period(suspect.dof),
        },
    };
    let mut sides = Sides::new(stretch.around(samples, known)?, stretch.period);
    let Some(bracket) = stretch.narrow(&mut sides)? else {
        return Ok(SearchResult::Clean);
    };
    let ends = [sides.left[0], sides.right[0]];
    let gap = Gap {
        stretch: &stretch,
        bracket: &bracket,
        sign: sides.sign,
        ends,
        jump: nearest(ends[1].value - ends[0].value, stretch.period),
    };
    let Some(found) = gap.as_break()? else {
        return Ok(SearchResult::Clean);
    };
    let side_states = gap.side_states()?;
    if let SideStates::OnLevels = side_states {
        return Ok(SearchResult::Found(found));
    }
    gap.repeat_ends()?;
    match side_states {
        SideStates::Flickering => gap.behind_the_zone(found),
        _ => Ok(SearchResult::Clean),
    }
}

/// A stretch of the loop with a suspected jump, after a step.
struct Stretch<'a> {
    evaluator: &'a Evaluator<'a>,
    phase_loop: &'a dyn Loop,
    h: f64,
    suspect: &'a Suspect,
    /// The period of the suspected coordinate.
    period: f64,
}

impl Stretch<'_> {
    /// The points at the parameters `s`, which may lie outside [0, 1).
    fn image(&self, s: &[f64]) -> Result<Vec<Point>, Error> {
        let on_loop: Vec<f64> = s.iter().map(|s| s.rem_euclid(1.0)).collect();
        let states = self.evaluator.image(self.phase_loop, self.h, &on_loop)?;
        let points = s.iter().enumerate();
        Ok((points.map(|(k, &s)| Point::of(self.suspect, &states, k, s))).collect())
    }

    /// The six samples around the jump.
    fn around(&self, samples: usize, known: Option<&Ensemble>) -> Result<Vec<Point>, Error> {
        // A cell at the beginning of the loop has neighbours at its end.
        let first = match self.suspect.cell {
            cell if cell < 2 => cell + samples - 2,
            cell => cell - 2,
        };
        let at = |k: usize| k as f64 / samples as f64;
        let around = first..first + 6;
        match known {
            Some(states) => Ok(around
                .map(|k| Point::of(self.suspect, states, k % samples, at(k)))
                .collect()),
            None => self.image(&around.map(at).collect::<Vec<f64>>()),
        }
    }

    /// Halves the stretch until no double lies between its sides; `None` if they meet.
    fn narrow(&self, sides: &mut Sides) -> Result<Option<Bracket>, Error> {
        let [low, high] = [sides.left[0], sides.right[0]];
        let (expected, _) = sides.step_and_smooth(0.5 * (low.s + high.s));
        let mut bracket = Bracket::new([low.s, high.s], expected);
        while !bracket.is_narrow() {
            let middle = bracket.middle();
            let (step, smooth) = sides.step_and_smooth(middle);
            let mut point = self.image(&[middle])?[0];
            point.value = sides.count(point.value);
            let end = match point.value < smooth + 0.5 * step {
                true => End::Low,
                false => End::High,
            };
            sides.add(end, point);
            if bracket.halve(end, step) == Progress::Continuous {
                return Ok(None);
            }
        }
        Ok(Some(bracket))
    }
}

/// The states on one side of a gap.
enum SideStates {
    /// They keep the level of their side.
    OnLevels,
    /// They take values of both sides.
    Flickering,
    /// They have other values.
    Elsewhere,
}

/// Two sides that are apart though no double lies between them.
struct Gap<'a> {
    stretch: &'a Stretch<'a>,
    bracket: &'a Bracket,
    /// 1 if the coordinate jumps upwards, else −1.
    sign: f64,
    ends: [Point; 2],
    /// Of the suspected coordinate.
    jump: f64,
}

impl Gap<'_> {
    /// The gap as a break, unless it is as small as rounding and slopes make it.
    fn as_break(&self) -> Result<Option<Break>, Error> {
        let Stretch {
            evaluator, suspect, ..
        } = self.stretch;
        let (dof, dofs, coordinates) = (suspect.dof, evaluator.dof(), evaluator.coordinates());
        let [low, high] = &self.ends;
        let jump_q = nearest(high.q - low.q, coordinates.period(dof));
        let jump_p = nearest(high.p - low.p, coordinates.momentum_period(dof));
        let is_rounding = evaluator.grain().is_some_and(|grain| {
            !grain.is_exceeded(dof, jump_q) && !grain.is_exceeded(dofs + dof, jump_p)
        });
        let is_little = self.bracket.is_little(self.jump);
        if is_rounding || is_little || !suspect.stands_out(self.jump.abs()) {
            return Ok(None);
        }
        let of_rounding = uncertainty(self.stretch.phase_loop, dof, [jump_q, jump_p])?;
        Ok(Some(Break {
            s: self.bracket.high.rem_euclid(1.0),
            uncertainty: self.bracket.high - self.bracket.low + of_rounding,
            dof,
            jump_q,
            jump_p,
            substep: None,
        }))
    }

    /// Advances both ends once more: what the map does at random, or as earlier calls left it, looks like a break.
    fn repeat_ends(&self) -> Result<(), Error> {
        let Stretch {
            evaluator, suspect, ..
        } = self.stretch;
        if evaluator.is_noisy() || evaluator.count().left() < self.ends.len() {
            return Ok(());
        }
        for first in &self.ends {
            // Alone, as the middles of brackets were.
            let again = self.stretch.image(&[first.s])?[0];
            let (c, results) = match suspect.coordinate {
                Coordinate::Q => (suspect.dof, [first.q, again.q]),
                Coordinate::P => (evaluator.dof() + suspect.dof, [first.p, again.p]),
            };
            evaluator.compare(c, results, self.jump);
        }
        Ok(())
    }

    /// Values on one side, from its end outwards.
    fn beside(&self, end: End, s: &[f64]) -> Result<Vec<f64>, Error> {
        let origin = self.ends[end as usize].value;
        let points = self.stretch.image(s)?.into_iter();
        let from_end =
            |point: Point| origin + nearest(self.sign * point.value - origin, self.stretch.period);
        Ok(points.map(from_end).collect())
    }

    /// Looks at more states next to the gap.
    fn side_states(&self) -> Result<SideStates, Error> {
        let mut close = self.ends.map(|point| vec![point.value]);
        let look = |close: &mut [Vec<f64>; 2], states: usize| -> Result<(), Error> {
            for (side, end) in close.iter_mut().zip([End::Low, End::High]) {
                let s = self.bracket.beside(end).take(states).skip(side.len());
                side.extend(self.beside(end, &s.collect::<Vec<f64>>())?);
            }
            Ok(())
        };
        for states in STATES_OF_LOOKS {
            look(&mut close, states)?;
            if stands_out(self.jump, [&close[0], &close[1]]) {
                look(&mut close, CONFIRMING_STATES)?;
                if !self.are_steady(&close)? {
                    return Ok(SideStates::Elsewhere);
                }
                if keeps_its_levels(self.jump, [&close[0], &close[1]]) {
                    return Ok(SideStates::OnLevels);
                }
                break;
            }
        }
        match flickers(self.jump, [&close[0], &close[1]]) {
            true => Ok(SideStates::Flickering),
            false => Ok(SideStates::Elsewhere),
        }
    }

    /// Whether both ends, displaced, stay on the levels of the jump.
    fn are_steady(&self, close: &[Vec<f64>; 2]) -> Result<bool, Error> {
        let stretch = self.stretch;
        let on_loop = self.ends.map(|point| point.s.rem_euclid(1.0));
        let mut states = states_at(stretch.phase_loop, &on_loop);
        for end in [End::Low, End::High] {
            displace(&mut states.block(), end as usize, 1 + end as usize);
        }
        stretch.evaluator.advance(&mut states, stretch.h)?;
        let lasting = lasting(self.jump, [&close[0], &close[1]]);
        let is_steady = |end: End| {
            let k = end as usize;
            let point = Point::of(stretch.suspect, &states, k, on_loop[k]);
            let moved = self.sign * point.value - self.ends[k].value;
            lands_on_a_level(self.jump, lasting, nearest(moved, stretch.period))
        };
        Ok(is_steady(End::Low) && is_steady(End::High))
    }

    /// Looks farther away, behind a zone next to the gap in which states flicker between its sides.
    fn behind_the_zone(&self, found: Break) -> Result<SearchResult, Error> {
        for distance in DISTANCES_FROM_ZONE {
            if self.stretch.evaluator.count().left()
                < 2 * (STATES_AROUND_ZONE - 1 + INTERMEDIATE_ZONE_STATES)
            {
                return Ok(SearchResult::Unaffordable);
            }
            let mut around = self.ends.map(|point| vec![point.value]);
            for (side, end) in around.iter_mut().zip([End::Low, End::High]) {
                let s: Vec<f64> = self.bracket.around(end, distance).skip(1).collect();
                side.extend(self.beside(end, &s)?);
            }
            if is_between_levels(self.jump, [&around[0], &around[1]]) {
                for (side, end) in around.iter_mut().zip([End::Low, End::High]) {
                    let s: Vec<f64> = self.bracket.between(end, distance).collect();
                    *side = interleaved(side, &self.beside(end, &s)?);
                }
                if is_between_levels(self.jump, [&around[0], &around[1]]) {
                    return Ok(SearchResult::Found(found));
                }
            }
        }
        Ok(SearchResult::Clean)
    }
}

/// How far along the loop the rounding of states may move a break with these jumps of q and p.
fn uncertainty(phase_loop: &dyn Loop, dof: usize, jumps: [f64; 2]) -> Result<f64, Error> {
    let states = Ensemble::sample(phase_loop, SAMPLES_OF_SIZE)?;
    let rows = [states.q().row(dof), states.p().row(dof)];
    let (mut rounding, mut largest) = (MAX_ROUNDINGS_OF_RESIDUAL * UNIT_ROUNDOFF, 0.0f64);
    for (row, jump) in rows.into_iter().zip(jumps) {
        let extent = Extent::of(row);
        if extent.length() > 0.0 {
            let part = extent.magnitude() / extent.length();
            rounding = rounding.max(MAX_ROUNDINGS_OF_RESIDUAL * UNIT_ROUNDOFF * part);
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
