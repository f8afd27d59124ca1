//! Why loops break: states on both sides of a break.

mod limits;

use limits::{
    DISTANCES, FIRST_PART_OF_STEP, MAX_COMPARED_BREAKS, MAX_COORDINATES, MAX_DISTANCE_OVER_JUMP,
    MAX_PART_OF_STEP, MAX_SECANT_TRIALS, MIN_DISTANCE, MIN_DISTANCE_IN_UNCERTAINTIES,
    MIN_EVALUATIONS_MADE, MIN_MADE_FOR_FLOW, SUBDIVISIONS,
};

use super::{GivenLoop, Runner};
use crate::breaks::Break;
use crate::error::Error;
use crate::evidence::{BreakAlongFlow, BreakSides, CoordinateAtBreak, PositionAtBreak};
use crate::map::{LoopSize, states_at};
use crate::rules::Subject;
use crate::signal::{Extent, dot, nearest};
use crate::state::{Ensemble, coordinate, coordinate_mut, period};

/// The images of states on both sides of a break, the nearest first.
struct Sides {
    /// The distances from the break along the loop.
    distances: Vec<f64>,
    /// Those below the break, then those above.
    after: Ensemble,
}

impl Runner<'_> {
    /// Looks at both sides of the largest break of the first loop that has one.
    pub(super) fn look_at_break(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        // What tells the cause costs a small part of what told the break.
        if self.count.made() < MIN_EVALUATIONS_MADE || given.probe.is_beyond_memory() {
            return Ok(());
        }
        let broken = (self.evidence.loops.iter()).find(|found| !found.winds && found.is_broken());
        let Some((found, step, jump)) = broken.and_then(|found| {
            let steps = found.steps.iter().filter(|step| step.jump.is_some());
            let size = |of: Option<f64>| of.map_or(f64::INFINITY, f64::abs);
            let step = steps.max_by(|a, b| size(a.step_size).total_cmp(&size(b.step_size)))?;
            Some((found, step, step.jump?))
        }) else {
            return Ok(());
        };
        let h = step.step_size.unwrap_or(self.largest);
        let others = (self.evidence.breaks.iter())
            .filter(|other| other.loop_index == found.index && other.step_size == step.step_size)
            .map(|other| other.found)
            .filter(|other| other.dof == jump.dof && other.s != jump.s);
        let breaks: Vec<Break> = std::iter::once(jump)
            .chain(others)
            .take(MAX_COMPARED_BREAKS)
            .collect();
        let random = (self.diagnostic).random_loop_of(found, &given.size, subject)?;
        let subject = subject.on(random.as_ref());
        let (loop_index, step_size) = (found.index, step.step_size);
        // Next to a break there may be another one: then the largest of those further away.
        let size = |of: &Break| of.jump_q.abs().max(of.jump_p.abs());
        let further = (breaks.iter())
            .filter(|of| (of.s - jump.s).abs() > DISTANCES[DISTANCES.len() - 1])
            .max_by(|a, b| size(a).total_cmp(&size(b)));
        let mut looks = std::iter::once(&jump).chain(further);
        let Some((mut sides, low_and_high)) = looks
            .find_map(|of| look(subject, h, of, &given.size).transpose())
            .transpose()?
        else {
            return Ok(());
        };
        (sides.loop_index, sides.step_size) = (loop_index, step_size);
        if step_size.is_some() && self.count.made() >= MIN_MADE_FOR_FLOW {
            sides.along_flow = along_flow(subject, h, &low_and_high, &given.size)?;
        }
        sides.places = places(subject, h, &breaks)?;
        if let Some(picture) = &self.evidence.picture {
            for of in &mut sides.coordinates {
                let c = if of.coordinate == 'q' {
                    of.dof
                } else {
                    sides.dof + of.dof
                };
                of.range = Extent::of(coordinate(&picture.after, c)).length();
            }
        }
        self.evidence.break_sides = Some(sides);
        Ok(())
    }
}

