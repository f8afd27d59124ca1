//! Periods that are stated, right or wrong, for maps that wrap positions or do not; loops that are given may wind.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::{Coordinates, Diagnostic, FourierLoop, Loop, PerSample, TimeAdvance};

use crate::truth_set::member::{Ellipses, Expected, Member, SYMPLECTIC, Subject, Truth, halvings};
use crate::truth_set::random::Random;

pub const COUNT: usize = 240;

/// A wrong period: nearly right, or quite another one.
fn wrong(random: &mut Random, period: f64) -> f64 {
    match random.whole(0, 3) {
        0 => period * (1.0 + random.sign() * random.log_between(1e-9, 1e-2)),
        1 => period * random.between(0.3, 0.7),
        2 => period * random.between(1.3, 1.7),
        // As it is typed.
        _ => {
            let unit = 10f64.powi(period.log10().floor() as i32 - 2);
            let rounded = (period / unit).round() * unit;
            match (rounded / period - 1.0).abs() > 1e-9 {
                true => rounded,
                false => period * 1.01,
            }
        }
    }
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(42, index);
    let dof = random.whole(1, 3);
    let of_momentum = matches!(index % 8, 6 | 7);
    let period = match of_momentum || random.chance(0.5) {
        true => TAU,
        false => random.log_between(0.01, 100.0),
    };
    let unit = TAU / period;
    let depth = random.row(dof, 0.3, 1.0);
    let coupling = random.between(0.0, 0.3);
    let wraps = (index / 2).is_multiple_of(2);
    let winds = index % 3 == 1;
    let is_wrong = index % 2 == 1;
    let stated = if is_wrong {
        wrong(random, period)
    } else {
        period * random.whole(1, 2) as f64
    };
    // Two periods are one, too, unless positions are wrapped by one.
    let stated = if wraps && !is_wrong { period } else { stated };
    let step = move |h: f64, q: &mut [f64], p: &mut [f64]| {
        // A momentum is periodic only in whole turns: h is 1 then, and a leapfrog is not one of the torus.
        let half = if of_momentum { 0.0 } else { 0.5 * h };
        for i in 0..dof {
            q[i] += half * p[i];
        }
        let x: Vec<f64> = q.to_vec();
        for i in 0..dof {
            p[i] -= h * depth[i] * unit * (unit * x[i]).sin();
            if i > 0 {
                let force = h * coupling * unit * (unit * (x[i] - x[i - 1])).sin();
                p[i] -= force;
                p[i - 1] += force;
            }
        }
        for i in 0..dof {
            q[i] += (h - half) * p[i];
            if wraps {
                q[i] = q[i].rem_euclid(period);
                if of_momentum {
                    p[i] = p[i].rem_euclid(period);
                }
            }
        }
    };
    let q0 = random.row(dof, -0.5 * period, period);
    let on = Ellipses {
        p0: random.row(dof, -unit, unit),
        radii_q: random.row(dof, 0.02 * period, 0.2 * period),
        radii_p: random.row(dof, 0.1 * unit, 0.5 * unit),
        q0,
    };
    let mut coordinates = Coordinates::plain(dof)
        .with_periods(vec![stated; dof])
        .unwrap();
    if of_momentum {
        coordinates = coordinates
            .with_momentum_periods(vec![stated; dof])
            .unwrap();
    }
    let map = PerSample::new(dof, step)
        .with_coordinates(coordinates)
        .unwrap();
    let map: Arc<dyn TimeAdvance> = Arc::new(map);
    let diagnostic = match of_momentum {
        true => Diagnostic {
            step_sizes: vec![1.0],
            ..Diagnostic::default()
        },
        false => halvings(random.between(0.3, 1.0) / unit, 4),
    };
    let expected = match is_wrong {
        true => Expected::WrongPeriod,
        false => SYMPLECTIC,
    };
    let is = if is_wrong { "wrong" } else { "right" };
    let label = format!(
        "pendula d = {dof}, period {period:.1e} stated {is} as {stated}, wraps {wraps}, momenta {of_momentum}, winds {winds}"
    );
    let truth = Truth::of(expected);
    let mut member = Member::new(label, map, on.circle(), diagnostic, truth);
    if winds
        && !of_momentum
        && let Subject::Map { on: given, .. } = &mut member.subject
    {
        let Ellipses {
            q0,
            p0,
            radii_q,
            radii_p,
        } = on;
        let p0: Vec<f64> = p0.iter().map(|p| p + 2.0 * unit).collect();
        let random_loop = FourierLoop::random(q0, p0, &radii_q, &radii_p, random.seed()).unwrap();
        *given = Arc::new(random_loop.winding(0, stated).unwrap()) as Arc<dyn Loop>;
    }
    member
}
