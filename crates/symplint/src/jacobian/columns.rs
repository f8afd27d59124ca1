//! Columns of the Jacobian at one point: derivatives of the step along tangent vectors.

use super::derivative::Derivative;
use super::directions::{self, Directions};
use super::evidence::{JacobianPoint, TangentDefect};
use super::frame::Estimate;
use super::sampler::Sampler;
use super::volume::PointVolume;
use crate::state::{coordinate, in_parallel};

/// Tangent vectors at a point, in units of the frame, and the derivatives along them once they are measured.
pub(super) struct Columns {
    /// Index of the point.
    pub point: usize,
    /// No component beyond ±1.
    pub directions: Vec<Vec<f64>>,
    /// The group of degrees of freedom that each direction belongs to.
    pub groups: Vec<usize>,
    /// Half the width of the interval in which each component of a direction lies, on a manifold; else none.
    pub direction_errors: Vec<Vec<f64>>,
    pub derivatives: Vec<Derivative>,
}

/// The columns at a point.
pub(super) struct Outcome {
    pub point: JacobianPoint,
    /// The two tangent vectors that have the worst defect.
    pub pair: (usize, usize),
    /// What no pair of each group exceeds, its uncertainty included; `None` for a group without pairs.
    pub bounds: Vec<Option<f64>>,
    /// What all unit vectors together show.
    pub volume: Option<PointVolume>,
    /// Largest change of a component; 0 where the derivatives did not converge.
    pub deformation: f64,
}

/// The images of tangent vectors under the derivative of a step at one point, in units of the loop.
pub(crate) struct TangentImages {
    pub vectors: Vec<Vec<f64>>,
    pub images: Vec<Vec<f64>>,
    /// Half the width of the interval in which each component of an image lies.
    pub errors: Vec<Vec<f64>>,
    /// The positions before and after the step, from the origin.
    pub positions: [Vec<f64>; 2],
}

impl Columns {
    /// The measurement; `None` if the map is not differentiable at the point.
    pub fn images(&self, sampler: &Sampler<'_>) -> Option<TangentImages> {
        let converged = self.derivatives.iter().all(|of| of.converged);
        let of_each = |field: fn(&Derivative) -> &Vec<f64>| {
            let values = self.derivatives.iter().map(field);
            values.cloned().collect::<Vec<_>>()
        };
        let positions = |state: &dyn Fn(usize) -> f64| {
            let positions = 0..sampler.frame.dof();
            positions
                .map(|c| state(c) / sampler.frame.size[c])
                .collect()
        };
        converged.then(|| TangentImages {
            positions: [
                positions(&|c| coordinate(&sampler.before, c)[self.point]),
                positions(&|c| sampler.after[self.point][c]),
            ],
            vectors: self.directions.clone(),
            images: of_each(|of| &of.value),
            errors: of_each(|of| &of.error),
        })
    }

    /// Not measured yet.
    pub fn new(point: usize, directions: Directions) -> Self {
        Columns {
            point,
            directions: directions.vectors,
            groups: directions.groups,
            direction_errors: Vec::new(),
            derivatives: Vec::new(),
        }
    }

    /// A combination of all tangent vectors whose largest component is 1, with seeded coefficients that do not
    /// vanish, and the derivative along it.
    pub fn combined(&self, seed: u64) -> (Vec<f64>, Derivative) {
        let coefficients = directions::dense(self.directions.len(), seed);
        let component = |c: usize| -> f64 {
            let terms = coefficients.iter().zip(&self.directions);
            terms.map(|(a, direction)| a * direction[c]).sum()
        };
        let direction: Vec<f64> = (0..self.directions[0].len()).map(component).collect();
        let largest = direction.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let terms = coefficients
            .iter()
            .map(|a| a / largest)
            .zip(&self.derivatives);
        let derivative = Derivative::combined(&terms.collect::<Vec<_>>());
        (direction.iter().map(|x| x / largest).collect(), derivative)
    }

    /// The change of the form on every two of the tangent vectors; they are unit vectors if `full`.
    /// Random vectors make pairs within their group.
    pub fn outcome(&self, sampler: &Sampler<'_>, full: bool) -> Outcome {
        let (frame, s) = (&sampler.frame, sampler.s[self.point]);
        let count = self.directions.len();
        let of_one_group = |&(i, j): &(usize, usize)| self.groups[i] == self.groups[j];
        let pairs: Vec<(usize, usize)> = (0..count)
            .flat_map(|i| (i + 1..count).map(move |j| (i, j)))
            .filter(|pair| full || of_one_group(pair))
            .collect();
        let defect = |&(i, j): &(usize, usize)| {
            let (u, v) = (&self.directions[i], &self.directions[j]);
            let (of_u, of_v) = (&self.derivatives[i], &self.derivatives[j]);
            let Estimate { value, mut error } = frame.change_of_form((u, of_u), (v, of_v));
            let errors = [i, j].map(|k| self.direction_errors.get(k));
            if let [Some(error_u), Some(error_v)] = errors {
                error += frame.error_of_form((u, error_u), (v, error_v));
            }
            let norm = frame.norm(u) * frame.norm(v);
            TangentDefect {
                s,
                signed: value / norm,
                uncertainty: error / norm,
                dofs: full.then(|| (frame.dof_of(i), frame.dof_of(j))),
            }
        };
        let defects = in_parallel(&pairs, 4 * frame.dof(), defect);
        let converged = self
            .derivatives
            .iter()
            .all(|derivative| derivative.converged);
        // Beyond the range of double precision no form can be found.
        if !converged || defects.iter().any(|defect| !defect.bound().is_finite()) {
            let (worst, bound) = (None, None);
            return Outcome {
                point: JacobianPoint { s, worst, bound },
                pair: (0, 0),
                bounds: Vec::new(),
                volume: None,
                deformation: 0.0,
            };
        }
        let method = sampler.method();
        let worst = TangentDefect::worst(method, defects.iter().copied());
        let changes: Vec<_> = (pairs.iter().copied().zip(defects.iter().copied())).collect();
        let volume = full.then(|| PointVolume::new(method, &self.derivatives, &changes, frame));
        let groups = self.groups.iter().max().map_or(0, |last| last + 1);
        let mut bounds: Vec<Option<f64>> = vec![None; groups];
        for (pair, defect) in pairs.iter().zip(&defects) {
            // Forms between a large group and a small one are known to the error of the large one alone.
            if of_one_group(pair) {
                let bound = &mut bounds[self.groups[pair.0]];
                *bound = Some(bound.map_or(defect.bound(), |bound| bound.max(defect.bound())));
            }
        }
        let of_worst = defects.iter().position(|defect| Some(*defect) == worst);
        let changes = self
            .directions
            .iter()
            .zip(&self.derivatives)
            .flat_map(|(u, of_u)| {
                let components = u.iter().zip(&of_u.value);
                components.map(|(u, of_u)| (of_u - u).abs())
            });
        Outcome {
            point: JacobianPoint {
                s,
                worst,
                bound: bounds.first().copied().flatten(),
            },
            bounds,
            volume: volume.flatten(),
            pair: pairs[of_worst.unwrap_or(0)],
            deformation: changes.fold(0.0, f64::max),
        }
    }
}
