//! The Jacobian test by differences against exact Jacobians: closed forms, and the tangent maps of the same
//! steps by dual numbers.

mod dual;

use dual::{METHODS, SYSTEMS, Step};
use symplint::{
    Agreement, Circle, Coordinates, Diagnostic, Error, FourierLoop, Inconclusive, JacobianEvidence,
    JacobianMethod, JacobianTest, JacobianVerdict, Loop, PerSample, RowsMut, StepFailure,
    TangentDefect, TimeAdvance, VerdictKind, compare_jacobian,
};

fn circle(dof: usize) -> Circle {
    Circle::new(vec![0.3; dof], vec![-0.2; dof], 1.0).unwrap()
}

fn run(map: &dyn TimeAdvance, phase_loop: &dyn Loop, h: f64) -> JacobianEvidence {
    JacobianTest::default().run(map, phase_loop, h).unwrap()
}

fn worst_of(report: &JacobianEvidence) -> TangentDefect {
    match report.verdict() {
        JacobianVerdict::NotSymplectic { worst } => worst,
        other => panic!("{other}"),
    }
}

#[track_caller]
fn assert_symplectic(report: &JacobianEvidence, least_digits: f64) {
    match report.verdict() {
        JacobianVerdict::SymplecticAlmostEverywhere { digits } => {
            assert!(digits >= least_digits, "{digits} digits");
        }
        other => panic!("{other}"),
    }
}

/// That every point of one degree of freedom has det DΦ − 1 = `exact` within its error bar.
#[track_caller]
fn assert_determinant(report: &JacobianEvidence, exact: f64, tolerance: f64) {
    for point in &report.points {
        let found = point
            .worst
            .unwrap_or_else(|| panic!("no derivative at s = {}", point.s));
        let off = (found.signed - exact).abs();
        assert!(
            off <= found.uncertainty && found.uncertainty < tolerance,
            "s = {}: {:e} for {exact:e}, off by {off:e}, error bar {:e}",
            point.s,
            found.signed,
            found.uncertainty
        );
    }
}

/// A linear map of one degree of freedom.
fn linear(m: [[f64; 2]; 2]) -> impl TimeAdvance {
    PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
        let (x, y) = (q[0], p[0]);
        q[0] = m[0][0] * x + m[0][1] * y;
        p[0] = m[1][0] * x + m[1][1] * y;
    })
}

#[test]
fn linear_maps_have_their_determinants() {
    let (sin, cos) = 0.7f64.sin_cos();
    let cases = [
        ("rotation", [[cos, sin], [-sin, cos]], 0.0),
        ("shear", [[1.0, 0.8], [0.0, 1.0]], 0.0),
        ("squeeze", [[8.0, 0.0], [0.0, 0.125]], 0.0),
        ("damped", [[1.0, 0.5], [-0.45, 0.675]], -0.1),
        ("wrong sign", [[1.0, 0.5], [0.5, 0.75]], -0.5),
        ("reflected", [[1.0, 0.0], [0.0, -1.0]], -2.0),
    ];
    let loops: [(&str, Circle); 3] = [
        ("unit", circle(1)),
        ("small", Circle::new(vec![0.3], vec![0.1], 1e-3).unwrap()),
        ("large", Circle::new(vec![0.3], vec![0.1], 1e6).unwrap()),
    ];
    for (name, matrix, exact) in cases {
        for (size, phase_loop) in &loops {
            let report = run(&linear(matrix), phase_loop, 0.5);
            assert_determinant(&report, exact, 1e-10);
            let symplectic = matches!(
                report.verdict(),
                JacobianVerdict::SymplecticAlmostEverywhere { .. }
            );
            assert_eq!(
                symplectic,
                exact == 0.0,
                "{name}, {size}: {}",
                report.verdict()
            );
        }
    }
}

#[test]
fn midpoint_on_a_spring_has_its_determinant() {
    for h in [2.0, 1.0, 0.5, 0.25, -0.5, 0.05] {
        let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
            let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0]);
            q[0] += h * p_half;
            p[0] -= h * q_half;
        });
        assert_determinant(&run(&map, &circle(1), h), h.powi(4) / 4.0, 1e-12);
    }
}

/// A map without its tangent map.
struct Bare<M>(M);

