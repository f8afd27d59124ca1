//! Central differences along rows that are smooth to rounding: the value of the transform, at a fraction of its cost.
//!
//! With the sums R_k = Σ_j p_j (q_{j+k} − q_{j−k}) round the loop, the central difference of order 2m gives
//! ∮ p dq ≈ Σ_{k ≤ m} c_k R_k ([`Stencil`]): ten sums give all orders from 2 to 20. At order 20 a loop with some twenty samples to its
//! shortest wavelength is integrated to rounding.
//!
//! The rule answers only for rows whose samples show nothing but rounding above that ([`Inspection`](inspection::Inspection)): no noise, no
//! jump, no kink, no mode that a difference misses. All others are left to the transform, which says what they are like. One [`Visit`]
//! inspects the samples and sums the products of every second one. These take a mode near the Nyquist mode for a long one: what the
//! inspection leaves of such modes is in the error. If order 10 is not enough, all samples are summed by order 20. Registers of any width
//! give the same bits: sums run in [`LANES`] lanes, and no multiplication is fused with an addition.

mod inspection;
mod lags;
mod visit;

use std::f64::consts::SQRT_2;
use std::ops::Range;
use std::sync::LazyLock;

use self::lags::LAGS;
pub(super) use self::visit::Visit;
use super::RowIntegral;
use super::stencil::{ALIASING_FACTOR, Stencil};
use crate::signal::{LANES, UNIT_ROUNDOFF};

/// The fewest samples that the rule is for: fewer are transformed nearly as fast, and have so few windows that a jump makes much of
/// what looks like noise.
const MIN_SAMPLES: usize = 512;

/// Samples whose sums are put by together: the rounding of sums grows with the root of this number. A rough row is given up at the end of a run.
const RUN: usize = 512;

/// What rounding makes of the sums, in units of what it makes of their scale. Calibrated: with this, errors of 896 random loops of 24
/// modes are at most half of what is stated.
const ROUNDINGS_OF_SUMS: f64 = 6.0;

/// The rule answers if its error estimate, with the jump that noise may hide, is at most this part of the scale of the integral: half of
/// what counts as round-off, as a defect has two integrals.
const MAX_ERROR: f64 = 5e-15;

/// Products of coordinates of these sizes, and the squares of their roundings, neither under- nor overflow.
const RANGE_OF_SIZES: Range<f64> = 1e-100..1e100;

/// The central differences of orders 8 and 10, for every second sample, and of orders 18 and 20, for all.
static CENTRED: LazyLock<[[Vec<f64>; 2]; 2]> = LazyLock::new(|| {
    let centred = |m: usize| Stencil::new(m).centred;
    [LAGS, 2 * LAGS].map(|m| [centred(m - 1), centred(m)])
});

/// ∮ p dq of a row that is smooth to rounding; `None` for any other, and for an odd number of samples. What q gains in one turn, `gain`, was
/// taken off it.
pub(super) fn integrate(visit: &mut Visit, q: &[f64], p: &[f64], gain: f64) -> Option<RowIntegral> {
    let samples = q.len();
    if samples < MIN_SAMPLES || !samples.is_multiple_of(2) {
        return None;
    }
    let mut sums = [0.0; 2 * LAGS];
    let [of_q, of_p] = visit.visit(q, p, &mut sums)?;
    if !(RANGE_OF_SIZES.contains(&of_q.deviation) && RANGE_OF_SIZES.contains(&of_p.deviation)) {
        return None;
    }
    let (q_size, p_size) = (of_q.size + gain.abs(), of_p.size);
    let scale = of_p.deviation * of_q.slope;
    let summed = ROUNDINGS_OF_SUMS * UNIT_ROUNDOFF * scale;
    let winding = 2.0 * UNIT_ROUNDOFF * gain.abs() * p_size;
    let of_jump = SQRT_2 * of_p.deviation * of_q.jump(q_size);

    // By every second sample if that is enough.
    for (stride, [lower, higher]) in [2, 1].into_iter().zip(CENTRED.iter()) {
        let root = ((samples / stride) as f64).sqrt();
        let stored = UNIT_ROUNDOFF * (q_size * of_p.slope + p_size * of_q.slope) / root;
        // Beyond what the stencils miss.
        let folded = ALIASING_FACTOR * (of_p.noise * of_q.slope + of_q.noise * of_p.slope) / root;
        let of_mean = gain.abs() * of_p.noise / root;
        let confused = match stride {
            2 => of_p.shortest_mode() * of_q.slope + of_q.shortest_mode() * of_p.slope,
            _ => 0.0,
        };
        // A jump and a mode both explain the largest difference of a window. The one with the larger error counts.
        let hidden = folded + of_mean + of_jump.max(confused);
        let most = MAX_ERROR * scale + 2.0 * stored;
        if hidden.is_nan() || hidden > most {
            continue;
        }
        if stride == 1 {
            sums.fill(0.0);
            let places = visit.padded.copy(q, p);
            visit.padded.add_lags::<0>(places.clone(), &mut sums);
            visit.padded.add_lags::<LAGS>(places, &mut sums[LAGS..]);
        }
        let [coarse, value] = [lower, higher].map(|stencil| weighted(stencil, &sums));
        let error = (value - coarse).abs() + hidden;
        if error <= most {
            let turned = if gain == 0.0 { 0.0 } else { gain * mean(p) };
            return Some(RowIntegral {
                value: value + turned,
                quadrature_error: Some(error),
                roundoff: stored + summed + winding,
                scale: scale + turned.abs(),
                omitted: Vec::new(),
                regularity: None,
            });
        }
    }
    None
}

