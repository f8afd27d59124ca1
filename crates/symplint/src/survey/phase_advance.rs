//! The phase advance of a step: by how much it turns the fastest motion.

use crate::error::Error;
use crate::map::Evaluator;
use crate::rules::Subject;
use crate::signal::{Extent, nearest, unwrap_row};
use crate::state::{Ensemble, coordinate, coordinate_mut, period};

/// States of the loop at which it is estimated; the median counts, as a break beside one of them looks like a very
/// fast motion.
const POINTS: usize = 3;

/// Arnoldi steps at each of them: as many as the phase space has dimensions, and no more than this. The largest
/// eigenvalues come first.
const MOST_STEPS: usize = 6;

/// Distance of central differences, in units of half the range of a coordinate on the loop: truncation of smooth maps
/// is below 1e-4, and so is the noise of single precision.
const DISTANCE: f64 = 1.0 / 256.0;

/// A new direction this much smaller than what the map made of the last one is rounding.
const BREAKDOWN: f64 = 1e-6;

/// Samples of the loop whose ranges are the units.
const SAMPLES: usize = 32;

/// The spectral radius of DΦ − 1 on the loop: 0 for a free flight or a kick, 2 sin(hω/2) for an oscillation of
/// frequency ω, the same in all units.
///
/// From Jacobian–vector products by Arnoldi's method (Saad, "Numerical Methods for Large Eigenvalue Problems",
/// section 6.2). `None` where it is not a number.
///
/// # Errors
/// Those of the map, which need not be defined beside the loop.
pub(crate) fn phase_advance(subject: Subject<'_>, h: f64) -> Result<Option<f64>, Error> {
    let dof = subject.dof();
    let s: Vec<f64> = (0..POINTS)
        .map(|k| (k as f64 + 0.31) / POINTS as f64)
        .collect();
    let mut centres = Ensemble::zeros(dof, POINTS);
    subject.phase_loop.sample(&s, &mut centres.block());
    let step = Differences {
        evaluator: subject.evaluator,
        units: units(subject)?,
        centres,
        h,
    };
    let mut spaces: Vec<Krylov> = (0..POINTS).map(|_| Krylov::new(2 * dof)).collect();
    for _ in 0..MOST_STEPS.min(2 * dof) {
        let open: Vec<usize> = (0..POINTS).filter(|&k| !spaces[k].complete).collect();
        let last = open.iter().map(|&k| (k, spaces[k].last())).collect();
        for (k, image) in open.into_iter().zip(step.images(last)?) {
            spaces[k].extend(image);
        }
    }
    let mut radii: Vec<f64> = (spaces.iter())
        .filter_map(|space| spectral_radius(space.projected()))
        .collect();
    radii.sort_by(f64::total_cmp);
    Ok(radii.get(radii.len() / 2).copied())
}

/// Half the range of each coordinate on the loop; of one at rest, the largest of its kind.
fn units(subject: Subject<'_>) -> Result<Vec<f64>, Error> {
    let dof = subject.dof();
    let samples = Ensemble::sample(subject.phase_loop, SAMPLES)?;
    let mut units: Vec<f64> = (0..2 * dof)
        .map(|c| {
            let mut row = coordinate(&samples, c).to_vec();
            unwrap_row(&mut row, period(subject.coordinates(), c));
            0.5 * Extent::of(&row).length()
        })
        .collect();
    for kind in units.chunks_mut(dof) {
        let largest = kind.iter().copied().fold(0.0, f64::max);
        for unit in kind.iter_mut().filter(|unit| **unit == 0.0) {
            *unit = if largest > 0.0 { largest } else { 1.0 };
        }
    }
    Ok(units)
}

/// Central differences of a step.
struct Differences<'a> {
    evaluator: &'a Evaluator<'a>,
    units: Vec<f64>,
    centres: Ensemble,
    h: f64,
}