impl<M: TimeAdvance> TimeAdvance for Bare<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn advance(&self, h: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
        self.0.advance(h, block)
    }
}

/// Two tests of one map agree within their error bars at every point.
#[track_caller]
fn assert_consistent(name: &str, a: &JacobianEvidence, b: &JacobianEvidence) {
    for (a, b) in a.points.iter().zip(&b.points) {
        let (x, y) = (a.worst.unwrap(), b.worst.unwrap());
        // The worst of either need not be the same pair, but neither exceeds the other's bound.
        for (x, other) in [(x, b), (y, a)] {
            assert!(
                x.magnitude() - x.uncertainty <= other.bound.unwrap(),
                "{name} at {}: {x:?} beside {other:?}",
                a.s
            );
        }
    }
}

#[test]
fn differences_agree_with_dual_numbers() {
    let test = JacobianTest {
        points: 24,
        ..JacobianTest::default()
    };
    for system in SYSTEMS {
        for method in METHODS {
            let map = Step(system, method);
            let phase_loop = circle(system.dof()).with_random_phases(4);
            let exact = test.run(&map, &phase_loop, 0.5).unwrap();
            let differences = test.run(&Bare(map), &phase_loop, 0.5).unwrap();
            let name = format!("{system:?}, {method:?}");
            assert_eq!(exact.method, JacobianMethod::TangentMap, "{name}");
            assert_consistent(&name, &exact, &differences);
            for (exact, found) in exact.points.iter().zip(&differences.points) {
                let (exact, found) = (exact.worst.unwrap(), found.worst.unwrap());
                assert!(exact.uncertainty < 2e-13, "{name}: {exact:?}");
                assert!(found.uncertainty < 1e-9, "{name}: {found:?}");
            }
            if method.is_symplectic() {
                assert_symplectic(&differences, 9.0);
                assert_symplectic(&exact, 13.0);
            } else {
                assert!(worst_of(&exact).dofs.is_some(), "{name}");
                assert_eq!(worst_of(&exact).dofs, worst_of(&differences).dofs, "{name}");
            }
        }
    }
}

/// Pendula side by side, each with its own frequency, by symplectic Euler, after what `spoil` does.
fn pendula(
    dof: usize,
    spoil: impl Fn(f64, &mut [f64], &mut [f64]) + Send + Sync,
) -> impl TimeAdvance {
    PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
        spoil(h, q, p);
        for i in 0..q.len() {
            let next = (i + 1) % q.len();
            let before = (i + q.len() - 1) % q.len();
            let springs = (q[next] - q[i]).sin() - (q[i] - q[before]).sin();
            p[i] += h * (springs - (1.0 + 0.01 * i as f64) * q[i].sin());
        }
        for i in 0..q.len() {
            q[i] += h * p[i];
        }
    })
}

#[test]
fn the_degrees_of_freedom_that_carry_the_defect_are_named() {
    for (dof, i, j) in [(8, 5, 2), (100, 37, 71)] {
        let phase_loop = circle(dof).with_random_phases(3);
        assert_symplectic(&run(&pendula(dof, |_, _, _| {}), &phase_loop, 0.3), 11.0);

        // One momentum is damped by 1 − h/100: ω of its plane shrinks by that, and no pair of unit
        // norms has more. A random pair that is not conjugate has less.
        let damped = pendula(dof, move |h, _, p| p[i] *= 1.0 - 0.01 * h);
        let worst = worst_of(&run(&damped, &phase_loop, 0.3));
        assert_eq!(worst.dofs, Some((i, i)));
        if dof == 8 {
            assert!((worst.signed + 0.003).abs() <= worst.uncertainty);
        }
        assert!(worst.magnitude() <= 0.003 + worst.uncertainty);
        assert!(worst.magnitude() > 0.001 && worst.uncertainty < 1e-11);

        // A force of j on i without its reaction.
        let one_sided = PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
            p[i] += 0.5 * h * q[j];
            for i in 0..q.len() {
                p[i] -= h * q[i].sin();
            }
        });
        let report = run(&one_sided, &phase_loop, 0.3);
        let worst = worst_of(&report);
        let dofs = worst.dofs.unwrap();
        assert!(dofs == (i, j) || dofs == (j, i), "{dofs:?}");
        // (ω(DΦ ∂_qj, DΦ ∂_qi) − 0) / (1 · 1) = −h/2, and no pair of unit norms has more.
        assert!(worst.magnitude() <= 0.15 + worst.uncertainty);
        assert_eq!(report.full, dof == 8);
        if report.full {
            assert!((worst.magnitude() - 0.15).abs() <= worst.uncertainty);
        }
        assert!(worst.uncertainty < 1e-11);
    }
}

