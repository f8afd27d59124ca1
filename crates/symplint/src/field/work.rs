//! The loop integral of a force with its error, from as many samples as it needs.

use super::evidence::{FieldLoopKind, LoopWork};
use super::integrand::{Integrand, Moments};
use super::limits::{BISECTIONS, MAX_ROUNDING_NOISE, MIN_JUMP_OVER_CHANGE, ROUNDINGS_OF_TERMS};
use super::spectrum::Spectrum;
use crate::error::Error;
use crate::loops::FourierLoop;
use crate::signal::SIGNIFICANT;
use crate::signal::noise::SAFETY;

/// How exactly the power is known on one loop.
#[derive(Clone, Copy)]
pub(super) struct PowerAccuracy {
    /// The standard deviation over short distances.
    pub noise: f64,
    /// The largest difference of repeated evaluations.
    pub repetitions: f64,
    /// The speed of the loop, and the size of the form on it.
    pub on: [f64; 2],
}

impl PowerAccuracy {
    /// How many times as large noise is on a loop of these moments.
    fn factor(&self, moments: &Moments) -> f64 {
        let [speed, size] = self.on;
        let of_size = match size > 0.0 {
            true => (moments.size() / size).max(1.0),
            false => 1.0,
        };
        moments.speed() / speed * of_size
    }
}

/// What noise and rounding leave uncertain.
struct Noise {
    of_integral: f64,
    /// The quadrature error that noise of the samples shows.
    of_samples: f64,
}

/// How far a loop may be refined.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Samples at most.
    pub samples: usize,
    /// Evaluations at most, apart from the first.
    pub evaluations: usize,
    /// Whether twice as many samples have to confirm that an integral is not zero: no other loop has shown it yet.
    pub confirms: bool,
}

/// A loop that is being integrated.
pub(super) struct Integration<'a> {
    integrand: &'a Integrand<'a>,
    phase_loop: &'a FourierLoop,
    pub power: Vec<f64>,
    pub moments: Moments,
}

impl<'a> Integration<'a> {
    /// Of the first samples.
    ///
    /// # Errors
    /// Those of the force.
    pub fn begin(
        integrand: &'a Integrand<'a>,
        phase_loop: &'a FourierLoop,
        samples: usize,
    ) -> Result<Self, Error> {
        let mut moments = Moments::default();
        let s: Vec<f64> = (0..samples).map(|k| k as f64 / samples as f64).collect();
        let power = integrand.power(phase_loop, &s, None, Some(&mut moments))?;
        Ok(Integration {
            integrand,
            phase_loop,
            power,
            moments,
        })
    }

    /// Twice as many samples.
    fn double(&mut self) -> Result<(), Error> {
        let count = self.power.len();
        let s: Vec<f64> = (0..count)
            .map(|k| (2 * k + 1) as f64 / (2 * count) as f64)
            .collect();
        let moments = Some(&mut self.moments);
        let between = self.integrand.power(self.phase_loop, &s, None, moments)?;
        let pairs = self.power.iter().zip(&between);
        self.power = pairs.flat_map(|(a, b)| [*a, *b]).collect();
        Ok(())
    }

    /// Doubles samples until the error is that of rounding and noise, and once more where the integral is not zero: samples in
    /// between have to confirm that.
    ///
    /// # Errors
    /// Those of the force.
    pub fn finish(
        mut self,
        kind: FieldLoopKind,
        known: PowerAccuracy,
        limits: Limits,
    ) -> Result<LoopWork, Error> {
        let mut made = 0;
        let mut confirmed = !limits.confirms;
        let (spectrum, noise) = loop {
            let spectrum = Spectrum::of(&self.power);
            let noise = self.noise(known, &spectrum);
            let is_resolved = spectrum.error() <= noise.of_samples;
            let noise = noise.of_integral;
            let is_zero = spectrum.mean.abs() <= SIGNIFICANT * (spectrum.error() + noise);
            let count = self.power.len();
            if (is_resolved && (is_zero || confirmed))
                || count >= limits.samples
                || made + count > limits.evaluations
                || self.integrand.evaluator.count().left() < count
            {
                break (spectrum, noise);
            }
            made += count;
            confirmed |= is_resolved && !is_zero;
            self.double()?;
        };
        self.work(kind, &spectrum, noise, known)
    }

