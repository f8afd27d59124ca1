//! How far loops reach, if the caller does not say.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;

use super::FieldKind;
use super::integrand::Integrand;
use super::limits::{
    EVALUATIONS_BEFORE_LOOPS, FACTOR_OF_WIDE_LOOPS, MAX_HALVINGS_OF_RADIUS, MAX_NONLINEAR_PART,
    MAX_ROUNDING_NOISE, PART_OF_CENTRE,
};
use crate::error::{Error, StateLocation};
use crate::map::Evaluator;
use crate::signal::unit;
use crate::state::{Ensemble, coordinate_mut};

/// Radii of this part of a period stay away from the other side of it.
const PART_OF_PERIOD: f64 = 0.125;

/// A direction in which every coordinate moves: components between ½ and 1 in size, of either sign, with a root mean square of 1.
pub(super) fn direction(count: usize, seed: u64, stream: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    // The mean square of numbers that are uniform between ½ and 1 is 7/12.
    let size = (12.0_f64 / 7.0).sqrt();
    (0..count)
        .map(|_| {
            let x = 2.0 * unit(&mut random) - 1.0;
            size * (0.5 * x + 0.5_f64.copysign(x))
        })
        .collect()
}

/// The state with `by` times a direction added, in units of the radii; positions first.
pub(super) fn displaced(
    (q0, p0): (&[f64], &[f64]),
    radius: &[f64],
    direction: &[f64],
    by: &[f64],
) -> Ensemble {
    let dof = q0.len();
    let mut states = Ensemble::zeros(dof, by.len());
    let mut block = states.block();
    for c in 0..2 * dof {
        let (centre, reach) = match c < dof {
            true => (q0[c], radius[c] * direction[c]),
            false => (p0[c - dof], radius.get(c).map_or(0.0, |r| r * direction[c])),
        };
        for (value, by) in coordinate_mut(&mut block, c).iter_mut().zip(by) {
            *value = centre + by * reach;
        }
    }
    states
}

fn norm(form: impl Iterator<Item = f64>) -> f64 {
    form.map(|x| x * x).sum::<f64>().sqrt()
}

/// The root mean square.
fn size_of(values: &[f64]) -> f64 {
    norm(values.iter().copied()) / (values.len().max(1) as f64).sqrt()
}

/// How far loops reach.
pub(super) struct LoopRadii {
    /// In each coordinate, positions first.
    pub radius: Vec<f64>,
    /// Every second loop is this many times as large.
    pub wide: f64,
}

/// The largest radius on which the form is nearly linear: a tenth of the size of the centre, or 1 if the centre is the origin, halved
/// until most of what a displacement changes is proportional to it. Momenta of a field are in proportion to positions as the field
/// suggests: displaced by its radius, each changes the rate of the other by as large a part.
///
/// # Errors
/// Those of the force at the centre, or at all radii.
pub(super) fn suggested(
    evaluator: &Evaluator<'_>,
    kind: FieldKind,
    centre: (&[f64], &[f64]),
    seed: u64,
) -> Result<LoopRadii, Error> {
    let dof = centre.0.len();
    let mut largest = Vec::new();
    let mut best: Option<(f64, f64)> = None;
    let mut failure = None;
    let integrand = Integrand {
        evaluator,
        kind,
        radius: first_radii(evaluator, kind, centre, seed)?,
        unit: 1.0,
    };
    let towards = direction(2 * dof, seed, 0);
    let reach = |factor: f64| LoopRadii {
        radius: integrand.radius.iter().map(|r| factor * r).collect(),
        wide: FACTOR_OF_WIDE_LOOPS.min(factor.recip()),
    };
    let middle = (integrand.form(displaced(centre, &integrand.radius, &towards, &[0.0])))
        .map_err(|error| error.at(|_| StateLocation::Centre))?;
    let of_middle = norm(middle.iter().map(|row| row[0]));
    let sides = |factor: f64| {
        integrand.form(displaced(
            centre,
            &integrand.radius,
            &towards,
            &[factor, -factor],
        ))
    };
    for halving in 0..=MAX_HALVINGS_OF_RADIUS {
        if evaluator.count().left() < 2 + EVALUATIONS_BEFORE_LOOPS {
            break;
        }
        let factor = 0.5_f64.powi(halving as i32);
        match sides(factor) {
            // Atoms may lie on each other there.
            Err(error) if error.is_of_map() => {
                failure = Some(error);
                largest.clear();
                continue;
            }
            Err(error) => return Err(error),
            Ok(rows) => {
                let odd: Vec<f64> = rows.iter().map(|row| 0.5 * (row[0] - row[1])).collect();
                let even =
                    norm((rows.iter().zip(&middle)).map(|(row, m)| 0.5 * (row[0] + row[1]) - m[0]));
                let linear = norm(odd.iter().copied());
                if linear.max(even) <= MAX_ROUNDING_NOISE * f64::EPSILON * of_middle {
                    // The form is constant as far as its rounding shows: larger radii show more.
                    let found = best.map_or(1.0, |(_, factor)| factor);
                    return Ok(reach(found));
                }
                if !largest.is_empty() {
                    // The radius before this one, of twice the size.
                    let off = norm(
                        (largest.iter().zip(&odd))
                            .map(|(large, small): (&f64, &f64)| large - 2.0 * small),
                    );
                    let nonlinear = off.max(4.0 * even) / (2.0 * linear);
                    if nonlinear <= MAX_NONLINEAR_PART {
                        return Ok(reach(2.0 * factor));
                    }
                    if nonlinear.is_finite() && best.is_none_or(|(least, _)| nonlinear < least) {
                        best = Some((nonlinear, 2.0 * factor));
                    }
                }
                largest = odd;
            }
        }
    }
    match (best, failure) {
        (Some((_, factor)), _) => Ok(reach(factor)),
        (None, Some(error)) => Err(error),
        (None, None) => Ok(reach(1.0)),
    }
}

