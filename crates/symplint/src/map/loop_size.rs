//! How far a loop reaches in each coordinate, and how far tests should go in those that it leaves at rest.

use std::f64::consts::TAU;

use super::{EvaluationCount, Evaluator, TimeAdvance};
use crate::error::Error;
use crate::loops::{Circle, FEW_SAMPLES, Loop};
use crate::signal::{Extent, Turns, nearest};
use crate::state::{Block, Coordinates, Ensemble, coordinate, coordinate_mut, period};

/// Repetitions of the balance of q against p: a ratio that is off by 2^60 where forces are bounded is off by a factor
/// of 1.3 then, and no more are needed where they are linear.
const BALANCE_ROUNDS: usize = 4;

/// Displacements that tell the ratio, in units of the radii: small, as forces that fall off would make radii that are
/// too large still larger; and not so small that the rounding of single precision shows.
const DISPLACEMENT: f64 = 1.0 / 64.0;

/// A degree of freedom at rest at a centre (q, p) is given this part of √(q²/ρ + ρp²) for a radius, if no other
/// one tells.
const PART_OF_CENTRE: f64 = 0.1;

/// Actions of a group differ by no more than this factor. A loop integral is a sum of actions: what is wrong in the
/// smallest one of a group shows three digits less.
const MAX_RATIO_IN_GROUP: f64 = 1e3;

/// Groups at most, down to actions of 1e-96 of the largest; the last one holds all smaller ones.
const MAX_GROUPS: usize = 32;

/// The motion on which a centre lies may be this many times as large as what a step shows of it.
const MAX_OVER_MOTION: f64 = 2.0;

/// A state this much smaller than others is what rounding leaves of zero.
const MAX_ROUNDED_ZERO: f64 = 1e-14;

/// Radii of a loop that fit a map: see [`balanced_radii`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BalancedRadii {
    /// One for each position.
    pub q: Vec<f64>,
    /// One for each momentum.
    pub p: Vec<f64>,
    /// Evaluations of the map that it took to find them.
    pub evaluations: usize,
}

impl BalancedRadii {
    /// A loop with these radii, for which a report counts the evaluations that found them.
    pub fn counted<L: Loop>(&self, phase_loop: L) -> impl Loop + use<L> {
        ChosenLoop {
            phase_loop,
            evaluations: self.evaluations,
        }
    }
}

/// A loop that was chosen by evaluations of the map.
struct ChosenLoop<L> {
    phase_loop: L,
    evaluations: usize,
}

impl<L: Loop> Loop for ChosenLoop<L> {
    fn dof(&self) -> usize {
        self.phase_loop.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        self.phase_loop.sample(s, block);
    }

    fn evaluations(&self) -> usize {
        self.evaluations
    }
}

/// Radii of a loop round (q0, p0) in the proportions that the map suggests at step size `h`, for
/// [`Circle::with_radii`](crate::Circle::with_radii).
///
/// In each degree of freedom the ratio ρ of the radius in q to that in p is balanced: displaced by its radius, q changes
/// p by as large a part of the radius of p as p changes q. The size is a tenth of that of the centre, √(q²/ρ + ρp²) with
/// the ratio taken out, or of the motion that a step shows of it, (Δq²/ρ + ρΔp²)/(hω)² times 4, if this is smaller: an
/// origin may be far away. Of a periodic position, one radian counts instead of q. A degree of freedom that is at the
/// origin is given the area of the largest of the others; if all are there, radii whose product is 1. The proportions
/// are the same in all units.
///
/// ```
/// use symplint::map::balanced_radii;
/// use symplint::{Circle, PerSample};
///
/// // A stiff spring: the motion runs on ellipses 100 times as high as they are wide.
/// let map = PerSample::new(1, |h, q, p| {
///     p[0] -= h * 1e4 * q[0];
///     q[0] += h * p[0];
/// });
/// let radii = balanced_radii(&map, &[0.3], &[0.0], 1e-3)?;
/// assert!((radii.q[0] - 0.03).abs() < 1e-3 && (radii.p[0] - 3.0).abs() < 0.1);
/// let circle = Circle::with_radii(vec![0.3], vec![0.0], radii.q.clone(), radii.p.clone())?;
/// let phase_loop = radii.counted(circle);
/// # Ok::<(), symplint::Error>(())
/// ```
///
/// # Errors
/// If map and centre differ in their degrees of freedom, a centre is not finite, or the map fails there.
pub fn balanced_radii(
    map: &dyn TimeAdvance,
    q0: &[f64],
    p0: &[f64],
    h: f64,
) -> Result<BalancedRadii, Error> {
    let count = EvaluationCount::unlimited();
    let evaluator = Evaluator::new(map, &count)?;
    evaluator.check_dof(q0.len())?;
    let none = vec![0.0; q0.len()];
    let centre = Circle::with_radii(q0.to_vec(), p0.to_vec(), none.clone(), none)?;
    evaluator.image(&centre, h, &[0.0])?;
    let [q, p] = LoopSize::of(&evaluator, &centre, h)?.radius;
    Ok(BalancedRadii {
        q,
        p,
        evaluations: count.made(),
    })
}

