//! Maps that are given, not integrated.
//!
//! Each is one step of size h = 1 of a splitting method, and is written here for any h, so that it
//! can be swept like a time step.

mod henon_map;
mod pendulum_rattle;
mod standard_map;

pub use henon_map::HenonMap;
pub use pendulum_rattle::PendulumRattle;
pub use standard_map::StandardMap;
