//! The centred difference of order 2m, and the m-th difference that shows what it misses.

use std::f64::consts::PI;

/// What lies beyond the Nyquist mode is as large as what a high difference shows near it, and folds back upon slopes: this many times their
/// product counts. 2 is 1.4 standard deviations of white noise, and six times the error that a kink makes.
pub(super) const ALIASING_FACTOR: f64 = 2.0;

/// Coefficients of the stencils of half width m: m neighbours on either side.
#[derive(Clone, Debug)]
pub(super) struct Stencil {
    /// c_1 … c_m: q' Δs ≈ Σ c_j (q_{k+j} − q_{k−j}) of order 2m,
    /// c_j = (−1)^{j+1} (m!)² / (j (m−j)! (m+j)!) (Fornberg, Math. Comp. 51, 1988).
    pub centred: Vec<f64>,
    /// (−1)^l binom(m, l) / √binom(2m, m), l = 0 … m: the m-th difference, scaled so that white noise
    /// keeps its variance.
    pub difference: Vec<f64>,
    /// The factor of a product of two m-th differences, scaled as above, in the error; see
    /// [`miss`](Self::miss).
    pub in_band: f64,
}

impl Stencil {
    /// The stencils of half width `m`, 1 or more.
    pub fn new(m: usize) -> Self {
        let of = |m: usize| m as f64;
        let mut centred = vec![of(m) / of(m + 1)];
        for j in 1..m {
            centred.push(-centred[j - 1] * of(j * (m - j)) / of((j + 1) * (m + j + 1)));
        }
        let mut binomials = vec![1.0];
        for l in 0..m {
            binomials.push(-binomials[l] * of(m - l) / of(l + 1));
        }
        // Vandermonde: the sum of the squares is binom(2m, m).
        let variance: f64 = binomials.iter().map(|w| w * w).sum();
        Stencil {
            centred,
            difference: binomials.iter().map(|w| w / variance.sqrt()).collect(),
            in_band: PI * variance * 0.25f64.powi(m as i32),
        }
    }

    /// A bound on the error of Σ p_k q'(s_k) Δs, if nothing lies beyond the Nyquist mode, from
    /// the norms of the m-th differences of q and p.
    ///
    /// A mode whose phase advances by θ from sample to sample is differentiated to
    /// s(θ) = sin θ Σ_{l<m} 4^l (l!)²/(2l+1)! sin^{2l} θ/2, the first terms of the series of θ, all of one
    /// sign. So 0 ≤ θ − s(θ) ≤ π sin^{2m} θ/2 up to θ = π, which is π/4^m times the square of what the m-th
    /// difference makes of the mode; the rest is the inequality of Cauchy and Schwarz.
    pub fn miss(&self, q: f64, p: f64) -> f64 {
        self.in_band * q * p
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The centred difference of a mode whose phase advances by θ from sample to sample.
    fn symbol(m: usize, theta: f64) -> f64 {
        let terms = Stencil::new(m).centred.into_iter().zip(1..);
        2.0 * terms
            .map(|(c, j)| c * (f64::from(j) * theta).sin())
            .sum::<f64>()
    }

    #[test]
    fn coefficients_are_those_of_the_textbooks() {
        let tables: [&[f64]; 4] = [
            &[1.0 / 2.0],
            &[2.0 / 3.0, -1.0 / 12.0],
            &[3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0],
            &[4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0],
        ];
        for (m, table) in (1..).zip(tables) {
            let centred = Stencil::new(m).centred;
            assert_eq!(centred.len(), m);
            for (c, expected) in centred.iter().zip(table) {
                assert!((c - expected).abs() < 1e-16, "m = {m}: {centred:?}");
            }
        }
    }

    #[test]
    fn powers_up_to_the_order_are_differentiated_exactly() {
        for m in 1..=16 {
            let centred = Stencil::new(m).centred;
            for power in (1..=2 * m - 1).step_by(2) {
                // Σ c_j (j^r − (−j)^r) = 1 for r = 1, 0 for the other odd r < 2m. Even powers cancel.
                let terms = centred.iter().zip(1..);
                let terms = terms.map(|(c, j)| 2.0 * c * f64::from(j).powi(power as i32));
                let (sum, size) = terms.fold((0.0, 0.0), |(s, a), t| (s + t, a + t.abs()));
                let expected = f64::from(power == 1);
                assert!(
                    (sum - expected).abs() < 1e-14 * size,
                    "m = {m}: power {power} gives {sum:e}"
                );
            }
        }
    }

    #[test]
    fn the_symbol_is_the_truncated_series_and_is_missed_by_no_more_than_said() {
        for m in [1, 2, 4, 8, 12, 16] {
            for step in 1..=200 {
                let theta = PI * f64::from(step) / 200.0;
                let x = (theta / 2.0).sin().powi(2);
                let (mut term, mut series) = (theta.sin(), 0.0);
                for l in 0..m {
                    series += term;
                    term *=
                        4.0 * x * ((l + 1) * (l + 1)) as f64 / ((2 * l + 2) * (2 * l + 3)) as f64;
                }
                let symbol = symbol(m, theta);
                assert!((symbol - series).abs() < 1e-14, "m = {m}, θ = {theta}");
                let missed = theta - symbol;
                let bound = PI * x.powi(m as i32);
                assert!(
                    missed > -1e-14 && missed < bound + 1e-14,
                    "m = {m}, θ = {theta}: {missed:e} where {bound:e} is allowed"
                );
            }
        }
    }

    #[test]
    fn differences_keep_the_variance_of_noise_and_remove_powers() {
        for m in 1..=16 {
            let difference = Stencil::new(m).difference;
            assert_eq!(difference.len(), m + 1);
            let squares: f64 = difference.iter().map(|w| w * w).sum();
            assert!((squares - 1.0).abs() < 1e-14);
            for power in 0..m {
                let terms = difference.iter().enumerate();
                let terms = terms.map(|(l, w)| w * (l as f64).powi(power as i32));
                let (sum, size) = terms.fold((0.0, 0.0), |(s, a), t| (s + t, a + t.abs()));
                assert!(sum.abs() < 1e-13 * size, "m = {m}, power {power}");
            }
        }
    }
}
