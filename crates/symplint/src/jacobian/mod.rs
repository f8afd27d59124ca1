//! The Jacobian test: does the derivative of a map conserve the symplectic form?
//!
//! It is independent of loop integrals: a map is symplectic where it is
//! differentiable if and only if ω(DΦ u, DΦ v) = ω(u, v) for all tangent vectors u and v. It
//! localises better than a loop integral, which is an average, and does not see jumps.
//!
//! Tangent vectors ([`directions`]) are counted in units of the loop ([`frame`]). States displaced along
//! them are advanced in large batches ([`sampler`]), and their differences are extrapolated to
//! derivatives with errors ([`richardson`]) that take the noise of the map into account ([`noise`]). A map that
//! has a tangent map gives derivatives to round-off ([`tangents`]), once it is found to be that of the map
//! ([`tangent_check`]). In many degrees of freedom tangent vectors are random, and a defect is traced to
//! the two degrees of freedom that carry it ([`bisection`]).

mod bisection;
mod constants;
mod cost;
mod derivative;
mod directions;
mod evidence;
mod frame;
mod noise;
mod richardson;
mod sampler;
mod tangent_check;
mod tangents;

pub use evidence::{
    JacobianEvidence, JacobianMethod, JacobianPoint, TangentDefect, TangentRejection,
};

use rayon::prelude::*;

use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use bisection::locate;
use derivative::Derivative;
use frame::{Estimate, Frame};
use sampler::{Sampler, TangentVector};

/// Tests at points of a loop whether the derivative of a map keeps the symplectic form.
///
/// Derivatives are differences, extrapolated, so any map can be tested, to about 11 digits. A map that
/// has a [`TangentMap`](crate::TangentMap) gives them to round-off; a tangent map that differs from the
/// differences is not used, and the [evidence](JacobianEvidence::method) says so. Momenta count with the weights
/// of [`Coordinates`](crate::Coordinates), positions modulo their periods. States are displaced from
/// the loop by up to an eighth of its size in every coordinate: the map must be defined there.
///
/// ```
/// use symplint::{Circle, JacobianTest, JacobianVerdict, PerSample};
///
/// // A unit mass on a unit spring, by the explicit midpoint rule: det DΦ = 1 + h⁴/4.
/// let map = PerSample::new(1, |h, q, p| {
///     let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0]);
///     q[0] += h * p_half;
///     p[0] -= h * q_half;
/// });
/// let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
/// let evidence = JacobianTest::default().run(&map, &circle, 0.5)?;
/// let JacobianVerdict::NotSymplectic { worst } = evidence.verdict() else {
///     panic!("{}", evidence.verdict());
/// };
/// assert!((worst.signed - 0.5f64.powi(4) / 4.0).abs() < worst.uncertainty);
/// assert!(worst.uncertainty < 1e-12);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JacobianTest {
    /// Points of the loop, 1 or more, nowhere near equidistant: a symmetric loop hides no defect.
    pub points: usize,
    /// Degrees of freedom up to which all pairs of unit vectors are tried.
    pub full_up_to: usize,
    /// Random tangent vectors at each point, 2 or more, beyond that; all pairs of them are tried.
    pub directions: usize,
    /// Evaluations at most. What is made beside [`evaluations`](Self::evaluations) where a map needs it
    /// stays within them, or is left out.
    pub budget: usize,
    /// Seed of the random tangent vectors.
    pub seed: u64,
}

impl Default for JacobianTest {
    /// 8 points; in full up to 8 degrees of freedom, 4 random tangent vectors beyond; no limit.
    fn default() -> Self {
        JacobianTest {
            points: 8,
            full_up_to: 8,
            directions: 4,
            budget: usize::MAX,
            seed: 1,
        }
    }
}

/// What the tangent vectors at one point showed.
struct Outcome {
    s: f64,
    /// Of every two of them, in the order of [`pairs`].
    defects: Vec<TangentDefect>,
    /// Whether derivatives converged and their form is within the range of double precision.
    usable: bool,
    deformation: f64,
}

impl JacobianTest {
    /// Tests one step of size `h` at points of `phase_loop`, on the threads of the current Rayon
    /// pool; the result does not depend on their number.
    ///
    /// # Errors
    /// If map and loop do not fit, the loop does not move positions or momenta at all, the step size is
    /// zero or not finite, there are no points, fewer than two tangent vectors or a smaller budget than the
    /// [`evaluations`](Self::evaluations), or the map fails or returns states that are not finite, on the loop or
    /// displaced from it: [`Error::OnTheWay`] says from which s.
    pub fn run(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        h: f64,
    ) -> Result<JacobianEvidence, Error> {
        let count = EvaluationCount::unlimited();
        self.run_with(&Evaluator::new(map, &count)?, phase_loop, h)
    }

