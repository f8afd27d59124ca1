//! Where samples of a loop do not resolve it.

use symplint_fft::Complex64;

use super::row::pack;
use super::take_off_ramp;
use super::transform::transform;
use crate::signal::unwrap_row;
use crate::state::{Coordinates, Ensemble, coordinate, in_parallel, period};

/// How much of each sample the upper half of the modes makes up, in units of the size of its coordinate; the largest of all
/// coordinates. Noise is everywhere along the loop, a narrow feature is at one place.
pub(crate) fn roughness(samples: &Ensemble, coordinates: &Coordinates) -> Vec<f64> {
    let n = samples.samples();
    let transform = transform(n);
    let row_of = |c: usize| periodic_part(samples, coordinates, c).0;
    let of_dof = |i: usize| {
        let (q, p) = (row_of(i), row_of(samples.dof() + i));
        let mut modes = vec![Complex64::ZERO; n];
        pack(&mut modes, &q, &p);
        transform.process(&mut modes);
        let quarter = n / 4;
        for (k, mode) in modes.iter_mut().enumerate() {
            // The transform of the conjugates is the inverse one, conjugated.
            *mode = match k.min(n - k) < quarter {
                true => Complex64::ZERO,
                false => mode.conj() / n as f64,
            };
        }
        transform.process(&mut modes);
        modes.iter().map(|x| x.norm()).collect::<Vec<f64>>()
    };
    let mut largest = vec![0.0f64; n];
    for of_dof in in_parallel(0..samples.dof(), 2 * n, of_dof) {
        let each = largest.iter_mut().zip(of_dof);
        each.for_each(|(largest, power)| *largest = largest.max(power));
    }
    largest
}

/// A coordinate round the loop without the ramp by which it gains whole periods, and the gain.
fn periodic_part(samples: &Ensemble, coordinates: &Coordinates, c: usize) -> (Vec<f64>, f64) {
    let period = period(coordinates, c);
    let mut row = coordinate(samples, c).to_vec();
    let gain = unwrap_row(&mut row, period) as f64 * period;
    if gain != 0.0 {
        take_off_ramp(&mut row, gain);
    }
    (row, gain)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn states(s: &[f64], of: impl Fn(f64) -> [f64; 2]) -> Ensemble {
        let mut states = Ensemble::zeros(1, s.len());
        for (k, &s) in s.iter().enumerate() {
            let [q, p] = of(s);
            states.block().q.row_mut(0)[k] = q;
            states.block().p.row_mut(0)[k] = p;
        }
        states
    }

    fn equispaced(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64 / n as f64).collect()
    }

    #[test]
    fn roughness_is_at_a_spike_and_everywhere_in_noise() {
        let coordinates = Coordinates::plain(1);
        let n = 256;
        let noise = |s: f64| ((s * 12.9898).sin() * 43758.5453).fract();
        let largest = |of: &dyn Fn(f64) -> [f64; 2]| {
            let rough = roughness(&states(&equispaced(n), of), &coordinates);
            let at = (0..n)
                .max_by(|&a, &b| rough[a].total_cmp(&rough[b]))
                .unwrap();
            let mut sorted = rough.clone();
            sorted.sort_by(f64::total_cmp);
            (at, rough[at] / sorted[n / 2])
        };
        let spike = |s: f64| {
            [
                (TAU * s).sin(),
                (TAU * s).cos() + 1e-8 * f64::from(s == 0.25),
            ]
        };
        let (at, outstanding) = largest(&spike);
        assert!(at == 64 && outstanding > 100.0, "{at} {outstanding}");
        let (_, outstanding) = largest(&|s| [(TAU * s).sin(), (TAU * s).cos() + 1e-8 * noise(s)]);
        assert!(outstanding < 8.0, "{outstanding}");
    }
}
