//! A defect whose order is below that of the method.

use super::{Cause, CauseKind, Clues};

impl Clues<'_> {
    /// One step of a method of order r differs by h^{r+1} from the flow, and the flow of Hamilton's equations conserves loop integrals.
    pub(super) fn order_below_method(&self) -> Option<Cause> {
        let stated = self.evidence.expected_order? as f64;
        let order = self.order.filter(|order| *order <= stated)?;
        let text = format!(
            "The defect goes as h^{order}. One step of a method of order {stated} changes loop integrals of Hamilton's equations by \
             h^{} or less: either the equations are not Hamilton's in these variables, or the step does not have the order {stated}, \
             as if its force is not the force at the states of the method.",
            stated + 1.0
        );
        let remedy = "Test the equations without the step: `check_force(F, q0)`, or `check_field(f, q0, p0)`. If they pass, look for a \
                      force that is kept from an earlier stage, interpolated or not converged.";
        Some(Cause::new(CauseKind::OrderBelowMethod, text, remedy))
    }
}
