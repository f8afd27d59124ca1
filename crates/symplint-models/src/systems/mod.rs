//! The test systems.

mod absolute_value;
mod chain;
mod charged_particle;
mod double_pendulum;
mod fput;
mod harmonic_oscillator;
mod henon_heiles;
mod interpolated_pendulum;
mod kepler;
mod pendulum;
mod pendulum_array;
mod rotational_force;
mod toda;
mod two_cell;

pub use absolute_value::AbsoluteValue;
pub use chain::{Bond, Chain, Ends};
pub use charged_particle::ChargedParticle;
pub use double_pendulum::DoublePendulum;
pub use fput::FputBond;
pub use harmonic_oscillator::HarmonicOscillator;
pub use henon_heiles::HenonHeiles;
pub use interpolated_pendulum::InterpolatedPendulum;
pub use kepler::Kepler;
pub use pendulum::{Pendulum, PendulumPotential};
pub use pendulum_array::PendulumArray;
pub use rotational_force::RotationalForce;
pub use toda::TodaBond;
pub use two_cell::TwoCell;
