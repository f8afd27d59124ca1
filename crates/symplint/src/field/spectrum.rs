//! The integral of a periodic function from equispaced samples, with its error.

use std::f64::consts::TAU;

use symplint_fft::num_complex::Complex;

use super::limits::MAX_DECAY_OF_JUMPS;
use crate::signal::CompensatedSum;
use crate::signal::noise::SAFETY;

/// What equispaced samples of a function of s in [0, 1) show.
pub(super) struct Spectrum {
    /// The mean: the integral by the trapezoidal rule, exact but for the modes that are multiples of the number of samples.
    pub mean: f64,
    /// c_m of the distance from the mean, for m = 0, 1, … up to half the number of samples.
    modes: Vec<Complex<f64>>,
    /// |c_m|.
    sizes: Vec<f64>,
}

impl Spectrum {
    /// Of `samples` at k/N.
    pub fn of(samples: &[f64]) -> Self {
        let count = samples.len();
        let mut sum = CompensatedSum::default();
        samples.iter().for_each(|x| sum.add(*x));
        let mean = sum.total() / count as f64;
        let mut modes: Vec<Complex<f64>> = samples.iter().map(|x| (x - mean).into()).collect();
        symplint_fft::forward(count).process(&mut modes);
        modes.truncate(count / 2 + 1);
        modes.iter_mut().for_each(|c| *c /= count as f64);
        Spectrum {
            mean,
            sizes: modes.iter().map(|c| c.norm()).collect(),
            modes,
        }
    }

    /// The largest coefficient of the highest quarter of the modes that samples tell apart. White noise of the samples moves the mean
    /// by as much, a jump by half of it or less; of a smooth function, the modes that move it are much smaller.
    fn tail(&self) -> f64 {
        let highest = self.sizes.len() - 1;
        let first = (3 * highest).div_ceil(4);
        self.sizes[first..].iter().fold(0.0, |m: f64, x| m.max(*x))
    }

    /// The error of the mean.
    pub fn error(&self) -> f64 {
        SAFETY * self.tail()
    }

    /// The function without the higher half of its modes, at s.
    pub fn smoothed(&self, s: f64) -> f64 {
        let lower = &self.modes[..self.modes.len() / 2];
        let terms = lower.iter().enumerate().skip(1).map(|(m, c)| {
            let (sin, cos) = (TAU * (m as f64 * s).fract()).sin_cos();
            2.0 * (c.re * cos - c.im * sin)
        });
        self.mean + terms.sum::<f64>()
    }

    /// The same at all samples.
    pub fn smoothed_samples(&self, count: usize) -> Vec<f64> {
        let lower = &self.modes[..self.modes.len() / 2];
        let mut modes = vec![Complex::ZERO; count];
        for (mode, c) in modes.iter_mut().zip(lower).skip(1) {
            // The transform has the other sign, so that it takes the conjugates.
            *mode = 2.0 * c.conj();
        }
        symplint_fft::forward(count).process(&mut modes);
        modes.iter().map(|x| self.mean + x.re).collect()
    }

    /// The power k with which the coefficients fall as m^-k over the last two octaves; `None` if there are too few.
    pub fn decay(&self) -> Option<f64> {
        let highest = self.sizes.len() - 1;
        let largest = |from: usize, to: usize| {
            let octave = self.sizes[from..to].iter();
            octave.fold(0.0, |m: f64, x| m.max(*x))
        };
        if highest < 16 {
            return None;
        }
        let (last, earlier) = (
            largest(highest / 2, highest),
            largest(highest / 8, highest / 4),
        );
        (last > 0.0).then(|| (earlier / last).log2() / 2.0)
    }

    /// The size of the jumps of a function whose coefficients fall like the coefficients of jumps, and not like white noise.
    pub fn jumps(&self) -> Option<f64> {
        let is_of_jumps = |decay: &f64| (0.5..MAX_DECAY_OF_JUMPS).contains(decay);
        self.decay().filter(is_of_jumps).map(|_| {
            let highest = self.sizes.len() - 1;
            // Samples of a jump of 1 have |c_m| = 1/(2N sin(πm/N)).
            let count = 2.0 * highest as f64;
            let of_mode =
                |m: usize| 2.0 * count * (0.5 * TAU * m as f64 / count).sin() * self.sizes[m];
            (highest / 2..highest).map(of_mode).fold(0.0, f64::max)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(count: usize, f: impl Fn(f64) -> f64) -> Spectrum {
        let samples: Vec<f64> = (0..count).map(|k| f(k as f64 / count as f64)).collect();
        Spectrum::of(&samples)
    }

    #[test]
    fn a_smooth_function_is_integrated_to_rounding() {
        // ∫ exp(cos 2πs) ds = I_0(1).
        let found = spectrum(64, |s| (TAU * s).cos().exp());
        assert!((found.mean - 1.266_065_877_752_008_4).abs() < 4e-16);
        assert!(found.error() < 1e-15, "{:e}", found.error());
        assert_eq!(found.jumps(), None);
    }

    #[test]
    fn the_error_covers_jumps_and_kinks_at_any_place() {
        for k in 0..100 {
            let at = 0.3 + 0.004_137 * f64::from(k);
            let jump = spectrum(256, |s| f64::from(u8::from(s < at)));
            assert!((jump.mean - at).abs() <= jump.error(), "{at}");
            assert!(jump.error() < 8.0 / 256.0);
            // Two jumps of 1.
            let size = jump.jumps().unwrap();
            assert!((0.9..2.01).contains(&size), "{size}");
            let kink = spectrum(256, |s| (s - at).abs());
            let exact = (at * at + (1.0 - at).powi(2)) / 2.0;
            assert!((kink.mean - exact).abs() <= kink.error(), "{at}");
        }
        let kink = spectrum(256, |s| (TAU * s).cos().abs());
        assert_eq!(kink.jumps(), None);
        assert!((kink.decay().unwrap() - 2.0).abs() < 0.2);
    }

    #[test]
    fn few_modes_are_not_changed_by_smoothing() {
        let f = |s: f64| 0.3 + (TAU * s).cos() - 2.0 * (TAU * 7.0 * s).sin();
        let found = spectrum(32, f);
        for s in [0.0, 0.123, 0.77] {
            assert!((found.smoothed(s) - f(s)).abs() < 1e-14);
        }
        for (k, smoothed) in found.smoothed_samples(32).iter().enumerate() {
            assert!((smoothed - f(k as f64 / 32.0)).abs() < 1e-14);
        }
    }

    #[test]
    fn white_noise_has_no_jumps() {
        let hash = |s: f64| ((s * 12345.678).sin() * 43758.5453).rem_euclid(1.0) - 0.5;
        let found = spectrum(512, hash);
        assert_eq!(found.jumps(), None);
        assert!(found.mean.abs() < found.error());
    }
}
