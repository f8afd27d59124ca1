//! Random numbers of a member: the same on every platform.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// The random numbers that a member is made from.
pub struct Random(ChaCha8Rng);

impl Random {
    /// That of member `index` of a family.
    pub fn of(family: u64, index: usize) -> Self {
        Random(ChaCha8Rng::seed_from_u64((family << 32) + index as u64))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The logarithm is uniform.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// One of `low`, …, `high`.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f64) as usize
    }

    /// True in this part of all cases.
    pub fn chance(&mut self, part: f64) -> bool {
        self.unit() < part
    }

    /// One of these.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.whole(0, of.len() - 1)]
    }

    /// 1 or −1.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// One number for each degree of freedom.
    pub fn row(&mut self, dof: usize, low: f64, high: f64) -> Vec<f64> {
        (0..dof).map(|_| self.between(low, high)).collect()
    }

    /// A seed for something else.
    pub fn seed(&mut self) -> u64 {
        self.0.next_u64() >> 16
    }
}
