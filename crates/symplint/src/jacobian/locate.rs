//! Which two degrees of freedom carry the defect of a pair of tangent vectors.

use std::ops::Range;

use super::frame::Estimate;
use super::lab::{Lab, Task};
use crate::error::Error;

/// Where a defect is, and how large it is there.
pub(super) struct Located {
    pub dofs: (usize, usize),
    /// Relative to the norms of the two tangent vectors.
    pub defect: Estimate,
}

/// Halves both tangent vectors by degrees of freedom again and again and keeps the halves that carry
/// most of the defect: log₂ d rounds instead of a Jacobian of 2d columns.
///
/// `None` if the map is not differentiable in one of the directions.
pub(super) fn locate(
    lab: &mut Lab<'_>,
    place: usize,
    [u, v]: [&[f64]; 2],
) -> Result<Option<Located>, Error> {
    let dof = lab.frame.dof();
    let (mut dofs_u, mut dofs_v) = (0..dof, 0..dof);
    loop {
        let (halves_u, halves_v) = (halves(&dofs_u), halves(&dofs_v));
        let parts = (halves_u.iter().map(|half| part(u, half)))
            .chain(halves_v.iter().map(|half| part(v, half)));
        let task = Task {
            place,
            directions: parts.collect(),
        };
        let tasks = [task];
        let derivatives = lab.derivatives(&tasks)?.remove(0);
        if derivatives.iter().any(|derivative| !derivative.converged) {
            return Ok(None);
        }
        let along: Vec<_> = (tasks[0].directions.iter().map(Vec::as_slice))
            .zip(&derivatives)
            .collect();
        let (of_u, of_v) = along.split_at(halves_u.len());
        let mut most: Option<(usize, usize, Estimate)> = None;
        for (i, &u) in of_u.iter().enumerate() {
            for (j, &v) in of_v.iter().enumerate() {
                let change = lab.frame.change_of_form(u, v);
                if most.is_none_or(|(_, _, best)| change.value.abs() > best.value.abs()) {
                    most = Some((i, j, change));
                }
            }
        }
        let Some((i, j, change)) = most else {
            return Ok(None);
        };
        dofs_u = halves_u[i].clone();
        dofs_v = halves_v[j].clone();
        if dofs_u.len() == 1 && dofs_v.len() == 1 {
            let norm = lab.frame.norm(of_u[i].0) * lab.frame.norm(of_v[j].0);
            return Ok(Some(Located {
                dofs: (dofs_u.start, dofs_v.start),
                defect: Estimate {
                    value: change.value / norm,
                    error: change.error / norm,
                },
            }));
        }
    }
}

fn halves(dofs: &Range<usize>) -> Vec<Range<usize>> {
    let middle = dofs.start + dofs.len() / 2;
    let halves = [dofs.start..middle, middle..dofs.end];
    halves.into_iter().filter(|half| !half.is_empty()).collect()
}

/// The components of a tangent vector that belong to some degrees of freedom.
fn part(vector: &[f64], dofs: &Range<usize>) -> Vec<f64> {
    let dof = vector.len() / 2;
    let keep = |(c, &x): (usize, &f64)| if dofs.contains(&(c % dof)) { x } else { 0.0 };
    vector.iter().enumerate().map(keep).collect()
}
