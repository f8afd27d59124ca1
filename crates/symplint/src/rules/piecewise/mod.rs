//! The piecewise rule: ∮ p·dq of a loop that a map may have broken, to near round-off.
//!
//! A map can be evaluated at any s. So the advanced loop is cut into pieces, each the image of a
//! polynomial to the tolerance ([`piece`], [`examine`]); jumps are found by their effect on the Chebyshev
//! coefficients of a piece ([`lobatto`]) and closed in on until no double lies between
//! ([`jump`]), kinks are cut at. States are evaluated in large batches, all pieces at once
//! ([`refinement`]), and none twice.
//!
//! The test of a piece is another one than that of equispaced samples in `breaks`: it takes all coordinates
//! together, works with few states at any distance, and tells a kink from a jump and from a steep stretch before
//! anything is bisected. How a jump is closed in on and told from noise is the same.
//!
//! The pieces give the absolutely continuous integral. The breaks are closed by segments
//! ([`closure`]): for a step that is a composition, where a break is born, and the segment is sent
//! through the rest of the step as another curve.

mod break_uncertainty;
mod closure;
mod curves;
mod examine;
mod fit;
mod grid;
mod integrator;
mod jump;
mod lift;
mod limits;
mod lobatto;
mod noise;
mod piece;
mod refinement;
mod samples;
mod scales;
mod stage_states;
mod sum;
mod task;
mod under_resolved;

use crate::breaks::Break;
use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use crate::rules::LoopIntegral;
use crate::signal::CompensatedSum;
use crate::state::Ensemble;
use break_uncertainty::break_uncertainty;
use closure::close;
use curves::{CurvePoint, Curves, PointImage};
pub(crate) use integrator::Identity;
use lift::Lift;
use limits::{FULL_LEVEL, REACH_AROUND_CUT, SAMPLES_TO_UNWRAP};
use piece::Piece;
use refinement::{Budget, Refinement};
use scales::Scales;

/// How the segments that close breaks are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Closure {
    /// Between the ends of the advanced loop: straight chords.
    Chords,
    /// At the breaks that a substep makes; the remaining substeps then advance the chords. A map without declared substeps has
    /// straight chords.
    ///
    /// A composition of symplectic substeps with continuous potentials then conserves the closed
    /// integral to round-off at every step size, however often its force jumps.
    #[default]
    Substeps,
}

/// The piecewise rule: adaptive, for maps that can be evaluated at any s.
///
/// ```
/// use symplint::{Circle, PerSample};
/// use symplint::rules::Piecewise;
///
/// // Position-first Strang splitting on H = p²/2 + |q|: the force jumps at q = 0.
/// let map = PerSample::new(1, |h, q, p| {
///     q[0] += 0.5 * h * p[0];
///     p[0] -= h * if q[0] < 0.0 { -1.0 } else { 1.0 };
///     q[0] += 0.5 * h * p[0];
/// });
/// let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
/// let h: f64 = 0.5;
/// let found = Piecewise::default().integrate(&map, &circle, h)?;
///
/// // The paper's closed form of the absolutely continuous integral.
/// let expected = std::f64::consts::PI + 4.0 * h * h / (h * h + 4.0).sqrt();
/// assert!((found.continuous.value - expected).abs() < 1e-12);
/// // Two breaks, and a closed integral that is conserved.
/// assert_eq!(found.breaks.len(), 2);
/// assert!((found.closed().value - std::f64::consts::PI).abs() < 1e-13);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piecewise {
    /// What an interpolant may be off, relative to the size of each coordinate on the loop.
    pub tolerance: f64,
    /// How breaks are closed.
    pub closure: Closure,
    /// Pieces to begin with, or as many as can be evaluated. Features between the states of a piece that looks smooth
    /// are not resolved, unless a position has a turning point there.
    pub pieces: usize,
    /// States to be advanced at most, 15 or more; what is not resolved by then is reported, and its error is an
    /// estimate that covers it.
    pub most_evaluations: usize,
}

impl Default for Piecewise {
    fn default() -> Self {
        Piecewise {
            tolerance: 1e-12,
            closure: Closure::default(),
            pieces: 4,
            most_evaluations: 4_000_000,
        }
    }
}

/// The result of the piecewise rule for an advanced loop.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PiecewiseIntegral {
    /// I_ac: the absolutely continuous part, what the paper's rules aim at.
    pub continuous: LoopIntegral,
    /// The part of its quadrature error that stands for breaks whose position is uncertain: if the loop only
    /// grazes what breaks it, rounding moves the breaks along s. The closed integral has none of it.
    pub break_uncertainty: f64,
    /// What breaks contribute at most that are so small that rounding inside the map may be their cause.
    pub insubstantial: f64,
    /// Contribution of the closing segments in each degree of freedom.
    pub closing: Vec<f64>,
    /// What other curves than straight segments could contribute, where the breaks begin: the sum of |Δq Δp| over breaks and
    /// degrees of freedom. 0 where momenta jump alone, as by a force that jumps, or positions alone: every curve contributes
    /// the same then.
    pub bend: f64,
    /// Every break, by its s.
    pub breaks: Vec<Break>,
    /// Breaks at which rounding decides on which side of them a state is, hundreds of roundings of s away from them:
    /// what the map compares there is small, such as what a solver leaves.
    pub flickering: usize,
    /// Pieces that the loop was cut into.
    pub pieces: usize,
    /// Stretches of s that could not be resolved; their error is in `quadrature_error`.
    pub unresolved: Vec<(f64, f64)>,
    /// States advanced, whole step or rest of one.
    pub evaluations: usize,
}

