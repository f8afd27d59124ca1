//! Forms that are preserved to within the errors of Jacobians: a null space with errors.

use nalgebra::DMatrix;

use crate::jacobian::JacobianMethod;
use crate::signal::SIGNIFICANT;

/// Linear equations Σ_k a_rk x_k = 0 with errors of their coefficients.
pub(super) struct Equations {
    pub values: DMatrix<f64>,
    /// Half the widths of the intervals in which the coefficients lie.
    pub errors: DMatrix<f64>,
}

/// The solutions of equations.
pub(super) enum Solutions {
    /// A space of solutions.
    Space(NullSpace),
    /// No unknowns solve the equations. The residual is the smallest one of unknowns whose largest is 1.
    None { residual: f64 },
    /// The errors leave it open.
    Open,
}

/// Unknowns in given units that solve equations to within their errors.
pub(super) struct NullSpace {
    /// An orthonormal basis, one column for each vector.
    pub basis: DMatrix<f64>,
    /// The error of each unknown of a solution of length 1.
    pub errors: Vec<f64>,
}

impl Equations {
    /// The solutions, in these units of the unknowns.
    ///
    /// Rows are divided by the errors that their coefficients cause, if no unknown is beyond its unit. So a solution has no
    /// residual above 1.
    pub fn solve(&self, units: &[f64]) -> Solutions {
        let (rows, count) = self.values.shape();
        if rows < count || count == 0 {
            return Solutions::Open;
        }
        let errors: Vec<f64> = (0..rows)
            .map(|r| (0..count).map(|k| self.errors[(r, k)] * units[k]).sum())
            .collect();
        let scaled = DMatrix::from_fn(rows, count, |r, k| self.values[(r, k)] * units[k]);
        let white = DMatrix::from_fn(rows, count, |r, k| scaled[(r, k)] / errors[r]);
        if white.iter().any(|x| !x.is_finite()) {
            return Solutions::Open;
        }
        let svd = white.clone().qr().r().svd(false, true);
        let Some(vectors) = svd.v_t else {
            return Solutions::Open;
        };
        // The smallest singular value first.
        let order: Vec<usize> = (0..count).rev().collect();
        let largest_of = |matrix: &DMatrix<f64>, k: usize| {
            let vector = vectors.row(k).transpose();
            (matrix * &vector).amax() / vector.amax()
        };
        let dimension = (order.iter())
            .take_while(|&&k| largest_of(&white, k) <= 1.0)
            .count();
        let Some(&next) = order.get(dimension) else {
            return self.space(&vectors, &svd.singular_values, dimension);
        };
        if dimension == 0 {
            let bound = SIGNIFICANT * (rows as f64).sqrt();
            let residual = largest_of(&scaled, next);
            let least_change = JacobianMethod::CentralDifferences { rejected: None }.least_defect();
            return match svd.singular_values[next] > bound && residual > least_change {
                true => Solutions::None { residual },
                false => Solutions::Open,
            };
        }
        match largest_of(&white, next) > SIGNIFICANT {
            true => self.space(&vectors, &svd.singular_values, dimension),
            false => Solutions::Open,
        }
    }

    /// The space of the last few right singular vectors.
    fn space(
        &self,
        vectors: &DMatrix<f64>,
        singular: &nalgebra::DVector<f64>,
        dimension: usize,
    ) -> Solutions {
        let count = singular.len();
        let first = count - dimension;
        let error = |unknown: usize| -> f64 {
            let terms = (0..first).map(|k| (vectors[(k, unknown)] / singular[k]).powi(2));
            terms.sum::<f64>().sqrt()
        };
        Solutions::Space(NullSpace {
            basis: DMatrix::from_fn(count, dimension, |i, k| vectors[(first + k, i)]),
            errors: (0..count)
                .map(|unknown| error(unknown).max(f64::EPSILON))
                .collect(),
        })
    }

