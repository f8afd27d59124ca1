//! Maps made from maps: sequences, repetitions, inverses and adjoints; and maps with a fault, to see
//! what it does.

mod adjoint;
mod compose;
mod damped;
mod inverse;
mod invertible;
mod single_precision;

pub use adjoint::Adjoint;
pub use compose::Compose;
pub use damped::DampedMap;
pub use inverse::Inverse;
pub use invertible::Invertible;
pub use single_precision::SinglePrecision;
