//! Splitting methods: the exact flows of T and V in turn.

use symplint::map::{Capabilities, Substeps, TangentMap};
use symplint::{Block, StepFailure, TimeAdvance};

use crate::error::ModelError;
use crate::hamiltonian::DriftKick;
use crate::maps::Invertible;
use crate::tangent::no_tangent;

/// Which part of H = T(p) + V(q) a substep follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// The flow of T: positions drift.
    Drift,
    /// The flow of V: momenta are kicked.
    Kick,
}

impl Flow {
    fn other(self) -> Self {
        match self {
            Flow::Drift => Flow::Kick,
            Flow::Kick => Flow::Drift,
        }
    }
}

/// Which flow a method begins with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// Begins with a drift.
    #[default]
    PositionFirst,
    /// Begins with a kick.
    MomentumFirst,
}

impl Variant {
    /// The flow that comes first.
    pub fn first(self) -> Flow {
        match self {
            Variant::PositionFirst => Flow::Drift,
            Variant::MomentumFirst => Flow::Kick,
        }
    }
}

/// One flow for a fraction of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substep {
    /// Which flow.
    pub flow: Flow,
    /// Its time in units of h.
    pub fraction: f64,
}

/// A splitting method: flows in the order in which they are applied, drifts and kicks in turn.
#[derive(Clone, Debug, PartialEq)]
pub struct SplittingMethod {
    name: &'static str,
    order: u32,
    substeps: Vec<Substep>,
    reference: &'static str,
}

impl SplittingMethod {
    /// A method from the flows it applies, the first to be applied first.
    ///
    /// Flows of fraction 0 are left out, and neighbours of one kind become one. The order is taken
    /// on trust; the reference says where the method is from.
    ///
    /// # Errors
    /// If a fraction is not finite, or no substep is left.
    pub fn new(
        name: &'static str,
        order: u32,
        substeps: &[Substep],
        reference: &'static str,
    ) -> Result<Self, ModelError> {
        for substep in substeps {
            ModelError::check_finite("the fraction of a splitting substep", substep.fraction)?;
        }
        let merged = merged(substeps.iter().copied());
        if merged.is_empty() {
            return Err(ModelError::NoSubsteps { method: name });
        }
        Ok(SplittingMethod {
            name,
            order,
            substeps: merged,
            reference,
        })
    }

    /// Drifts and kicks in turn, begun as `variant` says; for the tables, whose fractions are
    /// known to be good.
    pub(super) fn alternating(
        name: &'static str,
        order: u32,
        variant: Variant,
        fractions: &[f64],
        reference: &'static str,
    ) -> Self {
        let flows = std::iter::successors(Some(variant.first()), |flow| Some(flow.other()));
        let substeps = flows.zip(fractions);
        SplittingMethod {
            name,
            order,
            substeps: merged(substeps.map(|(flow, &fraction)| Substep { flow, fraction })),
            reference,
        }
    }

    /// `base` once for each of `fractions`, with that fraction of the step; for the tables.
    pub(super) fn composition(
        name: &'static str,
        order: u32,
        base: &SplittingMethod,
        fractions: &[f64],
        reference: &'static str,
    ) -> Self {
        let substeps = fractions.iter().flat_map(|whole| {
            base.substeps.iter().map(move |part| Substep {
                flow: part.flow,
                fraction: whole * part.fraction,
            })
        });
        SplittingMethod {
            name,
            order,
            substeps: merged(substeps),
            reference,
        }
    }

    /// Name of the method.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Order of accuracy for smooth Hamiltonians.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The flows in the order in which they are applied.
    pub fn substeps(&self) -> &[Substep] {
        &self.substeps
    }

    /// The source of the method.
    pub fn reference(&self) -> &'static str {
        self.reference
    }
}

/// Substeps of one kind that follow one another joined, those of fraction 0 left out.
fn merged(substeps: impl Iterator<Item = Substep>) -> Vec<Substep> {
    let mut merged: Vec<Substep> = Vec::new();
    for substep in substeps {
        match merged.last_mut() {
            Some(last) if last.flow == substep.flow => last.fraction += substep.fraction,
            _ => merged.push(substep),
        }
        // A fraction 0 separates nothing: whatever follows joins what was before.
        if merged.last().is_some_and(|last| last.fraction == 0.0) {
            merged.pop();
        }
    }
    merged
}

