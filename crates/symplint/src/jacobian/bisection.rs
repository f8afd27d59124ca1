//! Which two degrees of freedom carry the defect of a pair of tangent vectors, by bisection.

use std::ops::Range;

use super::derivative::Derivative;
use super::evidence::TangentDefect;
use super::frame::Estimate;
use super::sampler::{Sampler, TangentVector};
use crate::error::Error;

/// The components of a tangent vector that belong to some degrees of freedom.
#[derive(Clone)]
struct Part {
    dofs: Range<usize>,
    vector: Vec<f64>,
    derivative: Option<Derivative>,
    /// Whether the derivative is the difference of two others.
    subtracted: bool,
}

impl Part {
    fn new(vector: &[f64], dofs: Range<usize>) -> Self {
        let dof = vector.len() / 2;
        let keep = |(c, &x): (usize, &f64)| if dofs.contains(&(c % dof)) { x } else { 0.0 };
        Part {
            vector: vector.iter().enumerate().map(keep).collect(),
            dofs,
            derivative: None,
            subtracted: false,
        }
    }

    /// The two halves, or the part itself if it is one degree of freedom.
    fn halves(&self) -> Vec<Part> {
        let Range { start, end } = self.dofs;
        if end - start == 1 {
            return vec![self.clone()];
        }
        let middle = start.midpoint(end);
        [start..middle, middle..end]
            .map(|half| Part::new(&self.vector, half))
            .to_vec()
    }
}

/// Halves both tangent vectors by degrees of freedom again and again and keeps the halves that carry
/// most of the defect: log₂ d rounds instead of a Jacobian of 2d columns. The derivative along one half of a
/// vector is measured; subtracted from that along the whole, it leaves the derivative along the other half.
///
/// `None` if the map is not differentiable in one of the directions, or there are not enough evaluations to
/// spare.
pub(super) fn locate(
    sampler: &mut Sampler<'_>,
    point: usize,
    vectors: [&[f64]; 2],
) -> Result<Option<TangentDefect>, Error> {
    let dof = sampler.frame.dof();
    // All halves of the first round, one of each vector in later ones, and both vectors at the end.
    let directions = 2 * (2 + dof.next_power_of_two().ilog2() as usize);
    if !sampler.draw(directions * sampler.cost()) {
        return Ok(None);
    }
    let mut pair = vectors.map(|vector| Part::new(vector, 0..dof));
    while pair.iter().any(|part| part.dofs.len() > 1) {
        let mut halves = pair.each_ref().map(Part::halves);
        let unknown = (halves.iter_mut().zip(&pair)).flat_map(|(halves, whole)| {
            let count = halves
                .len()
                .min(if whole.derivative.is_some() { 1 } else { 2 });
            halves[..count].iter_mut()
        });
        if !measure(sampler, point, unknown)? {
            return Ok(None);
        }
        for (halves, whole) in halves.iter_mut().zip(&pair) {
            if let ([half, rest], Some(whole)) = (&mut halves[..], &whole.derivative) {
                rest.derivative = (half.derivative.as_ref())
                    .map(|half| Derivative::combined(&[(1.0, whole), (-1.0, half)]));
                rest.subtracted = true;
            }
        }
        let pairs = (halves[0].iter()).flat_map(|u| halves[1].iter().map(move |v| [u, v]));
        let size = |pair: &[&Part; 2]| change(sampler, *pair).map_or(0.0, |d| d.value.abs());
        let Some(largest) = pairs.reduce(|a, b| if size(&b) > size(&a) { b } else { a }) else {
            return Ok(None);
        };
        pair = largest.map(Part::clone);
    }
    for part in pair.iter_mut().filter(|part| part.subtracted) {
        part.derivative = None;
    }
    if !measure(sampler, point, pair.iter_mut())? {
        return Ok(None);
    }
    let norm = sampler.frame.norm(&pair[0].vector) * sampler.frame.norm(&pair[1].vector);
    Ok(
        change(sampler, pair.each_ref()).map(|change| TangentDefect {
            s: sampler.s[point],
            signed: change.value / norm,
            uncertainty: change.error / norm,
            dofs: Some((pair[0].dofs.start, pair[1].dofs.start)),
        }),
    )
}

/// Measures the derivatives that are missing; whether all of them converged.
fn measure<'p>(
    sampler: &mut Sampler<'_>,
    point: usize,
    parts: impl Iterator<Item = &'p mut Part>,
) -> Result<bool, Error> {
    let mut missing: Vec<&mut Part> = parts.filter(|part| part.derivative.is_none()).collect();
    let vectors: Vec<TangentVector<'_>> = (missing.iter())
        .map(|part| TangentVector {
            point,
            direction: &part.vector,
        })
        .collect();
    let derivatives = sampler.derivatives(&vectors)?;
    let converged = derivatives.iter().all(|derivative| derivative.converged);
    for (part, derivative) in missing.iter_mut().zip(derivatives) {
        part.derivative = Some(derivative);
    }
    Ok(converged)
}

fn change(sampler: &Sampler<'_>, [u, v]: [&Part; 2]) -> Option<Estimate> {
    let (of_u, of_v) = (u.derivative.as_ref()?, v.derivative.as_ref()?);
    Some((sampler.frame).change_of_form((&u.vector, of_u), (&v.vector, of_v)))
}
