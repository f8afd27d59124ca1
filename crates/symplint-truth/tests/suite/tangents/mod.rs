//! Tangent maps: every system with every integrator, and maps made of maps.

mod made_of_maps;
mod second_derivatives;
mod systems;
mod test_of_jacobian;

use crate::common::{State, stepped};
use symplint::state::RowsMut;
use symplint::{Block, TimeAdvance};
use systems::all;

/// A vector that moves all coordinates, another for each `seed`.
pub fn direction(dof: usize, seed: usize) -> State {
    let component = |i: usize| (2.3 * i as f64 + 1.7 * seed as f64 + 0.4).cos();
    let q = (0..dof).map(component).collect();
    (q, (dof..2 * dof).map(component).collect())
}

/// The state after a step and DΦ u.
pub fn with_tangent(map: &dyn TimeAdvance, h: f64, at: &State, along: &State) -> (State, State) {
    let tangent = map
        .capabilities()
        .tangent
        .expect("the map has a tangent map");
    let (mut state, mut along) = (at.clone(), along.clone());
    let dof = at.0.len();
    let mut z = Block::new(
        RowsMut::new(&mut state.0, dof, 1, 1),
        RowsMut::new(&mut state.1, dof, 1, 1),
    );
    let mut u = Block::new(
        RowsMut::new(&mut along.0, dof, 1, 1),
        RowsMut::new(&mut along.1, dof, 1, 1),
    );
    let advanced = tangent.advance_tangents(h, &mut z, &mut u);
    advanced.unwrap_or_else(|error| panic!("from {at:?}: {error}"));
    (state, along)
}

/// ω(u, v), momenta counted with their weights.
fn form(map: &dyn TimeAdvance, u: &State, v: &State) -> f64 {
    let coordinates = map.capabilities().coordinates;
    let plane = |i: usize| coordinates.weight(i) * (u.0[i] * v.1[i] - u.1[i] * v.0[i]);
    (0..u.0.len()).map(plane).sum()
}

fn size(u: &State) -> f64 {
    u.0.iter().chain(&u.1).map(|x| x * x).sum::<f64>().sqrt()
}

/// The derivative along `u` by differences of fourth order.
fn by_differences(map: &dyn TimeAdvance, h: f64, at: &State, u: &State) -> State {
    const STEP: f64 = 1e-3 / 8.0;
    let shifted = |k: f64| {
        let shift = |values: &[f64], u: &[f64]| -> Vec<f64> {
            values
                .iter()
                .zip(u)
                .map(|(x, u)| x + k * STEP * u)
                .collect()
        };
        stepped(map, h, &(shift(&at.0, &u.0), shift(&at.1, &u.1)))
    };
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(shifted);
    let difference = |a: &[f64], b: &[f64], c: &[f64], d: &[f64]| -> Vec<f64> {
        let each = a.iter().zip(b).zip(c).zip(d);
        each.map(|(((a, b), c), d)| (a - 8.0 * b + 8.0 * c - d) / (12.0 * STEP))
            .collect()
    };
    (
        difference(&a.0, &b.0, &c.0, &d.0),
        difference(&a.1, &b.1, &c.1, &d.1),
    )
}

#[test]
fn tangents_are_those_of_differences_and_states_those_of_the_step() {
    for subject in all() {
        for (name, _, map) in subject.maps() {
            for (seed, part) in [1.0, -0.6, 0.2].into_iter().enumerate() {
                let h = part * subject.step;
                let u = direction(map.dof(), seed);
                let (state, tangent) = with_tangent(&map, h, &subject.at, &u);
                assert_eq!(state, stepped(&map, h, &subject.at), "{name}");
                let expected = by_differences(&map, h, &subject.at, &u);
                let off = crate::common::distance(&tangent, &expected);
                assert!(off < 1e-9 * size(&expected), "{name}, h = {h}: {off:e}");
            }
        }
    }
}

#[test]
fn the_form_is_kept_to_round_off_if_and_only_if_the_method_keeps_it() {
    for subject in all() {
        for (name, info, map) in subject.maps() {
            // Accurate methods show what they are where they are not accurate.
            let h = if info.symplectic || info.is_implicit() {
                0.5
            } else {
                1.0
            };
            let mut defect = 0.0_f64;
            for seed in 0..6 {
                let (u, v) = (
                    direction(map.dof(), 2 * seed),
                    direction(map.dof(), 2 * seed + 1),
                );
                let of = |u: &State| with_tangent(&map, h, &subject.at, u).1;
                let (of_u, of_v) = (of(&u), of(&v));
                let change = form(&map, &of_u, &of_v) - form(&map, &u, &v);
                let norm = size(&of_u) * size(&of_v) + size(&u) * size(&v);
                defect = defect.max(change.abs() / norm);
            }
            let symplectic = info.symplectic && subject.name != "rotational force";
            if symplectic {
                assert!(defect < 4e-15, "{name}: {defect:e}");
            } else if subject.nonlinear {
                assert!(defect > 1e-12, "{name}: {defect:e}");
            }
        }
    }
}

#[test]
fn a_tangent_does_not_depend_on_its_block() {
    const WIDTH: usize = 19;
    for subject in all() {
        for (name, _, map) in subject.maps() {
            let dof = map.dof();
            let near = |k: usize| -> State {
                let shift = 1e-3 * k as f64;
                let moved = |values: &[f64]| values.iter().map(|x| x + shift).collect();
                (moved(&subject.at.0), moved(&subject.at.1))
            };
            let table = |part: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
                let columns: Vec<Vec<f64>> = (0..WIDTH).map(part).collect();
                (0..dof)
                    .flat_map(|i| columns.iter().map(move |c| c[i]))
                    .collect()
            };
            let mut tables = [
                table(&|k| near(k).0),
                table(&|k| near(k).1),
                table(&|k| direction(dof, k).0),
                table(&|k| direction(dof, k).1),
            ];
            let [q, p, dq, dp] = &mut tables;
            let rows = |table| RowsMut::new(table, dof, WIDTH, WIDTH);
            let mut states = Block::new(rows(q), rows(p));
            let rows = |table| RowsMut::new(table, dof, WIDTH, WIDTH);
            let mut tangents = Block::new(rows(dq), rows(dp));
            let tangent = map.capabilities().tangent.unwrap();
            tangent
                .advance_tangents(0.4, &mut states, &mut tangents)
                .unwrap();
            for k in 0..WIDTH {
                let (state, along) = with_tangent(&map, 0.4, &near(k), &direction(dof, k));
                let alone = [&state.0, &state.1, &along.0, &along.1];
                for (table, alone) in tables.iter().zip(alone) {
                    let column: Vec<f64> = (0..dof).map(|i| table[i * WIDTH + k]).collect();
                    assert_eq!(&column, alone, "{name}, sample {k}");
                }
            }
        }
    }
}
