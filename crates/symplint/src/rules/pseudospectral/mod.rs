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

mod ahead;
mod pair_lanes;
mod pair_sums;
mod regularity;
mod row;
mod spectrum;
mod transform;
mod vectors;

use std::cell::Cell;
use std::f64::consts::PI;
use std::sync::Arc;

use aligned_vec::{AVec, avec};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{RowIntegral, least};
use crate::signal::{UNIT_ROUNDOFF, unwrap_row};
use crate::state::Coordinates;
use crate::state::Ensemble;
use ahead::Ahead;
use pair_lanes::Band;
use pair_sums::{sums, value};
use regularity::sobolev_exponent;
use row::{pack, wraps};
use spectrum::{Folded, Modes, Spectrum};
use transform::{Scratch, Transform};

thread_local! {
    /// Kept for the next integral: of few degrees of freedom, making it would take as long as using it.
    static IDLE: Cell<Option<Workspace>> = const { Cell::new(None) };
}

/// Transform buffers of one thread.
struct Workspace {
    transform: Arc<Transform>,
    scratch: Scratch,
    unwrapped: Vec<f64>,
    /// On cache lines, so that no vector register is loaded from two.
    modes: AVec<Complex64>,
    /// Of the last rows, q and p.
    units: [f64; 2],
}

/// What the transform of a pair of rows does not show of them.
struct Rows {
    /// The transform is of q in this unit, a power of two.
    q_unit: f64,
    p_unit: f64,
    /// The largest coordinates as stored: their rounding is noise in I.
    q_largest: f64,
    p_largest: f64,
    /// The transform is of p less this.
    p_first: f64,
    /// What q gains in one turn; the transform is of q less this ramp.
    gain: f64,
}

impl Workspace {
    /// Lends `work` the workspace of this thread.
    fn lend<R>(transform: &Arc<Transform>, work: impl FnOnce(&mut Self) -> R) -> R {
        let mut workspace = (IDLE.take())
            .filter(|idle| idle.modes.len() == transform.samples())
            .unwrap_or_else(|| Workspace::new(Arc::clone(transform)));
        let result = work(&mut workspace);
        IDLE.set(Some(workspace));
        result
    }

    fn new(transform: Arc<Transform>) -> Self {
        Workspace {
            scratch: transform.scratch(),
            unwrapped: Vec::new(),
            modes: avec![Complex64::ZERO; transform.samples()],
            units: [1.0; 2],
            transform,
        }
    }

    fn integrate(&mut self, q: &[f64], p: &[f64], period: f64, ahead: Ahead) -> RowIntegral {
        // Neighbouring rows mostly have the same units: those of the last, then, and no second pass.
        let mut extents = pack(&mut self.modes, [q, p], self.units);
        let [q_largest, p_largest] = extents.map(|extent| extent.largest());
        let (mut q, mut gain) = (q, 0.0);
        if wraps(q, period) {
            self.unwrapped.clear();
            self.unwrapped.extend_from_slice(q);
            gain = unwrap_row(&mut self.unwrapped, period) as f64 * period;
            take_off_ramp(&mut self.unwrapped, gain);
            q = &self.unwrapped;
            extents = pack(&mut self.modes, [q, p], self.units);
        }
        let units = extents.map(|extent| extent.unit());
        if units != self.units {
            pack(&mut self.modes, [q, p], units);
            self.units = units;
        }
        let [q_unit, p_unit] = units;
        let rows = Rows {
            q_unit,
            p_unit,
            q_largest,
            p_largest,
            p_first: p[0],
            gain,
        };
        self.transform.forward(&mut self.modes, &mut self.scratch);
        rows.integral(Spectrum::new(&self.modes, self.transform.classes()), ahead)
    }
}

/// Leaves of a row that gains `gain` in one turn what is periodic.
fn take_off_ramp(row: &mut [f64], gain: f64) {
    let n = row.len() as f64;
    for (k, value) in row.iter_mut().enumerate() {
        *value -= gain * (k as f64 / n);
    }
}

/// Bands of modes that a transform may have: octaves and three more.
const MOST_BANDS: usize = usize::BITS as usize + 3;

/// What rounding makes of a mode, in the unit of its row: of the samples as stored and of the transform,
/// with a margin.
///
/// Transforms of other lengths than powers of two are less exact, those with large prime factors most: up
/// to 13 units for 4,097 samples and 100 for 262,147.
fn noise_of_mode(samples: usize, largest: f64, unit: f64) -> f64 {
    let n = samples as f64;
    let margin = match samples.is_power_of_two() {
        true => 4.0,
        false => 4.0 + n.sqrt() / 3.0,
    };
    margin * UNIT_ROUNDOFF * n.sqrt() * (largest / unit).max(1.0)
}

