//! Maps whose inner solver stops at a tolerance: the loop breaks wherever the number of iterations changes.

mod midpoint;
mod truth;
