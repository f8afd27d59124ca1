//! Forces and vector fields whose answer is known.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use symplint::field::{
    Certainty, FieldLoopKind, FieldRadius, FieldReport, FieldTest, FieldVerdict, check_field,
    check_force,
};
use symplint::{Coordinates, Error, PerSample, TimeAdvance};

/// F = −∇V for V = Π cos(q_i + i), plus a rotation in the plane of the first two coordinates.
fn waves(curl: f64) -> impl Fn(&[f64], &mut [f64]) + Send + Sync {
    move |q: &[f64], f: &mut [f64]| {
        for (i, f) in f.iter_mut().enumerate() {
            let factor = |j: usize| match i == j {
                true => (q[j] + j as f64).sin(),
                false => (q[j] + j as f64).cos(),
            };
            *f = (0..q.len()).map(factor).product();
        }
        f[0] -= curl * q[1];
        f[1] += curl * q[0];
    }
}

/// A force of a block of states as a map.
fn force(
    dof: usize,
    force: impl Fn(&[f64], &mut [f64]) + Send + Sync,
    coordinates: Coordinates,
) -> impl TimeAdvance {
    PerSample::new(dof, move |_, q: &mut [f64], p: &mut [f64]| force(q, p))
        .with_coordinates(coordinates)
        .unwrap()
}

fn on_ring(constant: f64) -> Result<FieldReport, Error> {
    let coordinates = Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
    let ring = force(1, move |q, f| f[0] = constant - q[0].sin(), coordinates);
    FieldTest::default().run_force(&ring, &[1.0])
}

#[test]
fn a_curl_of_one_part_in_a_trillion_is_found() {
    let q0 = [0.7, 0.4, -0.3];
    assert!(check_force(waves(0.0), &q0).unwrap().digits.unwrap() > 13.0);
    for exponent in 0..=12 {
        let curl = 10_f64.powi(-exponent);
        let report = check_force(waves(curl), &q0).unwrap();
        assert_eq!(report.verdict, FieldVerdict::NotAGradient, "{curl:e}");
        let worst = report.evidence.worst.unwrap();
        assert_eq!((worst.first.dof, worst.second.dof), (0, 1));
        assert!((worst.curl - 2.0 * curl).abs() <= worst.error, "{worst:?}");
    }
}

#[test]
fn lambda_is_the_ratio_of_frobenius_norms() {
    // J = S + A with random entries, in three coordinates (all pairs) and in forty (random pairs).
    for n in [3_usize, 40] {
        let entry = |i: usize, j: usize| ((i * 7 + j * 13) as f64 * 0.61).sin();
        let jacobian = move |i: usize, j: usize| {
            let [a, b] = [entry(i, j), entry(j, i)];
            0.5 * (a + b) + 0.01 * (a - b)
        };
        let linear = move |q: &[f64], f: &mut [f64]| {
            for (i, f) in f.iter_mut().enumerate() {
                *f = (0..n).map(|j| jacobian(i, j) * q[j]).sum();
            }
        };
        let square = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
            let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            all.map(|(i, j)| of(i, j).powi(2)).sum()
        };
        let antisymmetric = |i: usize, j: usize| 0.5 * (jacobian(i, j) - jacobian(j, i));
        let exact = (square(&antisymmetric) / square(&jacobian)).sqrt();
        let report = check_force(linear, &vec![1.0; n]).unwrap();
        let curl = report.evidence.curl.unwrap();
        let off = (curl.value - exact).abs();
        // Of random pairs, the error is a standard deviation.
        assert_eq!(curl.all, n == 3);
        let allowed = if curl.all { 1.0 } else { 3.0 };
        assert!(off <= allowed * curl.error + 1e-15, "{curl:?} {exact}");
    }
}

#[test]
fn bisection_finds_the_pair_in_many_coordinates() {
    let n = 100;
    let springs = move |q: &[f64], f: &mut [f64]| {
        for i in 0..n {
            f[i] = (q[(i + 1) % n] - q[i]).sin() - (q[i] - q[(i + n - 1) % n]).sin();
        }
        f[41] += 1e-4 * q[87];
    };
    let q0: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let report = check_force(springs, &q0).unwrap();
    assert_eq!(report.verdict, FieldVerdict::NotAGradient);
    let worst = report.evidence.worst.unwrap();
    let mut dofs = [worst.first.dof, worst.second.dof];
    dofs.sort_unstable();
    assert_eq!(dofs, [41, 87]);
    assert!((worst.curl.abs() - 1e-4).abs() <= worst.error);
}

