//! Tangent vectors: all unit vectors, or seeded random pairs.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::signal::unit;

/// The unit vectors of all 2d coordinates.
pub(super) fn units(dof: usize) -> Vec<Vec<f64>> {
    let unit = |c: usize| {
        let mut direction = vec![0.0; 2 * dof];
        direction[c] = 1.0;
        direction
    };
    (0..2 * dof).map(unit).collect()
}

/// The direction in which the noise of a map is looked for: it moves every coordinate.
pub(super) fn of_noise(dof: usize, seed: u64) -> Vec<f64> {
    random(2 * dof, &mut generator(seed, u64::MAX))
}

/// A pair of tangent vectors that move every coordinate, with ω(u, v) of the order of the product of
/// their norms. Every second pair is conjugate, v = J u; in the others half of v is independent of u, so
/// that forms between different degrees of freedom show.
pub(super) fn pair(dof: usize, seed: u64, place: usize, pair: usize) -> Vec<Vec<f64>> {
    let mut generator = generator(seed, ((place as u64) << 32) ^ pair as u64);
    let u = random(2 * dof, &mut generator);
    let (q, p) = u.split_at(dof);
    let mut v: Vec<f64> = p.iter().map(|p| -p).chain(q.iter().copied()).collect();
    if pair % 2 == 1 {
        let other = random(2 * dof, &mut generator);
        for (v, other) in v.iter_mut().zip(other) {
            *v = 0.5 * (*v + other);
        }
    }
    vec![u, v]
}

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

/// Components between ½ and 1 in size, of either sign.
fn random(len: usize, generator: &mut ChaCha8Rng) -> Vec<f64> {
    (0..len)
        .map(|_| {
            let x = 2.0 * unit(generator) - 1.0;
            if x < 0.0 {
                0.5 * x - 0.5
            } else {
                0.5 * x + 0.5
            }
        })
        .collect()
}
