//! Numbers that spread over an interval, random or not, and are the same on every platform.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::Rng;

/// A number in [0, 1) from the upper 53 bits of the next word of the generator.
pub(crate) fn unit(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// The golden ratio (√5 − 1)/2. Its multiples are the most evenly spread on a circle (three-distance theorem).
pub(crate) const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// Number `k` of the loop parameters at which a loop is probed. They are spread by the golden ratio: no two of them, nor their mirror
/// images, coincide, and none is at a symmetric place.
pub(crate) fn parameter(k: usize) -> f64 {
    const START: f64 = 0.137;
    (START + GOLDEN_RATIO * k as f64).fract()
}

/// The first of them.
pub(crate) fn parameters(count: usize) -> Vec<f64> {
    (0..count).map(parameter).collect()
}
