//! Which part of a step changes areas, from the blocks of the defect of its Jacobian.
//!
//! If Q commute and Q, P have canonical brackets, P are the momenta of a symplectic map and a function of Q. So if the brackets of P alone
//! are wrong, the step ends with a kick that is not a gradient. The other rules are the same statement for positions, for both, and for
//! the beginning of a step.

use super::{Cause, CauseKind, Clues};
use crate::jacobian::DefectBlocks;
use crate::signal::NEGLIGIBLE;
use crate::verdict::findings::blocks_text;
use crate::verdict::slope::{slope_of, slope_of_jacobian};
use crate::verdict::thresholds::MIN_TREND;

/// Defects of a model that is wrong have smaller slopes of log |defect| over log h, defects of a method larger ones. Conventional: between
/// the orders 1 and 2.
pub(super) const MAX_SLOPE_OF_MODEL: f64 = 1.5;

/// A block is the largest one if others are smaller by this factor. Conventional: the motion in a step, by which other blocks differ from
/// it, is less than this part of a radian.
const MIN_RATIO_OF_LARGEST_BLOCK: f64 = 2.0;

impl Clues<'_> {
    /// The slope of the defect against the step size, if it is known.
    pub(super) fn slope(&self) -> Option<f64> {
        self.order.or_else(|| slope_of(self.evidence))
    }

    /// The slope of the defect of the Jacobian, to which the blocks belong. If loops state a lower order, it is that one: at the state of
    /// the Jacobian, the largest step may be beyond the first term of the defect.
    fn slope_of_blocks(&self) -> Option<f64> {
        let of_jacobian = self.evidence.jacobian_decay.and_then(slope_of_jacobian);
        match (of_jacobian.map(|fit| fit.slope), self.order) {
            (Some(slope), Some(order)) => Some(slope.min(order)),
            (slope, _) => slope.or_else(|| self.slope()),
        }
    }

    /// Only the length of the step differs from state to state.
    pub(super) fn own_step_length(&self) -> Option<Cause> {
        let blocks = self.evidence.jacobian.as_ref()?.blocks.as_ref()?;
        blocks.across_time.filter(|left| *left <= NEGLIGIBLE)?;
        Some(Cause::new(
            CauseKind::ChosenStepLength,
            "The Jacobian differs from a symplectic one only along the trajectories (less than 0.1% of the defect is across them): the \
             step moves each state by its own length of time, which depends on the state."
                .to_owned(),
            "Give all states the same step size. If the step has to be short at some places, advance the equations in another time: \
             with h = τ·g(q, p), the Hamiltonian g·(H − H₀) has the same trajectories (Poincaré's transformation), and a symplectic \
             method with fixed τ conserves its areas.",
        ))
    }

    /// The part of the step that the blocks of the defect show, unless loops name a substep: a defect within one degree of freedom has the
    /// blocks of friction and of old values, whatever makes it.
    pub(super) fn part_of_step(&self) -> Option<Cause> {
        self.part_by_blocks().filter(|cause| {
            let is_vague = matches!(
                cause.kind,
                CauseKind::PartialFriction | CauseKind::FewIterations
            );
            !is_vague || (self.substep().is_none() && !self.is_constant())
        })
    }

    fn part_by_blocks(&self) -> Option<Cause> {
        let blocks = self.evidence.jacobian.as_ref()?.blocks.as_ref()?;
        let slope = self.slope_of_blocks();
        let of_model = slope.is_none_or(|slope| slope < MAX_SLOPE_OF_MODEL);
        // In other variables blocks are others.
        let form = self.evidence.preserved_form.as_ref();
        let no_form = form.is_some_and(|form| form.exists == Some(false));
        // If the search for a form has no result, other variables may explain a kick, as momenta in a magnetic field do, but no drift, and
        // no change of momenta by themselves.
        let is_unknown = form.is_some_and(|form| form.exists.is_none());
        let may_be_friction = is_unknown && slope.is_some_and(|slope| slope < MAX_SLOPE_OF_MODEL);
        let sides = [(&blocks.after, true), (&blocks.before, false)];
        let found = sides.into_iter().find_map(|(side, is_end)| {
            let mut is_zero = side.zeros();
            // A kick changes the brackets of momenta at the end of a step, and the areas of positions at its beginning.
            if is_end {
                is_zero.reverse();
            }
            let kind = match is_zero {
                [false, true, true] => CauseKind::ForceWithCurl,
                [true, true, false] => CauseKind::VelocityWithCurl,
                [true, false, true] if of_model => CauseKind::PartialFriction,
                [_, false, true] if !of_model => CauseKind::FewIterations,
                _ => return None,
            };
            Some((kind, side, is_end))
        });
        let Some((kind, side, is_end)) = found else {
            return self.largest_block(blocks).filter(|_| of_model && no_form);
        };
        let is_shown = match kind {
            _ if !of_model || no_form => true,
            CauseKind::PartialFriction => may_be_friction,
            CauseKind::VelocityWithCurl => is_unknown,
            _ => false,
        };
        if !is_shown {
            return None;
        }
        let (matrix, verb) = match is_end {
            true => (
                "the Poisson brackets after the step (less their canonical values)",
                "ends",
            ),
            false => ("MᵀJM − J", "begins"),
        };
        let part = match kind {
            CauseKind::ForceWithCurl => format!("The step {verb} with a kick by a force F(q) that is not a gradient"),
            CauseKind::VelocityWithCurl => {
                format!("The step {verb} with a drift by a velocity v(p) that is not a gradient")
            }
            CauseKind::PartialFriction => {
                format!("The step {verb} with friction, or another change of p that depends on p, or of q on q")
            }
            _ => "Parts of the step may use old values of each other: a force at old positions, an explicit Runge–Kutta method, or an \
             implicit method after one to three iterations. Momenta that are rescaled look the same"
                .to_owned(),
        };
        let text = format!(
            "{part}. Largest entries of {matrix}: {}.",
            blocks_text(side)
        );
        Some(Cause::new(kind, text, remedy(kind)))
    }

    /// If no block is 0, the largest one of a defect that falls with h.
    fn largest_block(&self, blocks: &DefectBlocks) -> Option<Cause> {
        // Without a trend chance decides about the largest block.
        self.slope().filter(|slope| *slope > MIN_TREND)?;
        // At the end of a step, positions and momenta change their parts.
        let [before, mut after] = [blocks.before.sizes, blocks.after.sizes];
        after.reverse();
        let is_largest = |block: usize| {
            [before, after].iter().all(|sizes| {
                let others = (0..3).filter(|&other| other != block);
                others
                    .into_iter()
                    .all(|other| sizes[block] > MIN_RATIO_OF_LARGEST_BLOCK * sizes[other])
            })
        };
        let (kind, meaning) = match (0..3).find(|&block| is_largest(block))? {
            0 => (
                CauseKind::ForceWithCurl,
                "kicks by a force F(q) that is not a gradient",
            ),
            1 => (CauseKind::PartialFriction, "friction on some momenta"),
            _ => (
                CauseKind::VelocityWithCurl,
                "drifts by a velocity v(p) that is not a gradient",
            ),
        };
        let text = format!(
            "The Jacobian differs from a symplectic one as with {meaning}. Largest entries of MᵀJM − J: {}; of the Poisson brackets after \
             the step: {}.",
            blocks_text(&blocks.before),
            blocks_text(&blocks.after)
        );
        Some(Cause::new(kind, text, remedy(kind)))
    }
}

