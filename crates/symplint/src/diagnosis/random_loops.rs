//! Further probes: random loops like the given one.

use crate::error::Error;
use crate::loops::{FourierLoop, Loop};
use crate::signal::Extent;
use crate::state::Coordinates;
use crate::state::Ensemble;

/// A random loop about as large as `phase_loop` round the same centre.
pub(super) fn random_loop(phase_loop: &dyn Loop, seed: u64) -> Result<FourierLoop, Error> {
    let ([q0, p0], [radius_q, radius_p]) = size(phase_loop)?;
    FourierLoop::random(q0, p0, &radius_q, &radius_p, seed)
}

/// A random loop that winds round the period of the first position that has one; `None` where none has.
///
/// It runs on one side of p = 0 there, so that ∮ p·dq does not vanish.
pub(super) fn winding_loop(
    phase_loop: &dyn Loop,
    coordinates: &Coordinates,
    seed: u64,
) -> Result<Option<FourierLoop>, Error> {
    let Some(dof) = (0..coordinates.dof()).find(|&i| coordinates.period(i) > 0.0) else {
        return Ok(None);
    };
    let ([q0, mut p0], [radius_q, radius_p]) = size(phase_loop)?;
    if p0[dof].abs() < 2.0 * radius_p[dof] {
        p0[dof] = (2.0 * radius_p[dof]).copysign(p0[dof]);
    }
    let winding = FourierLoop::random(q0, p0, &radius_q, &radius_p, seed)?;
    winding.winding(dof, coordinates.period(dof)).map(Some)
}

/// Centre and half the range of every coordinate of a loop, positions first.
type Size = ([Vec<f64>; 2], [Vec<f64>; 2]);

fn size(phase_loop: &dyn Loop) -> Result<Size, Error> {
    const SAMPLES: usize = 64;
    let mut extents = vec![[Extent::default(); 2]; phase_loop.dof()];
    Ensemble::in_parts(phase_loop, SAMPLES, |part| {
        for (i, [of_q, of_p]) in extents.iter_mut().enumerate() {
            part.q().row(i).iter().for_each(|&q| of_q.include(q));
            part.p().row(i).iter().for_each(|&p| of_p.include(p));
        }
        Ok(())
    })?;
    let of_each = |c: usize, what: fn(&Extent) -> f64| -> Vec<f64> {
        extents.iter().map(|of_dof| what(&of_dof[c])).collect()
    };
    let centre = [0, 1].map(|c| of_each(c, Extent::middle));
    let mut radius = [0, 1].map(|c| of_each(c, |extent| extent.length() / 2.0));
    drop(extents);
    // The map must keep areas in every plane: move what the given loop leaves at rest, too. A loop that
    // winds can leave all momenta at rest.
    let typical = [0, 1].map(|c: usize| radius[c].iter().copied().fold(0.0, f64::max));
    for c in [0, 1] {
        let typical = if typical[c] > 0.0 {
            typical[c]
        } else {
            typical[1 - c]
        };
        for radius in &mut radius[c] {
            if *radius == 0.0 {
                *radius = typical;
            }
        }
    }
    Ok((centre, radius))
}
