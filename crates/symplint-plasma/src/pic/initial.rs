//! Initial states: Landau damping and the two-stream instability (Barham & Burby, section 5.2).
//!
//! Random numbers come from one seeded stream, and all functions of them from `libm`, so a
//! seed gives the same bits on every platform.

use std::f64::consts::TAU;

use super::system::Pic;
use symplint_models::ModelError;
use symplint_models::random::Uniform;

/// The meaning of a thermal velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VelocityConvention {
    /// f ∝ exp(−v²/v_th²), of variance v_th²/2: the text of Barham & Burby.
    #[default]
    Text,
    /// Variance v_th²: their published code.
    Code,
}

impl VelocityConvention {
    /// The standard deviation of a velocity component.
    pub fn standard_deviation(self, thermal_velocity: f64) -> f64 {
        match self {
            VelocityConvention::Text => thermal_velocity * std::f64::consts::FRAC_1_SQRT_2,
            VelocityConvention::Code => thermal_velocity,
        }
    }
}

/// A plasma at rest with a density wave: positions from 1 + A cos(2πkx/L), velocities normal.
///
/// In two dimensions the wave runs along the first axis; along the second, positions are uniform
/// and velocities thermal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landau {
    /// A, from −1 to 1.
    pub amplitude: f64,
    /// k: wavelengths in the box.
    pub mode: u32,
    /// v_th.
    pub thermal_velocity: f64,
    /// What v_th means.
    pub convention: VelocityConvention,
}

impl Default for Landau {
    /// A = ½, k = 1, v_th = 1, as the text defines it.
    fn default() -> Self {
        Landau {
            amplitude: 0.5,
            mode: 1,
            thermal_velocity: 1.0,
            convention: VelocityConvention::default(),
        }
    }
}

/// Two beams through each other: positions uniform, velocities normal round ±v_b, each sign with
/// probability ½, then multiplied by 1 + A sin(2πkx/L).
///
/// In two dimensions the beams run along the first axis; along the second, positions are uniform
/// and velocities thermal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoStream {
    /// v_b.
    pub beam_velocity: f64,
    /// v_th, the width of the beams.
    pub thermal_velocity: f64,
    /// A.
    pub amplitude: f64,
    /// k: wavelengths in the box.
    pub mode: u32,
    /// What v_th means.
    pub convention: VelocityConvention,
}

impl Default for TwoStream {
    /// v_b = 3, v_th = 1 as the text defines it, A = ½, k = 1.
    fn default() -> Self {
        TwoStream {
            beam_velocity: 3.0,
            thermal_velocity: 1.0,
            amplitude: 0.5,
            mode: 1,
            convention: VelocityConvention::default(),
        }
    }
}

impl Landau {
    /// Positions and velocities of the particles of `pic`, drawn with `seed`.
    ///
    /// # Errors
    /// If the amplitude exceeds 1, the mode is 0, or the thermal velocity is negative or not
    /// finite.
    pub fn sample<const D: usize>(
        &self,
        pic: &Pic<D>,
        seed: u64,
    ) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        self.sample_box::<D>(pic.particles(), pic.length(), seed)
    }

    /// The same for any `particles` in a box of `D` axes of the given length.
    ///
    /// # Errors
    /// As [`sample`](Self::sample).
    pub fn sample_box<const D: usize>(
        &self,
        particles: usize,
        length: f64,
        seed: u64,
    ) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        let (amplitude, mode) = (self.amplitude, check_mode(self.mode)?);
        if !(-1.0..=1.0).contains(&amplitude) {
            return Err(ModelError::OutOfRange {
                what: "the amplitude of the density wave",
                value: amplitude,
                remedy: "give a number from -1 to 1, for a density cannot be negative",
            });
        }
        check_thermal_velocity(self.thermal_velocity)?;
        let deviation = self.convention.standard_deviation(self.thermal_velocity);
        let mut uniform = Uniform::from_seed(seed);
        let x = positions::<D>((particles, length), &mut uniform, |u| {
            wave_quantile(amplitude, mode, u)
        });
        let normal = Normal::from(uniform);
        let v = normal.take(x.len()).map(|z| deviation * z).collect();
        Ok((x, v))
    }
}

impl TwoStream {
    /// Positions and velocities of the particles of `pic`, drawn with `seed`.
    ///
    /// # Errors
    /// If the mode is 0, the thermal velocity is negative, or a parameter is not finite.
    pub fn sample<const D: usize>(
        &self,
        pic: &Pic<D>,
        seed: u64,
    ) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        self.sample_box::<D>(pic.particles(), pic.length(), seed)
    }

    /// The same for any `particles` in a box of `D` axes of the given length.
    ///
    /// # Errors
    /// As [`sample`](Self::sample).
    pub fn sample_box<const D: usize>(
        &self,
        particles: usize,
        length: f64,
        seed: u64,
    ) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        let mode = check_mode(self.mode)?;
        check_thermal_velocity(self.thermal_velocity)?;
        ModelError::check_finite("the velocity of the beams", self.beam_velocity)?;
        ModelError::check_finite("the amplitude of the velocity wave", self.amplitude)?;
        let deviation = self.convention.standard_deviation(self.thermal_velocity);
        let mut uniform = Uniform::from_seed(seed);
        let x = positions::<D>((particles, length), &mut uniform, |u| u);
        let beams: Vec<f64> = (uniform.by_ref().take(particles))
            .map(|u| self.beam_velocity.copysign(u - 0.5))
            .collect();
        let normal = Normal::from(uniform);
        let mut v: Vec<f64> = normal.take(x.len()).map(|z| deviation * z).collect();
        for (particle, beam) in beams.iter().enumerate() {
            let wave = libm::sin(TAU * mode * (x[D * particle] / length));
            v[D * particle] = (1.0 + self.amplitude * wave) * (beam + v[D * particle]);
        }
        Ok((x, v))
    }
}