    fn noise(&self, known: PowerAccuracy, spectrum: &Spectrum) -> Noise {
        let terms = f64::EPSILON * self.moments.terms();
        let rounding = ROUNDINGS_OF_TERMS * (terms + f64::EPSILON * spectrum.mean.abs());
        let factor = known.factor(&self.moments);
        let noise = factor * known.noise;
        let independent = noise / (self.power.len() as f64).sqrt();
        let of_integral = match noise <= MAX_ROUNDING_NOISE * terms {
            true => independent,
            // That of single precision or of a solver need not average out.
            false => noise,
        };
        let rest = factor * known.repetitions + rounding;
        Noise {
            of_integral: SAFETY * of_integral + rest,
            of_samples: SAFETY * of_integral.max(SAFETY * independent) + rest,
        }
    }

    /// The size of the integral if the force had no gradient in it.
    fn scale(&self, kind: FieldLoopKind) -> f64 {
        let moments = &self.moments;
        let moving = self.integrand.moving().max(1) as f64;
        match kind {
            // Relative to the work that a force of constant size does around the period.
            FieldLoopKind::Winding { .. } => moments.size() * moments.speed(),
            FieldLoopKind::Coordinates { .. } => moments.deviation() * moments.speed(),
            // Of a random loop in n coordinates, one part in √n.
            FieldLoopKind::Random | FieldLoopKind::Directions => {
                moments.deviation() * moments.speed() / moving.sqrt()
            }
        }
    }

    fn work(
        &self,
        kind: FieldLoopKind,
        spectrum: &Spectrum,
        noise: f64,
        known: PowerAccuracy,
    ) -> Result<LoopWork, Error> {
        let moments = &self.moments;
        let is_resolved = spectrum.error() <= self.noise(known, spectrum).of_samples;
        let jumps = (!is_resolved).then(|| spectrum.jumps()).flatten();
        let error = spectrum.error() + noise;
        let (mut jump_at, mut is_steep) = (None, false);
        if jumps.is_some() && spectrum.mean.abs() > SIGNIFICANT * error {
            match self.follow_jump(spectrum)? {
                Some(s) => jump_at = Some(s),
                None => is_steep = true,
            }
        }
        let unit = self.integrand.unit;
        Ok(LoopWork {
            kind,
            samples: self.power.len(),
            integral: unit * spectrum.mean,
            quadrature_error: unit * spectrum.error(),
            noise: unit * noise,
            scale: unit * self.scale(kind),
            is_constant: moments.deviation() <= ROUNDINGS_OF_TERMS * f64::EPSILON * moments.size(),
            is_resolved,
            jumps: jumps.map(|size| unit * size),
            jump_at,
            is_steep,
            action: moments.action(),
        })
    }

    /// Bisects the largest change between two samples that is not one of the lower modes: its s, if it does not vanish as a steep part
    /// of the force does.
    fn follow_jump(&self, spectrum: &Spectrum) -> Result<Option<f64>, Error> {
        let count = self.power.len();
        let at = |k: usize| k as f64 / count as f64;
        let smoothed = spectrum.smoothed_samples(count);
        let pairs = self.power.iter().zip(&smoothed);
        let mut rest: Vec<f64> = pairs.map(|(power, smoothed)| power - smoothed).collect();
        rest.push(rest[0]);
        let change = |k: usize| (rest[k + 1] - rest[k]).abs();
        let Some(largest) = (0..count).max_by(|&a, &b| change(a).total_cmp(&change(b))) else {
            return Ok(None);
        };
        let ends = [rest[largest], rest[largest + 1]];
        let whole = change(largest);
        let (mut low, mut high) = (at(largest), at(largest + 1));
        let [mut of_low, mut of_high] = ends;
        for _ in 0..BISECTIONS {
            if self.integrand.evaluator.count().left() == 0 {
                return Ok(None);
            }
            let middle = 0.5 * (low + high);
            let power = self
                .integrand
                .power(self.phase_loop, &[middle], None, None)?[0];
            let of_middle = power - spectrum.smoothed(middle);
            // A spike between the samples is a steep part of the potential.
            if ends.iter().all(|end| (of_middle - end).abs() > 2.0 * whole) {
                return Ok(None);
            }
            match (of_middle - of_low).abs() > (of_high - of_middle).abs() {
                true => (high, of_high) = (middle, of_middle),
                false => (low, of_low) = (middle, of_middle),
            }
        }
        let is_jump = (of_high - of_low).abs() > MIN_JUMP_OVER_CHANGE * whole;
        Ok(is_jump.then_some(low))
    }
}
