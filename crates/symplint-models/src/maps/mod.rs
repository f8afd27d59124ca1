//! Maps made from maps: sequences, repetitions, inverses and adjoints.

mod adjoint;
mod compose;
mod inverse;
mod invertible;
mod repeat;

pub use adjoint::Adjoint;
pub use compose::Compose;
pub use inverse::Inverse;
pub use invertible::Invertible;
pub use repeat::Repeat;