#[test]
fn the_cost_is_known_beforehand() {
    let test = JacobianTest::default();
    for (dof, expected) in [
        (1, 8 * (13 + 12 * 2)),
        (2, 8 * (13 + 12 * 4)),
        (8, 8 * (13 + 12 * 16)),
        (9, 8 * (13 + 12 * 4)),
    ] {
        let made = run(&pendula(dof, |_, _, _| {}), &circle(dof), 0.3).evaluations;
        assert_eq!((made, test.evaluations(dof, false)), (expected, expected));
    }
}

/// Two masses on a spring, each carried by its velocity.
struct Masses {
    weights: Option<[f64; 2]>,
}

impl TimeAdvance for Masses {
    fn dof(&self) -> usize {
        2
    }
    fn advance(&self, h: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
        for k in 0..block.len() {
            let pull = block.q.row(1)[k] - block.q.row(0)[k];
            block.p.row_mut(0)[k] += h * pull;
            block.p.row_mut(1)[k] -= h * pull / 3.0;
            for i in 0..2 {
                block.q.row_mut(i)[k] += h * block.p.row(i)[k];
            }
        }
        Ok(())
    }
    fn coordinates(&self) -> Coordinates {
        let plain = Coordinates::plain(2);
        match self.weights {
            None => plain,
            Some(weights) => plain.with_weights(weights.to_vec()).unwrap(),
        }
    }
}

#[test]
fn weights_make_momenta_canonical() {
    let masses = |weights| run(&Masses { weights }, &circle(2), 0.5);
    assert_symplectic(&masses(Some([1.0, 3.0])), 11.0);
    assert_symplectic(&masses(Some([-2.0, -6.0])), 11.0);
    // Velocities taken for momenta: ω(DΦ ∂_q0, DΦ ∂_q1) = h/3 − h for the kick.
    let worst = worst_of(&masses(None));
    assert!((worst.magnitude() - (0.5 - 0.5 / 3.0)).abs() < 1e-11);
    assert_eq!(worst.dofs, Some((0, 1)));
}

/// A pendulum whose angle is stored in [0, 2π).
struct Wrapped;

impl TimeAdvance for Wrapped {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            *p -= h * q.sin();
            *q = (*q + h * *p).rem_euclid(std::f64::consts::TAU);
        }
        Ok(())
    }
    fn coordinates(&self) -> Coordinates {
        let plain = Coordinates::plain(1);
        plain.with_periods(vec![std::f64::consts::TAU]).unwrap()
    }
}

#[test]
fn wrapped_positions_are_compared_modulo_their_period() {
    let test = JacobianTest {
        points: 50,
        ..JacobianTest::default()
    };
    for radius in [0.01, 1.0, 5.0] {
        let phase_loop = Circle::new(vec![0.0], vec![0.0], radius).unwrap();
        let report = test.run(&Wrapped, &phase_loop, 0.5).unwrap();
        assert_eq!(report.not_differentiable, 0);
        assert_symplectic(&report, 9.0);
    }
}

/// A kick by `force`, then a drift.
fn kick_drift(force: impl Fn(f64) -> f64 + Send + Sync) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] += h * force(q[0]);
        q[0] += h * p[0];
    })
}

/// A kick and a drift in single precision, with momenta damped by a factor.
fn single_precision(damping: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let (h, x) = (h as f32, q[0] as f32);
        let y = (p[0] as f32 - h * x.sin()) * damping as f32;
        q[0] = f64::from(x + h * y);
        p[0] = f64::from(y);
    })
}

