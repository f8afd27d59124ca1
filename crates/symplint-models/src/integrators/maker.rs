//! How the catalogue makes its maps: of which family, for which systems.

use symplint::TimeAdvance;

use super::implicit::{DiscreteGradient, ImplicitRungeKutta, StageSolver};
use super::splitting::{Splitting, SplittingMethod, Variant};
use super::tableau::{Tableau, TableauPair};
use super::{AdaptiveStrang, Boris, PartSplitting, RungeKutta};
use crate::error::ModelError;
use crate::model::Model;

/// A map, or the reason why it cannot be made.
pub type MapResult = Result<Box<dyn TimeAdvance>, ModelError>;

/// How an integrator of the catalogue is made.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Maker {
    /// A splitting method in one of its variants: [`Splitting`] or [`PartSplitting`].
    Splitting(fn(Variant) -> SplittingMethod, Variant),
    /// [`AdaptiveStrang`] in one of its variants.
    AdaptiveStrang(Variant),
    /// An explicit method: [`RungeKutta`].
    RungeKutta(fn() -> Tableau),
    /// A partitioned method: [`RungeKutta`] for separable Hamiltonians.
    Partitioned(fn() -> TableauPair),
    /// An implicit method: [`ImplicitRungeKutta`].
    Implicit(fn() -> Tableau),
    /// [`DiscreteGradient`].
    DiscreteGradient,
    /// [`Boris`].
    Boris,
    /// A scheme for one type of system, from the crate of that system.
    For {
        /// The systems, in words that complete "this is for …".
        needs: &'static str,
        /// Whether its steps have equations to be solved, by a [`StageSolver`].
        is_implicit: bool,
        /// The map, or nothing if it is not for this system.
        make: fn(&Model, StageSolver) -> Option<MapResult>,
    },
}

impl Maker {
    /// Whether its steps have equations to be solved, by a [`StageSolver`].
    pub(super) fn is_implicit(self) -> bool {
        match self {
            Maker::Implicit(_) | Maker::DiscreteGradient => true,
            Maker::For { is_implicit, .. } => is_implicit,
            _ => false,
        }
    }

    /// The map, or nothing if it is not for this kind of system.
    pub(super) fn make(self, model: Model, solver: StageSolver) -> Option<MapResult> {
        fn boxed<M: TimeAdvance + 'static>(map: Result<M, ModelError>) -> Option<MapResult> {
            Some(map.map(|map| Box::new(map) as Box<dyn TimeAdvance>))
        }
        match (self, model) {
            (Maker::Splitting(method, variant), Model::Separable(system)) => {
                boxed(Ok(Splitting::new(method(variant), system)))
            }
            (Maker::Splitting(method, variant), Model::Forced(system)) => {
                boxed(Ok(Splitting::new(method(variant), system)))
            }
            (Maker::Splitting(method, variant), Model::Split(system)) => {
                boxed(Ok(PartSplitting::new(&method(variant), system)))
            }
            (Maker::AdaptiveStrang(variant), Model::Separable(system)) => {
                boxed(Ok(AdaptiveStrang::new(variant, system)))
            }
            (Maker::AdaptiveStrang(variant), Model::Forced(system)) => {
                boxed(Ok(AdaptiveStrang::new(variant, system)))
            }
            (Maker::RungeKutta(tableau), Model::Separable(system)) => {
                boxed(RungeKutta::separable(tableau(), system))
            }
            (Maker::RungeKutta(tableau), Model::General(system)) => {
                boxed(RungeKutta::new(tableau(), system))
            }
            (Maker::RungeKutta(tableau), Model::Split(system)) => {
                boxed(RungeKutta::new(tableau(), system))
            }
            (Maker::RungeKutta(tableau), Model::Charged(system)) => {
                boxed(RungeKutta::new(tableau(), system))
            }
            (Maker::Partitioned(pair), Model::Separable(system)) => {
                boxed(RungeKutta::separable(pair(), system))
            }
            (Maker::Implicit(tableau), Model::Separable(system)) => {
                boxed(ImplicitRungeKutta::new(tableau(), system, solver))
            }
            (Maker::Implicit(tableau), Model::General(system)) => {
                boxed(ImplicitRungeKutta::new(tableau(), system, solver))
            }
            (Maker::Implicit(tableau), Model::Split(system)) => {
                boxed(ImplicitRungeKutta::new(tableau(), system, solver))
            }
            (Maker::Implicit(tableau), Model::Charged(system)) => {
                boxed(ImplicitRungeKutta::new(tableau(), system, solver))
            }
            (Maker::DiscreteGradient, Model::Separable(system)) => {
                boxed(DiscreteGradient::new(system, solver))
            }
            (Maker::DiscreteGradient, Model::General(system)) => {
                boxed(DiscreteGradient::new(system, solver))
            }
            (Maker::DiscreteGradient, Model::Split(system)) => {
                boxed(DiscreteGradient::new(system, solver))
            }
            (Maker::DiscreteGradient, Model::Charged(system)) => {
                boxed(DiscreteGradient::new(system, solver))
            }
            (Maker::Boris, Model::Charged(particle)) => boxed(Ok(Boris::new(particle))),
            (Maker::For { make, .. }, model) => make(&model, solver),
            _ => None,
        }
    }

    /// Its purpose, in words that complete "this is for …".
    pub(super) fn needs(self) -> &'static str {
        match self {
            Maker::Splitting(..) => {
                "parts with exact flows, such as drifts of positions and kicks of momenta by a force of the positions"
            }
            Maker::AdaptiveStrang(_) => {
                "positions that drift with their momenta and momenta kicked by a force of the positions"
            }
            Maker::RungeKutta(_) | Maker::Implicit(_) | Maker::DiscreteGradient => "Hamiltonians",
            Maker::Partitioned(_) => "separable Hamiltonians",
            Maker::Boris => "a charge in a magnetic field",
            Maker::For { needs, .. } => needs,
        }
    }
}
