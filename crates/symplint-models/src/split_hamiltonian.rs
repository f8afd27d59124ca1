//! Hamiltonians that are sums of any number of parts, each with an exact flow.

use std::any::Any;
use std::sync::Arc;

use symplint::state::{Rows, RowsMut};
use symplint::{Block, Coordinates};

use crate::hamiltonian::Hamiltonian;
use crate::tangent::SlopeTangent;

/// The flow of one part for a fraction of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartFlow {
    /// Which part, counted from 0.
    pub part: usize,
    /// Its time in units of the step size h.
    pub fraction: f64,
}

/// A Hamiltonian H = H_0 + … + H_n−1 whose parts have exact flows.
///
/// [`PartSplitting`](crate::integrators::PartSplitting) makes steps of them, in canonical variables like the steps of any
/// [`Hamiltonian`]. It is `Any`, so that an integrator for one type of system recognises it: see
/// [`Maker::For`](crate::integrators::catalogue::Maker::For).
pub trait SplitHamiltonian: Hamiltonian + Any {
    /// What kind of system it is, in words that complete "this is …".
    fn kind(&self) -> &'static str {
        "a sum of Hamiltonians with exact flows"
    }

    /// Number of parts n.
    fn parts(&self) -> usize;

    /// The name of a part in a report: `H_E`, say.
    fn part_name(&self, part: usize) -> &str;

    /// The exact flow of one part for a time `tau`, in place.
    fn flow(&self, part: usize, tau: f64, block: &mut Block<'_>);

    /// Flows of a step of size `h`, to the last bit as one after the other. By default it is just that; a system whose
    /// flows touch the same variables can do several in one pass over memory.
    fn flows(&self, h: f64, sequence: &[PartFlow], block: &mut Block<'_>) {
        for flow in sequence {
            self.flow(flow.part, flow.fraction * h, block);
        }
    }
}

impl Hamiltonian for Arc<dyn SplitHamiltonian> {
    fn dof(&self) -> usize {
        (**self).dof()
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        (**self).energy(q, p, out);
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        (**self).add_velocity(tau, q, p, out);
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        (**self).add_force(tau, q, p, out);
    }

    fn coordinates(&self) -> Coordinates {
        (**self).coordinates()
    }

    fn tangent(&self) -> Option<SlopeTangent<'_>> {
        (**self).tangent()
    }
}

impl SplitHamiltonian for Arc<dyn SplitHamiltonian> {
    fn kind(&self) -> &'static str {
        (**self).kind()
    }

    fn parts(&self) -> usize {
        (**self).parts()
    }

    fn part_name(&self, part: usize) -> &str {
        (**self).part_name(part)
    }

    fn flow(&self, part: usize, tau: f64, block: &mut Block<'_>) {
        (**self).flow(part, tau, block);
    }

    fn flows(&self, h: f64, sequence: &[PartFlow], block: &mut Block<'_>) {
        (**self).flows(h, sequence, block);
    }
}
