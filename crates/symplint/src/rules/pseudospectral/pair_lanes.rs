//! What is summed over the modes of two rows, as many modes at a time as a vector register has lanes.
//!
//! The rows are taken apart before anything is multiplied: a sum of |Z_k|² would cancel. No multiplication is
//! fused with an addition: rows that are equal enclose no area, to the last bit.

use pulp::Simd;

use super::spectrum::Parts;

/// Sums over all bands, both spectra unnormalised.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Σ k (Im P_k Re Q_k − Re P_k Im Q_k).
    pub value: f64,
    /// Σ k |Q_k|, at most 9 per cent too large.
    pub q_slope: f64,
    /// Σ k |P_k|, at most 9 per cent too large.
    pub p_slope: f64,
    /// Σ k² |Q_k|².
    pub q_slope_squared: f64,
    /// Σ k² |P_k|².
    pub p_slope_squared: f64,
}

/// Sums over one band of modes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Band {
    /// Σ k |P_k| |Q_k|, at most 18 per cent too large.
    pub scale: f64,
    /// Σ |Q_k|².
    pub q_power: f64,
    /// Σ |P_k|².
    pub p_power: f64,
}

/// Twice Q_k and P_k: what they are less is taken from the sums.
pub(super) struct Pair<S: Simd> {
    q: Parts<S>,
    p: Parts<S>,
}

impl<S: Simd> Pair<S> {
    /// From modes of q + i p and, highest k first, the modes N − k.
    #[inline(always)]
    pub fn apart(simd: S, modes: Parts<S>, mirrored: Parts<S>) -> Self {
        let mirrored = mirrored.reversed();
        Pair {
            q: Parts {
                re: simd.add_f64s(modes.re, mirrored.re),
                im: simd.sub_f64s(modes.im, mirrored.im),
            },
            p: Parts {
                re: simd.add_f64s(modes.im, mirrored.im),
                im: simd.sub_f64s(mirrored.re, modes.re),
            },
        }
    }

    /// Im P_k Re Q_k − Re P_k Im Q_k, four times.
    #[inline(always)]
    fn area(&self, simd: S) -> S::f64s {
        let (q, p) = (&self.q, &self.p);
        simd.sub_f64s(simd.mul_f64s(p.im, q.re), simd.mul_f64s(p.re, q.im))
    }
}

/// Sums, each in lanes.
pub(super) trait Accumulate<S: Simd> {
    /// Adds modes of wave numbers k.
    fn add(&mut self, simd: S, k: S::f64s, pair: Pair<S>);
}

/// [`Sums::value`] alone.
pub(super) struct ValueInLanes<S: Simd>(S::f64s);

impl<S: Simd> ValueInLanes<S> {
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        ValueInLanes(simd.splat_f64s(0.0))
    }

    #[inline(always)]
    pub fn total(&self, simd: S) -> f64 {
        0.25 * simd.reduce_sum_f64s(self.0)
    }
}

impl<S: Simd> Accumulate<S> for ValueInLanes<S> {
    #[inline(always)]
    fn add(&mut self, simd: S, k: S::f64s, pair: Pair<S>) {
        add_product(simd, &mut self.0, k, pair.area(simd));
    }
}

/// [`Sums`], and those of the band at hand.
pub(super) struct SumsInLanes<S: Simd> {
    value: S::f64s,
    q_slope: S::f64s,
    p_slope: S::f64s,
    q_slope_squared: S::f64s,
    p_slope_squared: S::f64s,
    pub band: BandInLanes<S>,
}

/// [`Band`].
pub(super) struct BandInLanes<S: Simd> {
    scale: S::f64s,
    q_power: S::f64s,
    p_power: S::f64s,
}

