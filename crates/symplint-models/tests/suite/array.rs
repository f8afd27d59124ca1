//! Steps of coupled pendula: the sweep that takes a drift, a kick and a drift at once.

use symplint::error::StateLocation;
use symplint::map::Parts;
use symplint::state::RowsMut;
use symplint::{Block, Ensemble, Error, TimeAdvance};
use symplint_models::integrators::{Splitting, SplittingMethod, Variant, splitting_methods};
use symplint_models::systems::PendulumArray;

type State = (Vec<f64>, Vec<f64>);

/// Positions in [−6, 6) and momenta in [−1, 1), all different.
fn state(pendula: usize, samples: usize) -> State {
    let even = |salt: f64| {
        let numbers =
            (0..pendula * samples).map(move |i| (0.618_033_988_749_895 * i as f64 + salt).fract());
        numbers.map(|u| 2.0 * u - 1.0)
    };
    (even(0.1).map(|u| 6.0 * u).collect(), even(0.7).collect())
}

fn on_block<R>(samples: usize, state: &mut State, work: impl FnOnce(&mut Block<'_>) -> R) -> R {
    let count = state.0.len() / samples;
    work(&mut Block::new(
        RowsMut::new(&mut state.0, count, samples, samples),
        RowsMut::new(&mut state.1, count, samples, samples),
    ))
}

fn bits(state: &State) -> Vec<u64> {
    state
        .0
        .iter()
        .chain(&state.1)
        .map(|x| x.to_bits())
        .collect()
}

fn array(pendula: usize, method: SplittingMethod) -> Splitting<PendulumArray> {
    Splitting::new(method, PendulumArray::new(pendula, 0.7, 1.3).unwrap())
}

fn strang(pendula: usize) -> Splitting<PendulumArray> {
    array(pendula, splitting_methods::strang(Variant::PositionFirst))
}

#[test]
fn a_sweep_is_its_flows_one_after_the_other_to_the_last_bit() {
    for variant in [Variant::PositionFirst, Variant::MomentumFirst] {
        for method in [
            splitting_methods::lie_trotter(variant),
            splitting_methods::strang(variant),
            splitting_methods::yoshida4(variant),
            splitting_methods::mclachlan4(variant),
        ] {
            for pendula in 1..=8 {
                for samples in [1, 7, 8, 21, 40] {
                    let map = array(pendula, method.clone());
                    let mut at_once = state(pendula, samples);
                    let mut apart = at_once.clone();
                    on_block(samples, &mut at_once, |block| map.advance(0.3, block)).unwrap();
                    on_block(samples, &mut apart, |block| {
                        for substep in 0..Parts::of(&map).count() {
                            Parts::of(&map).advance(substep, 0.3, block).unwrap();
                        }
                    });
                    assert_eq!(
                        bits(&at_once),
                        bits(&apart),
                        "{} {variant:?}, {pendula} pendula, {samples} samples",
                        method.name()
                    );
                }
            }
        }
    }
}

/// One Strang step against the equations of the paper, written down for a sample alone.
#[test]
fn a_step_is_that_of_the_equations() {
    let (pendula, samples, h) = (5, 19, 0.3);
    let mut got = state(pendula, samples);
    // Angles so large that sines of them are computed another way.
    got.0[2 * samples + 3] = 3e6;
    got.0[2 * samples + 17] = -1e9;
    let (start_q, start_p) = got.clone();
    on_block(samples, &mut got, |block| strang(pendula).advance(h, block)).unwrap();
    for k in 0..samples {
        let column = |rows: &[f64], i: usize| rows[(i % pendula) * samples + k];
        let half = |i| column(&start_q, i) + 0.5 * h * column(&start_p, i);
        for i in 0..pendula {
            let spring = half(i + 1) - 2.0 * half(i) + half(i + pendula - 1);
            let p = column(&start_p, i) + h * (0.7 * half(i).sin() + 1.3 * spring);
            let q = half(i) + 0.5 * h * p;
            for (got, expected) in [(&got.0, q), (&got.1, p)] {
                let got = column(got, i);
                let error = (got - expected).abs() / (1.0 + spring.abs() + half(i).abs());
                assert!(
                    error < 1e-15,
                    "pendulum {i} of sample {k}: {got}, {expected}"
                );
            }
        }
    }
}

/// Cut into blocks of an ensemble or alone, a sample goes the same way.
#[test]
fn samples_do_not_see_their_block() {
    let (pendula, samples) = (600, 75);
    let (q, p) = state(pendula, samples);
    let mut ensemble = Ensemble::zeros(pendula, samples);
    let mut block = ensemble.block();
    for i in 0..pendula {
        let row = i * samples..(i + 1) * samples;
        block.q.row_mut(i).copy_from_slice(&q[row.clone()]);
        block.p.row_mut(i).copy_from_slice(&p[row]);
    }
    let map = strang(pendula);
    ensemble.advance(&map, 0.3).unwrap();
    for k in [0, 1, 31, 32, 63, 64, 74] {
        let column = |rows: &[f64]| rows.iter().skip(k).step_by(samples).copied().collect();
        let mut alone: State = (column(&q), column(&p));
        on_block(1, &mut alone, |block| map.advance(0.3, block)).unwrap();
        for i in 0..pendula {
            assert_eq!(ensemble.q().row(i)[k].to_bits(), alone.0[i].to_bits());
            assert_eq!(ensemble.p().row(i)[k].to_bits(), alone.1[i].to_bits());
        }
    }
}

/// A state that is not finite, before or only after the step, is found wherever it is, and the error names the sample.
#[test]
fn states_that_are_not_finite_are_found() {
    let samples = 11;
    for pendula in 1..=5 {
        for i in 0..pendula {
            for (in_q, value) in [
                (true, f64::NAN),
                (false, f64::NAN),
                (true, f64::INFINITY),
                (false, f64::NEG_INFINITY),
                // Beyond all doubles after a step.
                (true, 1.7e308),
                (false, 1.7e308),
            ] {
                let map = strang(pendula);
                let (q, p) = state(pendula, samples);
                let mut ensemble = Ensemble::zeros(pendula, samples);
                let mut block = ensemble.block();
                for j in 0..pendula {
                    let row = j * samples..(j + 1) * samples;
                    block.q.row_mut(j).copy_from_slice(&q[row.clone()]);
                    block.p.row_mut(j).copy_from_slice(&p[row]);
                }
                map.advance(2.0, &mut block).unwrap();
                assert!(block.all_finite());
                let rows = if in_q { &mut block.q } else { &mut block.p };
                rows.row_mut(i)[6] = value;
                let at = format!("{pendula} pendula, {value} at {i} ({in_q})");
                let mut copy = ensemble.clone();
                let mut block = copy.block();
                map.advance(2.0, &mut block).unwrap();
                let finite = block.all_finite();
                match ensemble.advance(&map, 2.0) {
                    Err(Error::NotFinite {
                        at: StateLocation::Sample(6),
                        ..
                    }) => assert!(!finite, "{at}"),
                    // A single pendulum without neighbours may have gone on.
                    Ok(()) => assert!(finite && value.is_finite(), "{at}"),
                    other => panic!("{at}: {other:?}"),
                }
            }
        }
    }
}