#[test]
fn single_precision_leaves_a_bound() {
    let test = JacobianTest {
        points: 100,
        ..JacobianTest::default()
    };
    for radius in [1.0, 0.1] {
        for phase_loop in [
            Circle::new(vec![0.3], vec![-0.2], radius).unwrap(),
            Circle::new(vec![50.0], vec![0.0], radius).unwrap(),
        ] {
            let report = test.run(&single_precision(1.0), &phase_loop, 0.5).unwrap();
            let JacobianVerdict::Undecided {
                reason: Inconclusive::WeakBound { bound, .. },
            } = report.verdict()
            else {
                panic!("{}", report.verdict());
            };
            assert!((1e-6..0.05).contains(&bound), "{bound:e}");
            assert_determinant(&report, 0.0, 0.05);
            // The damped map's determinant is its factor: 0.5 is 0.5 in any precision.
            let damped = test.run(&single_precision(0.5), &phase_loop, 0.5).unwrap();
            assert_determinant(&damped, -0.5, 0.05);
            worst_of(&damped);
        }
    }
}

#[test]
fn single_precision_beyond_its_resolution_makes_no_claim() {
    // Far away from the origin values are coarser than the differences, then than the loop.
    for q in [1e3, 1e4, 1e5, 1e6, 1e7] {
        let phase_loop = Circle::new(vec![q], vec![0.0], 1.0).unwrap();
        let report = run(&single_precision(1.0), &phase_loop, 0.5);
        assert!(
            matches!(report.verdict(), JacobianVerdict::Undecided { .. }),
            "q = {q}: {}",
            report.verdict()
        );
    }
}

#[test]
fn a_wedge_is_symplectic_off_its_break() {
    let test = JacobianTest {
        points: 200,
        ..JacobianTest::default()
    };
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    for h in [1.9, 0.5, 0.1] {
        let report = test.run(&kick_drift(|x| -x.signum()), &unit, h).unwrap();
        assert!(report.not_differentiable <= 1);
        if h > 0.2 {
            assert_symplectic(&report, 9.0);
        } else {
            // The drift alone deforms the loop by h.
            assert!(matches!(
                report.verdict(),
                JacobianVerdict::Undecided {
                    reason: Inconclusive::LittleDeformation { .. }
                }
            ));
        }
    }
}

#[test]
fn a_point_on_a_jump_or_kink_is_named_and_left_out() {
    // The first point of the test: the map breaks right there, or within the smallest differences.
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    let s = run(&kick_drift(|x| -x), &unit, 0.5).points[0].s;
    let q = (std::f64::consts::TAU * s).sin();
    for distance in [0.0, 1e-12, 1e-8, -1e-6] {
        let at = q + distance;
        type Force = Box<dyn Fn(f64) -> f64 + Send + Sync>;
        let forces: [(&str, Force); 3] = [
            (
                "jump",
                Box::new(move |x: f64| if x < at { 1.0 } else { -1.0 }),
            ),
            (
                "small jump",
                Box::new(move |x: f64| x.sin() + if x < at { 1e-4 } else { 0.0 }),
            ),
            ("kink", Box::new(move |x: f64| -(x - at).abs())),
        ];
        for (name, force) in forces {
            let report = run(&kick_drift(force), &unit, 0.5);
            assert!(report.not_differentiable >= 1, "{name} at {distance:e}");
            assert!(report.points[0].worst.is_none(), "{name} at {distance:e}");
            assert_symplectic(&report, 9.0);
        }
    }
}

#[test]
fn steps_of_every_size_make_no_false_verdict() {
    // A force in steps, flat between them: symplectic almost everywhere, noise where steps are small.
    for exponent in 0..=14 {
        let width = 10f64.powi(-exponent);
        let map = kick_drift(move |x| -(x / width).floor() * width);
        let verdict = run(&map, &circle(1), 0.5).verdict();
        assert!(
            !matches!(verdict, JacobianVerdict::NotSymplectic { .. }),
            "steps of {width:e}: {verdict}"
        );
    }
}

#[test]
fn a_map_without_derivatives_is_told() {
    let rough = |x: f64| {
        (0..30)
            .map(|k| (2f64.powi(k) * 7.0 * x).sin().abs() * 0.8f64.powi(k))
            .sum()
    };
    let report = run(&kick_drift(rough), &circle(1), 0.5);
    assert!(
        matches!(
            report.verdict(),
            JacobianVerdict::Undecided {
                reason: Inconclusive::NoDerivative { .. } | Inconclusive::WeakBound { .. }
            }
        ),
        "{}",
        report.verdict()
    );
}

