//! How the catalogue makes its maps: of which family, for which systems.

use symplint::TimeAdvance;

use super::implicit::{DiscreteGradient, ImplicitRungeKutta, StageSolver};
use super::splitting::{Splitting, SplittingMethod, Variant};
use super::tableau::{Tableau, TableauPair};
use super::{AdaptiveStrang, Boris, PartSplitting, RungeKutta};
use crate::error::ModelError;
use crate::gempic::{Boris1d2v, Orbit, PlasmaStep};
use crate::model::Model;

/// How an integrator of the catalogue is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Maker {
    Splitting(fn(Variant) -> SplittingMethod, Variant),
    AdaptiveStrang(Variant),
    RungeKutta(fn() -> Tableau),
    Partitioned(fn() -> TableauPair),
    Implicit(fn() -> Tableau),
    DiscreteGradient,
    Boris,
    BorisPic(Boris1d2v),
    CrankNicolson(Orbit),
    Ecsim,
}

impl Maker {
    /// Whether its steps have equations to be solved, by a [`StageSolver`].
    pub(super) fn is_implicit(self) -> bool {
        matches!(
            self,
            Maker::Implicit(_) | Maker::DiscreteGradient | Maker::CrankNicolson(_) | Maker::Ecsim
        )
    }

    /// The map, or nothing where it is not for this kind of system.
    pub(super) fn make(
        self,
        model: Model,
        solver: StageSolver,
    ) -> Option<Result<Box<dyn TimeAdvance>, ModelError>> {
        fn boxed<M: TimeAdvance + 'static>(
            map: Result<M, ModelError>,
        ) -> Option<Result<Box<dyn TimeAdvance>, ModelError>> {
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
            (Maker::BorisPic(scheme), Model::Plasma(plasma)) => {
                boxed(Ok(PlasmaStep::boris((*plasma).clone(), scheme)))
            }
            (Maker::CrankNicolson(orbit), Model::Plasma(plasma)) => {
                boxed(PlasmaStep::crank_nicolson((*plasma).clone(), orbit, solver))
            }
            (Maker::Ecsim, Model::Plasma(plasma)) => {
                boxed(PlasmaStep::ecsim((*plasma).clone(), solver))
            }
            (maker, Model::Plasma(plasma)) => maker.make(Model::Split(plasma), solver),
            _ => None,
        }
    }

    /// What it is for, in words that complete "this is for …".
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
            Maker::BorisPic(_) | Maker::CrankNicolson(_) | Maker::Ecsim => {
                "electromagnetic plasmas"
            }
        }
    }
}