fn check_mode(mode: u32) -> Result<f64, ModelError> {
    if mode == 0 {
        return Err(ModelError::OutOfRange {
            what: "the mode of the initial wave",
            value: 0.0,
            remedy: "give 1 or more wavelengths in the box, or an amplitude of 0 for no wave",
        });
    }
    Ok(f64::from(mode))
}

fn check_thermal_velocity(value: f64) -> Result<(), ModelError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ModelError::OutOfRange {
        what: "the thermal velocity",
        value,
        remedy: "give a finite number, 0 or more",
    })
}

/// One position after the other, all axes of a particle together; `quantile` is that of the
/// first axis, in units of the length.
fn positions<const D: usize>(
    (particles, length): (usize, f64),
    uniform: &mut Uniform,
    quantile: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let numbers = uniform.by_ref().take(D * particles).enumerate();
    numbers
        .map(|(i, u)| length * if i % D == 0 { quantile(u) } else { u })
        .collect()
}

/// The θ in [0, 1] for which θ + A sin(2πkθ) / 2πk, the distribution function of
/// 1 + A cos(2πkθ), is `u`.
pub(crate) fn wave_quantile(amplitude: f64, mode: f64, u: f64) -> f64 {
    // The same curve in every wavelength.
    let wavelengths = (mode * u).floor();
    let rest = mode * u - wavelengths;
    let (mut low, mut high) = (0.0, 1.0);
    let mut phase = rest;
    // Newton's method, by bisection where that leaves the interval known to hold the root.
    // Bisection alone would need 53 rounds.
    for _ in 0..100 {
        let error = phase + amplitude / TAU * libm::sin(TAU * phase) - rest;
        if error == 0.0 {
            break;
        }
        if error > 0.0 {
            high = phase;
        } else {
            low = phase;
        }
        let newton = phase - error / (1.0 + amplitude * libm::cos(TAU * phase));
        let next = if low < newton && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if next == phase {
            break;
        }
        phase = next;
    }
    (wavelengths + phase) / mode
}

/// Normal random numbers of variance 1, two from two uniform ones (Box & Muller 1958).
struct Normal {
    uniform: Uniform,
    second: Option<f64>,
}

impl From<Uniform> for Normal {
    fn from(uniform: Uniform) -> Self {
        Normal {
            uniform,
            second: None,
        }
    }
}

impl Iterator for Normal {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        if let Some(second) = self.second.take() {
            return Some(second);
        }
        // In (0, 1], where the logarithm is finite.
        let distance = 1.0 - self.uniform.next()?;
        let angle = TAU * self.uniform.next()?;
        let radius = libm::sqrt(-2.0 * libm::log(distance));
        self.second = Some(radius * libm::sin(angle));
        Some(radius * libm::cos(angle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quantile_inverts_the_distribution() {
        for amplitude in [0.0, 0.5, -0.5, 0.999, 1.0, -1.0] {
            for mode in [1.0, 2.0, 7.0] {
                let mut last = 0.0;
                for step in 0..=1000 {
                    let u = f64::from(step) / 1000.0;
                    let theta = wave_quantile(amplitude, mode, u);
                    let k = TAU * mode;
                    let back = theta + amplitude * (k * theta).sin() / k;
                    assert!((back - u).abs() < 1e-15, "{amplitude}, {mode}, {u}: {back}");
                    assert!((last..=1.0).contains(&theta));
                    last = theta;
                }
            }
        }
    }

    #[test]
    fn normal_numbers_have_the_moments_of_the_normal_distribution() {
        let numbers: Vec<f64> = Normal::from(Uniform::from_seed(3)).take(100_000).collect();
        let moment = |n: i32| numbers.iter().map(|z| z.powi(n)).sum::<f64>() / 1e5;
        // Five standard deviations of each estimate: √(E z^2n − (E z^n)²) / √N.
        for (n, expected, spread) in [
            (1, 0.0, 1.0_f64),
            (2, 1.0, 2.0),
            (3, 0.0, 15.0),
            (4, 3.0, 96.0),
        ] {
            let off = (moment(n) - expected).abs();
            assert!(
                off < 5.0 * (spread / 1e5).sqrt(),
                "moment {n}: off by {off}"
            );
        }
        assert_eq!(wave_quantile(0.5, 1.0, 0.5), 0.5);
    }
}
