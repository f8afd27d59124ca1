//! Steps whose result depends on earlier calls, or on the other rows of the batch: they have to be refused.

use std::collections::HashMap;

use crate::truth_set::batches::{RowsOfBatch, map_of_batches, small_system};
use crate::truth_set::member::{Ellipses, Expected, Member, Truth, halvings};
use crate::truth_set::methods::leapfrog;
use crate::truth_set::random::Random;

pub const COUNT: usize = 240;

/// Adds a number to all momenta.
fn kick(p: &mut [f64], by: f64) {
    p.iter_mut().for_each(|p| *p += by);
}

fn damp(p: &mut [f64], by: f64) {
    p.iter_mut().for_each(|p| *p *= 1.0 - by);
}

fn first_mean(rows: &RowsOfBatch) -> f64 {
    rows.iter().map(|(q, _)| q[0]).sum::<f64>() / rows.len() as f64
}

/// A change of a batch of advanced rows, and its name.
type After = Box<dyn FnMut(&mut RowsOfBatch) + Send>;

fn depends_on_batch(random: &mut Random, size: f64) -> (String, After) {
    let rows_of_chunk = random.pick(&[8, 16, 32, 64, 128]);
    let least = random.whole(0, 200);
    match random.whole(0, 4) {
        0 => (
            "rows sorted".into(),
            Box::new(|rows| rows.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]))),
        ),
        1 => (
            format!("{size:.0e} of the mean, if more than {least} rows"),
            Box::new(move |rows| {
                let mean = first_mean(rows);
                if rows.len() > least {
                    rows.iter_mut().for_each(|(_, p)| kick(p, size * mean));
                }
            }),
        ),
        2 => (
            format!("the rest of a chunk of {rows_of_chunk} damped by {size:.0e}"),
            Box::new(move |rows| {
                let whole = rows.len() - rows.len() % rows_of_chunk;
                rows[whole..].iter_mut().for_each(|(_, p)| damp(p, size));
            }),
        ),
        3 => (
            format!("{size:.0e} of the row before, if more than {least} rows"),
            Box::new(move |rows| {
                let q: Vec<f64> = rows.iter().map(|(q, _)| q[0]).collect();
                let count = rows.len();
                for (k, (_, p)) in rows.iter_mut().enumerate().filter(|_| count > least) {
                    kick(p, size * q[(k + count - 1) % count]);
                }
            }),
        ),
        _ => (
            format!("{size:.0e} of the largest momentum"),
            Box::new(move |rows| {
                let largest = rows.iter().map(|(_, p)| p[0]).fold(0.0, f64::max);
                rows.iter_mut().for_each(|(_, p)| kick(p, size * largest));
            }),
        ),
    }
}

fn depends_on_calls(random: &mut Random, size: f64) -> (String, After) {
    let after = random.log_between(30.0, 4000.0) as usize;
    let (mut count, mut heat, mut before) = (0, 0.0, 0.0);
    match random.whole(0, 6) {
        0 => (
            format!("a thermostat of {size:.0e}"),
            Box::new(move |rows| {
                for (_, p) in rows {
                    damp(p, heat);
                    heat += size * (p[0] * p[0] - 0.3);
                }
            }),
        ),
        1 => (
            format!("a kick of {size:.0e} after {after} states"),
            Box::new(move |rows| {
                count += rows.len();
                if count > after {
                    rows.iter_mut().for_each(|(_, p)| kick(p, size));
                }
            }),
        ),
        2 => (
            format!("damped by {size:.0e} after {after} states"),
            Box::new(move |rows| {
                count += rows.len();
                if count > after {
                    rows.iter_mut().for_each(|(_, p)| damp(p, size));
                }
            }),
        ),
        3 => (
            format!("a kick of {size:.0e} of the count"),
            Box::new(move |rows| {
                for (_, p) in rows {
                    count += 1;
                    kick(p, size * 1e-3 * count as f64);
                }
            }),
        ),
        4 => (
            format!("{size:.0e} of the state before"),
            Box::new(move |rows| {
                for (q, p) in rows {
                    kick(p, size * before);
                    before = q[0];
                }
            }),
        ),
        5 => (
            format!("every second call damped by {size:.0e}"),
            Box::new(move |rows| {
                count += 1;
                if count % 2 == 0 {
                    rows.iter_mut().for_each(|(_, p)| damp(p, size));
                }
            }),
        ),
        _ => (
            format!("every second state damped by {size:.0e}"),
            Box::new(move |rows| {
                for (_, p) in rows {
                    count += 1;
                    if count % 2 == 0 {
                        damp(p, size);
                    }
                }
            }),
        ),
    }
}

