//! The parts of a step.

use super::{StepFailure, TimeAdvance};
use crate::state::Block;

/// A step that is a composition of maps of phase space, such as the drifts and kicks of a splitting method.
///
/// A map says that it has parts by [`Capabilities::substeps`](super::Capabilities::substeps). A verdict then names the part that is
/// not symplectic.
pub trait Substeps: Sync {
    /// Number of substeps, 1 or more.
    fn substeps(&self) -> usize;

    /// Takes one substep of a step of size `h`: all of them, 0 first, do what [`advance`](TimeAdvance::advance) does, to the last bit.
    ///
    /// # Errors
    /// As those of [`advance`](TimeAdvance::advance).
    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure>;

    /// The name of a substep in a report: `kick of 0.5 h`, say.
    fn substep_name(&self, substep: usize) -> String {
        format!("part {}", substep + 1)
    }
}

/// The substeps of any map: those that it has, or the step as one whole.
///
/// ```
/// use symplint::PerSample;
/// use symplint::map::Parts;
///
/// let drift = PerSample::new(1, |h, q, p| q[0] += h * p[0]);
/// assert_eq!(Parts::of(&drift).count(), 1);
/// ```
pub struct Parts<'a, M: ?Sized> {
    map: &'a M,
    substeps: Option<&'a dyn Substeps>,
}

impl<M: ?Sized> Clone for Parts<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: ?Sized> Copy for Parts<'_, M> {}

impl<'a, M: TimeAdvance + ?Sized> Parts<'a, M> {
    /// The parts of `map`.
    pub fn of(map: &'a M) -> Self {
        let substeps = map.capabilities().substeps;
        Parts { map, substeps }
    }

    /// How many there are, 1 or more.
    pub fn count(&self) -> usize {
        self.substeps.map_or(1, Substeps::substeps)
    }

    /// Takes one of them, as [`Substeps::advance_substep`] does.
    ///
    /// # Errors
    /// As those of [`advance`](TimeAdvance::advance).
    pub fn advance(&self, part: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        match self.substeps {
            Some(substeps) => substeps.advance_substep(part, h, block),
            None => self.map.advance(h, block),
        }
    }

    /// Its name.
    pub fn name(&self, part: usize) -> String {
        match self.substeps {
            Some(substeps) => substeps.substep_name(part),
            None => format!("part {}", part + 1),
        }
    }
}
