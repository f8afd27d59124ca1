//! The trigonometric interpolant of samples, and where the loop is not what its samples make of it.

use std::f64::consts::PI;

use symplint_fft::Complex64;

use super::row::pack;
use super::take_off_ramp;
use super::transform::transform;
use crate::signal::{Extent, dot, nearest, unwrap_row};
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

/// How far states `between` the samples, at parameters `s`, are from the trigonometric interpolant of the samples (barycentric,
/// Henrici, Numer. Math. 33, 1979), in units of the size of each coordinate; the largest of all coordinates.
pub(crate) fn misses(
    samples: &Ensemble,
    coordinates: &Coordinates,
    between: &Ensemble,
    s: &[f64],
) -> Vec<f64> {
    let n = samples.samples();
    let of_coordinate = |c: usize| {
        let (row, gain) = periodic_part(samples, coordinates, c);
        let size = 0.5 * Extent::of(&row).length();
        (row, gain, size)
    };
    let rows: Vec<(Vec<f64>, f64, f64)> = in_parallel(0..2 * samples.dof(), n, of_coordinate);
    let ones = vec![1.0; n];
    // Less than half a turn to either side: sines near π would be rounded more than they are large.
    let turns: Vec<[f64; 3]> = (0..n as i64)
        .map(|k| if 2 * k > n as i64 { k - n as i64 } else { k })
        .map(|k| {
            let (sin, cos) = (PI * k as f64 / n as f64).sin_cos();
            [sin, cos, if k % 2 == 0 { 1.0 } else { -1.0 }]
        })
        .collect();
    let of_state = |(j, &s): (usize, &f64)| {
        // Angles are taken from the nearest sample: the addition theorems lose nothing on the samples next to it.
        let nearest_sample = (s * n as f64).round();
        let (sin, cos) = (PI * (s - nearest_sample / n as f64)).sin_cos();
        let weight = |&[of_sin, of_cos, sign]: &[f64; 3]| {
            let denominator = sin * of_cos - cos * of_sin;
            match n.is_multiple_of(2) {
                true => sign * (cos * of_cos + sin * of_sin) / denominator,
                false => sign / denominator,
            }
        };
        // From the nearest sample round the loop.
        let mut weights: Vec<f64> = turns.iter().map(weight).collect();
        weights.rotate_right(nearest_sample as usize % n);
        // As the numerators are summed, so that what rounding does to both is alike.
        let all = dot(&weights, &ones);
        let miss = |(c, (row, gain, size)): (usize, &(Vec<f64>, f64, f64))| {
            let expected = dot(&weights, row) / all + gain * s;
            let off = nearest(coordinate(between, c)[j] - expected, period(coordinates, c));
            (off / size).abs()
        };
        // For a coordinate at rest, whose size is 0, and next to a sample, the quotient is not a number.
        let finite = rows
            .iter()
            .enumerate()
            .map(miss)
            .filter(|miss| miss.is_finite());
        finite.fold(0.0, f64::max)
    };
    in_parallel(s.iter().enumerate(), rows.len() * n, of_state)
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
    fn the_interpolant_of_a_smooth_loop_misses_nothing_and_shows_a_feature() {
        let coordinates = Coordinates::plain(1).with_periods(vec![2.0]).unwrap();
        // It winds, and its position is wrapped.
        let smooth = |s: f64| {
            let q = 4.0 * s + 0.3 * (TAU * s).sin();
            [q.rem_euclid(2.0), 1e5 + (2.0 * TAU * s).cos()]
        };
        let bumped = |s: f64| {
            let bump = 1e-6 * (-((s - 0.4) / 1e-3).powi(2)).exp();
            [smooth(s)[0], smooth(s)[1] + bump]
        };
        let s = [0.0131, 0.3999, 0.77];
        for n in [64, 101] {
            let samples = states(&equispaced(n), smooth);
            let off = misses(&samples, &coordinates, &states(&s, smooth), &s);
            assert!(off.iter().all(|&miss| miss < 1e-9), "{n}: {off:?}");
            let off = misses(&samples, &coordinates, &states(&s, bumped), &s);
            assert!(off[0] < 1e-9 && off[2] < 1e-9, "{n}: {off:?}");
            assert!((off[1] / 1e-6 - 1.0).abs() < 0.05, "{n}: {off:?}");
        }
    }

    #[test]
    fn high_modes_are_interpolated_to_rounding_on_both_sides_of_a_sample() {
        // Parameters, samples and phases are binary fractions: nothing but the interpolant is rounded.
        const N: usize = 4096;
        let wave = |s: f64| {
            let (sin, cos) = (TAU * (1025.0 * s).fract()).sin_cos();
            [cos, sin]
        };
        let samples = states(&equispaced(N), wave);
        let s: Vec<f64> = (1..N)
            .step_by(37)
            .flat_map(|k| [-0.25, -0.015625, 0.25, 0.5].map(|off| (k as f64 + off) / N as f64))
            .collect();
        let off = misses(&samples, &Coordinates::plain(1), &states(&s, wave), &s);
        let largest = off.iter().fold(0.0, |m: f64, x| m.max(*x));
        // Sines of angles up to π, instead of π/2, would make it 2e-13.
        assert!(largest < 2e-14, "{largest:e}");
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