/// The effect of the batch, or of earlier calls, on momenta of a leapfrog step.
fn of_leapfrog(random: &mut Random, on_batch: bool) -> Member {
    let system = small_system(random);
    let size = random.log_between(1e-7, 1e-1);
    let (what, mut after) = match on_batch {
        true => depends_on_batch(random, size),
        false => depends_on_calls(random, size),
    };
    let leap = leapfrog(&system);
    let map = map_of_batches(system.dof(), move |h, rows| {
        rows.iter_mut().for_each(|(q, p)| leap(h, q, p));
        after(rows);
    });
    let h = random.between(0.4, 1.0) / system.omega;
    let label = format!("{} d = {}, {what}", system.name, system.dof());
    let truth = Truth::of(Expected::Refused);
    Member::new(label, map, system.on.circle(), halvings(h, 8), truth)
}

/// Atoms on a line with Lennard-Jones forces between the pairs of a list that is kept until an atom moves by half a skin.
fn kept_list(random: &mut Random) -> Member {
    // The outer atoms are pairs of the list on a part of the loop.
    let skin = random.between(0.1, 0.2);
    let range = 2.3 - skin + random.between(-0.03, 0.03);
    let q0: Vec<f64> = [0.0, 1.15, 2.3]
        .map(|x| x + random.between(-0.03, 0.03))
        .to_vec();
    let on = Ellipses {
        q0,
        p0: random.row(3, -0.1, 0.1),
        // Ends move against the middle.
        radii_q: vec![0.12, 0.02, 0.05],
        radii_p: vec![0.3; 3],
    };
    /// Positions, and the pairs that were near then.
    type List = (Vec<f64>, Vec<(usize, usize)>);
    let mut list: Option<List> = None;
    let mut force = move |q: &[f64]| -> Vec<f64> {
        let is_old = |at: &Vec<f64>| at.iter().zip(q).any(|(a, b)| (a - b).abs() > 0.5 * skin);
        if list.as_ref().is_none_or(|(at, _)| is_old(at)) {
            let all = [(0, 1), (0, 2), (1, 2)].into_iter();
            let near = all.filter(|&(i, j)| (q[i] - q[j]).abs() < range + skin);
            list = Some((q.to_vec(), near.collect()));
        }
        let mut f = vec![0.0; 3];
        for &(i, j) in &list.as_ref().expect("it was made").1 {
            let r = q[i] - q[j];
            let pair = (48.0 * r.powi(-14) - 24.0 * r.powi(-8)) * r;
            f[i] += pair;
            f[j] -= pair;
        }
        f
    };
    let map = map_of_batches(3, move |h, rows| {
        for (q, p) in rows {
            (p.iter_mut().zip(force(q))).for_each(|(p, f)| *p += 0.5 * h * f);
            (q.iter_mut().zip(&*p)).for_each(|(q, p)| *q += h * p);
            (p.iter_mut().zip(force(q))).for_each(|(p, f)| *p += 0.5 * h * f);
        }
    });
    let label = format!("kept neighbour list, skin {skin:.2}, range {range:.2}");
    let diagnostic = halvings(0.08, 4);
    Member::new(
        label,
        map,
        on.circle(),
        diagnostic,
        Truth::of(Expected::Refused),
    )
}

/// Forces that are kept under the position, rounded.
fn cached_forces(random: &mut Random) -> Member {
    let system = small_system(random);
    let cells = random.log_between(5.0, 200.0) / system.on.radii_q[0];
    let mut cache: HashMap<Vec<i64>, Vec<f64>> = HashMap::new();
    let force = system.force.clone();
    let masses = system.masses.clone();
    let map = map_of_batches(system.dof(), move |h, rows| {
        for (q, p) in rows {
            let key = q.iter().map(|x| (x * cells).round() as i64).collect();
            let f = cache.entry(key).or_insert_with(|| {
                let mut f = vec![0.0; q.len()];
                force(q, &mut f);
                f
            });
            (p.iter_mut().zip(&*f)).for_each(|(p, f)| *p += h * f);
            for ((q, p), m) in q.iter_mut().zip(&*p).zip(&masses) {
                *q += h * p / m;
            }
        }
    });
    let label = format!("{} d = {}, forces cached", system.name, system.dof());
    let h = random.between(0.4, 1.0) / system.omega;
    // A state keeps the force of its cell for ever: what shows is a force in steps.
    let truth = Truth::of(Expected::Broken { closed: None });
    Member::new(label, map, system.on.circle(), halvings(h, 8), truth)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(31, index);
    match index % 12 {
        0..=4 => of_leapfrog(random, true),
        5..=9 => of_leapfrog(random, false),
        10 => kept_list(random),
        _ => cached_forces(random),
    }
}
