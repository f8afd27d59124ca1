//! The first check of a plasma physicist: the particle-in-cell system against linear theory.
//!
//! Not in the paper, which takes the physics of the method for granted.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde::Serialize;
use symplint::Ensemble;
use symplint_models::Separable;
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, series};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::pic::MAX_PARTICLES;
use super::settings::{Key, Settings};
use super::sweep::{least_squares, step_of};

pub const ITEM: Item = Item {
    id: "physics",
    title: "particle-in-cell against linear theory: oscillation, Landau damping, two-stream growth",
    cost: "1 s",
    keys: &[
        Key::whole_between(
            "cold_particles",
            1024,
            (100, MAX_PARTICLES),
            "number of particles of the cold plasma",
        ),
        Key::whole_between(
            "landau_particles",
            40000,
            (100, MAX_PARTICLES),
            "number of particles of the Landau-damped plasma",
        ),
        Key::whole_between(
            "beam_particles",
            4096,
            (100, MAX_PARTICLES),
            "number of particles of both beams together",
        ),
    ],
    check: None,
    run,
};

/// The amplitude of the longest wave of the density against time.
pub struct Wave {
    /// Times.
    pub times: Vec<f64>,
    /// (2/N) Σ cos(kx − phase), signed by its projection on the initial phase.
    pub amplitudes: Vec<f64>,
}

/// Spline degree, cells and step size of all runs.
const DEGREE: usize = 3;
const CELLS: usize = 64;
const STEP_SIZE: f64 = 0.05;

/// Advances a quiet start and records the wave.
fn run_wave(length: f64, x: Vec<f64>, v: Vec<f64>, until: f64) -> Result<Wave, PaperError> {
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Equal {
            particles: x.len(),
            density: 1.0,
        },
        cells: CELLS,
        length,
        degree: DEGREE,
        ..PicConfig::default()
    })?;
    let system: Arc<dyn Separable> = Arc::new(pic);
    let map = step_of("strang", "position-first", &system)?;
    let mut state = Ensemble::zeros(x.len(), 1);
    let mut block = state.block();
    for i in 0..x.len() {
        block.q.row_mut(i)[0] = x[i];
        block.p.row_mut(i)[0] = v[i];
    }
    let k = TAU / length;
    let mut wave = Wave {
        times: Vec::new(),
        amplitudes: Vec::new(),
    };
    for step in 0..=(until / STEP_SIZE).round() as usize {
        if step > 0 {
            state.advance(&*map, STEP_SIZE)?;
        }
        let q = state.q();
        let sum: f64 = (0..x.len()).map(|i| (k * q.row(i)[0]).cos()).sum();
        wave.times.push(step as f64 * STEP_SIZE);
        wave.amplitudes.push(2.0 * sum / x.len() as f64);
    }
    Ok(wave)
}

/// Position of the fraction u of the particles with density 1 + A cos kx.
fn wave_position(length: f64, amplitude: f64, u: f64) -> f64 {
    let mut phase = u;
    for _ in 0..60 {
        let error = phase + amplitude / TAU * (TAU * phase).sin() - u;
        phase -= error / (1.0 + amplitude * (TAU * phase).cos());
    }
    length * phase
}

