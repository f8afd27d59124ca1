//! Where the samples of a loop look as if it were broken.

use rayon::prelude::*;

use super::fourth_difference;
use crate::signal::unwrap_row;
use crate::state::Coordinates;
use crate::state::Ensemble;

/// Which coordinate of a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coordinate {
    Q,
    P,
}

/// A stretch of four cells in which a coordinate looks discontinuous.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Suspect {
    pub dof: usize,
    pub coordinate: Coordinate,
    /// The stretch begins at this sample.
    pub first: usize,
    /// Size of the fourth difference there.
    pub difference: f64,
    /// Mean of the absolute fourth difference along the loop: its noise.
    pub noise: f64,
}

impl Suspect {
    /// The difference over its noise.
    fn outstanding(&self) -> f64 {
        self.difference / self.noise
    }
}

/// How many suspects are worth following.
const MOST: usize = 4;

/// A fourth difference this many times the mean stands out: Gaussian noise reaches 6.3 times
/// its mean in a million samples.
pub(super) const OUTSTANDING: f64 = 8.0;

/// Fourth differences below this many roundings of the coordinate are none.
const ROUNDINGS: f64 = 64.0;

/// On a smooth stretch the fourth difference grows 16-fold with twice the spacing, at a
/// kink twofold, at a jump not at all.
const STAYS: f64 = 1.0 / 1.4;

/// The most suspicious stretches, the most outstanding first.
pub(super) fn suspects(ensemble: &Ensemble, coordinates: &Coordinates) -> Vec<Suspect> {
    if ensemble.samples() < 16 {
        return Vec::new();
    }
    let mut found: Vec<Suspect> = (0..ensemble.dof())
        .into_par_iter()
        .map_init(Vec::new, |buffer, dof| {
            let q = (
                Coordinate::Q,
                ensemble.q().row(dof),
                coordinates.period(dof),
            );
            let p = (Coordinate::P, ensemble.p().row(dof), 0.0);
            [q, p].map(|(coordinate, row, period)| suspect(buffer, dof, coordinate, row, period))
        })
        .flatten_iter()
        .flatten()
        .collect();
    most_outstanding(&mut found);
    found
}

/// Keeps the most suspicious stretches, the most outstanding first.
pub(crate) fn most_outstanding(found: &mut Vec<Suspect>) {
    // A stable sort: equals stay in the order of the degrees of freedom.
    found.sort_by(|a, b| b.outstanding().total_cmp(&a.outstanding()));
    found.truncate(MOST);
}

/// Fourth differences of one coordinate round the loop, from neighbouring samples and from every second.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Roughness {
    largest: f64,
    /// The stretch of the largest begins at this sample.
    first: usize,
    sum: f64,
    wide_largest: f64,
}

impl Roughness {
    /// Adds a run of stretches: the sum of their absolute differences, the largest one, which begins at sample
    /// `first`, and the largest from every second sample.
    pub fn add(&mut self, sum: f64, (first, largest): (usize, f64), wide_largest: f64) {
        self.sum += sum;
        if largest > self.largest {
            (self.largest, self.first) = (largest, first);
        }
        self.wide_largest = self.wide_largest.max(wide_largest);
    }

    /// The stretch that looks discontinuous, if one does, after one turn of `samples` samples, none of which is
    /// larger than `magnitude`.
    pub fn suspect(
        &self,
        dof: usize,
        coordinate: Coordinate,
        samples: usize,
        magnitude: f64,
    ) -> Option<Suspect> {
        let noise = self.sum / samples as f64;
        // Rounded to a few units in the last place, a coordinate jumps all the time.
        let rounding = ROUNDINGS * f64::EPSILON * magnitude;
        let suspicious = self.largest > rounding
            && self.largest > OUTSTANDING * noise
            && self.largest > STAYS * self.wide_largest;
        suspicious.then_some(Suspect {
            dof,
            coordinate,
            first: self.first % samples,
            difference: self.largest,
            noise,
        })
    }
}

fn suspect(
    buffer: &mut Vec<f64>,
    dof: usize,
    coordinate: Coordinate,
    row: &[f64],
    period: f64,
) -> Option<Suspect> {
    let n = row.len();
    buffer.clear();
    buffer.extend_from_slice(row);
    let gain = unwrap_row(buffer, period) as f64 * period;
    // Once more round the loop, so that no stencil has to wrap.
    for k in 0..8 {
        buffer.push(buffer[k] + gain);
    }
    let x = &buffer[..];
    let mut roughness = Roughness::default();
    for k in 0..n {
        let narrow = fourth_difference([x[k], x[k + 1], x[k + 2], x[k + 3], x[k + 4]]).abs();
        let wide = fourth_difference([x[k], x[k + 2], x[k + 4], x[k + 6], x[k + 8]]).abs();
        roughness.add(narrow, (k, narrow), wide);
    }
    let magnitude = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    roughness.suspect(dof, coordinate, n, magnitude)
}