    /// The same with the evaluations counted by `evaluator`.
    pub(crate) fn run_with(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        h: f64,
    ) -> Result<JacobianEvidence, Error> {
        evaluator.check_dof(phase_loop.dof())?;
        let dof = evaluator.dof();
        let planned = self.evaluations(dof, evaluator.has_tangent());
        self.check(h, planned)?;
        let (s, spare) = (parameters(self.points), self.budget - planned);
        let mut sampler = Sampler::new(evaluator, phase_loop, h, s, self.seed, spare)?;
        let mut outcomes = self.outcomes(&mut sampler)?;
        if sampler.rejected.is_some() {
            sampler.fall_back(self.count(dof), self.budget);
            outcomes = self.outcomes(&mut sampler)?;
        }
        let method = sampler.method();
        let points: Vec<JacobianPoint> =
            (outcomes.iter().map(|outcome| outcome.point(method))).collect();
        let mut worst = TangentDefect::worst(method, points.iter().filter_map(|p| p.worst));
        let mut bound = (points.iter().filter_map(|point| point.bound)).reduce(f64::max);
        let full = self.is_full(dof);
        if let Some(dense) = worst.filter(|found| !full && found.is_significant(method)) {
            let located = self.located(&mut sampler, &outcomes, dense)?;
            bound = bound.map(|bound| bound.max(located.bound()));
            worst = Some(located);
        }
        let usable = outcomes.iter().filter(|outcome| outcome.usable);
        Ok(JacobianEvidence {
            step_size: h,
            method,
            not_differentiable: points.iter().filter(|p| p.worst.is_none()).count(),
            full,
            worst,
            bound,
            deformation: usable.fold(0.0, |most, outcome| most.max(outcome.deformation)),
            noise: sampler.largest_noise(),
            evaluations: sampler.made(),
            points,
        })
    }

    /// What the tangent vectors show at each point; as far as the tangent map is not rejected.
    fn outcomes(&self, sampler: &mut Sampler<'_>) -> Result<Vec<Outcome>, Error> {
        let (dof, count) = (sampler.frame.dof(), sampler.s.len());
        let at_a_time = sampler.in_a_batch(self.count(dof) * sampler.cost());
        let mut outcomes = Vec::with_capacity(count);
        let mut compared = false;
        while outcomes.len() < count {
            let first = outcomes.len();
            // A tangent map that is wrong is wrong everywhere, as a rule: one point shows it, and leaves the rest of
            // the budget to differences.
            let at_once = match sampler.uses_tangents && first == 0 {
                true => 1,
                false => at_a_time,
            };
            let points = first..(first + at_once).min(count);
            let directions: Vec<Vec<Vec<f64>>> = points
                .clone()
                .map(|point| self.directions(dof, point))
                .collect();
            let vectors = points
                .clone()
                .zip(&directions)
                .flat_map(|(point, directions)| {
                    let at = move |direction| TangentVector { point, direction };
                    directions.iter().map(Vec::as_slice).map(at)
                });
            let derivatives = sampler.derivatives(&vectors.collect::<Vec<_>>())?;
            let of_points: Vec<&[Derivative]> = derivatives.chunks_exact(self.count(dof)).collect();
            if sampler.uses_tangents {
                compared |= sampler.check_tangents(first, &directions, &of_points, self.seed)?;
                if sampler.rejected.is_some() {
                    return Ok(outcomes);
                }
            }
            let full = self.is_full(dof);
            outcomes.extend((points.zip(&directions).zip(&of_points)).map(
                |((point, directions), derivatives)| {
                    outcome(
                        &sampler.frame,
                        sampler.s[point],
                        directions,
                        derivatives,
                        full,
                    )
                },
            ));
        }
        if sampler.uses_tangents && !compared {
            sampler.rejected = Some(TangentRejection::Unchecked);
        }
        Ok(outcomes)
    }

