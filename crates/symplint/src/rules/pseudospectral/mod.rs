//! The Fourier-pseudospectral rule without an inverse transform.
//!
//! With transforms P, Q of one row each (N samples, unnormalised) the paper's
//! p : (D q) Δs is
//!
//! I = (4π/N²) Σ_{k=1}^{⌈N/2⌉−1} k (Im P_k Re Q_k − Re P_k Im Q_k),
//!
//! with the Nyquist mode of an even N left out. Both rows go through one complex transform, as
//! real and imaginary part. That rounds relative to the larger of them, so both are
//! brought to the same size first, by powers of two, which costs no digit: a loop that is
//! 1e8 times wider in q than in p stays as accurate as any other.

mod interpolant;
mod regularity;
mod row;
mod sums;
mod transform;

use std::cell::Cell;
use std::f64::consts::PI;
use std::ops::Range;

use symplint_fft::Complex64;

use super::{RowIntegral, banded, least};
use crate::signal::{UNIT_ROUNDOFF, largest, unwrap_row, wraps};
use crate::state::{Coordinates, Rows};
pub(crate) use interpolant::roughness;
use regularity::sobolev_exponent;
use row::{Scaling, pack};
use sums::{Sums, fold, value};
use transform::{Transform, transform};

thread_local! {
    /// Kept for the next integral: of few degrees of freedom, making it would take as long as using it.
    static IDLE: Cell<Option<Box<Workspace>>> = const { Cell::new(None) };
}

/// Buffers of one thread.
struct Workspace {
    transform: Transform,
    scratch: Vec<Complex64>,
    unwrapped: Vec<f64>,
    modes: Vec<Complex64>,
    band: banded::Visit,
}

impl Workspace {
    /// Lends `work` the workspace of this thread.
    fn lend<R>(transform: &Transform, work: impl FnOnce(&mut Self) -> R) -> R {
        let mut workspace = (IDLE.take())
            .filter(|idle| idle.modes.len() == transform.len())
            .unwrap_or_else(|| Box::new(Workspace::new(Transform::clone(transform))));
        let result = work(&mut workspace);
        IDLE.set(Some(workspace));
        result
    }

    fn new(transform: Transform) -> Self {
        Workspace {
            scratch: vec![Complex64::ZERO; transform.get_inplace_scratch_len()],
            unwrapped: Vec::new(),
            modes: vec![Complex64::ZERO; transform.len()],
            transform,
            band: banded::Visit::new(),
        }
    }

    /// By the transform, or if `banded` by the band where this is enough.
    fn integrate(&mut self, q: &[f64], p: &[f64], period: f64, banded: bool) -> RowIntegral {
        let mut gain = 0.0;
        let mut periodic = q;
        let is_wrapped = wraps(q, period);
        if is_wrapped {
            self.unwrapped.clear();
            self.unwrapped.extend_from_slice(q);
            gain = unwrap_row(&mut self.unwrapped, period) as f64 * period;
            take_off_ramp(&mut self.unwrapped, gain);
            periodic = &self.unwrapped;
        }
        if banded && let Some(found) = banded::integrate(&mut self.band, periodic, p, gain) {
            return found;
        }
        let mut scalings = pack(&mut self.modes, periodic, p);
        if is_wrapped {
            scalings[0].largest = largest(q);
        }
        (self.transform).process_with_scratch(&mut self.modes, &mut self.scratch);
        integral(&mut self.modes, &scalings, gain)
    }
}

/// Leaves of a row that gains `gain` in one turn what is periodic.
fn take_off_ramp(row: &mut [f64], gain: f64) {
    let n = row.len() as f64;
    for (k, value) in row.iter_mut().enumerate() {
        *value -= gain * (k as f64 / n);
    }
}

/// What rounding makes of a mode: of the samples as stored and of the transform, with a margin. Infinite for a coordinate at
/// rest, which has no unit: its modes are the rounding of the other coordinate.
///
/// Transforms of other lengths than powers of two are less exact, those with large prime factors most: up
/// to 13 units for 4,097 samples and 100 for 262,147.
fn noise_of_mode(samples: usize, scaling: &Scaling) -> f64 {
    if scaling.unit == 0.0 {
        return f64::INFINITY;
    }
    let n = samples as f64;
    let margin = match samples.is_power_of_two() {
        true => 4.0,
        false => 4.0 + n.sqrt() / 3.0,
    };
    margin * UNIT_ROUNDOFF * n.sqrt() * (scaling.largest / scaling.unit).max(1.0)
}

/// Sobolev exponents of functions that jump: ½ by theory. Noise has −½, kinks have 3/2.
const EXPONENTS_OF_JUMPS: Range<f64> = 0.25..1.0;

