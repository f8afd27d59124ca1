//! Further probes: random loops like the given one.

use crate::error::Error;
use crate::evidence::LoopKind;
use crate::loops::FourierLoop;
use crate::map::LoopSize;
use crate::state::Coordinates;

/// The kind of random loop `index`: if the given loop leaves degrees of freedom at rest, every second one moves
/// them, too, the first of all: a plane that the map keeps can hide terms of lower order.
pub(super) fn random_kind(size: &LoopSize, index: usize) -> LoopKind {
    match !index.is_multiple_of(2) && size.at_rest.contains(&true) {
        true => LoopKind::Extended,
        false => LoopKind::Random,
    }
}

/// A random loop of this kind about as large as the given one round the same centre; `None` of a loop that should wind
/// where no position has a period, and of kinds that are not random.
pub(in crate::diagnosis::checks) fn loop_of_kind(
    kind: LoopKind,
    group: Option<usize>,
    size: &LoopSize,
    coordinates: &Coordinates,
    seed: u64,
) -> Result<Option<FourierLoop>, Error> {
    let random = |[radius_q, radius_p]: &[Vec<f64>; 2]| {
        let [q0, p0] = size.centre.clone();
        FourierLoop::random(q0, p0, radius_q, radius_p, seed).map(Some)
    };
    match kind {
        LoopKind::Winding => winding_loop(size, coordinates, seed),
        LoopKind::Extended => random(&size.radius),
        LoopKind::Group => {
            let Some(group) = group.and_then(|group| size.groups.get(group)) else {
                return Ok(None);
            };
            random(&radii_where(size, |i| group.dofs.binary_search(&i).is_ok()))
        }
        LoopKind::Given | LoopKind::Image => Ok(None),
        LoopKind::Random => random(&moving_radii(size)),
    }
}

/// A random loop that winds round the period of the first position that has one, and whose momentum has none.
///
/// It runs on one side of p = 0 there, so that ∮ p·dq does not vanish.
fn winding_loop(
    size: &LoopSize,
    coordinates: &Coordinates,
    seed: u64,
) -> Result<Option<FourierLoop>, Error> {
    let Some(dof) = (0..coordinates.dof())
        .find(|&i| coordinates.period(i) > 0.0 && coordinates.momentum_period(i) == 0.0)
    else {
        return Ok(None);
    };
    let [q0, mut p0] = size.centre.clone();
    let [mut radius_q, mut radius_p] = moving_radii(size);
    (radius_q[dof], radius_p[dof]) = (size.radius[0][dof], size.radius[1][dof]);
    if p0[dof].abs() < 2.0 * radius_p[dof] {
        p0[dof] = (2.0 * radius_p[dof]).copysign(p0[dof]);
    }
    let winding = FourierLoop::random(q0, p0, &radius_q, &radius_p, seed)?;
    winding.winding(dof, coordinates.period(dof)).map(Some)
}

/// The radii without those of degrees of freedom at rest.
fn moving_radii(size: &LoopSize) -> [Vec<f64>; 2] {
    radii_where(size, |i| !size.at_rest[i])
}

/// The radii of degrees of freedom that are picked; none of the others.
fn radii_where(size: &LoopSize, picked: impl Fn(usize) -> bool) -> [Vec<f64>; 2] {
    size.radius.each_ref().map(|radius| {
        let part = |(i, &radius): (usize, &f64)| if picked(i) { radius } else { 0.0 };
        radius.iter().enumerate().map(part).collect()
    })
}