/// States next to the break, and the images on its two sides. `None` if they do not show the jump: there may be another break next to it.
fn look(
    subject: Subject<'_>,
    h: f64,
    jump: &Break,
    size: &LoopSize,
) -> Result<Option<(BreakSides, Ensemble)>, Error> {
    let (evaluator, dof) = (subject.evaluator, subject.dof());
    let nearest_distance = MIN_DISTANCE.max(MIN_DISTANCE_IN_UNCERTAINTIES * jump.uncertainty);
    let distances: Vec<f64> = [nearest_distance, 2.0 * nearest_distance]
        .into_iter()
        .chain(
            DISTANCES
                .into_iter()
                .filter(|&d| d > 2.0 * nearest_distance),
        )
        .collect();
    let below = distances.iter().map(|d| jump.s - d);
    let s: Vec<f64> = below
        .chain(distances.iter().map(|d| jump.s + d))
        .map(|s| s.rem_euclid(1.0))
        .collect();
    let after = evaluator.image(subject.phase_loop, h, &s)?;
    let before = states_at(subject.phase_loop, &[jump.s]);
    let sides = Sides { distances, after };
    let mut low_and_high = Ensemble::zeros(dof, 2);
    let mut all = Vec::new();
    for c in 0..2 * dof {
        let found = sides.coordinate(c, dof, &before, size, period(evaluator.coordinates(), c));
        let mut block = low_and_high.block();
        coordinate_mut(&mut block, c).copy_from_slice(&found.after);
        all.push(found);
    }
    let shows = |of: f64, jumps: f64| (of - jumps).abs() <= 0.5 * jumps.abs();
    let [q, p] = [&all[jump.dof], &all[dof + jump.dof]];
    let shown = match jump.jump_q.abs() / q.radius > jump.jump_p.abs() / p.radius {
        true => shows(q.jump(), jump.jump_q),
        false => shows(p.jump(), jump.jump_p),
    };
    if !shown {
        return Ok(None);
    }
    let jumping = all.iter().filter(|of| of.jumps).count();
    let jumping_p = all[dof..].iter().filter(|of| of.jumps).count();
    Ok(Some((
        BreakSides {
            loop_index: 0,
            step_size: None,
            s: jump.s,
            coordinates: of_interest(all),
            dof,
            jumping,
            jumping_p,
            along_flow: None,
            of_break: jump.dof,
            places: Vec::new(),
        },
        low_and_high,
    )))
}

/// Coordinates that jump or are constant on one side, and their partners.
fn of_interest(all: Vec<CoordinateAtBreak>) -> Vec<CoordinateAtBreak> {
    let dof = all.len() / 2;
    let scaled = |of: &CoordinateAtBreak| match of.jumps {
        true => of.jump().abs() / of.radius,
        false => 0.0,
    };
    let mut order: Vec<usize> = (0..all.len())
        .filter(|&c| all[c].jumps || all[c].constant[0] != all[c].constant[1])
        .collect();
    order.sort_by(|&a, &b| scaled(&all[b]).total_cmp(&scaled(&all[a])));
    order.truncate(MAX_COORDINATES);
    for c in order.clone() {
        let partner = (c + dof) % (2 * dof);
        if !order.contains(&partner) {
            order.push(partner);
        }
    }
    order.into_iter().map(|c| all[c]).collect()
}

impl Sides {
    fn coordinate(
        &self,
        c: usize,
        dof: usize,
        before: &Ensemble,
        size: &LoopSize,
        period: f64,
    ) -> CoordinateAtBreak {
        let row = coordinate(&self.after, c);
        let [low, high] = [0, 1].map(|side| {
            let states = side * self.distances.len();
            // The second distance is twice the first one: the line through both states meets the break.
            let step = nearest(row[states] - row[states + 1], period);
            let constant = (row[states..states + self.distances.len()].iter())
                .all(|value| value.to_bits() == row[states].to_bits());
            (row[states] + step, step.abs(), constant)
        });
        let above = low.0 + nearest(high.0 - low.0, period);
        let rounding = 16.0 * f64::EPSILON * low.0.abs().max(above.abs());
        CoordinateAtBreak {
            range: 0.0,
            coordinate: if c < dof { 'q' } else { 'p' },
            dof: c % dof,
            before: coordinate(before, c)[0],
            after: [low.0, above],
            jumps: (above - low.0).abs() > rounding.max(low.1 + high.1),
            constant: [low.2, high.2],
            radius: size.radius[c / dof][c % dof],
        }
    }
}

