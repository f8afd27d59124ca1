//! A defect whose order is lower than the order of a method.

use super::{Cause, CauseKind, Clues};
use crate::text::size;
use crate::verdict::slope::constant_defect;

impl Clues<'_> {
    /// A step becomes the identity as h → 0. Wrong variables, friction and methods all have defects that fall.
    pub(super) fn independent_of_step_size(&self) -> Option<Cause> {
        let evidence = self.evidence;
        let fit = constant_defect(&evidence.loops, self.fits, evidence.jacobian_decay)?;
        let text = format!(
            "The {} is about the same at all step sizes from {} to {}. A step of size 0 leaves all states where they are: either a part of \
             the step that does not depend on h changes areas, or all these step sizes are too large.",
            fit.quantity,
            size(fit.from),
            size(fit.to)
        );
        let remedy = "Compare the states before and after a step of a very small size: they should be equal. Look for positions or momenta \
                      that the step returns in other units or in another order than it takes, a limit on a coordinate (a clip), a factor in every step instead \
                      of e^(−γh), and a tolerance of a solver.";
        Some(Cause::new(CauseKind::IndependentOfStepSize, text, remedy))
    }

    /// One step of a method of order r differs by h^{r+1} from the flow, and the flow of Hamilton's equations conserves loop integrals.
    pub(super) fn order_below_method(&self) -> Option<Cause> {
        let stated = self.evidence.expected_order? as f64;
        let order = self.order.filter(|order| *order <= stated)?;
        let text = format!(
            "The change is proportional to h^{order}. For Hamilton's equations, one step of a method of order {stated} changes loop \
             integrals in proportion to h^{} or a higher power. Either the equations are not Hamilton's in these variables, or the step does not reach order {stated}, for example because a force is taken at the wrong positions.",
            stated + 1.0
        );
        let remedy = "Test the equations without the step: `check_force(F, q0)`, or `check_field(f, q0, p0)`. If they pass, look for a \
                      force that is kept from an earlier stage, interpolated or not converged.";
        Some(Cause::new(CauseKind::OrderBelowMethod, text, remedy))
    }
}
