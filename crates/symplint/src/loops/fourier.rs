//! Loops made of a few Fourier modes.

use std::f64::consts::TAU;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;

use super::Loop;
use super::turn::sin_cos_turn;
use crate::error::Error;
use crate::signal::unit;
use crate::state::Block;
use crate::state::scratch;

/// One degree of freedom of one mode: cosine and sine amplitudes of q and of p.
#[derive(Clone, Copy, Debug)]
struct Amplitudes {
    q: (f64, f64),
    p: (f64, f64),
}

/// A centre and, for each mode m = 1, 2, …, amplitudes of cos 2πms and sin 2πms in every
/// coordinate; one position may gain a period on the way round.
#[derive(Clone, Debug)]
pub struct FourierLoop {
    q0: Vec<f64>,
    p0: Vec<f64>,
    /// Mode by mode, one entry for each degree of freedom.
    modes: Vec<Vec<Amplitudes>>,
    /// The position that winds, and what it gains in one turn.
    winding: Option<(usize, f64)>,
}

impl FourierLoop {
    /// A random loop round (q0, p0) that reaches no further than `radius_q[i]` and `radius_p[i]`.
    ///
    /// Its first mode runs an ellipse in every plane (q_i, p_i) with a random phase and a random
    /// size, always in the sense of positive ∮ p dq; modes 2 and 3 add random amplitudes
    /// of at most a quarter and an eighth. The areas of different planes therefore
    /// differ and never cancel, and no coordinate is symmetric about its centre. The loop depends on
    /// `seed` alone, on every platform.
    ///
    /// # Errors
    /// If the lists differ in length, or a radius is negative or not finite.
    pub fn random(
        q0: Vec<f64>,
        p0: Vec<f64>,
        radius_q: &[f64],
        radius_p: &[f64],
        seed: u64,
    ) -> Result<Self, Error> {
        let dof = q0.len();
        Error::check_length("centre p0", dof, p0.len())?;
        Error::check_length("radius in q", dof, radius_q.len())?;
        Error::check_length("radius in p", dof, radius_p.len())?;
        for &radius in radius_q.iter().chain(radius_p) {
            if !(radius.is_finite() && radius >= 0.0) {
                return Err(Error::OutOfRange {
                    what: "radius of the random loop",
                    value: radius,
                    remedy: "give a finite radius that is not negative",
                });
            }
        }
        // The modes together reach at most √2 (1/4 + 1/8) beyond the first.
        let size = 1.0 / (1.0 + 2f64.sqrt() * (1.0 / 4.0 + 1.0 / 8.0));
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut between = |low: f64, high: f64| low + (high - low) * unit(&mut random);
        let first = (0..dof)
            .map(|i| {
                let (sin, cos) = sin_cos_turn(between(0.0, 1.0));
                let (rq, rp) = (
                    size * radius_q[i] * between(0.7, 1.0),
                    size * radius_p[i] * between(0.7, 1.0),
                );
                // q = rq sin(2πs + φ), p = rp cos(2πs + φ): positive area π rq rp.
                Amplitudes {
                    q: (rq * sin, rq * cos),
                    p: (rp * cos, -rp * sin),
                }
            })
            .collect();
        let mut modes: Vec<Vec<Amplitudes>> = vec![first];
        for part in [1.0 / 4.0, 1.0 / 8.0] {
            modes.push(
                (0..dof)
                    .map(|i| {
                        let mut pair = |r: f64| (between(-r, r), between(-r, r));
                        Amplitudes {
                            q: pair(part * size * radius_q[i]),
                            p: pair(part * size * radius_p[i]),
                        }
                    })
                    .collect(),
            );
        }
        Ok(FourierLoop {
            q0,
            p0,
            modes,
            winding: None,
        })
    }

    /// The ellipse q0 + u_q cos 2πs + v_q sin 2πs, and the same in p, for two vectors u and v of d positions and d momenta each.
    pub(crate) fn ellipse(
        (q0, p0): (Vec<f64>, Vec<f64>),
        [u_q, u_p]: [&[f64]; 2],
        [v_q, v_p]: [&[f64]; 2],
    ) -> Self {
        let mode = (0..q0.len()).map(|i| Amplitudes {
            q: (u_q[i], v_q[i]),
            p: (u_p[i], v_p[i]),
        });
        FourierLoop {
            modes: vec![mode.collect()],
            q0,
            p0,
            winding: None,
        }
    }

    /// Writes dγ/ds at `s[k]` into sample k of `block`, as [`sample`](Loop::sample) writes γ.
    pub(crate) fn velocity(&self, s: &[f64], block: &mut Block<'_>) {
        block.q.fill(0.0);
        block.p.fill(0.0);
        if let Some((dof, period)) = self.winding {
            block.q.row_mut(dof).fill(period);
        }
        self.add_modes(s, block, |mode, (of_cos, of_sin)| {
            let rate = TAU * mode as f64;
            (rate * of_sin, -rate * of_cos)
        });
    }

