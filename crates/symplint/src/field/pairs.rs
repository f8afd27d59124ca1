//! Pairs of directions u, v: u·J v − v·J u from the integral around a small ellipse, and λ.
//!
//! ∮ F·dq = πr² (u·J v − v·J u) around an ellipse of half axes r u, r v, with the Jacobian J averaged over its disc. Unlike a
//! difference quotient it is zero for every gradient at any r. For random u and v the mean of its square is ‖J − Jᵀ‖², and the mean of |J u|²
//! is ‖J‖² (M. Hutchinson, Commun. Stat. Simul. Comput. 19, 1990): few pairs give λ in any number of degrees of freedom.

use super::evidence::{CoordinateName, Curl, FieldLoopKind, LoopWork, WorstPair};
use super::integrand::Integrand;
use super::limits::{
    FIRST_SAMPLES_OF_PAIR, MAX_COORDINATES_OF_ALL_PAIRS, MAX_SAMPLES_OF_PAIR, PAIR_PART_OF_RADIUS,
    RANDOM_PAIRS,
};
use super::radius::direction;
use super::work::{Integration, Limits, PowerAccuracy};
use crate::error::Error;
use crate::loops::{FourierLoop, Loop};
use crate::signal::parameter;
use crate::state::{Ensemble, coordinate};

/// Streams of random numbers from here on belong to pairs.
const FIRST_STREAM_OF_PAIRS: u64 = 1 << 32;

/// Where pairs are tested, and how exactly the force is known there.
pub(super) struct Pairs<'a> {
    pub integrand: &'a Integrand<'a>,
    /// Ellipses have their centres on this loop.
    pub around: &'a FourierLoop,
    pub known: PowerAccuracy,
    pub seed: u64,
    /// Whether all pairs of coordinates are tested, and not random directions.
    pub takes_all: bool,
    /// Whether no loop has shown a curl yet.
    pub confirms: bool,
}

/// Two directions at a point, in units of the radii.
#[derive(Clone)]
struct Pair {
    point: usize,
    vectors: [Vec<f64>; 2],
    kind: FieldLoopKind,
}

