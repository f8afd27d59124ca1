//! Time-advance maps of Hamiltonian systems: splitting methods and Runge–Kutta methods.
//!
//! A method is data: a list of substeps ([`splitting_methods`]) or a Butcher tableau
//! ([`tableaus`]). Each family has one stepping loop: [`Splitting`], [`PartSplitting`] for more than two parts, [`RungeKutta`] where stages
//! are explicit, [`ImplicitRungeKutta`] where they are to be solved. [`AdaptiveStrang`],
//! [`Boris`] and [`DiscreteGradient`] stand for themselves. The [`catalogue`] gives all of them by name.

mod adaptive_strang;
pub mod aliases;
mod boris;
pub mod catalogue;
mod dormand_prince;
mod implicit;
mod maker;
mod part_splitting;
mod runge_kutta;
mod splitting;
pub mod splitting_methods;
mod stage_plan;
mod tableau;
pub mod tableaus;

pub use adaptive_strang::AdaptiveStrang;
pub use boris::Boris;
pub use implicit::{DiscreteGradient, ImplicitRungeKutta, Solver, StageSolver, Stop};
pub use part_splitting::PartSplitting;
pub use runge_kutta::RungeKutta;
pub use splitting::{Flow, Splitting, SplittingMethod, Substep, Variant};
pub use tableau::{Residual, Tableau, TableauPair};