    /// The defect of a random pair in the two degrees of freedom that carry most of it: in their norms
    /// it is larger, as a rule, than in that of vectors that move everything.
    fn located(
        &self,
        sampler: &mut Sampler<'_>,
        outcomes: &[Outcome],
        dense: TangentDefect,
    ) -> Result<TangentDefect, Error> {
        let found = outcomes.iter().enumerate().find_map(|(point, outcome)| {
            let pair = outcome.defects.iter().position(|&defect| defect == dense)?;
            Some((point, pair))
        });
        let directions = |point| self.directions(sampler.frame.dof(), point);
        let found = found.and_then(|(point, pair)| {
            let directions = directions(point);
            let (i, j) = pairs(directions.len()).nth(pair)?;
            Some((point, [directions[i].clone(), directions[j].clone()]))
        });
        let Some((point, [u, v])) = found else {
            return Ok(dense);
        };
        Ok(locate(sampler, point, [&u, &v])?.map_or(dense, |found| {
            let located = TangentDefect {
                signed: found.defect.value,
                uncertainty: found.defect.error,
                dofs: Some(found.dofs),
                ..dense
            };
            let spread_evenly = TangentDefect {
                dofs: located.dofs,
                ..dense
            };
            let candidates = [located, spread_evenly].into_iter();
            TangentDefect::worst(sampler.method(), candidates).unwrap_or(dense)
        }))
    }

    fn check(&self, h: f64, planned: usize) -> Result<(), Error> {
        let range = |what, value, remedy| {
            Err(Error::OutOfRange {
                what,
                value,
                remedy,
            })
        };
        if !h.is_finite() || h == 0.0 {
            return range("step size", h, "give a finite step size that is not zero");
        }
        if self.points == 0 {
            return range(
                "number of points of the Jacobian test",
                0.0,
                "give one or more",
            );
        }
        if self.directions < 2 {
            return range(
                "number of random tangent vectors of the Jacobian test",
                self.directions as f64,
                "give two or more",
            );
        }
        if planned > self.budget {
            return range(
                "budget of the Jacobian test",
                self.budget as f64,
                "give at least the evaluations that the test makes, or take JacobianTest::within",
            );
        }
        Ok(())
    }

    fn is_full(&self, dof: usize) -> bool {
        dof <= self.full_up_to
    }

    /// Tangent vectors at each point.
    fn count(&self, dof: usize) -> usize {
        match self.is_full(dof) {
            true => 2 * dof,
            false => self.directions,
        }
    }

    fn directions(&self, dof: usize, point: usize) -> Vec<Vec<f64>> {
        match self.is_full(dof) {
            true => directions::units(dof),
            false => directions::random(dof, self.seed, point, self.directions),
        }
    }
}

/// Loop parameters that the golden ratio spreads: no two of them, nor their mirror images, coincide.
fn parameters(count: usize) -> Vec<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const START: f64 = 0.137;
    (0..count)
        .map(|k| (START + GOLDEN * k as f64).fract())
        .collect()
}

/// Every two of so many.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

fn outcome(
    frame: &Frame,
    s: f64,
    directions: &[Vec<f64>],
    derivatives: &[Derivative],
    full: bool,
) -> Outcome {
    let defect = |(i, j): (usize, usize)| {
        let (u, v) = (&directions[i], &directions[j]);
        let Estimate { value, error } =
            frame.change_of_form((u, &derivatives[i]), (v, &derivatives[j]));
        let norm = frame.norm(u) * frame.norm(v);
        TangentDefect {
            s,
            signed: value / norm,
            uncertainty: error / norm,
            dofs: full.then(|| (frame.dof_of(i), frame.dof_of(j))),
        }
    };
    let all: Vec<(usize, usize)> = pairs(directions.len()).collect();
    let defects: Vec<TangentDefect> = all.into_par_iter().map(defect).collect();
    let changes = (directions.iter().zip(derivatives)).flat_map(|(u, of_u)| {
        let components = u.iter().zip(&of_u.value);
        components.map(|(u, of_u)| (of_u - u).abs())
    });
    Outcome {
        s,
        usable: derivatives.iter().all(|derivative| derivative.converged)
            && defects.iter().all(|defect| defect.bound().is_finite()),
        deformation: changes.fold(0.0, f64::max),
        defects,
    }
}

impl Outcome {
    fn point(&self, method: JacobianMethod) -> JacobianPoint {
        let defects = || self.defects.iter().copied().filter(|_| self.usable);
        JacobianPoint {
            s: self.s,
            worst: TangentDefect::worst(method, defects()),
            bound: defects().map(|defect| defect.bound()).reduce(f64::max),
        }
    }
}