/// Centre and half the range of every coordinate of a loop: the sizes of what tests do next to it.
///
/// A loop need not move all coordinates, and tests must: a map has to be symplectic in every direction. In a degree of
/// freedom at rest the product of both radii is the largest one of the others, as actions have one unit in all of
/// them; that of its centre, if this is much smaller. The ratio ρ of both is balanced by the response of the map: displaced by a part
/// of its radius, q changes p by as large a part of the radius of p as p changes q. Both are the same in all units.
#[derive(Clone, Debug)]
pub(crate) struct LoopSize {
    /// Of all positions, then of all momenta.
    pub centre: [Vec<f64>; 2],
    /// In the same order.
    pub radius: [Vec<f64>; 2],
    /// Degrees of freedom that the loop leaves at rest.
    pub at_rest: Vec<bool>,
    /// Degrees of freedom in groups of similar action, weight × radius in q × radius in p, the largest first; none
    /// where there is only one.
    pub groups: Vec<ActionGroup>,
}

/// Degrees of freedom of similar action.
#[derive(Clone, Debug)]
pub(crate) struct ActionGroup {
    /// Which, in ascending order.
    pub dofs: Vec<usize>,
    /// Their largest action, as a part of the largest one of all.
    pub action: f64,
}

impl ActionGroup {
    /// Groups of degrees of freedom with these actions; none where there is only one.
    fn of(actions: &[f64]) -> Vec<ActionGroup> {
        let lowest = actions.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = actions.iter().copied().fold(0.0, f64::max);
        if lowest * MAX_RATIO_IN_GROUP >= highest {
            return Vec::new();
        }
        let mut order: Vec<usize> = (0..actions.len()).collect();
        order.sort_by(|&a, &b| actions[b].total_cmp(&actions[a]));
        let largest = order.first().map_or(1.0, |&i| actions[i]);
        let mut groups: Vec<ActionGroup> = Vec::new();
        for i in order {
            let action = actions[i] / largest;
            let full = groups.len() == MAX_GROUPS;
            match groups.last_mut() {
                Some(last) if full || action * MAX_RATIO_IN_GROUP >= last.action => {
                    last.dofs.push(i)
                }
                _ => groups.push(ActionGroup {
                    dofs: vec![i],
                    action,
                }),
            }
        }
        for group in &mut groups {
            group.dofs.sort_unstable();
        }
        groups
    }
}

impl LoopSize {
    /// The same with radii that are this many times as large.
    pub fn times(&self, factor: f64) -> Self {
        let scaled = |radii: &Vec<f64>| radii.iter().map(|radius| factor * radius).collect();
        LoopSize {
            radius: self.radius.each_ref().map(scaled),
            ..self.clone()
        }
    }

    /// That of `phase_loop`; coordinates at rest are displaced, and advanced by a step of size `h`.
    ///
    /// # Errors
    /// If the samples of the loop do not fit into memory. If the map cannot be evaluated, coordinates at rest have
    /// a size without it.
    pub fn of(evaluator: &Evaluator<'_>, phase_loop: &dyn Loop, h: f64) -> Result<Self, Error> {
        let dof = phase_loop.dof();
        let coordinates = evaluator.coordinates();
        let mut extents = vec![[Extent::default(); 2]; dof];
        let mut turns = vec![[Turns::default(); 2]; dof];
        Ensemble::in_parts(phase_loop, FEW_SAMPLES, |part| {
            for (i, [of_q, of_p]) in extents.iter_mut().enumerate() {
                for &q in part.q().row(i) {
                    of_q.include(turns[i][0].unwrap(q, coordinates.period(i)));
                }
                for &p in part.p().row(i) {
                    of_p.include(turns[i][1].unwrap(p, coordinates.momentum_period(i)));
                }
            }
            Ok(())
        })?;
        let of_each = |what: fn(&Extent) -> f64| {
            [0, 1].map(|c: usize| extents.iter().map(|of_dof| what(&of_dof[c])).collect())
        };
        let radius: [Vec<f64>; 2] = of_each(|extent| extent.length() / 2.0);
        let mut size = LoopSize {
            centre: of_each(Extent::middle),
            at_rest: (0..dof)
                .map(|i| radius[0][i] == 0.0 && radius[1][i] == 0.0)
                .collect(),
            radius,
            groups: Vec::new(),
        };
        drop(extents);
        let open: Vec<usize> = (0..dof)
            .filter(|&i| size.radius[0][i] == 0.0 || size.radius[1][i] == 0.0)
            .collect();
        if !open.is_empty() {
            let mut state = Ensemble::zeros(dof, 1);
            phase_loop.sample(&[0.0], &mut state.block());
            size.balance(evaluator, &state, &open, h);
        }
        let action = |i: usize| coordinates.weight(i).abs() * size.radius[0][i] * size.radius[1][i];
        let actions: Vec<f64> = (0..dof).map(action).collect();
        size.groups = ActionGroup::of(&actions);
        Ok(size)
    }