#[test]
fn as_many_evaluations_in_any_number_of_coordinates() {
    let springs = |q: &[f64], f: &mut [f64]| {
        let n = q.len();
        for i in 0..n {
            f[i] = (q[(i + 1) % n] - q[i]).sin() - (q[i] - q[(i + n - 1) % n]).sin();
        }
    };
    let evaluations = |n: usize| {
        let q0: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let report = check_force(springs, &q0).unwrap();
        assert_eq!(report.verdict, FieldVerdict::Gradient);
        report.evidence.evaluations
    };
    let (few, many) = (evaluations(10), evaluations(20_000));
    assert!(many <= 2 * few, "{few} {many}");
}

#[test]
fn fields_are_hamiltonian_or_not() {
    // Two coupled pendula with masses, in momenta and in velocities.
    let mass = [1.0, 3.0];
    let accelerations = |q: &[f64]| {
        let pull = 0.3 * (q[0] - q[1]).sin();
        [-q[0].sin() - pull, -q[1].sin() + pull]
    };
    let momenta = move |q: &mut [f64], p: &mut [f64]| {
        let f = accelerations(q);
        for i in 0..2 {
            (q[i], p[i]) = (p[i] / mass[i], f[i]);
        }
    };
    let velocities = move |q: &mut [f64], v: &mut [f64]| {
        let f = accelerations(q);
        for i in 0..2 {
            (q[i], v[i]) = (v[i], f[i] / mass[i]);
        }
    };
    let (q0, p0) = ([1.0, 0.3], [0.5, -0.2]);
    let report = check_field(momenta, &q0, &p0).unwrap();
    assert_eq!(report.verdict, FieldVerdict::Hamiltonian);
    assert!(report.digits.unwrap() > 12.0);
    let report = check_field(velocities, &q0, &p0).unwrap();
    assert_eq!(report.verdict, FieldVerdict::NotHamiltonian);
    assert_eq!(report.evidence.damping, None);
    let weighted = PerSample::new(2, move |_, q: &mut [f64], p: &mut [f64]| velocities(q, p));
    let weights = Coordinates::plain(2).with_weights(mass.to_vec()).unwrap();
    let weighted = weighted.with_coordinates(weights).unwrap();
    let report = FieldTest::default().run_field(&weighted, &q0, &p0).unwrap();
    assert_eq!(report.verdict, FieldVerdict::Hamiltonian);
}

#[test]
fn friction_is_named_with_its_rate() {
    let damped = |q: &mut [f64], p: &mut [f64]| {
        for i in 0..3 {
            (q[i], p[i]) = (p[i], -q[i].powi(3) - 0.2 * p[i]);
        }
    };
    let report = check_field(damped, &[1.0, 0.5, 0.2], &[0.1, 0.0, 0.3]).unwrap();
    assert_eq!(report.verdict, FieldVerdict::NotHamiltonian);
    let (rate, error) = report.evidence.damping.unwrap();
    assert!(
        (rate - 0.2).abs() <= error && error < 1e-9,
        "{rate} {error}"
    );
    assert!(report.to_string().contains("uniform friction"));
}

#[test]
fn a_constant_force_on_a_ring_has_no_potential() {
    let report = on_ring(0.1).unwrap();
    assert_eq!(report.verdict, FieldVerdict::NotAGradient);
    assert!(matches!(report.certainty, Certainty::WorkAroundPeriod(_)));
    let around = report.evidence.loops.iter();
    let around = around.filter(|work| work.kind == FieldLoopKind::Winding { dof: 0 });
    let work: Vec<f64> = around.map(|work| work.integral).collect();
    assert!((work[0] - 0.1 * TAU).abs() < 1e-13);
    let report = on_ring(0.0).unwrap();
    assert_eq!(report.verdict, FieldVerdict::Gradient);
    // Without the period every force of one position is a gradient.
    let report = check_force(|q, f| f[0] = 0.1 - q[0].sin(), &[1.0]).unwrap();
    assert_eq!(report.verdict, FieldVerdict::Gradient);
    assert_eq!(report.certainty, Certainty::OnePosition);
}

#[test]
fn a_wrong_period_is_an_error() {
    let coordinates = Coordinates::plain(1).with_periods(vec![6.0]).unwrap();
    let ring = force(1, |q, f| f[0] = -q[0].sin(), coordinates);
    let error = FieldTest::default().run_force(&ring, &[1.0]).unwrap_err();
    assert!(
        matches!(error, Error::NotAPeriodOfForce { dof: 0, .. }),
        "{error}"
    );
}

