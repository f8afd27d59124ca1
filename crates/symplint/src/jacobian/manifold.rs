//! Tangent vectors of the manifold on which a map acts.

use super::columns::Columns;
use super::derivative::Derivative;
use super::directions::Directions;
use super::richardson::{self, LEVELS};
use super::sampler::Sampler;
use crate::error::Error;
use crate::signal::{NEGLIGIBLE, nearest};
use crate::state::{Block, Ensemble, coordinate, coordinate_mut};

impl Sampler<'_> {
    /// Columns along these directions at a point; if the map acts on a manifold, along tangent vectors of it: a basis
    /// of the tangent space if the directions are all unit vectors, else the directions projected.
    pub(super) fn columns(
        &self,
        point: usize,
        directions: Directions,
        full: bool,
    ) -> Result<Columns, Error> {
        if self.evaluator.constraint().is_none() {
            return Ok(Columns::new(point, directions));
        }
        let projected = (directions.vectors.iter())
            .map(|direction| self.projected(point, direction))
            .collect::<Result<Vec<Derivative>, Error>>()?;
        let tangents = match full {
            true => self.basis(projected),
            false => projected.iter().map(Derivative::to_unit_size).collect(),
        };
        let (vectors, errors): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (tangents.into_iter())
            .map(|tangent| (tangent.value, tangent.error))
            .unzip();
        let groups = match full {
            // They mix the degrees of freedom.
            true => vec![0; vectors.len()],
            false => directions.groups,
        };
        Ok(Columns {
            direction_errors: errors,
            ..Columns::new(point, Directions { vectors, groups })
        })
    }

    /// The derivative of the projection along a direction.
    fn projected(&self, point: usize, direction: &[f64]) -> Result<Derivative, Error> {
        let distances: Vec<f64> = richardson::displacements(0..LEVELS).collect();
        let mut states = Ensemble::zeros(self.frame.dof(), distances.len());
        self.fill(&mut states.block(), |k| (point, direction, distances[k]));
        states.check_finite(None)?;
        Ok(richardson::derivative(self.coordinates(), LEVELS, |c| {
            let (from, size) = (coordinate(&self.before, c)[point], self.frame.size[c]);
            let mut differences = [0.0; richardson::STATES];
            for (difference, value) in differences.iter_mut().zip(coordinate(&states, c)) {
                *difference = nearest(value - from, self.frame.period[c]) / size;
            }
            (differences, 2.0 * f64::EPSILON * from.abs() / size)
        }))
    }

    /// A basis of the space that these vectors span, orthogonal in the norm of the frame (Gram–Schmidt with pivoting).
    fn basis(&self, mut left: Vec<Derivative>) -> Vec<Derivative> {
        let norm = |vector: &Derivative| self.frame.norm(&vector.value);
        let of_units: Vec<f64> = left.iter().map(norm).collect();
        let largest = of_units.into_iter().fold(0.0, f64::max);
        let mut basis: Vec<Derivative> = Vec::new();
        // If a vector depends on the others, only its error is left.
        while let Some(pivot) = (0..left.len())
            .max_by(|&a, &b| norm(&left[a]).total_cmp(&norm(&left[b])))
            .filter(|&pivot| norm(&left[pivot]) > NEGLIGIBLE * largest)
        {
            let taken = left.swap_remove(pivot);
            let squared = norm(&taken).powi(2);
            for other in &mut left {
                let part = self.frame.inner(&taken.value, &other.value) / squared;
                *other = Derivative::combined(&[(1.0, other), (-part, &taken)]);
            }
            basis.push(taken.to_unit_size());
        }
        basis
    }

    /// Writes states displaced by a distance along a direction from a point, all three told by the sample, and puts
    /// them on the manifold.
    pub(super) fn fill<'d>(
        &self,
        block: &mut Block<'_>,
        at: impl Fn(usize) -> (usize, &'d [f64], f64),
    ) {
        for c in 0..self.coordinates() {
            let (from, size) = (coordinate(&self.before, c), self.frame.size[c]);
            for (k, value) in coordinate_mut(block, c).iter_mut().enumerate() {
                let (point, direction, distance) = at(k);
                *value = from[point] + distance * direction[c] * size;
            }
        }
        if let Some(constraint) = self.evaluator.constraint() {
            constraint.project(block);
        }
    }
}