    /// Sizes for the coordinates at rest of the degrees of freedom `open`.
    fn balance(&mut self, evaluator: &Evaluator<'_>, state: &Ensemble, open: &[usize], h: f64) {
        let coordinates = evaluator.coordinates();
        let given = self.radius.clone();
        let action = |i: usize| coordinates.weight(i).abs() * given[0][i] * given[1][i];
        let action = (0..given[0].len()).map(action).fold(0.0, f64::max);
        let displaced = DisplacedState {
            evaluator,
            state,
            open,
            h,
        };
        let motion = displaced.motion().ok();
        let mut ratios = self.first_ratios(&displaced, motion.as_ref());
        // Advanced by a radian in a step, until it is known.
        let mut squared_advances = vec![1.0; open.len()];
        for repetition in 0..=BALANCE_ROUNDS {
            let of_centres = (open.iter().zip(&ratios).enumerate())
                .map(|(k, (&i, &ratio))| {
                    let moved = motion.as_ref().map(|[q, p]| [q[k], p[k]]);
                    let weight = coordinates.weight(i).abs();
                    weight * self.of_centre(i, ratio, moved, squared_advances[k], coordinates)
                })
                .collect();
            self.take(&given, open, &ratios, of_centres, action, coordinates);
            if repetition == BALANCE_ROUNDS {
                break;
            }
            // If the map fails next to the loop, what is known has to be enough.
            let Ok(balanced) = displaced.balanced(&self.radius) else {
                break;
            };
            for (k, balanced) in balanced.into_iter().enumerate() {
                if let Some((ratio, squared_advance)) = balanced {
                    (ratios[k], squared_advances[k]) = (ratio, squared_advance);
                }
            }
        }
    }

    /// The action, without the weight, of a loop of a tenth of the size of the centre: of its distance from the origin, or
    /// of the motion that a step of (hω)² = `squared_advance` moves along, if this is smaller. An origin may be far
    /// away.
    fn of_centre(
        &self,
        i: usize,
        ratio: f64,
        moved: Option<[f64; 2]>,
        squared_advance: f64,
        coordinates: &Coordinates,
    ) -> f64 {
        let squared = |q: f64, p: f64| q * q / ratio + ratio * p * p;
        let of_origin = match coordinates.period(i) {
            0.0 => squared(self.centre[0][i], self.centre[1][i]),
            period => squared(period / TAU, self.centre[1][i]),
        };
        let of_motion = moved.map(|[q, p]| squared(q, p) / squared_advance);
        let within = of_motion.map(|squared| MAX_OVER_MOTION * MAX_OVER_MOTION * squared);
        let smaller =
            within.filter(|&within| within > MAX_ROUNDED_ZERO * of_origin && within < of_origin);
        PART_OF_CENTRE * PART_OF_CENTRE * smaller.unwrap_or(of_origin)
    }

    /// Ratios of the size of q to that of p that change with units as they should: of the motions in a step, or of
    /// the state; else the ratio of the largest sizes of the loop.
    fn first_ratios(
        &self,
        displaced: &DisplacedState<'_>,
        motion: Option<&[Vec<f64>; 2]>,
    ) -> Vec<f64> {
        let largest = [0, 1].map(|c: usize| self.radius[c].iter().copied().fold(0.0, f64::max));
        let usable = |ratio: &f64| ratio.is_normal();
        let typical = Some(largest[0] / largest[1]).filter(usable).unwrap_or(1.0);
        (displaced.open.iter().enumerate())
            .map(|(k, &i)| {
                let of_motion = motion.map(|[q, p]| (q[k] / p[k]).abs());
                let of_state =
                    (displaced.state.q().row(i)[0] / displaced.state.p().row(i)[0]).abs();
                (of_motion.filter(usable))
                    .or(Some(of_state).filter(usable))
                    .unwrap_or(typical)
            })
            .collect()
    }