impl Rows {
    /// The integral from the transform of q + i p in these units, which it uses up.
    fn integral(&self, spectrum: Spectrum, ahead: Ahead) -> RowIntegral {
        let samples = spectrum.modes();
        let n = samples as f64;
        let modes = samples.div_ceil(2);
        // Bands from the highest modes down: the highest quarter, the rest of the upper half, and the lower
        // half by octaves, 2^j ≤ k < 2^{j+1}, whose energies tell how smooth the loop is. What the
        // octaves leave of it comes before them.
        let top_start = (3 * modes / 4).clamp(1, modes - 1);
        let octaves = (modes / 2).ilog2() as usize;
        let mut edges = [1; MOST_BANDS + 1];
        edges[..3].copy_from_slice(&[modes, top_start, modes / 2]);
        for (edge, j) in edges[3..].iter_mut().zip((0..=octaves).rev()) {
            *edge = 1 << j;
        }
        let mut bands = [Band::default(); MOST_BANDS];
        let all = sums(&spectrum, &edges[..4 + octaves], &mut bands, ahead);
        let [top, rest_of_upper, ..] = bands;
        let upper_scale = top.scale + rest_of_upper.scale;
        let scale: f64 = bands.iter().map(|band| band.scale).sum();
        let octave_energies = |power: fn(&Band) -> f64| {
            let mut energies = [0.0; MOST_BANDS];
            for (energy, band) in energies.iter_mut().zip(bands[3..3 + octaves].iter().rev()) {
                *energy = power(band);
            }
            energies
        };

        let factor = 4.0 * PI / (n * n);
        let unit = self.q_unit * self.p_unit;
        let mean = spectrum.mode(0).im / n;
        let p_mean = self.p_first + self.p_unit * mean;
        let scale = factor * scale;

        // Rounding of the stored samples: white noise of half an ulp of the largest.
        let noise = PI * UNIT_ROUNDOFF * (8.0 / n).sqrt() / n;
        let stored = self.q_largest * self.p_unit * (noise * all.p_slope_squared.sqrt())
            + self.p_largest * self.q_unit * (noise * all.q_slope_squared.sqrt());
        let transformed = UNIT_ROUNDOFF * n.log2() * scale;

        let quadrature_error = (samples / 2 >= 3).then(|| {
            // Root mean squares of the highest quarter of the modes: a jump or kink that the samples do
            // not resolve, or the noise of the states. Modes beyond N/2 fold back with about this size.
            let top_modes = (modes - top_start) as f64;
            let q_top = (top.q_power / top_modes).sqrt();
            let p_top = (top.p_power / top_modes).sqrt();
            let folded = factor * (p_top * all.q_slope + q_top * all.p_slope);
            // What still arrives at the end of the band.
            let tail = factor * upper_scale;
            // The same integral from every second sample; from the lower half of the modes where N
            // is odd.
            let lower = 1..(samples / 2).div_ceil(2);
            let (coarse, coarse_mean) = if samples.is_multiple_of(2) {
                let folded = Folded::new(spectrum);
                (value(&folded, lower), folded.mode(0).im)
            } else {
                (value(&spectrum, lower), spectrum.mode(0).im)
            };
            let change = factor * (all.value - coarse).abs();
            // The highest modes fold back into the mean as into every other mode.
            let mean_change = (mean - coarse_mean / n).abs().max(p_top / n);
            unit * change.max(tail).max(folded) + self.gain.abs() * self.p_unit * mean_change
        });
        RowIntegral {
            value: unit * (factor * all.value) + self.gain * p_mean,
            quadrature_error,
            roundoff: stored
                + unit * transformed
                + 2.0 * UNIT_ROUNDOFF * self.gain.abs() * self.p_largest,
            scale: unit * scale + (self.gain * p_mean).abs(),
            omitted: Vec::new(),
            regularity: {
                let q = octave_energies(|band| band.q_power);
                let p = octave_energies(|band| band.p_power);
                least(
                    sobolev_exponent(
                        &q[..octaves],
                        noise_of_mode(samples, self.q_largest, self.q_unit),
                    ),
                    sobolev_exponent(
                        &p[..octaves],
                        noise_of_mode(samples, self.p_largest, self.p_unit),
                    ),
                )
            },
        }
    }
}

pub(super) fn rows(ensemble: &Ensemble, coordinates: &Coordinates) -> Vec<RowIntegral> {
    let transform = Transform::of(ensemble.samples());
    let (q, p) = (ensemble.q(), ensemble.p());
    (0..ensemble.dof())
        .into_par_iter()
        .map(|i| {
            let ahead = match i + 1 {
                next if next < ensemble.dof() => Ahead::new([q.row(next), p.row(next)]),
                _ => Ahead::nothing(),
            };
            Workspace::lend(&transform, |workspace| {
                workspace.integrate(q.row(i), p.row(i), coordinates.period(i), ahead)
            })
        })
        .collect()
}
