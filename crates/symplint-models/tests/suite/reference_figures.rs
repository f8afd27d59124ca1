//! The systems and rules against figures computed by independent code.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use symplint::rules::{Cutoff, Cutoffs};
use symplint::{Circle, Defect, Ensemble, LoopIntegral, Phases, Rule, TimeAdvance, Trace};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::{
    AbsoluteValue, InterpolatedPendulum, Pendulum, PendulumArray, PendulumPotential,
};

/// Rows of a CSV file by column name.
fn table(text: &str) -> Vec<HashMap<String, String>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().trim().split(',').collect();
    lines
        .map(|line| {
            let values = line.trim().split(',').map(str::to_owned);
            names
                .iter()
                .map(|name| (*name).to_owned())
                .zip(values)
                .collect()
        })
        .collect()
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column]
        .parse()
        .unwrap_or_else(|_| panic!("{column}: {}", row[column]))
}

fn step(name: &str, variant: &str, system: &Arc<dyn Separable>) -> Box<dyn TimeAdvance> {
    build(name, Some(variant), Arc::clone(system)).unwrap()
}

/// Loop integrals before and after one step.
fn integrals(
    circle: &Circle,
    map: &dyn TimeAdvance,
    h: f64,
    samples: usize,
    rule: Rule,
) -> (LoopIntegral, LoopIntegral) {
    let mut ensemble = Ensemble::sample(circle, samples).unwrap();
    let initial = LoopIntegral::of(&ensemble, &rule).unwrap();
    ensemble.advance(map, h).unwrap();
    (initial, LoopIntegral::of(&ensemble, &rule).unwrap())
}

/// Within 1% where the reference is above 1e-11, below that otherwise.
fn assert_agrees(measured: f64, reference: f64, what: &str) {
    if reference > 1e-11 {
        let off = (measured / reference - 1.0).abs();
        assert!(
            off < 0.01,
            "{what}: {measured:e} where the reference has {reference:e}"
        );
    } else {
        assert!(
            measured < 1e-11,
            "{what}: {measured:e} where the reference has {reference:e}"
        );
    }
}

fn check_interpolated_pendulum(text: &str, p0_column: Option<&str>) {
    for row in table(text) {
        let degree = number(&row, "order") as usize;
        let (samples, h) = (number(&row, "Ns") as usize, number(&row, "dt"));
        let p0 = p0_column.map_or(0.0, |column| number(&row, column));
        let system: Arc<dyn Separable> = Arc::new(InterpolatedPendulum::new(degree, 25).unwrap());
        let circle = Circle::new(vec![PI], vec![p0], 1.0).unwrap();
        for (label, name, variant) in [
            ("strang", "strang", "position-first"),
            ("rk2", "rk2", "midpoint"),
        ] {
            let map = step(name, variant, &system);
            let what = format!("degree {degree}, {label}, N = {samples}, h = {h}, p0 = {p0}");
            let (_, advanced) = integrals(&circle, &*map, h, samples, Rule::Pseudospectral);
            let error = (advanced.value / PI - 1.0).abs();
            assert_agrees(
                error,
                number(&row, &format!("relerr_{label}_vs_exact")),
                &what,
            );

            let rule = Rule::FiniteDifference(Cutoffs::relative(10.0));
            let (initial, advanced) = integrals(&circle, &*map, h, samples, rule);
            let defect = Defect::between(&initial, &advanced).unwrap().magnitude();
            let what = format!("{what}, finite differences");
            assert_agrees(defect, number(&row, &format!("fd_relerr_{label}")), &what);
            let omitted = advanced.omitted.unwrap().len() as f64;
            let dropped = number(&row, &format!("fd_dropped_{label}"));
            assert!(
                (omitted - dropped).abs() <= 2.0,
                "{what}: {omitted} omitted, not {dropped}"
            );
        }
    }
}

#[test]
fn interpolated_pendulum_against_samples() {
    check_interpolated_pendulum(include_str!("reference/piecewise_M_sweep_o0.csv"), None);
    check_interpolated_pendulum(include_str!("reference/piecewise_M_sweep_o1.csv"), None);
    check_interpolated_pendulum(include_str!("reference/piecewise_M_sweep_o2.csv"), None);
    check_interpolated_pendulum(include_str!("reference/piecewise_M_sweep_o3.csv"), None);
}

#[test]
fn interpolated_pendulum_against_step_sizes() {
    check_interpolated_pendulum(include_str!("reference/piecewise_dt_sweep_o0.csv"), None);
    check_interpolated_pendulum(include_str!("reference/piecewise_dt_sweep_o3.csv"), None);
}

#[test]
fn interpolated_pendulum_against_step_sizes_degree_1() {
    check_interpolated_pendulum(include_str!("reference/piecewise_dt_sweep_o1.csv"), None);
}

#[test]
fn interpolated_pendulum_against_step_sizes_degree_2() {
    check_interpolated_pendulum(include_str!("reference/piecewise_dt_sweep_o2.csv"), None);
}

#[test]
fn interpolated_pendulum_off_the_axis() {
    check_interpolated_pendulum(
        include_str!("reference/piecewise_dt_sweep_p0half.csv"),
        Some("p0"),
    );
}

