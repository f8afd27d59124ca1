//! The Jacobian test: does the derivative of a map keep the symplectic form?
//!
//! A second opinion beside loop integrals, and independent of them: a map is symplectic where it is
//! differentiable if and only if ω(DΦ u, DΦ v) = ω(u, v) for all tangent vectors u and v. It
//! localises better than a loop integral, which is an average, and cannot see jumps.
//!
//! Tangent vectors ([`directions`]) are counted in units of the loop ([`frame`]); states displaced along
//! them are advanced in large blocks ([`lab`]); their differences are extrapolated to
//! derivatives with error bars ([`richardson`]) that know of the noise of the map ([`noise`]). A map that
//! has a tangent map gives derivatives to round-off ([`tangents`]), once it is found to be that of the map
//! ([`tangent_check`]). For many degrees of freedom random pairs are tried, and a defect is followed to
//! the two that carry it ([`locate`]).

mod directions;
mod evidence;
mod frame;
mod lab;
mod locate;
mod method;
mod noise;
mod richardson;
mod tangent_check;
mod tangents;

pub use evidence::{JacobianEvidence, JacobianPoint, TangentDefect};
pub use method::{JacobianMethod, TangentRejection};

use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use frame::{Estimate, Frame};
use lab::{Lab, Task};
use locate::locate;
use richardson::Derivative;

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
    /// Random pairs of tangent vectors at each point, 1 or more, beyond that.
    pub pairs: usize,
    /// Seed of the random tangent vectors.
    pub seed: u64,
}

impl Default for JacobianTest {
    /// 8 points; in full up to 8 degrees of freedom, 16 random pairs beyond.
    fn default() -> Self {
        JacobianTest {
            points: 8,
            full_up_to: 8,
            pairs: 16,
            seed: 1,
        }
    }
}

/// What one task says of the form.
struct Outcome {
    defects: Vec<TangentDefect>,
    converged: bool,
    deformation: f64,
}

impl Outcome {
    /// Whether derivatives converged and their form is within the range of double precision.
    fn is_usable(&self) -> bool {
        self.converged && (self.defects.iter()).all(|defect| defect.bound().is_finite())
    }
}

impl JacobianTest {
    /// Tests one step of size `h` at points of `phase_loop`, on the threads of the current Rayon
    /// pool; the result does not depend on their number.
    ///
    /// A point costs 49 states and 18 for each of its 2d unit vectors, or 36 for each random pair. With a
    /// tangent map it costs 74 states, and 7 with their tangent vectors for each unit vector, or 14 for each pair.
    ///
    /// # Errors
    /// If map and loop do not fit, the loop does not move positions or momenta at all, the step size is
    /// zero or not finite, there are no points or no pairs, or the map fails or returns states that are
    /// not finite, at the loop or displaced from it: [`Error::OnTheWay`] says from which s.
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
        self.check(h)?;
        let dof = evaluator.dof();
        let full = dof <= self.full_up_to;
        let mut lab = Lab::new(evaluator, phase_loop, h, places(self.points), self.seed)?;
        let task = |(place, pair): (usize, usize)| Task {
            place,
            directions: if full {
                directions::units(dof)
            } else {
                directions::pair(dof, self.seed, place, pair)
            },
        };
        let pairs = if full { 1 } else { self.pairs };
        let directions = if full { 2 * dof } else { 2 };
        let count = lab.tasks_in_a_batch(directions);
        let mut keys = (0..self.points).flat_map(|place| (0..pairs).map(move |k| (place, k)));
        let mut outcomes: Vec<Vec<Outcome>> = (0..self.points).map(|_| Vec::new()).collect();
        loop {
            let tasks: Vec<Task> = keys.by_ref().take(count).map(task).collect();
            if tasks.is_empty() {
                break;
            }
            let derivatives = lab.derivatives(&tasks)?;
            for (task, derivatives) in tasks.iter().zip(&derivatives) {
                let s = lab.places[task.place];
                outcomes[task.place].push(outcome(&lab.frame, s, task, derivatives, full));
            }
        }
        let points: Vec<JacobianPoint> = (outcomes.iter().zip(&lab.places))
            .map(|(outcomes, &s)| summed_up(lab.method, s, outcomes))
            .collect();
        let mut found =
            TangentDefect::worst(lab.method, points.iter().filter_map(|point| point.worst));
        let mut bound = (points.iter().filter_map(|point| point.bound)).reduce(f64::max);
        if let Some(dense) = found.filter(|found| !full && found.is_significant(lab.method)) {
            let located = self.located(&mut lab, &outcomes, dense)?;
            bound = bound.map(|bound| bound.max(located.bound()));
            found = Some(located);
        }
        let usable = outcomes
            .iter()
            .flatten()
            .filter(|outcome| outcome.is_usable());
        let deformations = usable.map(|outcome| outcome.deformation);
        Ok(JacobianEvidence {
            step_size: h,
            method: lab.method,
            not_differentiable: points.iter().filter(|p| p.worst.is_none()).count(),
            full,
            worst: found,
            bound,
            deformation: deformations.fold(0.0, f64::max),
            noise: lab.largest_noise(),
            evaluations: lab.evaluations,
            points,
        })
    }

    /// The defect of a random pair in the two degrees of freedom that carry most of it: in their norms
    /// it is larger, as a rule, than in that of vectors that move everything.
    fn located(
        &self,
        lab: &mut Lab<'_>,
        outcomes: &[Vec<Outcome>],
        dense: TangentDefect,
    ) -> Result<TangentDefect, Error> {
        let is_it = |outcome: &Outcome| outcome.defects.contains(&dense);
        let at = (outcomes.iter().enumerate())
            .find_map(|(place, pairs)| Some((place, pairs.iter().position(is_it)?)));
        let Some((place, pair)) = at else {
            return Ok(dense);
        };
        let vectors = directions::pair(lab.frame.dof(), self.seed, place, pair);
        let found = locate(lab, place, [&vectors[0], &vectors[1]])?;
        Ok(found.map_or(dense, |found| {
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
            TangentDefect::worst(lab.method, [located, spread_evenly].into_iter()).unwrap_or(dense)
        }))
    }

    fn check(&self, h: f64) -> Result<(), Error> {
        if !h.is_finite() || h == 0.0 {
            return Err(Error::OutOfRange {
                what: "step size",
                value: h,
                remedy: "give a finite step size that is not zero",
            });
        }
        for (what, count) in [
            ("number of points of the Jacobian test", self.points),
            ("number of random pairs of the Jacobian test", self.pairs),
        ] {
            if count == 0 {
                return Err(Error::OutOfRange {
                    what,
                    value: 0.0,
                    remedy: "give one or more",
                });
            }
        }
        Ok(())
    }
}

