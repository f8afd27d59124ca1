//! Splitting methods for Hamiltonians of more than two parts.

use symplint::map::{Capabilities, Substeps};
use symplint::{Block, StepFailure, TimeAdvance};

use super::splitting::{SplittingMethod, Variant};
use crate::maps::Invertible;
use crate::split_hamiltonian::{PartFlow, SplitHamiltonian};

/// A splitting method applied to a Hamiltonian of any number of parts with exact flows.
///
/// Every splitting method for two parts is a composition of Lie–Trotter steps of two parts and their adjoints. The same
/// composition of Lie–Trotter steps of n parts has the same order (R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151;
/// HLW, section II.5). So the methods are those of [`splitting_methods`](super::splitting_methods): position first
/// begins with part 0, momentum first with the last part.
///
/// Symplectic if the forces of all parts are continuous. It needs no memory other than the states and what the flows
/// need.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSplitting<S> {
    substeps: Vec<PartFlow>,
    system: S,
}

impl<S: SplitHamiltonian> PartSplitting<S> {
    /// The map of `method` for `system`.
    pub fn new(method: &SplittingMethod, system: S) -> Self {
        let substeps = flows(method, system.parts());
        PartSplitting { substeps, system }
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The flows in the order in which they are applied.
    pub fn flows(&self) -> &[PartFlow] {
        &self.substeps
    }
}

/// The flows of `method` for `parts` parts.
fn flows(method: &SplittingMethod, parts: usize) -> Vec<PartFlow> {
    /// The remainder of a fraction after subtractions of numbers around 1: rounding errors.
    const ROUNDOFF: f64 = 1e-13;
    let flow = |part, fraction| PartFlow { part, fraction };
    let forth = |fraction| (0..parts).map(move |part| flow(part, fraction));
    let back = |fraction| (0..parts).rev().map(move |part| flow(part, fraction));
    let momentum_first = method.substeps()[0].flow == Variant::MomentumFirst.first();
    let mut flows: Vec<PartFlow> = Vec::new();
    // A Lie–Trotter step ends with the flow with which its adjoint begins, and conversely: a fraction of the method for
    // two parts is the sum of those of two neighbours.
    let mut fraction = 0.0;
    for (i, substep) in method.substeps().iter().enumerate() {
        fraction = substep.fraction - fraction;
        if fraction.abs() < ROUNDOFF {
            fraction = 0.0;
            continue;
        }
        let step: &mut dyn Iterator<Item = PartFlow> = if (i % 2 == 1) == momentum_first {
            &mut forth(fraction)
        } else {
            &mut back(fraction)
        };
        for flow in step {
            match flows.last_mut() {
                Some(last) if last.part == flow.part => last.fraction += flow.fraction,
                _ => flows.push(flow),
            }
        }
    }
    flows
}

impl<S: SplitHamiltonian> TimeAdvance for PartSplitting<S> {
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.system.flows(h, &self.substeps, block);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            ..Capabilities::of_coordinates(self.system.coordinates())
        }
    }
}

impl<S: SplitHamiltonian> Substeps for PartSplitting<S> {
    fn substeps(&self) -> usize {
        self.substeps.len()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let substep = &self.substeps[substep];
        self.system.flow(substep.part, substep.fraction * h, block);
        Ok(())
    }

    fn substep_name(&self, substep: usize) -> String {
        let PartFlow { part, fraction } = self.substeps[substep];
        let part = self.system.part_name(part);
        match fraction {
            1.0 => format!("{part} for h"),
            _ => format!("{part} for {} h", (fraction * 1e4).round() / 1e4),
        }
    }
}

impl<S: SplitHamiltonian> Invertible for PartSplitting<S> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for substep in self.substeps.iter().rev() {
            self.system.flow(substep.part, -substep.fraction * h, block);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::splitting_methods::{lie_trotter, mclachlan4, strang, yoshida4, yoshida6};
    use super::*;

    const VARIANTS: [Variant; 2] = [Variant::PositionFirst, Variant::MomentumFirst];

    fn pairs(method: &SplittingMethod, parts: usize) -> Vec<(usize, f64)> {
        let flows = flows(method, parts);
        flows
            .iter()
            .map(|flow| (flow.part, flow.fraction))
            .collect()
    }

    #[test]
    fn lie_trotter_and_strang_are_the_known_ones() {
        let [first, last] = VARIANTS;
        let lie = |variant| pairs(&lie_trotter(variant), 3);
        assert_eq!(lie(first), [(0, 1.0), (1, 1.0), (2, 1.0)]);
        assert_eq!(lie(last), [(2, 1.0), (1, 1.0), (0, 1.0)]);
        let strang = |variant| pairs(&strang(variant), 3);
        assert_eq!(
            strang(first),
            [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)]
        );
        assert_eq!(
            strang(last),
            [(2, 0.5), (1, 0.5), (0, 1.0), (1, 0.5), (2, 0.5)]
        );
    }

    #[test]
    fn two_parts_give_the_method_itself() {
        for method in [lie_trotter, strang, mclachlan4, yoshida4, yoshida6] {
            for variant in VARIANTS {
                let method = method(variant);
                let flows = flows(&method, 2);
                assert_eq!(flows.len(), method.substeps().len(), "{}", method.name());
                for (flow, substep) in flows.iter().zip(method.substeps()) {
                    let is_first_part = substep.flow == Variant::PositionFirst.first();
                    assert_eq!(flow.part == 0, is_first_part);
                    assert!((flow.fraction - substep.fraction).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn every_part_flows_for_the_whole_step() {
        for method in [lie_trotter, strang, mclachlan4, yoshida4, yoshida6] {
            let flows = flows(&method(Variant::PositionFirst), 4);
            for part in 0..4 {
                let of_part = flows.iter().filter(|flow| flow.part == part);
                let sum: f64 = of_part.map(|flow| flow.fraction).sum();
                assert!((sum - 1.0).abs() < 1e-14);
            }
        }
    }
}