fn weighted(stencil: &[f64], sums: &[f64]) -> f64 {
    let terms = stencil.iter().zip(sums).map(|(c, sum)| c * sum);
    // The smallest first.
    terms.rev().sum()
}

fn mean(row: &[f64]) -> f64 {
    row[0] + row.iter().map(|x| x - row[0]).sum::<f64>() / row.len() as f64
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::breaks::rounding;

    pub(super) fn row(samples: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..samples)
            .map(|k| of(k as f64 / samples as f64))
            .collect()
    }

    fn of_rows(q: &[f64], p: &[f64]) -> Option<RowIntegral> {
        wound(q, p, 0.0)
    }

    fn wound(q: &[f64], p: &[f64], gain: f64) -> Option<RowIntegral> {
        integrate(&mut Visit::new(), q, p, gain)
    }

    /// Modes of a coordinate, their numbers with the amplitudes of cosine and sine.
    type Modes = Vec<(usize, [f64; 2])>;

    fn loop_of(samples: usize, centre: f64, modes: &Modes) -> Vec<f64> {
        // Angles below one turn, to be as exact as samples can be.
        let at = |m: usize, k: usize| (TAU * (m * k % samples) as f64 / samples as f64).sin_cos();
        let value = |k: usize| {
            let terms = modes.iter().map(|&(m, [a, b])| {
                let (sin, cos) = at(m, k);
                a * cos + b * sin
            });
            centre + terms.sum::<f64>()
        };
        (0..samples).map(value).collect()
    }

    /// ∮ p dq = π Σ m (p_m^c q_m^s − p_m^s q_m^c).
    fn closed_form(q: &Modes, p: &Modes) -> f64 {
        let terms = q.iter().zip(p);
        PI * terms
            .map(|((m, q), (_, p))| *m as f64 * (p[0] * q[1] - p[1] * q[0]))
            .sum::<f64>()
    }

    fn random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    #[test]
    fn resolved_loops_have_their_closed_form() {
        let mut seed = 1;
        let (mut taken, mut worst) = (0, 0.0f64);
        for samples in [512, 514, 600, 998, 1000, 1024, 4096, 5000, 16384] {
            for (centre, stretch) in [(0.0, 1.0), (0.0, 1e8), (0.0, 1e-8), (1e3, 1.0), (-1e6, 1.0)]
            {
                for trial in 0..20 {
                    // From the fundamental mode alone to modes of twenty samples.
                    let highest = 1 + trial * (samples / 20 - 1) / 19;
                    let mut modes = |size: f64| -> Modes {
                        let numbers = (0..24).map(|j| 1 + j * (highest - 1) / 23);
                        let mode = |m| (m, [(); 2].map(|()| size * random(&mut seed) / m as f64));
                        numbers.map(mode).collect()
                    };
                    let (of_q, of_p) = (modes(stretch), modes(1.0));
                    let (q, p) = (
                        loop_of(samples, centre, &of_q),
                        loop_of(samples, centre, &of_p),
                    );
                    let Some(found) = of_rows(&q, &p) else {
                        continue;
                    };
                    taken += 1;
                    // The numbers of modes are not all different: sum by pairs of equal numbers.
                    let merged = |modes: &Modes| {
                        let mut merged: Modes = Vec::new();
                        for &(m, [a, b]) in modes {
                            match merged.last_mut() {
                                Some((last, of)) if *last == m => *of = [of[0] + a, of[1] + b],
                                _ => merged.push((m, [a, b])),
                            }
                        }
                        merged
                    };
                    let off = (found.value - closed_form(&merged(&of_q), &merged(&of_p))).abs();
                    worst = worst.max(off / (found.roundoff + found.quadrature_error.unwrap()));
                }
            }
        }
        println!("{taken} {worst}");
        assert!(taken > 700, "{taken}");
        // Nor is the error stated many times too large.
        assert!((0.1..1.0).contains(&worst), "{worst}");
    }

    #[test]
    fn rows_that_show_more_than_rounding_are_left_to_the_transform() {
        for samples in [512, 1000, 4096] {
            let sine = row(samples, |s| (TAU * s).sin());
            let cosine = row(samples, |s| (TAU * s).cos());
            assert!(of_rows(&sine, &cosine).is_some());
            let noise = |s: f64| ((s * 12.9898).sin() * 43758.5453).fract();
            let shapes: [(&str, &dyn Fn(f64) -> f64); 7] = [
                ("kink", &|s| 1e-6 * (s - 0.3).abs()),
                ("jump", &|s| 1e-12 * f64::from(s > 0.3)),
                ("noise", &|s| 1e-13 * noise(s)),
                ("spike", &|s| 1e-12 * f64::from(s == 0.25)),
                ("wave of eight samples", &|s| {
                    1e-3 * (TAU * (samples / 8) as f64 * s).sin()
                }),
                ("not a number", &|s| if s > 0.99 { f64::NAN } else { 0.0 }),
                ("infinite", &|s| if s == 0.5 { f64::INFINITY } else { 0.0 }),
            ];
            for (what, shape) in shapes {
                let rough: Vec<f64> = (sine.iter().zip(row(samples, shape)))
                    .map(|(x, rough)| x + rough)
                    .collect();
                assert!(of_rows(&rough, &cosine).is_none(), "{what}, {samples}");
                assert!(of_rows(&cosine, &rough).is_none(), "{what} of p, {samples}");
            }
            // Nor rows that have no size, or sizes whose squares are no numbers.
            for size in [0.0, 1e-200, 1e200] {
                let scaled: Vec<f64> = sine.iter().map(|x| size * x).collect();
                assert!(of_rows(&scaled, &cosine).is_none(), "{size}");
                assert!(of_rows(&cosine, &scaled).is_none(), "{size}");
            }
        }
        for samples in [MIN_SAMPLES - 2, MIN_SAMPLES + 1] {
            let others = row(samples, |s| (TAU * s).sin());
            assert!(of_rows(&others, &others).is_none(), "{samples}");
        }
    }

    #[test]
    fn jumps_of_any_size_are_in_the_error_or_left_to_the_transform() {
        let mut seed = 3;
        let (mut taken, mut beyond) = (0, 0);
        for samples in [512, 1000, 4096] {
            for trial in 0..2000 {
                let size = 1e-16 * 10f64.powi(trial % 5);
                let (at, phase) = (random(&mut seed) + 0.5, TAU * random(&mut seed));
                let jump = |s: f64| size * (f64::from(s > at) - s);
                let q = row(samples, |s| (TAU * s + phase).sin() + jump(s));
                let p = row(samples, |s| (TAU * s + phase).cos());
                let Some(found) = of_rows(&q, &p) else {
                    continue;
                };
                taken += 1;
                // The jump closed by a chord; the slope of q changes the integral by nothing.
                let of_jump = size * (TAU * at + phase).cos();
                let off = (found.value - PI).abs();
                // Jumps of 32 roundings and less count as rounding.
                let known =
                    found.roundoff + found.quadrature_error.unwrap() + rounding(UNIT_ROUNDOFF);
                let ratio = of_jump.abs().max(off) / known;
                beyond += usize::from(ratio > 1.0);
                // The window that shows a jump and the value have their own rounding.
                assert!(
                    ratio < 1.2,
                    "{samples}, {size:e}: {of_jump:e} {off:e} {known:e}"
                );
            }
        }
        println!("{taken} {beyond}");
        assert!(
            taken > 1000 && beyond < taken / 100,
            "{beyond} of {taken} are beyond their error"
        );
    }

    #[test]
    fn a_jump_in_any_cell_is_seen() {
        for samples in 512..546 {
            let smooth = row(samples, |s| (TAU * s).sin());
            let other = row(samples, |s| (TAU * s).cos());
            for cell in 0..samples {
                // A slope round the loop, and back in one cell: too little for windows twice as far apart.
                let slope = |k: usize| ((k + samples - cell) % samples) as f64 / samples as f64;
                let jumping: Vec<f64> = (smooth.iter().enumerate())
                    .map(|(k, x)| x + 1e-12 * slope(k))
                    .collect();
                assert!(of_rows(&jumping, &other).is_none(), "{samples}, {cell}");
            }
        }
    }

    #[test]
    fn modes_that_the_lower_order_misses_take_the_higher_one() {
        let samples = 4096;
        for (mode, by_lower) in [(1, true), (10, true), (100, false), (200, false)] {
            let q = loop_of(samples, 0.0, &vec![(mode, [0.0, 1.0])]);
            let p = loop_of(samples, 0.0, &vec![(mode, [1.0, 0.0])]);
            let found = of_rows(&q, &p).expect("20 samples or more");
            let exact = PI * mode as f64;
            assert!(
                (found.value / exact - 1.0).abs() < 2e-15,
                "{mode}: {found:?}"
            );
            let mut sums = [0.0; 2 * LAGS];
            Visit::new().visit(&q, &p, &mut sums).expect("it is smooth");
            let lower = weighted(&CENTRED[0][1], &sums);
            assert_eq!((lower / exact - 1.0).abs() < 1e-15, by_lower, "{mode}");
        }
    }

    #[test]
    fn modes_that_every_second_sample_confuses_are_in_the_error_or_left_to_the_transform() {
        let mut taken = 0;
        for (samples, centre) in [(512, 0.0), (4096, 0.0), (4096, 1e3), (1000, 1e6)] {
            let base = |m: usize, sine: f64| (m, [1.0 - sine, sine]);
            for (m, mode) in [1, 3]
                .into_iter()
                .flat_map(|m| [(m, samples / 2 - m), (m, samples / 4 + m)])
            {
                for step in 0..100 {
                    let size = 1e-16 * (1.0 + centre) * 10f64.powf(0.05 * f64::from(step));
                    let (plain_q, plain_p) = (vec![base(m, 1.0)], vec![base(m, 0.0)]);
                    let beside = |row: &Modes| [row.clone(), vec![(mode, [size, 0.0])]].concat();
                    let pairs = [
                        (plain_q.clone(), beside(&plain_p)),
                        (beside(&plain_q), plain_p.clone()),
                        (beside(&plain_q), beside(&plain_p)),
                    ];
                    for (q, p) in pairs {
                        let rows = [&q, &p].map(|modes| loop_of(samples, centre, modes));
                        let Some(found) = of_rows(&rows[0], &rows[1]) else {
                            continue;
                        };
                        taken += 1;
                        let off = (found.value - PI * m as f64).abs();
                        let known = found.roundoff + found.quadrature_error.unwrap();
                        assert!(
                            off <= known,
                            "{samples}, {centre}, {m}, {mode}, {size:e}: {off:e} {known:e}"
                        );
                    }
                }
            }
        }
        assert!(taken > 1000, "{taken}");
    }

    #[test]
    fn equal_rows_enclose_no_area() {
        for samples in [512, 1000] {
            let q = row(samples, |s| (TAU * s).sin() + 0.3 * (2.0 * TAU * s).cos());
            let found = of_rows(&q, &q).unwrap();
            assert!(found.value.abs() <= found.roundoff, "{found:?}");
        }
    }

    #[test]
    fn a_position_that_winds_adds_the_mean_momentum() {
        for (gain, centre) in [(3.0, 0.5), (-2.0, 100.0)] {
            let q = row(1024, |s| 0.2 * (TAU * s).sin());
            let p = row(1024, |s| centre + (TAU * s).cos());
            let found = wound(&q, &p, gain).unwrap();
            let off = (found.value - (0.2 * PI + gain * centre)).abs();
            assert!(off <= found.roundoff, "{found:?}");
        }
    }
}