    /// Takes radii with these ratios: of this action, where both are open.
    fn take(
        &mut self,
        given: &[Vec<f64>; 2],
        open: &[usize],
        ratios: &[f64],
        of_centres: Vec<f64>,
        action: f64,
        coordinates: &Coordinates,
    ) {
        let largest = of_centres.iter().copied().fold(0.0, f64::max);
        for (k, (&i, ratio)) in open.iter().zip(ratios).enumerate() {
            let radii = match [given[0][i], given[1][i]] {
                [0.0, 0.0] => {
                    // A centre that is rounding compared with the largest is the origin.
                    let at_origin = of_centres[k] <= MAX_ROUNDED_ZERO * MAX_ROUNDED_ZERO * largest;
                    let own = if at_origin { largest } else { of_centres[k] };
                    // A body that is much lighter than those that move has its own action.
                    let is_small = !at_origin && own * MAX_RATIO_IN_GROUP < action;
                    let mut known = [if is_small { own } else { action }, own].into_iter();
                    let action = known.find(|&action| action > 0.0).unwrap_or(1.0);
                    let area = action / coordinates.weight(i).abs();
                    [(area * ratio).sqrt(), (area / ratio).sqrt()]
                }
                [0.0, p] => [p * ratio, p],
                [q, _] => [q, q / ratio],
            };
            (self.radius[0][i], self.radius[1][i]) = (radii[0], radii[1]);
        }
    }
}

/// A state that is displaced in some degrees of freedom, all of them at once, and advanced by one step.
struct DisplacedState<'a> {
    evaluator: &'a Evaluator<'a>,
    state: &'a Ensemble,
    open: &'a [usize],
    h: f64,
}

impl DisplacedState<'_> {
    /// By how much a step moves the state: positions and momenta of the open degrees of freedom.
    fn motion(&self) -> Result<[Vec<f64>; 2], Error> {
        let mut after = self.state.clone();
        self.evaluator.advance(&mut after, self.h)?;
        let dof = after.dof();
        Ok([0, dof].map(|first| {
            let of = |&i: &usize| {
                let c = first + i;
                let moved = coordinate(&after, c)[0] - coordinate(self.state, c)[0];
                nearest(moved, period(self.evaluator.coordinates(), c))
            };
            self.open.iter().map(of).collect()
        }))
    }

    /// The ratio ρ of both radii at which displacements by them have equal effects on each other, where both have one,
    /// ρ² = |∂q'/∂p| / |∂p'/∂q|, and the square of what they advance, |∂q'/∂p| |∂p'/∂q|: (hω)² of an oscillation.
    fn balanced(&self, radius: &[Vec<f64>; 2]) -> Result<Vec<Option<(f64, f64)>>, Error> {
        let dof = self.state.dof();
        // Two samples displaced in q, two in p.
        let mut states = Ensemble::zeros(dof, 4);
        let mut block = states.block();
        for c in 0..2 * dof {
            coordinate_mut(&mut block, c).fill(coordinate(self.state, c)[0]);
        }
        // Of changing signs: a translation of all of them together may move nothing else.
        let sign = |i: usize| {
            if (i.wrapping_mul(0x9E37_79B9) >> 16).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            }
        };
        for (kind, radius) in radius.iter().enumerate() {
            for &i in self.open {
                let row = coordinate_mut(&mut block, kind * dof + i);
                row[2 * kind] += sign(i) * DISPLACEMENT * radius[i];
                row[2 * kind + 1] -= sign(i) * DISPLACEMENT * radius[i];
            }
        }
        self.evaluator.advance(&mut states, self.h)?;
        let slope = |kind: usize, i: usize| {
            let c = (1 - kind) * dof + i;
            let row = coordinate(&states, c);
            let apart = row[2 * kind] - row[2 * kind + 1];
            let period = period(self.evaluator.coordinates(), c);
            (nearest(apart, period) / radius[kind][i]).abs()
        };
        let of_dof = |&i: &usize| {
            let [of_q, of_p] = [0, 1].map(|kind| slope(kind, i) / (2.0 * DISPLACEMENT));
            let (ratio, squared_advance) = ((of_p / of_q).sqrt(), of_p * of_q);
            (ratio.is_normal() && squared_advance.is_normal()).then_some((ratio, squared_advance))
        };
        Ok(self.open.iter().map(of_dof).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_of_similar_action() {
        let groups = |actions: &[f64]| -> Vec<Vec<usize>> {
            let groups = ActionGroup::of(actions);
            groups.into_iter().map(|group| group.dofs).collect()
        };
        assert_eq!(groups(&[1.0, 2.0, 1.1e-3, 1e-3]), [vec![0, 1], vec![2, 3]]);
        assert!(groups(&[1.0, 2.1e-3, 2.0]).is_empty());
        assert_eq!(
            groups(&[1e-15, 3e-16, 1.0, 0.0]),
            [vec![2], vec![0, 1], vec![3]]
        );
        let many: Vec<f64> = (0..40).map(|k| 0.1f64.powi(4 * k)).collect();
        assert_eq!(groups(&many).len(), MAX_GROUPS);
        assert_eq!(groups(&many)[MAX_GROUPS - 1].len(), 9);
    }
}
