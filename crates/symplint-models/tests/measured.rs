//! Loops measured from their samples alone, against answers known by evaluating the map.

use std::sync::Arc;

use symplint::{
    Circle, Coordinates, Diagnosis, Ensemble, Snapshot, TimeAdvance, VerdictKind, measure,
};
use symplint_models::integrators::catalogue;
use symplint_models::pic::{ParticleWeights, Pic1d, PicConfig, ShapeFamily};

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
    (map, Circle::new(x, v, 1.0).unwrap())
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
    let of_map = map.coordinates();
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
        let point = &diagnosis.points[0];
        println!(
            "{samples:6} {:16} {} E = {:+.6} ± {:?}, {:?} cells, {:?} jumps, closed {:?}",
            point.rule,
            diagnosis.verdict.kind,
            point.signed_defect,
            point.quadrature_error,
            point.omitted_cells,
            point.jumps,
            point.closed_defect
        );
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