/// The step size that takes one side of the break to the other, and how nearly: the rate at which the map moves each side gives a
/// first estimate, the secant method the rest.
fn along_flow(
    subject: Subject<'_>,
    h: f64,
    sides: &Ensemble,
    size: &LoopSize,
) -> Result<Option<BreakAlongFlow>, Error> {
    let (evaluator, dof) = (subject.evaluator, subject.dof());
    // In units of the radii.
    let difference = |from: (&Ensemble, usize), to: (&Ensemble, usize)| -> Vec<f64> {
        let of = |c: usize| {
            let (from, to) = (coordinate(from.0, c)[from.1], coordinate(to.0, c)[to.1]);
            nearest(to - from, period(evaluator.coordinates(), c)) / size.radius[c / dof][c % dof]
        };
        (0..2 * dof).map(of).collect()
    };
    let mut states = sides.clone();
    evaluator.advance(&mut states, FIRST_PART_OF_STEP * h)?;
    let first = [0, 1].map(|side| {
        let towards = difference((sides, side), (sides, 1 - side));
        let moved = difference((sides, side), (&states, side));
        FIRST_PART_OF_STEP * dot(&towards, &moved) / dot(&moved, &moved)
    });
    // The flow leads from one side to the other in positive time.
    let side = usize::from(first[1] > first[0]);
    let length = norm(&difference((sides, 0), (sides, 1)));
    let mut known = (0.0, difference((sides, side), (sides, 1 - side)));
    let mut part = first[side];
    let mut best: Option<BreakAlongFlow> = None;
    for _ in 0..MAX_SECANT_TRIALS {
        if !(part > 0.0 && part <= MAX_PART_OF_STEP) {
            break;
        }
        let mut state = column(sides, side);
        for _ in 0..SUBDIVISIONS {
            evaluator.advance(&mut state, part * h / SUBDIVISIONS as f64)?;
        }
        let miss = difference((&state, 0), (sides, 1 - side));
        let distance = norm(&miss) / length;
        if best.is_none_or(|best| distance < best.distance) {
            best = Some(BreakAlongFlow { part, distance });
        }
        if distance < MAX_DISTANCE_OVER_JUMP {
            break;
        }
        let moved: Vec<f64> = (known.1.iter().zip(&miss)).map(|(a, b)| a - b).collect();
        let next = part + (part - known.0) * dot(&miss, &moved) / dot(&moved, &moved);
        known = (part, miss);
        part = next;
    }
    Ok(best)
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// One of the states.
fn column(states: &Ensemble, sample: usize) -> Ensemble {
    let mut state = Ensemble::zeros(states.dof(), 1);
    for c in 0..2 * states.dof() {
        coordinate_mut(&mut state.block(), c)[0] = coordinate(states, c)[sample];
    }
    state
}

/// The states of the degrees of freedom that jump at these breaks.
fn places(subject: Subject<'_>, h: f64, breaks: &[Break]) -> Result<Vec<PositionAtBreak>, Error> {
    let s: Vec<f64> = breaks.iter().map(|found| found.s).collect();
    let before = states_at(subject.phase_loop, &s);
    let beside: Vec<f64> = (breaks.iter())
        .map(|found| {
            let distance = MIN_DISTANCE.max(MIN_DISTANCE_IN_UNCERTAINTIES * found.uncertainty);
            (found.s - distance).rem_euclid(1.0)
        })
        .collect();
    let after = subject.evaluator.image(subject.phase_loop, h, &beside)?;
    let of = |(k, found): (usize, &Break)| PositionAtBreak {
        before: before.q().row(found.dof)[k],
        velocity: before.p().row(found.dof)[k],
        after: after.q().row(found.dof)[k] + 0.5 * found.jump_q,
        jump_q: found.jump_q,
    };
    Ok(breaks.iter().enumerate().map(of).collect())
}
