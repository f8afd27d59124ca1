//! Maps whose Jacobians have closed forms.

use symplint::map::Capabilities;
use symplint::state::RowsMut;
use symplint::verdict::{Agreement, InconclusiveReason, JacobianVerdict, compare_jacobian};
use symplint::{
    Circle, Coordinates, Diagnostic, FourierLoop, JacobianTest, Loop, PerSample, StepFailure,
    TimeAdvance, VerdictKind,
};

use crate::jacobian::{assert_determinant, assert_symplectic, circle, run, worst_of};

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

    fn capabilities(&self) -> Capabilities<'_> {
        let plain = Coordinates::plain(2);
        Capabilities::of_coordinates(match self.weights {
            None => plain,
            Some(weights) => plain.with_weights(weights.to_vec()).unwrap(),
        })
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

    fn capabilities(&self) -> Capabilities<'_> {
        let plain = Coordinates::plain(1);
        Capabilities::of_coordinates(plain.with_periods(vec![std::f64::consts::TAU]).unwrap())
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
            reason: InconclusiveReason::LittleDeformation { .. }
        }
    ));
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