#[test]
fn forces_that_do_not_change_are_gradients() {
    for constant in [0.0, 0.1, 1e300, 1e-300] {
        let report = check_force(move |_, f| f.fill(constant), &[0.7, 0.4, 3.0]).unwrap();
        assert_eq!(report.certainty, Certainty::Constant, "{constant:e}");
        assert_eq!(
            (report.verdict, report.digits),
            (FieldVerdict::Gradient, None)
        );
        assert_eq!(report.evidence.curl, None);
    }
}

#[test]
fn units_do_not_matter() {
    for unit in [1e-150, 1e-30, 1e30, 1e150] {
        let inner = waves(1e-6);
        let scaled = move |q: &[f64], f: &mut [f64]| {
            inner(q, f);
            f.iter_mut().for_each(|f| *f *= unit);
        };
        let report = check_force(scaled, &[0.7, 0.4, -0.3]).unwrap();
        assert_eq!(report.verdict, FieldVerdict::NotAGradient, "{unit:e}");
        let curl = report.evidence.worst.unwrap().curl;
        assert!((curl / unit - 2e-6).abs() < 1e-12, "{curl:e}");
    }
}

#[test]
fn tiny_forces_that_vanish_at_the_centre_are_not_constant() {
    for unit in [1e-250, 1e-30, 1.0, 1e250] {
        let spring = move |curl: f64| {
            move |q: &[f64], f: &mut [f64]| {
                f[0] = unit * (-q[0] - curl * q[1]);
                f[1] = unit * (-q[1] + curl * q[0]);
            }
        };
        let report = check_force(spring(0.0), &[0.0, 0.0]).unwrap();
        assert_eq!(report.certainty, Certainty::Closed, "{unit:e}");
        let report = check_force(spring(1e-9), &[0.0, 0.0]).unwrap();
        assert_eq!(report.verdict, FieldVerdict::NotAGradient, "{unit:e}");
    }
}

#[test]
fn jumps_of_a_gradient_close_and_tangential_jumps_do_not() {
    let jump = |normal: f64, tangential: f64| {
        move |q: &[f64], f: &mut [f64]| {
            let beyond = f64::from(u8::from(q[0] > 0.72));
            f[0] = -q[1] + normal * beyond;
            f[1] = -q[0] + tangential * beyond;
        }
    };
    let closed = check_force(jump(0.02, 0.0), &[0.7, 0.4]).unwrap();
    assert_ne!(closed.verdict, FieldVerdict::NotAGradient);
    let report = check_force(jump(0.0, 0.02), &[0.7, 0.4]).unwrap();
    assert_eq!(report.verdict, FieldVerdict::NotAGradient);
    assert!(matches!(report.certainty, Certainty::WorkAcrossJumps(_)));
    assert!(report.summary().contains("jump"), "{}", report.summary());
}

#[test]
fn small_jumps_of_a_solver_are_no_verdict() {
    let solver = |q: &[f64], f: &mut [f64]| {
        let tangential = if q[0] > 0.71 { 1e-6 } else { 0.0 };
        (f[0], f[1]) = (-q[1], -q[0] + tangential);
    };
    let test = FieldTest {
        radius: FieldRadius::Same(0.1),
        ..FieldTest::default()
    };
    let solver = force(2, solver, Coordinates::plain(2));
    let report = test.run_force(&solver, &[0.7, 0.4]).unwrap();
    assert!(
        matches!(report.certainty, Certainty::Tolerance(_)),
        "{report}"
    );
    assert_eq!(report.verdict, FieldVerdict::Undecided);
}

#[test]
fn a_steep_wall_is_no_jump() {
    // V = q1² w(q0) with a step w of width 1e-7: between its steep parts the force is that of two potentials.
    let wall = |q: &[f64], f: &mut [f64]| {
        let x = (q[0] - 0.72) / 1e-7;
        let (step, slope) = (x.tanh(), (1.0 - x.tanh().powi(2)) / 1e-7);
        (f[0], f[1]) = (-q[1] * q[1] * slope, -2.0 * q[1] * step);
    };
    let test = FieldTest {
        radius: FieldRadius::Same(0.1),
        ..FieldTest::default()
    };
    let report = test
        .run_force(&force(2, wall, Coordinates::plain(2)), &[0.7, 0.4])
        .unwrap();
    assert_ne!(report.verdict, FieldVerdict::NotAGradient, "{report}");
}