/// Jumps of this part of the size of a coordinate, taken together, are too small to be followed: they bound the digits alone.
const MAX_IGNORED_JUMPS: f64 = 1e-10;

/// Whether the Sobolev exponent that an octave and the one before tell is that of jumps of this `size`. Larger ones are followed where
/// samples show them, and states may have a noise under which kinks look like jumps. For those too small to be followed, besides which
/// there is the rounding of double precision alone, it need only be nearer to that of jumps than to that of noise, by how much that
/// scatters.
fn looks_like_jumps(exponent: f64, octave: usize, size: f64) -> bool {
    match size < MAX_IGNORED_JUMPS {
        true => ((-0.5 + 3.0 * scatter(octave, 3.0)).max(0.0)..1.25).contains(&exponent),
        false => EXPONENTS_OF_JUMPS.contains(&exponent),
    }
}

/// The uncertainty that jumps make, in units of the largest momentum times the root of the sum of their squares: that of
/// thirty-six equal ones that all add up.
const ERROR_OVER_JUMPS: f64 = 6.0;

/// Jumps of this part of the size of a coordinate are searched for between the samples, and are not part of an error.
const MAX_JUMPS_IN_ERROR: f64 = 1e-3;

/// By how much an exponent scatters that is a difference of the logarithms of the energies of octaves: those of the modes of each
/// add up to 3 times those of the highest `octave` if it is of two octaves, and the difference of two such exponents has 13. (An energy of
/// n independent modes scatters by 1/√n of itself, and an octave has half as many modes as the next.)
fn scatter(octave: usize, variance: f64) -> f64 {
    0.5 * std::f64::consts::LOG2_E * (variance / f64::from(1u32 << octave)).sqrt()
}

/// From one octave to the next the Sobolev exponent of jumps stays, or falls to theirs, but for how much it scatters; the exponent of a
/// smooth feature as narrow as the samples are apart grows. Derived: from ¼ to 1, those of [`EXPONENTS_OF_JUMPS`], by 0.36 or more if its modes fall
/// exponentially, and by 0.56 or more if they fall as for a Gaussian. So does the exponent of two jumps that are near each other,
/// which are followed if they are large enough.
const MIN_GROWTH_OF_FEATURE: f64 = 0.3;

/// √(Σ J²) of the jumps J of a function from the energy Σ |c_k|² of its octave `first` ≤ k < 2 `first`: far up, c_k is a sum
/// of J/(2πik), each with its own phase, and Σ 1/k² over an octave is about 1/(2 first).
fn jump_size(first: usize, energy: f64) -> f64 {
    PI * (8.0 * first as f64 * energy).sqrt()
}

/// The last octave that stands clear of rounding, from the energies of the octaves and what rounding makes of a mode: there a
/// smooth function is the smallest compared with jumps.
fn last_clear(energies: &[f64], noise: f64) -> Option<usize> {
    let is_clear = |&j: &usize| energies[j].sqrt() > noise * f64::from(1u32 << j).sqrt();
    (0..energies.len()).rev().find(is_clear)
}

/// Octaves of modes that a transform may have.
const MAX_OCTAVES: usize = usize::BITS as usize;