/// A splitting method applied to a system: the flows one after the other, in place.
///
/// Symplectic if the force is the gradient of a potential and continuous: every flow is. It needs
/// no memory other than the states.
///
/// ```
/// use symplint::TimeAdvance;
/// use symplint_models::integrators::{Splitting, Variant, splitting_methods};
/// use symplint_models::systems::HenonHeiles;
///
/// let step = Splitting::new(splitting_methods::yoshida4(Variant::MomentumFirst), HenonHeiles);
/// assert_eq!(step.dof(), 2);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Splitting<S> {
    method: SplittingMethod,
    system: S,
}

impl<S: DriftKick> Splitting<S> {
    /// The map of `method` for `system`.
    pub fn new(method: SplittingMethod, system: S) -> Self {
        Splitting { method, system }
    }

    /// The method.
    pub fn method(&self) -> &SplittingMethod {
        &self.method
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    fn step(&self, h: f64, block: &mut Block<'_>) {
        let mut substeps = self.method.substeps.as_slice();
        while let [first, others @ ..] = substeps {
            // Kicks and drifts alternate: a drift, a kick and a drift are taken at once.
            if let (Flow::Drift, [kick, drift, rest @ ..]) = (first.flow, others) {
                let taus = [first, kick, drift].map(|substep| substep.fraction * h);
                (self.system).drift_kick_drift(taus, &mut block.q, &mut block.p);
                substeps = rest;
            } else {
                self.follow(first, h, block);
                substeps = others;
            }
        }
    }

    fn follow(&self, substep: &Substep, h: f64, block: &mut Block<'_>) {
        let tau = substep.fraction * h;
        match substep.flow {
            Flow::Drift => self.system.drift(tau, block.p.as_rows(), &mut block.q),
            Flow::Kick => self.system.kick(tau, block.q.as_rows(), &mut block.p),
        }
    }
}

impl<S: DriftKick> TimeAdvance for Splitting<S> {
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.step(h, block);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            tangent: self.system.tangent().map(|_| self as &dyn TangentMap),
            ..Capabilities::of_coordinates(self.system.coordinates())
        }
    }
}

impl<S: DriftKick> Substeps for Splitting<S> {
    fn substeps(&self) -> usize {
        self.method.substeps.len()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.follow(&self.method.substeps[substep], h, block);
        Ok(())
    }

    fn substep_name(&self, substep: usize) -> String {
        let Substep { flow, fraction } = self.method.substeps[substep];
        let flow = match flow {
            Flow::Drift => "drift",
            Flow::Kick => "kick",
        };
        match fraction {
            1.0 => format!("{flow} of h"),
            _ => format!("{flow} of {} h", (fraction * 1e4).round() / 1e4),
        }
    }
}

impl<S: DriftKick> TangentMap for Splitting<S> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let derivative = self.system.tangent().ok_or_else(no_tangent)?;
        for substep in &self.method.substeps {
            let tau = substep.fraction * h;
            let (q, p) = (states.q.as_rows(), states.p.as_rows());
            let Block { q: dq, p: dp } = tangents;
            match substep.flow {
                Flow::Drift => derivative.drift_tangent(tau, p, dp.as_rows(), dq),
                Flow::Kick => derivative.kick_tangent(tau, q, dq.as_rows(), dp),
            }
            self.follow(substep, h, states);
        }
        Ok(())
    }
}

impl<S: DriftKick> Invertible for Splitting<S> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for substep in self.method.substeps.iter().rev() {
            self.follow(substep, -h, block);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn substep(flow: Flow, fraction: f64) -> Substep {
        Substep { flow, fraction }
    }

    #[test]
    fn neighbours_of_one_kind_merge_across_what_vanishes() {
        let substeps = [
            substep(Flow::Drift, 0.25),
            substep(Flow::Kick, 0.5),
            substep(Flow::Kick, -0.5),
            substep(Flow::Drift, 0.5),
            substep(Flow::Kick, 0.0),
            substep(Flow::Drift, 0.25),
            substep(Flow::Kick, 1.0),
        ];
        let method = SplittingMethod::new("test", 1, &substeps, "").unwrap();
        assert_eq!(
            method.substeps(),
            [substep(Flow::Drift, 1.0), substep(Flow::Kick, 1.0)]
        );
    }

    #[test]
    fn methods_without_meaning_are_refused() {
        let method = |substeps: &[Substep]| SplittingMethod::new("test", 1, substeps, "");
        assert!(method(&[]).is_err());
        assert!(method(&[substep(Flow::Drift, 0.0)]).is_err());
        assert!(method(&[substep(Flow::Kick, f64::NAN)]).is_err());
    }
}
