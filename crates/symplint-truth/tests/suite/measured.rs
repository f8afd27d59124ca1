//! Loops measured from their samples alone, against answers known by evaluating the map.

use std::sync::Arc;

use symplint::rules::Piecewise;
use symplint::{
    Circle, Coordinates, Defect, Diagnosis, Ensemble, FourierLoop, LoopIntegral, Phases, Rule,
    Snapshot, TimeAdvance, VerdictKind, measure,
};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::{self, CATALOGUE};
use symplint_models::systems::{HenonHeiles, Pendulum, PendulumArray};
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig, ShapeFamily};

/// Two particles of linear splines: the case of many jumps, by the midpoint rule.
fn two_particles(degree: usize) -> (Box<dyn TimeAdvance>, Circle) {
    let particles = 2;
    let length = 50.0;
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Each(vec![length / particles as f64; particles]),
        cells: 128,
        length,
        family: ShapeFamily::BSpline,
        degree,
        filter_passes: 0,
    })
    .unwrap();
    let golden = 0.618_033_988_749_894_9;
    let index = |a: usize| a as f64;
    let x = (0..particles)
        .map(|a| length * (0.5 + index(a) * golden).fract())
        .collect();
    let v = (0..particles)
        .map(|a| 3.0 * [1.0, -1.0][a % 2] + 0.3 * (1.0 + index(a)).sin())
        .collect();
    let map = catalogue::build("rk2", Some("midpoint"), Arc::new(pic)).unwrap();
    let circle = Circle::new(x, v, 1.0).unwrap();
    (map, circle.with_phases(Phases::Equal))
}

/// Only the samples and what a file may state go into the measurement.
fn measured(
    map: &dyn TimeAdvance,
    circle: &Circle,
    h: f64,
    samples: usize,
    shift: f64,
) -> Diagnosis {
    let before = Ensemble::sample(circle, samples).unwrap();
    let mut after = before.clone();
    after.advance(map, h).unwrap();
    let moved = |mut ensemble: Ensemble| {
        for dof in 0..ensemble.dof() {
            ensemble
                .block()
                .q
                .row_mut(dof)
                .iter_mut()
                .for_each(|q| *q += shift);
        }
        Snapshot::new(ensemble)
    };
    let of_map = map.capabilities().coordinates;
    let coordinates = Coordinates::plain(of_map.dof())
        .with_periods((0..of_map.dof()).map(|i| of_map.period(i)).collect())
        .unwrap()
        .with_weights((0..of_map.dof()).map(|i| of_map.weight(i)).collect())
        .unwrap();
    measure(&moved(before), &[moved(after).after_step(h)], &coordinates).unwrap()
}

/// I_ac by the piecewise rule, which evaluates the map: NUMERICS has the same digits.
const CONTINUOUS: f64 = -0.309_852_2;
const CLOSED: f64 = -0.0907;

#[test]
fn the_cut_off_rule_is_wrong_here_and_the_samples_say_so() {
    let (map, circle) = two_particles(1);
    for exponent in 4..=17 {
        let samples = 1 << exponent;
        let diagnosis = measured(&*map, &circle, 0.1, samples, 0.0);
        let point = &diagnosis.points()[0];
        if let Some(error) = point.quadrature_error {
            let off = (point.signed_defect - CONTINUOUS).abs();
            assert!(
                off <= error + 1e-7,
                "{samples} samples: {off} beyond {error}"
            );
        }
        assert_ne!(diagnosis.verdict.kind, VerdictKind::Symplectic);
        if samples >= 1 << 10 {
            assert_eq!(
                diagnosis.verdict.kind,
                VerdictKind::BrokenLoops,
                "{samples} samples"
            );
            let closed = point.closed_defect.unwrap();
            assert!(
                (closed + CLOSED).abs() < 60.0 / samples as f64,
                "{samples}: {closed}"
            );
        }
    }
}

#[test]
fn the_origin_does_not_matter_there() {
    let (map, circle) = two_particles(1);
    let here = measured(&*map, &circle, 0.1, 4096, 0.0);
    let there = measured(&*map, &circle, 0.1, 4096, 1e3);
    let (a, b) = (&here.points()[0], &there.points()[0]);
    assert_eq!((a.jumps, a.omitted_cells), (b.jumps, b.omitted_cells));
    assert!((a.signed_defect - b.signed_defect).abs() < 1e-10);
    assert_eq!(here.verdict.kind, there.verdict.kind);
}