#[test]
fn results_that_depend_on_earlier_calls_are_no_verdict() {
    let calls = AtomicUsize::new(0);
    let drifting = |q: &[f64], f: &mut [f64]| {
        let drift = 1e-2 * calls.fetch_add(1, Ordering::Relaxed) as f64;
        (f[0], f[1]) = (-q[0] - drift, -q[1] + drift);
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let report = pool
        .unwrap()
        .install(|| check_force(drifting, &[0.7, 0.4]).unwrap());
    assert_eq!(report.verdict, FieldVerdict::Undecided);
    assert_eq!(report.certainty, Certainty::Repetitions, "{report}");
}

#[test]
fn the_report_is_the_same_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let q0: Vec<f64> = (0..200).map(|i| (i as f64).sin()).collect();
            serde_json::to_string(&check_force(waves(1e-3), &q0).unwrap()).unwrap()
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn failures_are_errors_with_their_place() {
    let test = |radius: f64| FieldTest {
        radius: FieldRadius::Same(radius),
        ..FieldTest::default()
    };
    let root = |_: f64, q: &mut [f64], p: &mut [f64]| (p[0], p[1]) = (q[0].sqrt(), q[1]);
    let root = PerSample::new(2, root);
    let error = test(0.5).run_force(&root, &[0.1, 1.0]).unwrap_err();
    assert!(
        matches!(
            error,
            Error::NotFinite {
                coordinate: "p",
                dof: 0,
                ..
            }
        ),
        "{error}"
    );
    // The suggested radius stays where the force exists.
    let report = FieldTest::default().run_force(&root, &[0.1, 1.0]).unwrap();
    assert_eq!(report.verdict, FieldVerdict::Gradient);
    let failing = PerSample::new(1, |_, _: &mut [f64], _: &mut [f64]| Err("no force"));
    let error = test(0.5).run_force(&failing, &[0.1]).unwrap_err();
    assert!(matches!(error, Error::StepFailed { .. }), "{error}");
    for (test, q0) in [
        (test(-1.0), vec![0.0, 0.0]),
        (test(0.0), vec![0.0, 0.0]),
        (test(f64::NAN), vec![0.0, 0.0]),
        (test(1.0), vec![0.0]),
        (test(1.0), vec![f64::NAN, 0.0]),
        (
            FieldTest {
                loops: 0,
                ..test(1.0)
            },
            vec![0.0, 0.0],
        ),
        (
            FieldTest {
                budget: 99,
                ..test(1.0)
            },
            vec![0.0, 0.0],
        ),
    ] {
        assert!(test.run_force(&root, &q0).is_err(), "{test:?}");
    }
}

#[test]
fn the_budget_is_kept() {
    let made = AtomicUsize::new(0);
    let rough = |q: &[f64], f: &mut [f64]| {
        made.fetch_add(1, Ordering::Relaxed);
        for (i, f) in f.iter_mut().enumerate() {
            *f = if (q[i] * 37.0).sin() > 0.3 {
                1.0
            } else {
                -q[(i + 1) % q.len()]
            };
        }
    };
    let waves = |q: &[f64], f: &mut [f64]| {
        made.fetch_add(1, Ordering::Relaxed);
        for (f, q) in f.iter_mut().zip(q) {
            *f = if (37.0 * q).sin() > 0.3 { 1.0 } else { q.cos() };
        }
    };
    for n in [1, 2, 12, 30] {
        let q0: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let periods = Coordinates::plain(n).with_periods(vec![TAU; n]).unwrap();
        let maps: [Box<dyn TimeAdvance + '_>; 2] = [
            Box::new(force(n, rough, Coordinates::plain(n))),
            Box::new(force(n, waves, periods)),
        ];
        for (map, budget) in maps
            .iter()
            .flat_map(|map| [100, 101, 150, 200, 300, 500, 1000, 5000].map(|budget| (map, budget)))
        {
            let before = made.load(Ordering::Relaxed);
            let test = FieldTest {
                budget,
                ..FieldTest::default()
            };
            let report = test.run_force(map, &q0).unwrap();
            let count = made.load(Ordering::Relaxed) - before;
            assert_eq!(count, report.evidence.evaluations);
            assert!(count <= budget, "{count} {budget}");
        }
    }
}

#[test]
fn smooth_forces_have_a_verdict_at_the_least_budget() {
    for n in [2, 30] {
        let q0: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        for (curl, verdict) in [
            (0.0, FieldVerdict::Gradient),
            (1e-3, FieldVerdict::NotAGradient),
        ] {
            let map = force(n, waves(curl), Coordinates::plain(n));
            let test = FieldTest {
                budget: 200,
                ..FieldTest::default()
            };
            assert_eq!(
                test.run_force(&map, &q0).unwrap().verdict,
                verdict,
                "{n} {curl}"
            );
        }
    }
}
