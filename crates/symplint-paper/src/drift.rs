//! Whether an energy drifts, or only fluctuates.
//!
//! The error of an energy wanders: steps across the knots of splines change it a little at random, so that the
//! line through it rises or falls in any run, and by how much is a matter of the seed. A drift is a rise
//! that stands out of this and matters to the energy.

use super::claim::Judgement;
use super::sweep::Line;

/// Least length of a run that shows a drift, in plasma oscillations of period 2π/ω_p = 2π.
const MIN_PERIODS: f64 = 20.0;

/// Largest rise, relative to the energy, that is not a drift: a hundredth of what a two-stream instability
/// moves between particles and field, and several times what the error wanders with linear splines.
pub const MAX_STEADY_RISE: f64 = 1e-3;

/// Largest error of an energy that is conserved well.
const MAX_GOOD_ERROR: f64 = 1e-2;

/// Blocks, longer than the oscillations, whose means are about independent.
pub const BLOCKS: usize = 10;

/// Least standard errors of a rise that stands out.
const MIN_STANDARD_ERRORS: f64 = 4.0;

/// The trend of the error of an energy.
pub struct Drift {
    /// Its mean.
    pub mean: f64,
    /// The largest error.
    pub worst: f64,
    /// By how much its least-squares line rises over the run.
    pub rise: f64,
    /// Standard error of the rise, from block means: neighbouring moments are not independent.
    pub error: f64,
}

impl Drift {
    /// From (time, relative error of the energy) at even distances.
    pub fn of(errors: &[(f64, f64)]) -> Self {
        let mean = |points: &[(f64, f64)], of: fn(&(f64, f64)) -> f64| {
            points.iter().map(of).sum::<f64>() / points.len() as f64
        };
        let blocks: Vec<(f64, f64)> = (errors.chunks_exact((errors.len() / BLOCKS).max(1)))
            .map(|block| (mean(block, |p| p.0), mean(block, |p| p.1)))
            .collect();
        let line = Line::through(&blocks);
        let span = match errors {
            [first, .., last] => last.0 - first.0,
            _ => f64::NAN,
        };
        Drift {
            mean: mean(errors, |p| p.1),
            worst: errors.iter().map(|p| p.1.abs()).fold(0.0, f64::max),
            rise: line.slope * span,
            error: line.error * span,
        }
    }

    /// Well on average: close throughout, and without drift.
    pub fn judgement(&self, until: f64) -> Judgement {
        let periods = until / std::f64::consts::TAU;
        let judgement = if self.worst >= MAX_GOOD_ERROR {
            Judgement::DoesNotHold
        } else if self.rise.abs() <= MAX_STEADY_RISE {
            Judgement::Holds
        } else {
            // So large a rise that may be chance is neither drift nor none.
            Judgement::DoesNotHold.if_resolved(self.rise.abs() > MIN_STANDARD_ERRORS * self.error)
        };
        judgement.if_resolved(periods >= MIN_PERIODS && self.rise.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(until: f64, mut error: impl FnMut(f64) -> f64) -> Judgement {
        let moments: Vec<(f64, f64)> = (0..=2000)
            .map(|k| until * f64::from(k) / 2000.0)
            .map(|t| (t, error(t)))
            .collect();
        Drift::of(&moments).judgement(until)
    }

    /// Steps of ±`size` by a linear congruential generator, held within ±`bound`.
    fn walk(seed: u64, size: f64, bound: f64) -> impl FnMut(f64) -> f64 {
        let (mut state, mut at) = (seed, 0.0f64);
        move |_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let step = if state >> 63 == 0 { size } else { -size };
            at = (at + step).clamp(-bound, bound);
            at
        }
    }

    #[test]
    fn oscillations_are_no_drift_and_a_drift_is_found_under_them() {
        assert_eq!(judged(500.0, |t| 1e-4 * t.sin() - 7e-5), Judgement::Holds);
        let drifting = |t: f64| 1e-3 * t.sin() + 4e-6 * t;
        assert_eq!(judged(500.0, drifting), Judgement::DoesNotHold);
        assert_eq!(judged(500.0, |t| 2e-2 * t.sin()), Judgement::DoesNotHold);
        assert_eq!(judged(10.0, |t| 1e-4 * t.sin()), Judgement::Unresolved);
    }

    #[test]
    fn what_wanders_does_not_drift_whatever_the_seed() {
        for seed in 0..200 {
            assert_eq!(
                judged(500.0, walk(seed, 3e-6, 3e-4)),
                Judgement::Holds,
                "{seed}"
            );
        }
    }

    #[test]
    fn large_wandering_is_not_taken_for_conservation() {
        let judgements: Vec<_> = (0..200)
            .map(|seed| judged(500.0, walk(seed, 1e-4, 9e-3)))
            .collect();
        assert!(judgements.contains(&Judgement::Unresolved));
    }

    #[test]
    fn the_energy_that_heuns_method_gives_an_oscillator_drifts() {
        // q' = p, p' = −q: a step multiplies the energy by 1 + h⁴/4.
        let h: f64 = 0.03;
        let heun = |(q, p): (f64, f64)| {
            let (q1, p1) = (q + h * p, p - h * q);
            (q + 0.5 * h * (p + p1), p - 0.5 * h * (q + q1))
        };
        let mut state = (1.0, 0.0);
        let errors: Vec<(f64, f64)> = (0..16_000)
            .map(|step| {
                let (q, p): (f64, f64) = state;
                state = heun(state);
                (h * f64::from(step), q * q + p * p - 1.0)
            })
            .collect();
        let drift = Drift::of(&errors);
        let expected = 16_000.0 * h.powi(4) / 4.0;
        assert!((drift.rise / expected - 1.0).abs() < 0.01, "{}", drift.rise);
        assert!(drift.worst < MAX_GOOD_ERROR);
        assert_eq!(drift.judgement(480.0), Judgement::DoesNotHold);
    }
}