impl Differences<'_> {
    /// (DΦ − 1) v for each point with its v.
    fn images(&self, vectors: Vec<(usize, &[f64])>) -> Result<Vec<Vec<f64>>, Error> {
        let dof = self.centres.dof();
        let mut states = Ensemble::zeros(dof, 2 * vectors.len());
        let mut block = states.block();
        for c in 0..2 * dof {
            let (centres, unit) = (coordinate(&self.centres, c), self.units[c]);
            let row = coordinate_mut(&mut block, c);
            for ((point, vector), pair) in vectors.iter().zip(row.chunks_exact_mut(2)) {
                let by = DISTANCE * vector[c] * unit;
                pair.copy_from_slice(&[centres[*point] + by, centres[*point] - by]);
            }
        }
        self.evaluator.advance(&mut states, self.h)?;
        let image = |k: usize, vector: &[f64]| {
            let of = |c: usize| {
                let row = coordinate(&states, c);
                let period = period(self.evaluator.coordinates(), c);
                let apart = nearest(row[2 * k] - row[2 * k + 1], period);
                apart / (2.0 * DISTANCE * self.units[c]) - vector[c]
            };
            (0..2 * dof).map(of).collect()
        };
        let vectors = vectors.iter().enumerate();
        Ok(vectors.map(|(k, (_, vector))| image(k, vector)).collect())
    }
}

/// A Krylov space with an orthonormal basis, and the map projected on it.
struct Krylov {
    basis: Vec<Vec<f64>>,
    /// Columns of the Hessenberg matrix.
    columns: Vec<Vec<f64>>,
    /// Whether the space is mapped into itself.
    complete: bool,
}

impl Krylov {
    /// Of one vector in which no coordinate is singled out.
    fn new(dimensions: usize) -> Self {
        let vector = (0..dimensions).map(|c| (1.0 + 2.4 * c as f64).sin());
        let mut first: Vec<f64> = vector.collect();
        normalise(&mut first);
        Krylov {
            basis: vec![first],
            columns: Vec::new(),
            complete: false,
        }
    }

    fn last(&self) -> &[f64] {
        &self.basis[self.basis.len() - 1]
    }

    /// Takes in the image of the last vector of the basis.
    fn extend(&mut self, mut image: Vec<f64>) {
        let size = dot(&image, &image).sqrt();
        let mut column = Vec::with_capacity(self.basis.len() + 1);
        for vector in &self.basis {
            let part = dot(vector, &image);
            (image.iter_mut().zip(vector)).for_each(|(x, v)| *x -= part * v);
            column.push(part);
        }
        let rest = normalise(&mut image);
        // Not `rest <= …`: what is not a number ends it, too.
        self.complete = !(rest > BREAKDOWN * size) || self.basis.len() == image.len();
        if !self.complete {
            column.push(rest);
            self.basis.push(image);
        }
        self.columns.push(column);
    }

    /// The square matrix of the map on the space without its last vector.
    fn projected(&self) -> Vec<Vec<f64>> {
        let n = self.columns.len();
        let entry = |i: usize, k: usize| self.columns[k].get(i).copied().unwrap_or(0.0);
        (0..n)
            .map(|i| (0..n).map(|k| entry(i, k)).collect())
            .collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Makes its length 1, and returns what that was.
fn normalise(vector: &mut [f64]) -> f64 {
    let length = dot(vector, vector).sqrt();
    vector.iter_mut().for_each(|x| *x /= length);
    length
}

/// lim ‖Aⁿ‖^{1/n} (Gelfand), by squaring; `None` where it is not a number.
fn spectral_radius(mut matrix: Vec<Vec<f64>>) -> Option<f64> {
    /// n = 2^SQUARINGS: the limit to a few parts in a million.
    const SQUARINGS: i32 = 20;
    let mut logarithm = 0.0;
    for k in 0..=SQUARINGS {
        let norm = (matrix.iter().flatten().map(|x| x * x)).sum::<f64>().sqrt();
        if norm == 0.0 {
            return Some(0.0);
        }
        if !norm.is_finite() {
            return None;
        }
        logarithm += norm.ln() * 0.5f64.powi(k);
        matrix.iter_mut().flatten().for_each(|x| *x /= norm);
        let n = matrix.len();
        let product = |i: usize, j: usize| (0..n).map(|k| matrix[i][k] * matrix[k][j]).sum();
        matrix = (0..n)
            .map(|i| (0..n).map(|j| product(i, j)).collect())
            .collect();
    }
    Some(logarithm.exp())
}