/// ∮ p dq from the transform of q + i p, which it uses up. What q gains in one turn, `gain`, was taken off it.
fn integral(z: &mut [Complex64], [of_q, of_p]: &[Scaling; 2], gain: f64) -> RowIntegral {
    let samples = z.len();
    let n = samples as f64;
    let modes = samples.div_ceil(2);
    // From the highest modes down: the highest quarter, the rest of the upper half, and the lower
    // half by octaves, 2^j ≤ k < 2^{j+1}, whose energies tell how smooth the loop is. The part that the
    // octaves leave of it comes before them.
    let top_start = 3 * modes / 4;
    let top = Sums::over(z, top_start..modes);
    let upper = top + Sums::over(z, modes / 2..top_start);
    let octaves = (modes / 2).ilog2() as usize;
    let mut all = upper + Sums::over(z, 1 << octaves..modes / 2);
    let [mut q_energies, mut p_energies] = [[0.0; MAX_OCTAVES]; 2];
    for j in (0..octaves).rev() {
        let octave = Sums::over(z, 1 << j..2 << j);
        (q_energies[j], p_energies[j]) = (octave.q_power, octave.p_power);
        all = all + octave;
    }

    let factor = 4.0 * PI / (n * n);
    let unit = of_q.unit * of_p.unit;
    let mean = z[0].im / n;
    let p_mean = of_p.first + of_p.unit * mean;
    let scale = factor * all.scale;

    // Rounding of the stored samples: white noise of half an ulp of the largest.
    let noise = PI * UNIT_ROUNDOFF * (8.0 / n).sqrt() / n;
    let stored = of_q.largest * of_p.unit * (noise * all.p_slope_squared.sqrt())
        + of_p.largest * of_q.unit * (noise * all.q_slope_squared.sqrt());
    let transformed = UNIT_ROUNDOFF * n.log2() * scale;
    let winding = 2.0 * UNIT_ROUNDOFF * gain.abs() * of_p.largest;
    let noise_of_positions = noise_of_mode(samples, of_q);
    let of_positions = sobolev_exponent(&q_energies[..octaves], noise_of_positions);
    let of_momenta = sobolev_exponent(&p_energies[..octaves], noise_of_mode(samples, of_p));
    // The difference of the integral of the loop with its jumps closed from that between them.
    let jumps = match last_clear(&q_energies[..octaves], noise_of_positions) {
        Some(last) if last > 0 => {
            let exponent = |j: usize| 0.5 * (q_energies[j - 1] / q_energies[j]).log2();
            let size = jump_size(1 << last, q_energies[last] / (n * n));
            let grows = |growth: f64| growth > MIN_GROWTH_OF_FEATURE.max(3.0 * scatter(last, 13.0));
            let is_feature =
                size > MAX_IGNORED_JUMPS && last > 1 && grows(exponent(last) - exponent(last - 1));
            let is_jump = looks_like_jumps(exponent(last), last, size) && !is_feature;
            match size < MAX_JUMPS_IN_ERROR && is_jump {
                true => ERROR_OVER_JUMPS * of_p.largest * of_q.unit * size,
                false => 0.0,
            }
        }
        _ => 0.0,
    };
    let regularity = least(of_positions, of_momenta);

    let quadrature_error = (samples / 2 >= 3).then(|| {
        // Root mean squares of the highest quarter of the modes: a jump or kink that the samples do
        // not resolve, or the noise of the states. Modes beyond N/2 fold back with about this size.
        let top_modes = (modes - top_start) as f64;
        let q_top = (top.q_power / top_modes).sqrt();
        let p_top = (top.p_power / top_modes).sqrt();
        let folded = factor * (p_top * all.q_slope + q_top * all.p_slope);
        // What still arrives at the end of the band.
        let tail = factor * upper.scale;
        // The same integral from every second sample; from the lower half of the modes where N
        // is odd.
        let half = if samples.is_multiple_of(2) {
            fold(z)
        } else {
            z
        };
        let coarse = value(half, 1..(samples / 2).div_ceil(2));
        let change = factor * (all.value - coarse).abs();
        // The highest modes fold back into the mean as into every other mode.
        let mean_change = (mean - half[0].im / n).abs().max(p_top / n);
        unit * change.max(tail).max(folded) + gain.abs() * of_p.unit * mean_change + jumps
    });
    RowIntegral {
        value: unit * (factor * all.value) + gain * p_mean,
        quadrature_error,
        roundoff: stored + unit * transformed + winding,
        scale: unit * scale + (gain * p_mean).abs(),
        omitted: Vec::new(),
        regularity,
    }
}

