//! Random numbers that are the same, bit for bit, on every machine and for every release.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// Uniform random numbers in [0, 1) from a seed.
///
/// ChaCha with 8 rounds, the seed as the first eight bytes (little-endian) of an otherwise
/// zero key; the upper 53 bits of each 64-bit output, times 2^-53, exactly.
pub struct Uniform {
    generator: ChaCha8Rng,
}

impl Uniform {
    /// The numbers of this seed.
    pub fn from_seed(seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        Uniform {
            generator: ChaCha8Rng::from_seed(key),
        }
    }
}

impl Iterator for Uniform {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;
        Some((self.generator.next_u64() >> 11) as f64 * UNIT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_the_published_one() {
        // First 16 bytes of ChaCha8 with a zero key and nonce (test vector TC1 of
        // J. Strombergson, draft-strombergson-chacha-test-vectors).
        let outputs = [0xd640_5f89_2fef_003e_u64, 0xa1a5_091f_e8b8_5b7f];
        for (got, output) in Uniform::from_seed(0).zip(outputs) {
            assert_eq!(got, (output >> 11) as f64 / 9_007_199_254_740_992.0);
        }
    }

    #[test]
    fn numbers_fill_the_unit_interval_evenly() {
        let numbers: Vec<f64> = Uniform::from_seed(42).take(10_000).collect();
        assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)));
        let mean = numbers.iter().sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 0.015, "{mean}");
        assert_ne!(Uniform::from_seed(1).next(), Uniform::from_seed(2).next());
    }
}