#[test]
fn what_deforms_nothing_tests_nothing() {
    let translation = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        q[0] += h;
        p[0] -= h;
    });
    let verdict = run(&translation, &circle(1), 0.5).verdict();
    assert!(matches!(
        verdict,
        JacobianVerdict::Undecided {
            reason: Inconclusive::LittleDeformation { .. }
        }
    ));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let map = pendula(60, |h, _, p| p[11] *= 1.0 - h);
    let phase_loop = circle(60).with_random_phases(5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| run(&map, &phase_loop, 0.3))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_defect_that_a_symmetric_loop_hides_is_seen() {
    // p' = p (1 + h q / 10): areas grow where q > 0 and shrink where q < 0.
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] *= 1.0 + 0.1 * h * q[0];
        q[0] += h * p[0];
    });
    let centred = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    let diagnostic = Diagnostic {
        loops: 1,
        jacobian: false,
        ..Diagnostic::halving(-1, -4)
    };
    let loops = diagnostic.run(&map, &centred).unwrap().verdict;
    assert_eq!(loops.kind, VerdictKind::Symplectic, "{loops}");
    let report = run(&map, &centred, 0.5);
    let worst = worst_of(&report);
    let q = (std::f64::consts::TAU * worst.s).sin();
    assert!((worst.signed - 0.05 * q).abs() <= worst.uncertainty);
    let finding = compare_jacobian(&report, loops.kind, loops.digits);
    assert_eq!(finding.agreement, Agreement::HiddenFromLoops);
}

#[test]
fn coordinates_of_different_sizes_are_counted_in_their_own() {
    // q in metres, p in kilograms times metres a second, of an electron: H = p²/2m + ….
    let mass = 9e-31;
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * mass * q[0] * 1e24 * (1.0 - 1e-7 * p[0] / mass);
        q[0] += h * p[0] / mass;
    });
    let phase_loop = FourierLoop::random(vec![0.0], vec![0.0], &[1e-6], &[1e-24], 2).unwrap();
    let report = run(&map, &phase_loop, 1e-12);
    // ∂p'/∂p = 1 + 1e5 q for h = 1e-12, and the drift keeps areas.
    for point in &report.points {
        let found = point.worst.unwrap();
        let mut state = ([0.0], [0.0]);
        let mut block = symplint::Block::new(
            RowsMut::new(&mut state.0, 1, 1, 1),
            RowsMut::new(&mut state.1, 1, 1, 1),
        );
        phase_loop.sample(&[point.s], &mut block);
        let exact = 1e-12 * 1e24 * 1e-7 * state.0[0];
        assert!((found.signed - exact).abs() <= found.uncertainty);
        assert!(found.uncertainty < 1e-10);
    }
}

#[test]
fn bad_input_is_an_error() {
    let map = kick_drift(|x| -x);
    let unit = circle(1);
    let test = JacobianTest::default();
    for h in [0.0, f64::NAN, f64::INFINITY] {
        let error = test.run(&map, &unit, h).unwrap_err();
        assert!(matches!(
            error,
            Error::OutOfRange {
                what: "step size",
                ..
            }
        ));
    }
    let none = [
        JacobianTest { points: 0, ..test },
        JacobianTest {
            directions: 1,
            ..test
        },
        JacobianTest {
            budget: 8 * 37 - 1,
            ..test
        },
    ];
    for test in none {
        assert!(matches!(
            test.run(&map, &unit, 0.5),
            Err(Error::OutOfRange { .. })
        ));
    }
    let error = test.run(&map, &circle(2), 0.5).unwrap_err();
    assert!(matches!(error, Error::DofMismatch { .. }));
    let flat = FourierLoop::random(vec![1.0], vec![1.0], &[1.0], &[0.0], 1).unwrap();
    let error = test.run(&map, &flat, 0.5).unwrap_err();
    assert!(error.to_string().contains("momenta"), "{error}");
    let failing = kick_drift(|x| x.ln());
    let error = test.run(&failing, &unit, 0.5).unwrap_err();
    assert!(matches!(error, Error::OnTheWay { .. }), "{error}");
}
