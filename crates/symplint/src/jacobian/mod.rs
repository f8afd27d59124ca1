//! The Jacobian test: does the derivative of a map conserve the symplectic form?
//!
//! It is independent of loop integrals: a map is symplectic where it is
//! differentiable if and only if ω(DΦ u, DΦ v) = ω(u, v) for all tangent vectors u and v. It
//! localises better than a loop integral, which is an average, and does not see jumps.
//!
//! Tangent vectors (`directions`) are counted in units of the loop (`frame`). States displaced along
//! them are advanced in large batches (`sampler`), and their differences are extrapolated to
//! derivatives with errors (`richardson`) that take the noise of the map into account (`noise`). A map that
//! has a tangent map gives derivatives to round-off (`tangents`), once it is found to be that of the map
//! (`tangent_check`). In many degrees of freedom tangent vectors are random, and a defect is traced to
//! the two degrees of freedom that carry it (`bisection`), in few to blocks of its matrix (`blocks`). Of a map that acts on a manifold, states and tangent vectors are
//! those of the manifold (`manifold`).

mod bisection;
mod blocks;
mod columns;
mod constants;
mod cost;
mod derivative;
mod directions;
mod evidence;
mod frame;
mod manifold;
mod noise;
mod richardson;
mod sampler;
mod tangent_check;
mod tangents;
mod time;
mod volume;

pub(crate) use columns::TangentImages;
pub(crate) use evidence::is_given;
pub use evidence::{
    BlockDefects, DefectBlocks, JacobianDecay, JacobianEvidence, JacobianMethod, JacobianPoint,
    TangentDefect, TangentRejection, VolumeEvidence,
};

use crate::error::Error;
use crate::loops::Loop;
use crate::map::{ActionGroup, EvaluationCount, Evaluator, LoopSize, TimeAdvance};
use crate::signal::parameters;
use bisection::locate;
use columns::{Columns, Outcome};
use directions::Directions;
use sampler::Sampler;
use volume::PointVolume;

/// Tests at points of a loop whether the derivative of a map keeps the symplectic form.
///
/// Derivatives are differences, extrapolated, so any map can be tested, to about 11 digits. A map that
/// has a [`TangentMap`](crate::map::TangentMap) gives them to round-off; a tangent map that differs from the
/// differences is not used, and the [evidence](JacobianEvidence::method) reports this. Momenta count with the weights
/// of [`Coordinates`](crate::Coordinates), positions modulo their periods. States are displaced from
/// the loop by up to an eighth of its size in every coordinate: the map must be defined there.
///
/// ```
/// use symplint::{Circle, JacobianTest, PerSample};
/// use symplint::verdict::JacobianVerdict;
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
    /// The maximum number of evaluations. Those made in addition to [`evaluations`](Self::evaluations) if a map needs them
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

