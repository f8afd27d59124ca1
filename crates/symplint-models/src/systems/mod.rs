//! The test systems.

mod absolute_value;
mod harmonic_oscillator;
mod henon_heiles;
mod interpolated_pendulum;
mod pendulum;
mod pendulum_array;

pub use absolute_value::AbsoluteValue;
pub use harmonic_oscillator::HarmonicOscillator;
pub use henon_heiles::HenonHeiles;
pub use interpolated_pendulum::InterpolatedPendulum;
pub use pendulum::{Pendulum, PendulumPotential};
pub use pendulum_array::PendulumArray;

use symplint::Coordinates;

/// One degree of freedom whose position has the period 2π.
fn angle() -> Coordinates {
    Coordinates::plain(1)
        .with_periods(vec![std::f64::consts::TAU])
        .expect("2π is a period, and there is one degree of freedom")
}