    /// Whether unknowns with errors solve all equations to within the errors.
    pub fn hold(&self, unknowns: &[f64], of_unknowns: &[f64]) -> bool {
        let (rows, count) = self.values.shape();
        (0..rows).all(|r| {
            let sum = |term: &dyn Fn(usize) -> f64| (0..count).map(term).sum::<f64>();
            let residual = sum(&|k| self.values[(r, k)] * unknowns[k]);
            let error = sum(&|k| {
                self.errors[(r, k)] * unknowns[k].abs() + self.values[(r, k)].abs() * of_unknowns[k]
            });
            residual.abs() <= error
        })
    }
}

impl NullSpace {
    /// Of a space whose vectors have no unknown in common: each unknown with its group, if every unknown belongs to one. Groups are
    /// vectors of length 1.
    pub fn groups(&self) -> Option<Vec<(usize, f64)>> {
        let (count, dimension) = self.basis.shape();
        let projector = &self.basis * self.basis.transpose();
        let mut found: Vec<Option<(usize, f64)>> = vec![None; count];
        for group in 0..dimension {
            let pivot = (0..count)
                .filter(|&i| found[i].is_none())
                .max_by(|&a, &b| projector[(a, a)].total_cmp(&projector[(b, b)]))?;
            let length = projector[(pivot, pivot)].sqrt();
            for (i, found) in found.iter_mut().enumerate() {
                let value = projector[(i, pivot)] / length;
                if found.is_none() && value.abs() > self.errors[i] {
                    *found = Some((group, value));
                }
            }
        }
        found.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn equations(rows: &[&[f64]], error: f64) -> Equations {
        let (count, unknowns) = (rows.len(), rows[0].len());
        Equations {
            values: DMatrix::from_fn(count, unknowns, |r, k| rows[r][k]),
            errors: DMatrix::from_element(count, unknowns, error),
        }
    }

    #[test]
    fn a_null_vector_has_its_components_within_its_errors() {
        // x0 : x1 : x2 = 1 : 3 : -0.5, with coefficients that are off by 1e-9.
        let rows: [&[f64]; 4] = [
            &[3.0, -1.0 + 1e-9, 0.0],
            &[0.5, 0.0, 1.0],
            &[0.0, 0.5, 3.0 - 1e-9],
            &[1.0, 1.0, 8.0],
        ];
        let Solutions::Space(space) = equations(&rows, 2e-9).solve(&[1.0, 1.0, 1.0]) else {
            panic!("no space");
        };
        assert_eq!(space.basis.ncols(), 1);
        let groups = space.groups().unwrap();
        for (k, exact) in [1.0, 3.0, -0.5].into_iter().enumerate() {
            let found = groups[k].1 / groups[0].1;
            assert!((found - exact).abs() < 10.0 * space.errors[k], "{found}");
        }
        assert!(space.errors.iter().all(|error| *error < 1e-8));
    }

    #[test]
    fn equations_without_a_solution_say_by_how_much() {
        let rows: [&[f64]; 2] = [&[1.0, 0.0], &[0.0, 1e-3]];
        let Solutions::None { residual } = equations(&rows, 1e-9).solve(&[1.0, 1.0]) else {
            panic!("a space");
        };
        assert!((residual - 1e-3).abs() < 1e-15);
        // Within ten errors nothing is said.
        let solved = equations(&rows, 1e-3 / 5.0).solve(&[1.0, 1.0]);
        assert!(matches!(solved, Solutions::Open));
    }

    #[test]
    fn uncoupled_unknowns_are_groups() {
        let rows: [&[f64]; 4] = [
            &[2.0, -1.0, 0.0, 0.0],
            &[0.0, 0.0, 1.0, 1.0],
            &[0.0, 0.0, 2.0, 2.0],
            &[4.0, -2.0, 0.0, 0.0],
        ];
        let Solutions::Space(space) = equations(&rows, 1e-12).solve(&[1.0; 4]) else {
            panic!("no space");
        };
        let groups = space.groups().unwrap();
        assert_eq!(groups[0].0, groups[1].0);
        assert_eq!(groups[2].0, groups[3].0);
        assert_ne!(groups[0].0, groups[2].0);
        assert!((groups[1].1 / groups[0].1 - 2.0).abs() < 1e-12);
        assert!((groups[3].1 / groups[2].1 + 1.0).abs() < 1e-12);
    }
}