impl JacobianTest {
    /// Tests one step of size `h` at points of `phase_loop`, on the threads of the current Rayon
    /// pool; the result does not depend on their number.
    ///
    /// # Errors
    /// If map and loop do not fit, an area of the loop is beyond the range of doubles, the step size is
    /// zero or not finite, there are no points, fewer than two tangent vectors or a smaller budget than the
    /// [`evaluations`](Self::evaluations), or the map fails or returns states that are not finite, on the loop or
    /// displaced from it: [`StateLocation::Displaced`](crate::error::StateLocation::Displaced) says from which s.
    pub fn run(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        h: f64,
    ) -> Result<JacobianEvidence, Error> {
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count)?;
        evaluator.check_dof(phase_loop.dof())?;
        self.check(h, self.evaluations(map.dof(), evaluator.has_tangent()))?;
        let size = LoopSize::of(&evaluator, phase_loop, h)?;
        let s = parameters(self.points);
        self.run_at(&evaluator, phase_loop, &size, h, s)
    }

    /// The same at these parameters of the loop, as many as there are points, with the evaluations counted by `evaluator`, next to a
    /// loop of this size.
    pub(crate) fn run_at(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        size: &LoopSize,
        h: f64,
        s: Vec<f64>,
    ) -> Result<JacobianEvidence, Error> {
        let (found, _) = self.run_keeping(evaluator, phase_loop, size, h, s)?;
        Ok(found)
    }

    /// The same with the images of all unit vectors at the points at which the map is differentiable. There are no images if tangent
    /// vectors are random or those of a manifold.
    pub(crate) fn run_keeping(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        size: &LoopSize,
        h: f64,
        s: Vec<f64>,
    ) -> Result<(JacobianEvidence, Vec<TangentImages>), Error> {
        evaluator.check_dof(phase_loop.dof())?;
        let dof = evaluator.dof();
        let planned = self.evaluations(dof, evaluator.has_tangent());
        self.check(h, planned)?;
        let spare = self.budget - planned;
        let mut sampler = Sampler::new(evaluator, (phase_loop, size), h, s, self.seed, spare)?;
        let groups = &size.groups;
        let (mut outcomes, mut images) = self.outcomes(&mut sampler, groups)?;
        if sampler.rejected.is_some() {
            sampler.fall_back(self.count(dof), self.budget);
            (outcomes, images) = self.outcomes(&mut sampler, groups)?;
        }
        let (method, full) = (sampler.method(), self.is_full(dof));
        let projected = evaluator.constraint().is_some();
        let points: Vec<JacobianPoint> = outcomes.iter().map(|outcome| outcome.point).collect();
        let volumes: Vec<PointVolume> = (outcomes.iter_mut())
            .filter_map(|outcome| outcome.volume.take())
            .collect();
        let mut worst = TangentDefect::worst(method, points.iter().filter_map(|p| p.worst));
        let mut bound = points.iter().filter_map(|p| p.bound).reduce(f64::max);
        let significant = worst.filter(|worst| !full && !projected && worst.is_significant(method));
        let point = points
            .iter()
            .position(|point| significant.is_some() && point.worst == significant);
        if let (Some(dense), Some(point)) = (significant, point) {
            let directions = self.directions(dof, groups, point).vectors;
            let (i, j) = outcomes[point].pair;
            if let Some(located) = locate(&mut sampler, point, [&directions[i], &directions[j]])? {
                // In the norms of two degrees of freedom it is larger, unless it is spread evenly over many.
                let spread = TangentDefect {
                    dofs: located.dofs,
                    ..dense
                };
                worst = TangentDefect::worst(method, [located, spread].into_iter());
                bound = bound
                    .into_iter()
                    .chain(worst.map(|w| w.bound()))
                    .reduce(f64::max);
            }
        }
        let mut blocks = blocks::together(&volumes, dof);
        if let (Some(blocks), Some(_)) = (&mut blocks, evaluator.stated(h)) {
            blocks.across_time = time::across_time(&mut sampler, &images)?;
        }
        let found = JacobianEvidence {
            step_size: evaluator.stated(h),
            loop_index: 0,
            method,
            not_differentiable: points.iter().filter(|p| p.worst.is_none()).count(),
            full,
            projected,
            worst,
            bound,
            bounds_of_groups: bounds_of_groups(&outcomes, groups.len().max(1)),
            volume: PointVolume::together(&volumes, method),
            blocks,
            deformation: (outcomes.iter().map(|o| o.deformation)).fold(0.0, f64::max),
            noise: sampler.largest_noise(),
            evaluations: sampler.made(),
            points,
        };
        Ok((found, images))
    }

    /// The images of tangent vectors at these parameters of the loop, all unit vectors or this number of random ones, at points at which
    /// the map is differentiable. It makes 13 evaluations for each point and 12 for each vector, and at most `spare` more.
    pub(crate) fn images(
        &self,
        evaluator: &Evaluator<'_>,
        (phase_loop, size): (&dyn Loop, &LoopSize),
        h: f64,
        s: Vec<f64>,
        random: Option<usize>,
        spare: usize,
    ) -> Result<Vec<TangentImages>, Error> {
        let (dof, points) = (evaluator.dof(), s.len());
        let mut sampler = Sampler::new(evaluator, (phase_loop, size), h, s, self.seed, spare)?;
        // A tangent map need not be that of the map.
        sampler.uses_tangents = false;
        let vectors = |point| match random {
            Some(count) => Directions::random(dof, &[], count, self.seed, point),
            None => Directions::units(dof, &[]),
        };
        let mut columns: Vec<Columns> = (0..points)
            .map(|point| Columns::new(point, vectors(point)))
            .collect();
        sampler.differentiate(&mut columns)?;
        let images = columns.iter().filter_map(|of| of.images(&sampler));
        Ok(images.collect())
    }

    /// The largest defect at the point where `found` has its largest one, after a step of size `h`. `None` if the map is not
    /// differentiable there. It takes the [`evaluations`](Self::evaluations) of one point, for each group if tangent vectors are random.
    pub(crate) fn decay(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        size: &LoopSize,
        found: &JacobianEvidence,
        h: f64,
    ) -> Result<Option<JacobianDecay>, Error> {
        let Some(((point, larger), of_found)) = found.worst_point().zip(found.step_size) else {
            return Ok(None);
        };
        let mut sampler = Sampler::new(
            evaluator,
            (phase_loop, size),
            h,
            vec![larger.s],
            self.seed,
            0,
        )?;
        sampler.uses_tangents = found.method == JacobianMethod::TangentMap;
        let dof = evaluator.dof();
        let directions = self.directions(dof, &size.groups, point);
        let mut columns = [sampler.columns(0, directions, found.full)?];
        sampler.differentiate(&mut columns)?;
        let outcome = columns[0].outcome(&sampler, found.full && !found.projected);
        Ok(outcome.point.worst.map(|smaller| JacobianDecay {
            step_sizes: [of_found, h],
            defects: [larger, smaller],
        }))
    }

    /// The defects from the tangent vectors at each point, unless the tangent map is rejected; and the images of unit vectors.
    fn outcomes(
        &self,
        sampler: &mut Sampler<'_>,
        groups: &[ActionGroup],
    ) -> Result<(Vec<Outcome>, Vec<TangentImages>), Error> {
        let (dof, count) = (sampler.frame.dof(), sampler.s.len());
        let full = self.is_full(dof);
        // The first group is planned for; further ones are examined if there are evaluations to spare.
        let further = match full {
            true => 0,
            false => groups.len().saturating_sub(1) * self.directions * sampler.cost(),
        };
        let of_point = self.count(dof) * sampler.cost() + further;
        let at_a_time = sampler.in_a_batch(of_point);
        let mut outcomes = Vec::with_capacity(count);
        let mut images = Vec::new();
        let projected = sampler.evaluator.constraint().is_some();
        let mut compared = false;
        while outcomes.len() < count {
            let first = outcomes.len();
            // A tangent map that is wrong is wrong everywhere, as a rule: one point shows it, and leaves the rest of
            // the budget to differences.
            let last = match sampler.uses_tangents && first == 0 {
                true => 1,
                false => (first + at_a_time).min(count),
            };
            let mut columns = Vec::with_capacity(last - first);
            for point in first..last {
                let groups = if sampler.draw(further) { groups } else { &[] };
                let directions = self.directions(dof, groups, point);
                columns.push(sampler.columns(point, directions, full)?);
            }
            sampler.differentiate(&mut columns)?;
            if sampler.uses_tangents {
                compared |= sampler.check_tangents(&columns, self.seed)?;
                if sampler.rejected.is_some() {
                    return Ok((Vec::new(), Vec::new()));
                }
            }
            let units = full && !projected;
            outcomes.extend(
                columns
                    .iter()
                    .map(|columns| columns.outcome(sampler, units)),
            );
            if units {
                images.extend(columns.iter().filter_map(|of| of.images(sampler)));
            }
        }
        if sampler.uses_tangents && !compared {
            sampler.rejected = Some(TangentRejection::Unchecked);
        }
        Ok((outcomes, images))
    }

    fn check(&self, h: f64, planned: usize) -> Result<(), Error> {
        let range = |what, value, remedy| Error::OutOfRange {
            what,
            value,
            remedy,
        };
        if !h.is_finite() || h == 0.0 {
            let remedy = "give a finite step size that is not zero";
            return Err(range("step size", h, remedy));
        }
        if self.points == 0 {
            let what = "number of points of the Jacobian test";
            return Err(range(what, 0.0, "give one or more"));
        }
        if self.directions < 2 {
            let what = "number of random tangent vectors of the Jacobian test";
            return Err(range(what, self.directions as f64, "give two or more"));
        }
        if planned > self.budget {
            let remedy = "give the evaluations that the test makes, or take JacobianTest::within";
            return Err(range(
                "budget of the Jacobian test",
                self.budget as f64,
                remedy,
            ));
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

    fn directions(&self, dof: usize, groups: &[ActionGroup], point: usize) -> Directions {
        match self.is_full(dof) {
            true => Directions::units(dof, groups),
            false => Directions::random(dof, groups, self.directions, self.seed, point),
        }
    }
}

/// What no pair of each group exceeds at any point.
fn bounds_of_groups(outcomes: &[Outcome], groups: usize) -> Vec<Option<f64>> {
    let of_group = |group: usize| {
        let bounds = outcomes
            .iter()
            .filter_map(|outcome| *outcome.bounds.get(group)?);
        bounds.reduce(f64::max)
    };
    (0..groups).map(of_group).collect()
}
