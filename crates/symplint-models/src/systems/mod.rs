//! The test systems.

mod absolute_value;
mod harmonic_oscillator;
mod henon_heiles;
mod interpolated_pendulum;
mod pendulum;
mod pendulum_array;
mod two_cell;

pub use absolute_value::AbsoluteValue;
pub use harmonic_oscillator::HarmonicOscillator;
pub use henon_heiles::HenonHeiles;
pub use interpolated_pendulum::InterpolatedPendulum;
pub use pendulum::{Pendulum, PendulumPotential};
pub use pendulum_array::PendulumArray;
pub use two_cell::TwoCell;