/// The integral of each row. If `banded`, rows that are smooth to rounding are spared the transform.
pub(super) fn of_rows<'a>(
    q: Rows<'a>,
    p: Rows<'a>,
    coordinates: &'a Coordinates,
    banded: bool,
) -> impl Fn(usize) -> RowIntegral + Sync + 'a {
    let transform = transform(q.len());
    move |i| {
        Workspace::lend(&transform, |workspace| {
            workspace.integrate(q.row(i), p.row(i), coordinates.period(i), banded)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Ensemble;

    #[test]
    fn narrow_features_that_samples_resolve_are_not_taken_for_jumps() {
        const SAMPLES: usize = 4096;
        const SIZE: f64 = 1e-4;
        let at = |k: usize| k as f64 / SAMPLES as f64;
        for step in 0..40 {
            // Cells.
            let width = 1.5 * 1.05f64.powi(step);
            let gaussian = |x: f64| (-(x / width).powi(2)).exp();
            let sech = |x: f64| (x / width).cosh().powi(-2);
            let shapes: [&dyn Fn(f64) -> f64; 2] = [&gaussian, &sech];
            for of in shapes {
                let mut states = Ensemble::zeros(1, SAMPLES);
                for k in 0..SAMPLES {
                    let (sin, cos) = (2.0 * PI * at(k)).sin_cos();
                    let feature = SIZE * (of(k as f64 - 512.0) + of(k as f64 - 1536.3));
                    states.block().q.row_mut(0)[k] = sin + feature;
                    states.block().p.row_mut(0)[k] = cos;
                }
                let found = of_rows(states.q(), states.p(), &Coordinates::plain(1), false)(0);
                let error = found.quadrature_error.unwrap();
                assert!(error < SIZE, "{width}: {error:e}");
            }
        }
    }

    #[test]
    fn some_jumps_are_not_taken_for_features() {
        const SIZE: f64 = 1e-5;
        for samples in [256, 1024, 4096] {
            for seed in 0..60 {
                let random = |k: usize| (0.137 + 0.618_034 * (7 * seed + 31 * k) as f64).fract();
                let mut states = Ensemble::zeros(1, samples);
                for k in 0..samples {
                    let s = k as f64 / samples as f64;
                    let (sin, cos) = (2.0 * PI * s).sin_cos();
                    // Four jumps, of which two go down.
                    let jumps = (0..4).map(|j| {
                        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
                        sign * SIZE * f64::from(u8::from(s > random(j)))
                    });
                    states.block().q.row_mut(0)[k] = sin + jumps.sum::<f64>();
                    states.block().p.row_mut(0)[k] = cos;
                }
                let found = of_rows(states.q(), states.p(), &Coordinates::plain(1), false)(0);
                let error = found.quadrature_error.unwrap();
                assert!(error > SIZE, "{samples}, {seed}: {error:e}");
            }
        }
    }

    #[test]
    fn small_jumps_are_told_from_noise_by_how_much_octaves_scatter() {
        // Three standard deviations above −½: 1.44·√(3/2^octave)·½, at octaves 4, 5, 6: 0.312, 0.221, 0.156.
        for (octave, least) in [(4, 0.437), (5, 0.163), (6, 0.0), (12, 0.0)] {
            assert!(!looks_like_jumps(least - 0.005, octave, 1e-12), "{octave}");
            assert!(looks_like_jumps(least + 0.005, octave, 1e-12), "{octave}");
            assert!(looks_like_jumps(1.24, octave, 1e-12));
            assert!(!looks_like_jumps(1.26, octave, 1e-12));
        }
        // Larger ones have to look like nothing else.
        for octave in [4, 12] {
            let is_jump = [0.2, 0.3, 0.95, 1.05].map(|s| looks_like_jumps(s, octave, 1e-6));
            assert_eq!(is_jump, [false, true, true, false]);
        }
    }

    #[test]
    fn a_coordinate_at_rest_has_no_regularity() {
        let n = 512;
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
        let q: Vec<f64> = (0..n)
            .map(|k| angle(k).cos() + 0.2 * angle(k).sin().powi(2))
            .collect();
        let of = |q: &[f64], p: &[f64]| {
            Workspace::lend(&transform(n), |workspace| {
                workspace.integrate(q, p, 0.0, false)
            })
        };
        for rest in [0.0, 1e-300, 3.0] {
            let rest = vec![rest; n];
            for found in [of(&q, &rest), of(&rest, &q)] {
                assert!(found.regularity.is_none_or(|s| s > 6.0), "{found:?}");
                assert!(found.value.abs() <= found.roundoff + found.quadrature_error.unwrap());
            }
        }
    }

    #[test]
    fn units_of_coordinates_scale_every_estimate() {
        // Jumps too small for the error of the highest modes to show.
        let n = 512;
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
        let jump = |k: usize| 1e-6 * f64::from((100..300).contains(&k));
        let q: Vec<f64> = (0..n).map(|k| angle(k).cos() + jump(k)).collect();
        let p: Vec<f64> = (0..n)
            .map(|k| angle(k).sin() + 0.3 * (3.0 * angle(k)).cos())
            .collect();
        let of = |q_unit: f64, p_unit: f64| {
            let scaled = |row: &[f64], unit: f64| row.iter().map(|x| unit * x).collect::<Vec<_>>();
            let transform = transform(n);
            Workspace::lend(&transform, |workspace| {
                workspace.integrate(&scaled(&q, q_unit), &scaled(&p, p_unit), 0.0, false)
            })
        };
        let plain = of(1.0, 1.0);
        let error = plain.quadrature_error.unwrap();
        assert!(error > 1e-6, "{error:e}");
        for (q_unit, p_unit) in [
            (1024.0, 1.0),
            (1.0, 1024.0),
            (2f64.powi(-30), 2f64.powi(20)),
        ] {
            let (unit, scaled) = (q_unit * p_unit, of(q_unit, p_unit));
            assert_eq!(scaled.value, unit * plain.value);
            assert_eq!(scaled.scale, unit * plain.scale);
            assert_eq!(scaled.quadrature_error, Some(unit * error));
            assert_eq!(scaled.roundoff, unit * plain.roundoff);
            assert_eq!(scaled.regularity, plain.regularity);
        }
    }
}
