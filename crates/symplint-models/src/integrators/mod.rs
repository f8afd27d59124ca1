//! Time-advance maps of Hamiltonian systems: splitting methods and explicit Runge–Kutta methods.
//!
//! A method is data: a list of substeps ([`splitting_methods`]) or a Butcher tableau
//! ([`tableaus`]). Each family has one stepping loop, [`Splitting`] and [`RungeKutta`]. The
//! [`catalogue`] gives all of them by name.

pub mod catalogue;
mod runge_kutta;
mod splitting;
pub mod splitting_methods;
mod stage_plan;
mod tableau;
pub mod tableaus;

pub use runge_kutta::RungeKutta;
pub use splitting::{Flow, Splitting, SplittingMethod, Substep, Variant};
pub use tableau::{Residual, Tableau, TableauPair};
