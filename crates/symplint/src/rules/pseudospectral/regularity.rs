//! How smooth a loop is, from the decay of its Fourier coefficients.
//!
//! A periodic function is in the Sobolev space H^s where Σ |k|^{2s} |c_k|² is finite. The root of
//! the energy of an octave of modes, 2^j ≤ k < 2^{j+1}, then falls as 2^{−js}: a jump has s = ½, a
//! kink 3/2, a jump of the second derivative 5/2, and an analytic loop more than any number.

/// Octaves that a slope is fitted to: the highest that stand clear of round-off.
const FITTED_OCTAVES: usize = 4;

/// The Sobolev exponent s of one coordinate, from the energies Σ |c_k|² of its octaves, k from 1;
/// `None` where there are fewer than three, or the coordinate is at rest.
///
/// `noise` is the size of a mode that is round-off. If the modes fall to round-off before they end, s counts the fall down to
/// there: it is a lower bound then. The same holds if they fall to noise, whose energy rises with every octave. Where noise fills
/// all octaves that are fitted, s is −½.
pub(super) fn sobolev_exponent(energies: &[f64], noise: f64) -> Option<f64> {
    let octaves = energies.len();
    if octaves < 3 || !noise.is_finite() {
        return None;
    }
    // Logarithms to base 2 of the root energies.
    let mut levels = [0.0; usize::BITS as usize];
    let mut clear = 0;
    for (j, energy) in energies.iter().enumerate() {
        let floor = noise * ((1u64 << j) as f64).sqrt();
        let root = energy.sqrt();
        levels[j] = root.max(floor).log2();
        clear = j + 1;
        if root <= floor {
            break;
        }
    }
    // The noise of the map may end the fall above round-off.
    let rising = |j: usize| levels[j] > levels[j - 1];
    let plateau = (1..clear).rev().take_while(|&j| rising(j)).count();
    let end = match plateau < FITTED_OCTAVES - 1 {
        true => clear - plateau,
        false => clear,
    };
    if end < 2 {
        return None;
    }
    // A fall to round-off or noise is fitted whole: its last octave alone is as steep as chance has it.
    let fitted = if end < octaves {
        &levels[..end]
    } else {
        &levels[end - FITTED_OCTAVES.min(end)..end]
    };
    Some(-slope(fitted))
}

/// Slope of the straight line that fits equidistant values best.
fn slope(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let middle = (n - 1.0) / 2.0;
    let (mut product, mut square) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let x = k as f64 - middle;
        product += x * value;
        square += x * x;
    }
    product / square
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::UNIT_ROUNDOFF;
    use std::f64::consts::TAU;
    use symplint_fft::Complex64;

    /// Of a function on [0, 1) with `samples` samples.
    fn exponent(samples: usize, f: impl Fn(f64) -> f64) -> f64 {
        let at = |k: usize| Complex64::new(f(k as f64 / samples as f64), 0.0);
        let mut modes: Vec<Complex64> = (0..samples).map(at).collect();
        symplint_fft::forward(samples).process(&mut modes);
        let octaves = (samples / 4).ilog2();
        let energy = |j: u32| modes[1 << j..2 << j].iter().map(|c| c.norm_sqr()).sum();
        let energies: Vec<f64> = (0..octaves).map(energy).collect();
        let noise = 4.0 * UNIT_ROUNDOFF * (samples as f64).sqrt();
        sobolev_exponent(&energies, noise).unwrap()
    }

    #[test]
    fn jumps_kinks_and_bends_have_half_integers() {
        let distance = |s: f64| (s - 0.3).abs().min(1.0 - (s - 0.3).abs());
        for samples in [256, 1000, 4096] {
            let jump = exponent(samples, |s| {
                (TAU * s).sin() + f64::from(s > 0.3) * (1.0 - s) - s
            });
            assert!((jump - 0.5).abs() < 0.2, "{samples}: {jump}");
            let kink = exponent(samples, |s| (TAU * s).sin() + distance(s));
            assert!((kink - 1.5).abs() < 0.2, "{samples}: {kink}");
            let bend = exponent(samples, |s| {
                let x = (TAU * (s - 0.3)).sin();
                x * x.abs()
            });
            assert!((bend - 2.5).abs() < 0.3, "{samples}: {bend}");
        }
    }

    #[test]
    fn analytic_loops_have_many_derivatives() {
        assert!(exponent(256, |s| (TAU * s).sin()) > 8.0);
        assert!(exponent(256, |s| 1.0 / (2.0 + (TAU * s).cos())) > 6.0);
    }

    #[test]
    fn noise_does_not_make_an_analytic_loop_rough_nor_a_kink_smooth() {
        let noise = |s: f64| ((s * 12.9898).sin() * 43758.5453).fract() - 0.5;
        let distance = |s: f64| (s - 0.3).abs().min(1.0 - (s - 0.3).abs());
        for samples in [64, 128, 256, 512, 1024, 2048, 4096] {
            for size in [1e-14, 1e-12, 1e-9] {
                let analytic = exponent(samples, |s| {
                    (TAU * s).cos() + 0.3 * (0.4 * (TAU * s).sin()).sin() + size * noise(s)
                });
                // Of noise alone the exponent is −½.
                let smooth = !(0.25..=4.5).contains(&analytic);
                assert!(smooth, "{samples}, {size:e}: {analytic}");
                let kink = exponent(samples, |s| (TAU * s).sin() + distance(s) + size * noise(s));
                let kinked = samples < 256 || (kink - 1.5).abs() < 0.3;
                assert!(kinked, "{samples}, {size:e}: {kink}");
            }
        }
    }

    #[test]
    fn few_modes_or_none_tell_nothing() {
        assert_eq!(sobolev_exponent(&[0.0; 6], 0.0), None);
        assert_eq!(sobolev_exponent(&[0.0; 6], 1e-16), None);
        assert_eq!(sobolev_exponent(&[1.0, 0.1], 1e-16), None);
        // A row at rest has no unit to measure noise in.
        assert_eq!(sobolev_exponent(&[0.0; 6], f64::INFINITY), None);
    }

    #[test]
    fn the_slope_is_that_of_the_line_of_best_fit() {
        let line = [7.0, 6.5, 6.0, 5.5, 5.0];
        assert!((slope(&line) + 0.5).abs() < 1e-15);
        // A bump in the middle tilts nothing; normal equations of the last: 2·(1·4 − 1·1)/10 less what symmetry takes.
        assert!((slope(&[7.0, 6.5, 9.0, 5.5, 5.0]) + 0.5).abs() < 1e-15);
        assert!((slope(&[0.0, 0.0, 0.0, 0.0, 5.0]) - 1.0).abs() < 1e-15);
    }
}
