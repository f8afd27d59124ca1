//! Quiet starts: particles in phase space without the noise of random numbers.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use symplint_models::random::Uniform;

/// A place in (0, 1), two normal numbers of variance 1, and which of the copies at this place it is.
pub(super) struct Draw {
    pub(super) place: f64,
    pub(super) normals: [f64; 2],
    pub(super) copy: usize,
}

/// The points of J. M. Hammersley, Ann. N. Y. Acad. Sci. 86 (1960) 844, shifted by random numbers (R. Cranley & T. N. L.
/// Patterson, SIAM J. Numer. Anal. 13 (1976) 904): `copies` draws at each, every second of them with the other sign of
/// the second normal number.
pub(super) fn quiet_draws(
    particles: usize,
    copies: usize,
    seed: u64,
) -> impl Iterator<Item = Draw> {
    let mut uniform = Uniform::from_seed(seed);
    let shifts: [f64; 3] = std::array::from_fn(|_| uniform.next().unwrap_or(0.0));
    let places = particles.div_ceil(copies);
    (0..particles).map(move |a| {
        let (index, copy) = (a / copies, a % copies);
        let shifted = |value: f64, shift: f64| (value + shift).fract();
        let normal = |base: usize, shift: f64, is_mirrored: bool| {
            let value = normal_quantile(shifted(radical_inverse(index, base), shift));
            if is_mirrored { -value } else { value }
        };
        Draw {
            place: shifted((index as f64 + 0.5) / places as f64, shifts[0]),
            normals: [
                normal(2, shifts[1], false),
                normal(3, shifts[2], copy % 2 == 1),
            ],
            copy,
        }
    })
}

/// The z for which a normal number of variance 1 is below z with the probability `u`; finite for every u.
fn normal_quantile(u: f64) -> f64 {
    // Beyond this, no number in [0, 1) but 0 leaves a difference.
    const FARTHEST: f64 = 38.0;
    let below = |z: f64| 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
    let density = |z: f64| libm::exp(-0.5 * z * z) / libm::sqrt(TAU);
    let (mut low, mut high, mut z) = (-FARTHEST, FARTHEST, 0.0);
    // Newton's method, by bisection where that leaves the interval known to hold the root.
    for _ in 0..100 {
        let error = below(z) - u;
        if error == 0.0 {
            break;
        }
        if error > 0.0 {
            high = z;
        } else {
            low = z;
        }
        let newton = z - error / density(z);
        let next = if low < newton && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if next == z {
            break;
        }
        z = next;
    }
    z
}

/// The digits of `index` in base `base`, mirrored at the point.
fn radical_inverse(mut index: usize, base: usize) -> f64 {
    let (mut sum, mut place) = (0.0, 1.0);
    while index > 0 {
        place /= base as f64;
        sum += place * (index % base) as f64;
        index /= base;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_mirrored() {
        let inverses = [
            (1, 2, 0.5),
            (6, 2, 0.375),
            (5, 3, 7.0 / 9.0),
            (7, 5, 11.0 / 25.0),
        ];
        for (index, base, expected) in inverses {
            assert!((radical_inverse(index, base) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn the_quantile_inverts_the_distribution() {
        // Tabulated quantiles of the normal distribution.
        for (u, z) in [
            (0.5, 0.0),
            (0.841_344_746_068_542_9, 1.0),
            (0.975, 1.959_963_984_540_054),
            (0.001, -3.090_232_306_167_813),
            (1e-10, -6.361_340_902_404_056),
        ] {
            let got = normal_quantile(u);
            assert!((got - z).abs() < 1e-13, "{u}: {got} for {z}");
        }
        assert!(normal_quantile(0.0).is_finite() && normal_quantile(1.0_f64.next_down()) > 8.0);
    }

    /// With as many random places, at least 4,000, the moments would be off by 0.016, 0.02, 0.06 and 0.15.
    #[test]
    fn moments_are_those_of_the_distribution() {
        const N: usize = 48_000;
        for copies in [1, 2, 12] {
            let draws: Vec<Draw> = quiet_draws(N, copies, 3).collect();
            let mean = |f: &dyn Fn(&Draw) -> f64| draws.iter().map(f).sum::<f64>() / N as f64;
            for i in 0..2 {
                for (n, expected, bound) in [
                    (1, 0.0, 2e-3),
                    (2, 1.0, 4e-3),
                    (3, 0.0, 0.03),
                    (4, 3.0, 0.06),
                ] {
                    let off = (mean(&|draw| draw.normals[i].powi(n)) - expected).abs();
                    assert!(off < bound, "{copies} copies, moment {n}: off by {off}");
                }
            }
            if copies > 1 {
                assert!(mean(&|draw| draw.normals[1]).abs() < 1e-13);
            }
            assert!((mean(&|draw| draw.place) - 0.5).abs() < 1e-3);
        }
    }
}