#[test]
fn pendulum_array_from_the_same_state() {
    let bytes = include_bytes!("reference/init_array_N1024.npy");
    // A NumPy 1.0 header, then 1024 pairs (q, p): the array is in Fortran order.
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let values: Vec<f64> = (bytes[start..].chunks_exact(8))
        .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap()))
        .collect();
    let q0 = values.iter().step_by(2).copied().collect();
    let p0 = values.iter().skip(1).step_by(2).copied().collect();
    let system: Arc<dyn Separable> = Arc::new(PendulumArray::new(1024, 1.0, 1.0).unwrap());
    let circle = Circle::new(q0, p0, 1.0).unwrap().with_phases(Phases::Equal);
    for row in table(include_str!("reference/array_dt_sweep_N1024_M1024.csv")) {
        let h = number(&row, "dt");
        for (column, name, variant) in [
            (
                "relerr_strang_qfirst_paperforce",
                "strang",
                "position-first",
            ),
            (
                "relerr_strang_pfirst_paperforce",
                "strang",
                "momentum-first",
            ),
            ("relerr_midpoint_paperforce", "rk2", "midpoint"),
            ("relerr_heun_paperforce", "rk2", "heun"),
        ] {
            let map = step(name, variant, &system);
            let (initial, advanced) = integrals(&circle, &*map, h, 1024, Rule::Pseudospectral);
            let defect = Defect::between(&initial, &advanced).unwrap().magnitude();
            assert_agrees(
                defect,
                number(&row, column),
                &format!("{column} at h = {h}"),
            );
            assert!(
                name != "strang" || defect < 1e-13,
                "{column} at h = {h}: {defect:e}"
            );
        }
    }
}

#[test]
fn traces_of_the_pendulum() {
    let system: Arc<dyn Separable> = Arc::new(Pendulum::new(PendulumPotential::Cos));
    let map = step("strang", "position-first", &system);
    let trace = Trace {
        rule: Rule::Pseudospectral,
        samples: 2048,
        step_size: 0.1,
        steps: 999,
        snapshots: vec![],
    };
    let run = |q0, p0| {
        let circle = Circle::new(vec![q0], vec![p0], 1.0).unwrap();
        trace.run(&*map, &circle, None).unwrap().points
    };
    // Round-off for ever.
    let stable = run(PI, 0.5);
    let reference = table(include_str!("reference/nl_pendulum_loop_pi_half.csv"));
    assert_eq!(stable.len(), reference.len());
    for (point, row) in stable.iter().zip(&reference) {
        assert!(
            point.defect < 1e-13,
            "t = {}: {:e}",
            point.time,
            point.defect
        );
        assert!((point.integral / TAU - number(row, "I")).abs() < 1e-13);
    }
    // Blow-up: the same figures while the loop is nearly resolved, lost at the same time.
    let unstable = run(0.0, 0.0);
    let reference = table(include_str!("reference/nl_pendulum_loop_0_0.csv"));
    let mut compared = 0;
    for (point, row) in unstable.iter().zip(&reference) {
        let error = number(row, "relerr");
        if error > 1e-11 && error < 1e-2 && point.time < 10.0 {
            assert_agrees(point.defect, error, &format!("t = {}", point.time));
            compared += 1;
        }
    }
    assert!(compared > 10, "only {compared} points to compare");
    let onset = unstable
        .iter()
        .find(|point| point.defect > 1e-12)
        .unwrap()
        .time;
    assert!((5.5..6.5).contains(&onset), "blow-up at t = {onset}");
}

#[test]
fn closed_forms_of_the_absolute_value() {
    let system: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.0).unwrap());
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    // τ_q between the slope of smooth q and that of the smallest jump, h² N; a jump of p alone does no harm.
    let absolute = Rule::FiniteDifference(Cutoffs {
        q: Cutoff::Absolute(50.0),
        p: Cutoff::Absolute(f64::INFINITY),
    });
    // At h = 0.001 a jump of q is as flat as the loop, but the jump of p in the same cell is not.
    let relative = Rule::FiniteDifference(Cutoffs::relative(1000.0));
    for row in table(include_str!("reference/abs_potential_loop_integrals.csv")) {
        let (h, exact) = (number(&row, "h"), number(&row, "exact_ac"));
        let (name, variant) = match row["map"].as_str() {
            "lie_q" => ("lie-trotter", "position-first"),
            "lie_p" => ("lie-trotter", "momentum-first"),
            "strang_q" => ("strang", "position-first"),
            _ => ("strang", "momentum-first"),
        };
        let map = step(name, variant, &system);
        let rule = if h < 0.01 { relative } else { absolute };
        let (_, advanced) = integrals(&circle, &*map, h, 1 << 20, rule);
        let off = (advanced.value / exact - 1.0).abs();
        // A rule of first order, whose error grows with h.
        let bound = if h <= 1.9 { 1e-5 } else { 3e-5 };
        assert!(off < bound, "{name}, {variant}, h = {h}: {off:e}");
    }
}

#[test]
fn the_mollified_absolute_value_is_conserved() {
    let system: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.1).unwrap());
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    for name in ["lie-trotter", "strang"] {
        for variant in ["position-first", "momentum-first"] {
            let map = step(name, variant, &system);
            for h in [1.9, 1.0, 0.5, 0.1, 0.01] {
                let (initial, advanced) = integrals(&circle, &*map, h, 8192, Rule::Pseudospectral);
                let defect = Defect::between(&initial, &advanced).unwrap().magnitude();
                assert!(defect < 1e-12, "{name}, {variant}, h = {h}: {defect:e}");
            }
        }
    }
}