/// Van der Corput's sequence in base 2: fills [0, 1) evenly whatever its length.
fn van_der_corput(index: usize) -> f64 {
    ((index as u64).reverse_bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Normal numbers by Box and Muller from two low-discrepancy sequences: quieter than random ones.
fn quiet_normal(index: usize) -> f64 {
    let angle = van_der_corput(index);
    let radius = (index as f64 * 0.754_877_666_246_692_7 + 0.5).fract();
    (-2.0 * (1.0 - radius).ln()).sqrt() * (TAU * angle).cos()
}

/// A cold plasma rings at ω_p = 1.
pub fn cold_plasma(particles: usize) -> Result<(Wave, f64), PaperError> {
    let length = TAU;
    let x = (0..particles)
        .map(|a| wave_position(length, 0.01, (a as f64 + 0.5) / particles as f64))
        .collect();
    let wave = run_wave(length, x, vec![0.0; particles], 40.0)?;
    // Frequency from the first and last crossing of zero.
    let crossings: Vec<f64> = (wave.times.windows(2).zip(wave.amplitudes.windows(2)))
        .filter(|(_, a)| a[0] * a[1] < 0.0)
        .map(|(t, a)| t[0] + (t[1] - t[0]) * a[0] / (a[0] - a[1]))
        .collect();
    let frequency = match crossings[..] {
        [first, .., last] => (crossings.len() - 1) as f64 * (TAU / 2.0) / (last - first),
        _ => f64::NAN,
    };
    Ok((wave, frequency))
}

/// Landau damping at kλ_D = ½: γ = −0.1533, ω = 1.4156.
pub fn landau_damping(particles: usize) -> Result<(Wave, f64), PaperError> {
    let length = 2.0 * TAU;
    let x = (0..particles)
        .map(|a| wave_position(length, 0.05, (a as f64 + 0.5) / particles as f64))
        .collect();
    let v = (1..=particles).map(quiet_normal).collect();
    let wave = run_wave(length, x, v, 12.0)?;
    // Peaks of the amplitude, by least squares; the first belongs to the transient.
    let peaks: Vec<(f64, f64)> = (wave.times.windows(3).zip(wave.amplitudes.windows(3)))
        .filter(|(_, a)| a[1].abs() > a[0].abs() && a[1].abs() >= a[2].abs())
        .map(|(t, a)| (t[1], a[1].abs().ln()))
        .collect();
    let rate = least_squares(&peaks[..peaks.len().min(5)]);
    Ok((wave, rate))
}

/// Two cold beams at the wave of fastest growth, kv = (√3/2)(ω_p/√2): γ = ω_p/(2√2).
pub fn two_stream(particles: usize) -> Result<(Wave, f64), PaperError> {
    let beam = 3.0;
    let length = TAU * beam / (0.75f64.sqrt() * 0.5f64.sqrt());
    let x = (0..particles)
        .map(|a| {
            wave_position(
                length,
                1e-4,
                ((a / 2) as f64 + 0.5) / (particles / 2) as f64,
            )
        })
        .collect();
    let v = (0..particles)
        .map(|a| if a % 2 == 0 { beam } else { -beam })
        .collect();
    let wave = run_wave(length, x, v, 30.0)?;
    let growing: Vec<(f64, f64)> = (wave.times.iter().zip(&wave.amplitudes))
        .map(|(t, a)| (*t, a.abs()))
        .filter(|(t, a)| *t > 8.0 && (1e-3..0.1).contains(a))
        .map(|(t, a)| (t, a.ln()))
        .collect();
    Ok((wave, least_squares(&growing)))
}

/// Linear theory.
const OMEGA_P: f64 = 1.0;
const LANDAU_RATE: f64 = -0.153_359_466_909;
const TWO_STREAM_RATE: f64 = 0.353_553_390_593;

/// Moments for each marker.
const MOMENTS_PER_MARKER: usize = 16;

#[derive(Serialize)]
struct Row {
    case: &'static str,
    time: f64,
    amplitude: f64,
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let cases = [
        (
            "cold plasma",
            cold_plasma(settings.count("cold_particles"))?,
            OMEGA_P,
            "rings at ω_p",
        ),
        (
            "Landau damping",
            landau_damping(settings.count("landau_particles"))?,
            LANDAU_RATE,
            "is damped at kλ_D = ½ with γ = −0.1534",
        ),
        (
            "two-stream",
            two_stream(settings.count("beam_particles"))?,
            TWO_STREAM_RATE,
            "grows at best with γ = ω_p/(2√2)",
        ),
    ];
    let mut claims = Vec::new();
    let mut panels = Vec::new();
    let mut rows = Vec::new();
    for (index, (case, (wave, measured), theory, says)) in cases.into_iter().enumerate() {
        let off = (measured / theory - 1.0).abs();
        claims.push(Claim {
            item: "physics",
            origin: Origin::Beyond,
            place: "linear theory",
            says: format!("{case}: the wave {says}"),
            measured: format!("{measured:.4}, off by {:.1}%", 100.0 * off),
            // No number where no wave could be followed.
            judgement: Judgement::of(off < 0.05).if_resolved(off.is_finite()),
        });
        let points: Vec<(f64, f64)> = (wave.times.iter().copied())
            .zip(wave.amplitudes.iter().copied())
            .collect();
        rows.extend(points.iter().map(|&(time, amplitude)| Row {
            case,
            time,
            amplitude,
        }));
        let logarithmic = index > 0;
        let largest = points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
        let measured = if logarithmic {
            let sizes = points.iter().map(|p| (p.0, p.1.abs())).collect();
            series("measured", sizes, Style::Line, 0)
        } else {
            // A line would hide the theory, which it meets everywhere.
            let some = points.iter().copied().step_by(MOMENTS_PER_MARKER).collect();
            let label = format!("measured, every {MOMENTS_PER_MARKER}th time");
            series(&label, some, Style::Points, 0)
        };
        let mut drawn = vec![measured];
        // The envelope touches the wave in the middle third, after transients and before saturation.
        let thirds = points.len() / 3;
        let ratios = points[thirds..points.len() - thirds].iter();
        let start = match logarithmic {
            true => ratios
                .map(|p| p.1.abs() * (-theory * p.0).exp())
                .fold(0.0, f64::max),
            false => points[0].1,
        };
        let law = points.iter().map(|p| {
            let wave = if logarithmic {
                (theory * p.0).exp()
            } else {
                (theory * p.0).cos()
            };
            (p.0, start.abs() * wave)
        });
        let law = law.filter(|p| p.1 <= largest).collect();
        drawn.push(series("linear theory", law, Style::Dashed, 6));
        panels.push(Panel {
            title: case.into(),
            x: axis("time t ωₚ", Scale::Linear),
            y: axis(
                "wave of the density",
                if logarithmic {
                    Scale::Log10
                } else {
                    Scale::Linear
                },
            ),
            series: drawn,
            equal_aspect: false,
        });
    }
    let figure = Figure::new(panels, 1).with_shared_legend();
    figure.save(&folder.figures(), "physics")?;
    folder.write_csv("physics.csv", &rows)?;
    Ok(claims)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cold_plasma_rings_at_the_plasma_frequency() {
        let (_, frequency) = cold_plasma(1024).unwrap();
        assert!((frequency - OMEGA_P).abs() < 0.005, "{frequency}");
    }

    #[test]
    fn waves_are_landau_damped() {
        let (_, rate) = landau_damping(40_000).unwrap();
        assert!((rate / LANDAU_RATE - 1.0).abs() < 0.05, "{rate}");
    }

    #[test]
    fn beams_are_unstable() {
        let (_, rate) = two_stream(4096).unwrap();
        assert!((rate / TWO_STREAM_RATE - 1.0).abs() < 0.05, "{rate}");
    }
}