impl PiecewiseIntegral {
    /// The integral of the loop with its breaks closed.
    pub fn closed(&self) -> LoopIntegral {
        let mut closed = self.continuous.clone();
        let mut value = CompensatedSum::default();
        for (sum, closing) in closed.contributions.iter_mut().zip(&self.closing) {
            *sum += closing;
            value.add(*sum);
        }
        closed.value = value.total();
        closed.quadrature_error =
            (closed.quadrature_error).map(|error| (error - self.break_uncertainty).max(0.0));
        closed
    }

    /// States that the pieces are made of.
    pub fn nodes(&self) -> usize {
        self.pieces * lobatto::NODES
    }
}

impl Piecewise {
    /// The same without a limit of evaluations: for the loop before the step, which costs none.
    fn unlimited(&self) -> Self {
        Piecewise {
            most_evaluations: Piecewise::default().most_evaluations,
            ..*self
        }
    }

    /// Integrates the loop that `map` makes of `phase_loop` in one step of size `h`.
    ///
    /// On the threads of the current Rayon pool; the result does not depend on their number.
    ///
    /// # Errors
    /// If map and loop differ in their degrees of freedom, the tolerance is not positive, fewer than 15 states may be
    /// advanced, the map fails or returns states that are not finite, or the integral overflows.
    pub fn integrate(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        h: f64,
    ) -> Result<PiecewiseIntegral, Error> {
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count)?;
        let samples = match evaluator.coordinates().has_momentum_periods() {
            true => {
                self.check(&evaluator, phase_loop)?;
                let mut samples = Ensemble::sample(phase_loop, SAMPLES_TO_UNWRAP)?;
                evaluator.advance(&mut samples, h)?;
                Some(samples)
            }
            false => None,
        };
        self.integrate_beside(&evaluator, phase_loop, h, samples.as_ref())
    }

    /// The same in addition to equispaced `samples` of the advanced loop. Every piece has to agree with them, so that nothing
    /// as wide as their distance is missed; and where they show, or pieces find, narrower features, the error says
    /// so. The regularity of the integral is that of the samples.
    pub(crate) fn integrate_beside(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        h: f64,
        samples: Option<&Ensemble>,
    ) -> Result<PiecewiseIntegral, Error> {
        self.check(evaluator, phase_loop)?;
        let most_evaluations = self.most_evaluations.min(evaluator.count().left());
        let coordinates = evaluator.coordinates();
        let curves = Curves {
            evaluator,
            h,
            phase_loop,
            segments: Vec::new(),
            lift: samples.map_or_else(Lift::default, |samples| Lift::new(samples, coordinates)),
        };
        let features = evaluator.features();
        let known: Vec<f64> = features.iter().map(|feature| feature.s).collect();
        let mut pieces = self.first_pieces(&known, most_evaluations);
        let points: Vec<CurvePoint> = pieces.iter().flat_map(Piece::missing_points).collect();
        let (images, evaluations) = curves.images(&points, 0)?;
        let mut images = images.into_iter();
        pieces.iter_mut().for_each(|piece| piece.fill(&mut images));
        let at_nodes = pieces
            .iter()
            .flat_map(|piece| (0..lobatto::NODES).map(|k| piece.image(k)));
        let at_nodes: Vec<&PointImage> = at_nodes.collect();
        evaluator.learn_grain(phase_loop, at_nodes.len(), |c, k| at_nodes[k].after()[c]);
        let scales = Scales::new(
            &at_nodes,
            coordinates,
            self.tolerance,
            evaluator.grain().as_deref(),
        );
        let budget = Budget::new(most_evaluations, evaluations);
        let mut refinement = Refinement::new(curves, coordinates, scales, budget, samples);
        refinement.run(0, pieces)?;
        refinement.repeat_ends()?;
        let closing = close(&mut refinement, self.closure)?;
        let break_uncertainty = break_uncertainty(&mut refinement)?;
        let mut integral = sum::sum(&refinement, &closing, break_uncertainty)?;
        if refinement.curves.lift.winds {
            integral.continuous.quadrature_error = None;
        }
        Ok(integral)
    }

    /// A few pieces of one length, cut round the breaks that are known; fewer where their states are more than may
    /// be evaluated.
    fn first_pieces(&self, known: &[f64], most_evaluations: usize) -> Vec<Piece> {
        // Neighbours share a state.
        let affordable = (most_evaluations.saturating_sub(1) / (lobatto::POINTS - 1)).max(1);
        let count = self.pieces.clamp(1, affordable);
        let mut edges: Vec<f64> = (0..=count).map(|k| k as f64 / count as f64).collect();
        let around = (known.iter().filter(|s| s.is_finite()))
            .flat_map(|s| [s - REACH_AROUND_CUT, s + REACH_AROUND_CUT])
            .filter(|edge| (REACH_AROUND_CUT..1.0 - REACH_AROUND_CUT).contains(edge));
        edges.extend(around.take(affordable - count));
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        (edges.windows(2))
            .map(|ends| Piece::new(0, [ends[0], ends[1]], FULL_LEVEL, [None, None]))
            .collect()
    }

    fn check(&self, evaluator: &Evaluator<'_>, phase_loop: &dyn Loop) -> Result<(), Error> {
        evaluator.check_dof(phase_loop.dof())?;
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            return Err(Error::OutOfRange {
                what: "tolerance of the piecewise rule",
                value: self.tolerance,
                remedy: "give a positive number such as 1e-11",
            });
        }
        if self.most_evaluations < lobatto::POINTS {
            return Err(Error::OutOfRange {
                what: "number of states that the piecewise rule may advance",
                value: self.most_evaluations as f64,
                remedy: "allow 15 or more",
            });
        }
        Ok(())
    }
}
