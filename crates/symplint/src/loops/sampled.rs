//! A loop given by samples on the uniform grid s = k/N.

use std::sync::Arc;

use symplint_fft::Complex64;

use super::Loop;
use super::turn::sin_cos_turn;
use crate::error::Error;
use crate::signal::unwrap_row;
use crate::state::Block;
use crate::state::Coordinates;
use crate::state::Ensemble;

/// The trigonometric interpolant of a loop's samples.
///
/// At the grid points it returns the samples to the last bit; in between, the value of the
/// trigonometric polynomial through them (of a winding position, after its ramp
/// is taken off). A sample off the grid costs N_s operations for each coordinate.
#[derive(Clone, Debug)]
pub struct SampledLoop {
    /// Unwrapped samples.
    grid: Arc<Ensemble>,
    /// Rows q_0, p_0, q_1, p_1, …
    rows: Vec<Interpolant>,
}

#[derive(Clone, Debug)]
struct Interpolant {
    /// The gain of the coordinate in one turn: winding × period.
    gain: f64,
    /// Mean and Fourier coefficients of the periodic part, k = 0 … N/2.
    spectrum: Vec<Complex64>,
}

impl SampledLoop {
    /// Interpolates the loop whose samples are `ensemble`, sample k at s = k/N_s.
    ///
    /// Coordinates with a period (see [`Coordinates`]) are unwrapped first.
    ///
    /// # Errors
    /// If there are fewer than 3 samples, one is not finite, or `coordinates` has
    /// other degrees of freedom than `ensemble`.
    pub fn new(mut ensemble: Ensemble, coordinates: &Coordinates) -> Result<Self, Error> {
        let (dof, samples) = (ensemble.dof(), ensemble.samples());
        Error::check_length("coordinates", dof, coordinates.dof())?;
        if samples < 3 {
            return Err(Error::TooFewSamples { samples });
        }
        ensemble.check_finite(None)?;
        let transform = symplint_fft::forward(samples);
        let mut rows = Vec::with_capacity(2 * dof);
        let interpolant = |row: &[f64], gain: f64| {
            let periodic = |(k, x): (usize, &f64)| x - gain * (k as f64 / samples as f64);
            let mut spectrum: Vec<Complex64> = (row.iter().enumerate())
                .map(|sample| periodic(sample).into())
                .collect();
            transform.process(&mut spectrum);
            spectrum.truncate(samples / 2 + 1);
            for coefficient in &mut spectrum {
                *coefficient /= samples as f64;
            }
            Interpolant { gain, spectrum }
        };
        let mut block = ensemble.block();
        for i in 0..dof {
            let period = coordinates.period(i);
            let winding = unwrap_row(block.q.row_mut(i), period);
            rows.push(interpolant(block.q.row(i), winding as f64 * period));
            let period = coordinates.momentum_period(i);
            let winding = unwrap_row(block.p.row_mut(i), period);
            rows.push(interpolant(block.p.row(i), winding as f64 * period));
        }
        Ok(SampledLoop {
            grid: Arc::new(ensemble),
            rows,
        })
    }
}

impl Interpolant {
    fn at(&self, s: f64, samples: usize) -> f64 {
        let mut value = self.spectrum[0].re + self.gain * s;
        for (k, coefficient) in self.spectrum.iter().enumerate().skip(1) {
            let (sin, cos) = sin_cos_turn(k as f64 * s);
            // The Nyquist mode counts once, every other mode also for its conjugate.
            let weight = if 2 * k == samples { 1.0 } else { 2.0 };
            value += weight * (coefficient.re * cos - coefficient.im * sin);
        }
        value
    }
}

impl Loop for SampledLoop {
    fn dof(&self) -> usize {
        self.grid.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let samples = self.grid.samples();
        for (k, &s) in s.iter().enumerate() {
            let turns = s.floor();
            let position = (s - turns) * samples as f64;
            let nearest = position.round();
            // k/N in floating point times N may miss k by rounding.
            let on_grid = (position - nearest).abs() <= 4.0 * f64::EPSILON * nearest.max(1.0);
            for i in 0..self.dof() {
                let (q, p) = (&self.rows[2 * i], &self.rows[2 * i + 1]);
                let (q_value, p_value) = if on_grid && (nearest as usize) < samples {
                    let column = nearest as usize;
                    (
                        self.grid.q().row(i)[column] + turns * q.gain,
                        self.grid.p().row(i)[column] + turns * p.gain,
                    )
                } else {
                    (q.at(s, samples), p.at(s, samples))
                };
                block.q.row_mut(i)[k] = q_value;
                block.p.row_mut(i)[k] = p_value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::FourierLoop;
    use crate::state::RowsMut;

    #[test]
    fn returns_its_samples_and_interpolates_between_them() {
        let ones = [1.0, 1.0];
        let smooth = FourierLoop::random(vec![2.0; 2], vec![0.0; 2], &ones, &ones, 5).unwrap();
        for samples in [9, 16, 33] {
            let ensemble = Ensemble::sample(&smooth, samples).unwrap();
            let sampled = SampledLoop::new(ensemble.clone(), &Coordinates::plain(2)).unwrap();
            let again = Ensemble::sample(&sampled, samples).unwrap();
            assert_eq!(again.q().row(1), ensemble.q().row(1));
            let finer = Ensemble::sample(&sampled, 7 * samples).unwrap();
            let exact = Ensemble::sample(&smooth, 7 * samples).unwrap();
            for (a, b) in finer.p().row(0).iter().zip(exact.p().row(0)) {
                assert!((a - b).abs() < 1e-14, "{samples} samples: {a} against {b}");
            }
        }
    }

    #[test]
    fn a_wrapped_winding_position_is_unwrapped() {
        // q runs once round a period of 2 while p = cos 2πs; stored in [0, 2).
        let samples = 16;
        let mut ensemble = Ensemble::zeros(1, samples);
        for k in 0..samples {
            let s = k as f64 / samples as f64;
            ensemble.block().q.row_mut(0)[k] = (1.5 + 2.0 * s) % 2.0;
            ensemble.block().p.row_mut(0)[k] = sin_cos_turn(s).1;
        }
        let coordinates = Coordinates::plain(1).with_periods(vec![2.0]).unwrap();
        let sampled = SampledLoop::new(ensemble, &coordinates).unwrap();
        let (mut q, mut p) = ([0.0; 2], [0.0; 2]);
        let mut block = Block::new(RowsMut::new(&mut q, 1, 2, 2), RowsMut::new(&mut p, 1, 2, 2));
        sampled.sample(&[0.61, 1.25], &mut block);
        assert!((q[0] - (1.5 + 2.0 * 0.61)).abs() < 1e-14);
        assert!((q[1] - (1.5 + 2.0 * 1.25)).abs() < 1e-14);
    }
}