fn remedy(kind: CauseKind) -> &'static str {
    match kind {
        CauseKind::ForceWithCurl => {
            "Test the force without the step: `check_force(F, q0)`. Look for a pair force without its reaction, a coupling with a wrong \
             sign, a force from a table or a network that predicts forces instead of an energy. If the force passes, look for time steps \
             that differ from particle to particle, and for masses that differ between the kicks of the step."
        }
        CauseKind::VelocityWithCurl => {
            "Test how positions are advanced: dq/dt has to be the gradient of a kinetic energy in p, with a symmetric mass matrix."
        }
        CauseKind::PartialFriction => {
            "Look for friction, a thermostat, a filter or a limit on these momenta, for momenta that the step rescales, and for masses that \
             depend on q or p: velocities are no momenta then (`mass_matrix`), and the force needs its part −∂T/∂q (`check_field`). Time \
             steps that differ from particle to particle look the same. With friction on purpose, the step is not symplectic."
        }
        _ => {
            "In a splitting such as the leapfrog method, each kick needs the force at the newest positions, and each drift the newest \
             momenta. An implicit method has to iterate until its stages are solved to rounding error. Instead of an explicit \
             Runge–Kutta method, use a symplectic one of its order, such as a splitting. If the step rescales momenta, to keep the \
             energy or a temperature, leave that out."
        }
    }
}
