//! Further probes: random loops like the given one.

use crate::coordinates::Coordinates;
use crate::ensemble::Ensemble;
use crate::error::Error;
use crate::loops::{FourierLoop, Loop};

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
    let ensemble = Ensemble::sample(phase_loop, 64)?;
    let (mut centre, mut radius) = ([vec![], vec![]], [vec![], vec![]]);
    for (c, rows) in [ensemble.q(), ensemble.p()].into_iter().enumerate() {
        for i in 0..rows.count() {
            let row = rows.row(i);
            let low = row.iter().copied().fold(f64::INFINITY, f64::min);
            let high = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            centre[c].push((low + high) / 2.0);
            radius[c].push((high - low) / 2.0);
        }
    }
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