#[test]
fn smoother_splines_are_not_called_broken() {
    for degree in [2, 3] {
        let (map, circle) = two_particles(degree);
        for exponent in 5..=14 {
            let verdict = measured(&*map, &circle, 0.1, 1 << exponent, 0.0).verdict;
            assert_ne!(
                verdict.kind,
                VerdictKind::BrokenLoops,
                "degree {degree}, 2^{exponent}"
            );
            assert_ne!(
                verdict.kind,
                VerdictKind::Symplectic,
                "degree {degree}, 2^{exponent}"
            );
        }
    }
}

/// A smooth system with the centre and the radius of its loops.
type System = (Arc<dyn Separable>, Vec<f64>, Vec<f64>, f64);

/// Every integrator on smooth systems, on random loops of few and of many samples.
#[test]
fn no_wrong_verdict_on_smooth_systems() {
    let array = PendulumArray::new(4, 1.0, 1.0).unwrap();
    let (array_q, array_p) = array.uniform_state(3);
    let systems: [System; 3] = [
        (Arc::new(Pendulum::default()), vec![2.0], vec![0.5], 1.0),
        (Arc::new(HenonHeiles), vec![0.0, 0.1], vec![0.2, 0.0], 0.2),
        (Arc::new(array), array_q, array_p, 0.8),
    ];
    let (mut undecided, mut of_all) = (0, 0);
    for (system, q, p, radius) in &systems {
        let radii = vec![*radius; q.len()];
        // Implicit methods converge for smaller steps only.
        let model = symplint_models::Model::Separable(Arc::clone(system));
        let wanted = CATALOGUE.iter().filter(|info| !info.is_implicit());
        for info in wanted.filter(|info| info.is_for(&model)) {
            let map = catalogue::build(info.name, None, Arc::clone(system)).unwrap();
            for seed in 0..3 {
                let random =
                    FourierLoop::random(q.clone(), p.clone(), &radii, &radii, seed).unwrap();
                for samples in [33, 64, 128, 500, 2048] {
                    let before = Ensemble::sample(&random, samples).unwrap();
                    let mut after = before.clone();
                    after.advance(&*map, 1.0).unwrap();
                    let plain = Coordinates::plain(q.len());
                    let (before, after) = (Snapshot::new(before), Snapshot::new(after));
                    // A loop whose areas cancel says nothing.
                    let Ok(found) = measure(&before, &[after.after_step(1.0)], &plain) else {
                        continue;
                    };
                    let kind = found.verdict.kind;
                    let what = format!("{}, seed {seed}, {samples}: {found:?}", info.name);
                    let right = match info.symplectic {
                        true => VerdictKind::Symplectic,
                        false => VerdictKind::NotSymplectic,
                    };
                    assert!(kind == right || kind == VerdictKind::Undecided, "{what}");
                    if samples >= 128 {
                        of_all += 1;
                        undecided += usize::from(kind == VerdictKind::Undecided);
                    }
                }
            }
        }
    }
    assert!(
        20 * undecided < of_all,
        "{undecided} of {of_all} are undecided"
    );
}

/// Jumps down to far below the distance of two samples, against the rule that evaluates the map.
#[test]
fn small_jumps_are_within_the_error() {
    let (map, circle) = two_particles(1);
    let fine = Ensemble::sample(&circle, 64).unwrap();
    let initial = LoopIntegral::in_coordinates(
        &fine,
        &Rule::Pseudospectral,
        &map.capabilities().coordinates,
    )
    .unwrap();
    for h in [0.5, 0.03, 0.01, 0.003, 1e-3] {
        let exact = Piecewise::default().integrate(&*map, &circle, h).unwrap();
        let truth = Defect::between(&initial, &exact.continuous).unwrap();
        for exponent in 5..=15 {
            let found = measured(&*map, &circle, h, 1 << exponent, 0.0);
            let point = &found.points()[0];
            let off = (point.signed_defect - truth.signed).abs();
            if let Some(error) = point.quadrature_error {
                assert!(
                    off <= error,
                    "h = {h}, 2^{exponent}: {off:e} beyond {error:e}"
                );
            }
        }
    }
}