/// Loop parameters that the golden ratio spreads: no two, nor their mirror images, meet.
fn places(count: usize) -> Vec<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const START: f64 = 0.137;
    (0..count)
        .map(|k| (START + GOLDEN * k as f64).fract())
        .collect()
}

fn outcome(frame: &Frame, s: f64, task: &Task, derivatives: &[Derivative], full: bool) -> Outcome {
    let along: Vec<(&[f64], &Derivative)> = (task.directions.iter().map(Vec::as_slice))
        .zip(derivatives)
        .collect();
    let mut defects = Vec::with_capacity(along.len() * (along.len() - 1) / 2);
    for (i, &u) in along.iter().enumerate() {
        for (j, &v) in along.iter().enumerate().skip(i + 1) {
            let Estimate { value, error } = frame.change_of_form(u, v);
            let norm = frame.norm(u.0) * frame.norm(v.0);
            defects.push(TangentDefect {
                s,
                signed: value / norm,
                uncertainty: error / norm,
                dofs: full.then(|| (frame.dof_of(i), frame.dof_of(j))),
            });
        }
    }
    let changes = (along.iter()).flat_map(|(u, of_u)| u.iter().zip(&of_u.value));
    Outcome {
        defects,
        converged: derivatives.iter().all(|derivative| derivative.converged),
        deformation: changes.fold(0.0, |most: f64, (u, of_u)| most.max((of_u - u).abs())),
    }
}

fn summed_up(method: JacobianMethod, s: f64, outcomes: &[Outcome]) -> JacobianPoint {
    let usable = outcomes.iter().all(Outcome::is_usable);
    let defects = || outcomes.iter().flat_map(|outcome| outcome.defects.iter());
    JacobianPoint {
        s,
        worst: TangentDefect::worst(method, defects().copied()).filter(|_| usable),
        bound: (defects().map(TangentDefect::bound))
            .reduce(f64::max)
            .filter(|_| usable),
    }
}

impl JacobianTest {
    /// TEMP
    pub(crate) fn within(_budget: usize, dof: usize, _t: bool) -> Option<JacobianTest> {
        let all = JacobianTest::default();
        Some(if dof < 256 {
            all
        } else {
            JacobianTest {
                points: 2,
                pairs: 4,
                ..all
            }
        })
    }
}