impl Pairs<'_> {
    /// Pairs of the coordinates that loops move, if they are few and the budget allows them all.
    pub fn all(integrand: &Integrand<'_>) -> bool {
        let moving = integrand.moving();
        moving <= MAX_COORDINATES_OF_ALL_PAIRS
            && moving * (moving - 1) / 2 * FIRST_SAMPLES_OF_PAIR
                <= integrand.evaluator.count().left()
    }

    fn name(&self, c: usize) -> CoordinateName {
        CoordinateName::of(c, self.integrand.evaluator.dof())
    }

    /// All of them, or random ones, in an order in which any first few make sense.
    fn pairs(&self) -> Vec<Pair> {
        let count = self.integrand.coordinates();
        let moving: Vec<usize> = (0..count)
            .filter(|&c| self.integrand.radius[c] > 0.0)
            .collect();
        if moving.len() < 2 {
            return Vec::new();
        }
        if self.takes_all {
            let of_first = |k: usize| moving[k + 1..].iter().map(move |&c| (k, c));
            let pairs = (0..moving.len()).flat_map(of_first);
            return pairs
                .enumerate()
                .map(|(point, (k, c))| self.of_coordinates(point, moving[k], c))
                .collect();
        }
        let random = |k: usize| Pair {
            point: k,
            vectors: [0, 1]
                .map(|of| direction(count, self.seed, FIRST_STREAM_OF_PAIRS + 2 * k as u64 + of)),
            kind: FieldLoopKind::Directions,
        };
        (0..RANDOM_PAIRS).map(random).collect()
    }

    fn of_coordinates(&self, point: usize, first: usize, second: usize) -> Pair {
        let unit = |c: usize| {
            let mut vector = vec![0.0; self.integrand.coordinates()];
            vector[c] = 1.0;
            vector
        };
        Pair {
            point,
            vectors: [unit(first), unit(second)],
            kind: FieldLoopKind::Coordinates {
                first: self.name(first),
                second: self.name(second),
            },
        }
    }

    /// The ellipse of a pair.
    fn ellipse(&self, pair: &Pair) -> FourierLoop {
        let dof = self.integrand.evaluator.dof();
        let mut centre = Ensemble::zeros(dof, 1);
        let s = parameter(pair.point);
        self.around.sample(&[s], &mut centre.block());
        let at = |c: usize| coordinate(&centre, c)[0];
        let half_axis = |vector: &[f64]| {
            let part = |c: usize| match (vector.get(c), self.integrand.radius.get(c)) {
                (Some(x), Some(radius)) => PAIR_PART_OF_RADIUS * radius * x,
                _ => 0.0,
            };
            [
                (0..dof).map(part).collect::<Vec<f64>>(),
                (dof..2 * dof).map(part).collect(),
            ]
        };
        let [u, v] = pair.vectors.each_ref().map(|vector| half_axis(vector));
        FourierLoop::ellipse(
            ((0..dof).map(at).collect(), (dof..2 * dof).map(at).collect()),
            [&u[0], &u[1]],
            [&v[0], &v[1]],
        )
    }

    fn measure(&self, pair: &Pair, most: usize) -> Result<LoopWork, Error> {
        let ellipse = self.ellipse(pair);
        Integration::begin(self.integrand, &ellipse, FIRST_SAMPLES_OF_PAIR)?.finish(
            pair.kind,
            self.known,
            Limits {
                samples: MAX_SAMPLES_OF_PAIR,
                evaluations: most,
                confirms: self.confirms,
            },
        )
    }

    /// The integrals of all pairs, as far as the budget allows.
    ///
    /// # Errors
    /// Those of the force.
    pub fn run(&self) -> Result<Vec<LoopWork>, Error> {
        let pairs = self.pairs();
        let mut found = Vec::with_capacity(pairs.len());
        for (k, pair) in pairs.iter().enumerate() {
            let left = self.integrand.evaluator.count().left();
            if left < FIRST_SAMPLES_OF_PAIR {
                break;
            }
            let share = left / (pairs.len() - k);
            found.push(self.measure(pair, share.saturating_sub(FIRST_SAMPLES_OF_PAIR))?);
        }
        Ok(found)
    }

    /// λ from the integrals of pairs; `None` without pairs, or if the force does not change.
    pub fn curl(&self, found: &[LoopWork]) -> Option<Curl> {
        let count = found.len() as f64;
        let all = self.takes_all;
        // All pairs of n unit vectors hold half of ‖J − Jᵀ‖², and n − 1 times ‖J‖²/2.
        let factor = match all {
            true => (self.integrand.moving() as f64 - 1.0).sqrt(),
            false => 1.0,
        };
        let norm =
            |of: fn(&LoopWork) -> f64| found.iter().map(|w| of(w).powi(2)).sum::<f64>().sqrt();
        let (integral, error, scale) = (
            norm(|work| work.integral),
            norm(LoopWork::error),
            norm(|work| work.scale),
        );
        if !(scale > 0.0 && scale.is_finite()) || found.iter().all(|work| work.is_constant) {
            return None;
        }
        let value = factor * integral / scale;
        // The squares of independent normal numbers have a relative variance of 2.
        let scatter = match all {
            true => 0.0,
            false => value / (2.0 * count).sqrt(),
        };
        Some(Curl {
            value,
            error: factor * error / scale + scatter,
            pairs: found.len(),
            all,
        })
    }

    /// The two coordinates that carry a curl: the worst of all pairs, or by halving the support of both directions of the pair that
    /// shows it best, again and again. `None` if it is not significant, or the budget does not allow it.
    ///
    /// # Errors
    /// Those of the force.
    pub fn worst(&self, found: &[LoopWork]) -> Result<Option<WorstPair>, Error> {
        let certainty = |work: &LoopWork| work.integral.abs() / work.error();
        let Some((index, shown)) = (found.iter().enumerate())
            .filter(|(_, work)| work.is_clear())
            .max_by(|a, b| {
                let of = |work: &LoopWork| match self.takes_all {
                    true => work.relative(),
                    false => certainty(work),
                };
                of(a.1).total_cmp(&of(b.1))
            })
        else {
            return Ok(None);
        };
        let pair = &self.pairs()[index];
        if self.takes_all {
            let [first, second] = pair.vectors.each_ref().map(|vector| position(vector));
            return Ok(self.named(shown, first, second));
        }
        let rounds = 2 * self.integrand.coordinates().ilog2() as usize + 4;
        if self.integrand.evaluator.count().left() < rounds * FIRST_SAMPLES_OF_PAIR {
            return Ok(None);
        }
        let mut pair = pair.clone();
        let mut whole = shown.integral;
        for of in [1, 0] {
            let count = self.integrand.coordinates();
            let mut support: Vec<usize> = (0..count)
                .filter(|&c| pair.vectors[of][c] != 0.0 && self.integrand.radius[c] > 0.0)
                .collect();
            while support.len() > 1 {
                let (first, second) = support.split_at(support.len() / 2);
                let mut half = pair.clone();
                for &c in second {
                    half.vectors[of][c] = 0.0;
                }
                let integral = self.measure(&half, 0)?.integral;
                // The integral is linear in each direction.
                let rest = whole - integral;
                let (kept, left_out);
                (kept, left_out, whole) = match integral.abs() >= rest.abs() {
                    true => (first, second, integral),
                    false => (second, first, rest),
                };
                for &c in left_out {
                    pair.vectors[of][c] = 0.0;
                }
                support = kept.to_vec();
            }
        }
        let [first, second] = pair.vectors.each_ref().map(|vector| position(vector));
        if first == second {
            return Ok(None);
        }
        let alone = self.of_coordinates(pair.point, first, second);
        let work = self.measure(&alone, 0)?;
        Ok(self.named(&work, first, second).filter(|_| work.is_clear()))
    }

    fn named(&self, work: &LoopWork, first: usize, second: usize) -> Option<WorstPair> {
        let radius = |c: usize| PAIR_PART_OF_RADIUS * self.integrand.radius[c];
        let area = std::f64::consts::PI * radius(first) * radius(second);
        Some(WorstPair {
            first: self.name(first),
            second: self.name(second),
            curl: work.integral / area,
            error: work.error() / area,
        })
    }
}

/// The component of a unit vector that is not zero.
fn position(vector: &[f64]) -> usize {
    vector.iter().position(|&x| x != 0.0).unwrap_or(0)
}
