//! How far a loop reaches in each coordinate, and how far tests should go in those that it leaves at rest.

use super::Evaluator;
use crate::error::Error;
use crate::loops::Loop;
use crate::signal::{Extent, Turns, nearest};
use crate::state::{Coordinates, Ensemble, coordinate, coordinate_mut, period};

/// Samples of the loop that tell its ranges.
const SAMPLES: usize = 64;

/// Repetitions of the balance of q against p: a ratio that is off by 2^60 where forces are bounded is off by a factor
/// of 1.3 then, and no more are needed where they are linear.
const REPETITIONS: usize = 4;

/// A degree of freedom at rest at a centre (q, p) is given this part of √(q²/ρ + ρp²) for a radius, where no other
/// one tells.
const PART_OF_CENTRE: f64 = 0.1;

/// Centre and half the range of every coordinate of a loop: the sizes of what tests do beside it.
///
/// A loop need not move all coordinates, and tests must: a map has to be symplectic in every direction. In a degree of
/// freedom at rest the product of both radii is the largest one of the others, as actions have one unit in all of
/// them. The ratio ρ of both is balanced by what the map does: displaced by its radius, q changes p by as large a part
/// of the radius of p as p changes q. Both are the same in all units.
#[derive(Clone, Debug)]
pub(crate) struct LoopSize {
    /// Of all positions, then of all momenta.
    pub centre: [Vec<f64>; 2],
    /// In the same order.
    pub radius: [Vec<f64>; 2],
    /// Degrees of freedom that the loop leaves at rest.
    pub at_rest: Vec<bool>,
}

impl LoopSize {
    /// That of `phase_loop`; coordinates at rest are displaced, and advanced by a step of size `h`.
    ///
    /// # Errors
    /// If the samples of the loop do not fit into memory. Where the map cannot be evaluated, coordinates at rest have
    /// a size without it.
    pub fn of(evaluator: &Evaluator<'_>, phase_loop: &dyn Loop, h: f64) -> Result<Self, Error> {
        let dof = phase_loop.dof();
        let coordinates = evaluator.coordinates();
        let mut extents = vec![[Extent::default(); 2]; dof];
        let mut turns = vec![Turns::default(); dof];
        Ensemble::in_parts(phase_loop, SAMPLES, |part| {
            for (i, [of_q, of_p]) in extents.iter_mut().enumerate() {
                for &q in part.q().row(i) {
                    of_q.include(turns[i].unwrap(q, coordinates.period(i)));
                }
                part.p().row(i).iter().for_each(|&p| of_p.include(p));
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
        Ok(size)
    }

    /// Sizes for the coordinates at rest of the degrees of freedom `open`.
    fn balance(&mut self, evaluator: &Evaluator<'_>, state: &Ensemble, open: &[usize], h: f64) {
        let coordinates = evaluator.coordinates();
        let given = self.radius.clone();
        let action = |i: usize| coordinates.weight(i).abs() * given[0][i] * given[1][i];
        let action = (0..given[0].len()).map(action).fold(0.0, f64::max);
        let displaced = Displaced {
            evaluator,
            state,
            open,
            h,
        };
        let mut ratios = self.first_ratios(&displaced);
        for repetition in 0..=REPETITIONS {
            self.take(&given, open, &ratios, action, coordinates);
            if repetition == REPETITIONS {
                break;
            }
            // Where the map fails beside the loop, what is known has to do.
            let Ok(balanced) = displaced.balanced(&self.radius) else {
                break;
            };
            for (ratio, balanced) in ratios.iter_mut().zip(balanced) {
                *ratio = balanced.unwrap_or(*ratio);
            }
        }
    }

    /// Ratios of the size of q to that of p that change with units as they should: of the motions in a step, or of
    /// the state; else the ratio of the largest sizes of the loop.
    fn first_ratios(&self, displaced: &Displaced<'_>) -> Vec<f64> {
        let largest = [0, 1].map(|c: usize| self.radius[c].iter().copied().fold(0.0, f64::max));
        let usable = |ratio: &f64| ratio.is_normal();
        let typical = Some(largest[0] / largest[1]).filter(usable).unwrap_or(1.0);
        let motion = displaced.motion().ok();
        (displaced.open.iter().enumerate())
            .map(|(k, &i)| {
                let of_motion = motion.as_ref().map(|[q, p]| (q[k] / p[k]).abs());
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
        action: f64,
        coordinates: &Coordinates,
    ) {
        for (&i, ratio) in open.iter().zip(ratios) {
            let radii = match [given[0][i], given[1][i]] {
                [0.0, 0.0] => {
                    let weight = coordinates.weight(i).abs();
                    let of_centre =
                        self.centre[0][i].powi(2) / ratio + ratio * self.centre[1][i].powi(2);
                    let action = match (action > 0.0, of_centre > 0.0) {
                        (true, _) => action / weight,
                        (false, true) => PART_OF_CENTRE.powi(2) * of_centre,
                        (false, false) => 1.0 / weight,
                    };
                    [(action * ratio).sqrt(), (action / ratio).sqrt()]
                }
                [0.0, p] => [p * ratio, p],
                [q, _] => [q, q / ratio],
            };
            (self.radius[0][i], self.radius[1][i]) = (radii[0], radii[1]);
        }
    }
}

/// A state that is displaced in some degrees of freedom, all of them at once, and advanced by one step.
struct Displaced<'a> {
    evaluator: &'a Evaluator<'a>,
    state: &'a Ensemble,
    open: &'a [usize],
    h: f64,
}

impl Displaced<'_> {
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

    /// The ratio ρ of both radii at which displacements by them have equal effects on each other, where both have one:
    /// ρ² = |∂q'/∂p| / |∂p'/∂q|.
    fn balanced(&self, radius: &[Vec<f64>; 2]) -> Result<Vec<Option<f64>>, Error> {
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
                row[2 * kind] += sign(i) * radius[i];
                row[2 * kind + 1] -= sign(i) * radius[i];
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
        let ratio =
            |&i: &usize| Some((slope(1, i) / slope(0, i)).sqrt()).filter(|ratio| ratio.is_normal());
        Ok(self.open.iter().map(ratio).collect())
    }
}