impl<S: Simd> SumsInLanes<S> {
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        SumsInLanes {
            value: zero,
            q_slope: zero,
            p_slope: zero,
            q_slope_squared: zero,
            p_slope_squared: zero,
            band: BandInLanes::new(simd),
        }
    }

    /// Sums over all bands.
    #[inline(always)]
    pub fn total(&self, simd: S) -> Sums {
        Sums {
            value: 0.25 * simd.reduce_sum_f64s(self.value),
            q_slope: 0.5 * OUTWARDS * simd.reduce_sum_f64s(self.q_slope),
            p_slope: 0.5 * OUTWARDS * simd.reduce_sum_f64s(self.p_slope),
            q_slope_squared: 0.25 * simd.reduce_sum_f64s(self.q_slope_squared),
            p_slope_squared: 0.25 * simd.reduce_sum_f64s(self.p_slope_squared),
        }
    }
}

impl<S: Simd> BandInLanes<S> {
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        BandInLanes {
            scale: zero,
            q_power: zero,
            p_power: zero,
        }
    }

    #[inline(always)]
    pub fn total(&self, simd: S) -> Band {
        Band {
            scale: 0.25 * OUTWARDS * OUTWARDS * simd.reduce_sum_f64s(self.scale),
            q_power: 0.25 * simd.reduce_sum_f64s(self.q_power),
            p_power: 0.25 * simd.reduce_sum_f64s(self.p_power),
        }
    }
}

impl<S: Simd> Accumulate<S> for SumsInLanes<S> {
    #[inline(always)]
    fn add(&mut self, simd: S, k: S::f64s, pair: Pair<S>) {
        let (q_size, p_size) = (pair.q.octagon(simd), pair.p.octagon(simd));
        let (q_squared, p_squared) = (pair.q.squared(simd), pair.p.squared(simd));
        let k_squared = simd.mul_f64s(k, k);
        add_product(simd, &mut self.value, k, pair.area(simd));
        add_product(simd, &mut self.q_slope, k, q_size);
        add_product(simd, &mut self.p_slope, k, p_size);
        add_product(simd, &mut self.q_slope_squared, k_squared, q_squared);
        add_product(simd, &mut self.p_slope_squared, k_squared, p_squared);
        add_product(simd, &mut self.band.scale, k, simd.mul_f64s(p_size, q_size));
        self.band.q_power = simd.add_f64s(self.band.q_power, q_squared);
        self.band.p_power = simd.add_f64s(self.band.p_power, p_squared);
    }
}

#[inline(always)]
fn add_product<S: Simd>(simd: S, sum: &mut S::f64s, a: S::f64s, b: S::f64s) {
    *sum = simd.add_f64s(*sum, simd.mul_f64s(a, b));
}

/// 1/cos(π/8): from an octagon in a circle to the one round it.
const OUTWARDS: f64 = 1.082_392_200_292_394;

impl<S: Simd> Parts<S> {
    /// |z|².
    #[inline(always)]
    fn squared(&self, simd: S) -> S::f64s {
        simd.add_f64s(
            simd.mul_f64s(self.re, self.re),
            simd.mul_f64s(self.im, self.im),
        )
    }

    /// |z| within a factor of [`OUTWARDS`], from below: the gauge of the regular octagon round the unit circle.
    ///
    /// Without a root, which would take longer than all else that is done to a mode.
    #[inline(always)]
    fn octagon(&self, simd: S) -> S::f64s {
        let (x, y) = (simd.abs_f64s(self.re), simd.abs_f64s(self.im));
        let half_root = simd.splat_f64s(std::f64::consts::FRAC_1_SQRT_2);
        let diagonal = simd.mul_f64s(half_root, simd.add_f64s(x, y));
        simd.max_f64s(diagonal, simd.max_f64s(x, y))
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;
    use rustfft::num_complex::Complex64;

    use super::*;

    #[test]
    fn the_bound_on_a_modulus_is_tight_to_nine_per_cent() {
        for degree in 0..360 {
            let z = Complex64::cis(f64::from(degree).to_radians());
            let parts = Parts::<Scalar> { re: z.re, im: z.im };
            let bound = OUTWARDS * parts.octagon(Scalar);
            assert!((1.0 - 1e-15..1.0824).contains(&bound), "{degree}: {bound}");
        }
    }
}