/// The largest radii that are tried.
fn first_radii(
    evaluator: &Evaluator<'_>,
    kind: FieldKind,
    centre: (&[f64], &[f64]),
    seed: u64,
) -> Result<Vec<f64>, Error> {
    let (q0, p0) = centre;
    let dof = q0.len();
    let ratio = match kind {
        FieldKind::Force => 1.0,
        FieldKind::Field => ratio(evaluator, centre, seed)?,
    };
    let size = size_of(q0).max(size_of(p0) / ratio);
    let first = match size > 0.0 {
        true => PART_OF_CENTRE * size,
        false => ratio.sqrt().recip(),
    };
    let period = |i: usize| evaluator.coordinates().period(i);
    let first = (0..dof)
        .filter(|&i| period(i) > 0.0)
        .fold(first, |first, i| first.min(PART_OF_PERIOD * period(i)));
    let mut radius = vec![first; dof];
    if kind == FieldKind::Field {
        radius.extend(vec![first * ratio; dof]);
    }
    Ok(radius)
}

/// Radius in p over radius in q.
fn ratio(evaluator: &Evaluator<'_>, centre: (&[f64], &[f64]), seed: u64) -> Result<f64, Error> {
    /// Displacements, as a part of the size of the centre.
    const DISPLACEMENT_PART: f64 = 1.0 / 1024.0;
    let (q0, p0) = centre;
    let dof = q0.len();
    let sizes = [q0, p0].map(|values| match size_of(values) {
        0.0 => 1.0,
        size => size,
    });
    let towards = direction(2 * dof, seed, 0);
    let changed = |of: usize| {
        let mut radius = vec![0.0; 2 * dof];
        radius[of * dof..(of + 1) * dof].fill(DISPLACEMENT_PART * sizes[of]);
        let mut states = displaced(centre, &radius, &towards, &[1.0, -1.0]);
        evaluator.advance(&mut states, 1.0)?;
        let rates = if of == 0 { states.p() } else { states.q() };
        let of_dof = |i: usize| {
            let weight = evaluator.coordinates().weight(i);
            weight * (rates.row(i)[0] - rates.row(i)[1])
        };
        Ok::<f64, Error>(norm((0..dof).map(of_dof)) / sizes[of])
    };
    match (changed(0), changed(1)) {
        (Ok(of_q), Ok(of_p)) => {
            let ratio = (of_q / of_p).sqrt();
            match ratio.is_finite() && ratio > 0.0 {
                true => Ok(ratio),
                false => Ok(sizes[1] / sizes[0]),
            }
        }
        // A smaller radius may do.
        (Err(error), _) | (_, Err(error)) if error.is_of_map() => Ok(sizes[1] / sizes[0]),
        (Err(error), _) | (_, Err(error)) => Err(error),
    }
}