    /// Adds all modes at `s`, with the amplitudes of cosine and sine that `amplitudes` makes of those of a mode m.
    fn add_modes(
        &self,
        s: &[f64],
        block: &mut Block<'_>,
        amplitudes: impl Fn(usize, (f64, f64)) -> (f64, f64),
    ) {
        let n = s.len();
        scratch::with_buffer(2 * n, |buffer| {
            let (sin, cos) = buffer.split_at_mut(n);
            for (m, mode) in self.modes.iter().enumerate() {
                for (k, &s) in s.iter().enumerate() {
                    (sin[k], cos[k]) = sin_cos_turn((m + 1) as f64 * s);
                }
                for (i, of_dof) in mode.iter().enumerate() {
                    let rows = [
                        (block.q.row_mut(i), of_dof.q),
                        (block.p.row_mut(i), of_dof.p),
                    ];
                    for (row, of_row) in rows {
                        let (of_cos, of_sin) = amplitudes(m + 1, of_row);
                        for k in 0..n {
                            row[k] += of_cos * cos[k] + of_sin * sin[k];
                        }
                    }
                }
            }
        });
    }

    /// The same loop, but for position `dof`, which gains `period` on the way round: of a map that knows it
    /// as a period, a closed loop that cannot be contracted.
    ///
    /// # Errors
    /// If the loop has fewer degrees of freedom, or the period is not positive and finite.
    pub fn winding(mut self, dof: usize, period: f64) -> Result<Self, Error> {
        let count = self.q0.len();
        if dof >= count {
            return Err(Error::NoSuchDof { dof, count });
        }
        if !(period.is_finite() && period > 0.0) {
            return Err(Error::OutOfRange {
                what: "period that the loop winds round",
                value: period,
                remedy: "give a positive finite period",
            });
        }
        self.winding = Some((dof, period));
        Ok(self)
    }
}

impl Loop for FourierLoop {
    fn dof(&self) -> usize {
        self.q0.len()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for i in 0..self.dof() {
            block.q.row_mut(i).fill(self.q0[i]);
            block.p.row_mut(i).fill(self.p0[i]);
        }
        if let Some((dof, period)) = self.winding {
            for (q, s) in block.q.row_mut(dof).iter_mut().zip(s) {
                *q += period * s;
            }
        }
        self.add_modes(s, block, |_, amplitudes| amplitudes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::{LoopIntegral, Rule};
    use crate::state::Coordinates;
    use crate::state::Ensemble;
    use std::f64::consts::PI;

    fn random(seed: u64) -> FourierLoop {
        let ones = [1.0; 3];
        FourierLoop::random(vec![5.0; 3], vec![-1.0; 3], &ones, &ones, seed).unwrap()
    }

    #[test]
    fn the_integral_is_the_sum_of_the_modes() {
        let phase_loop = random(11);
        // ∮ p dq of modes a cos + b sin: π m (p_cos q_sin − p_sin q_cos).
        let exact: f64 = (phase_loop.modes.iter().enumerate())
            .map(|(m, mode)| {
                let sum: f64 = mode.iter().map(|a| a.p.0 * a.q.1 - a.p.1 * a.q.0).sum();
                PI * (m + 1) as f64 * sum
            })
            .sum();
        let ensemble = Ensemble::sample(&phase_loop, 16).unwrap();
        let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
        assert!((integral.value - exact).abs() < 1e-14);
        assert!(integral.contributions.iter().all(|&area| area > 0.06 * PI));
    }

    #[test]
    fn winding_adds_the_period_times_the_mean_momentum() {
        let integral = |phase_loop: &FourierLoop| {
            let ensemble = Ensemble::sample(phase_loop, 16).unwrap();
            let coordinates = Coordinates::plain(3)
                .with_periods(vec![0.0, 20.0, 0.0])
                .unwrap();
            LoopIntegral::in_coordinates(&ensemble, &Rule::Pseudospectral, &coordinates).unwrap()
        };
        let winding = random(11).winding(1, 20.0).unwrap();
        let gained = integral(&winding).value - integral(&random(11)).value;
        // The centre is at p = −1; ∮ p dq of the ramp is the period times the mean of p.
        assert!((gained + 20.0).abs() < 1e-13, "{gained}");
        assert!(random(11).winding(3, 20.0).is_err());
        assert!(random(11).winding(0, 0.0).is_err());
    }

    #[test]
    fn the_velocity_is_the_derivative() {
        let phase_loop = random(7).winding(1, 20.0).unwrap();
        let at = |s: f64| {
            let mut state = Ensemble::zeros(3, 1);
            phase_loop.sample(&[s], &mut state.block());
            state
        };
        let mut velocity = Ensemble::zeros(3, 1);
        phase_loop.velocity(&[0.3], &mut velocity.block());
        let (ahead, behind) = (at(0.3 + 1e-6), at(0.3 - 1e-6));
        for i in 0..3 {
            let of_q = (ahead.q().row(i)[0] - behind.q().row(i)[0]) / 2e-6;
            let of_p = (ahead.p().row(i)[0] - behind.p().row(i)[0]) / 2e-6;
            assert!((velocity.q().row(i)[0] - of_q).abs() < 1e-7, "{of_q}");
            assert!((velocity.p().row(i)[0] - of_p).abs() < 1e-7, "{of_p}");
        }
    }

    #[test]
    fn a_seed_is_a_loop() {
        let same = Ensemble::sample(&random(3), 8).unwrap();
        let again = Ensemble::sample(&random(3), 8).unwrap();
        let other = Ensemble::sample(&random(4), 8).unwrap();
        assert_eq!(same.q().row(2), again.q().row(2));
        assert_ne!(same.q().row(2), other.q().row(2));
    }
}
