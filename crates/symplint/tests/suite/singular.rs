//! Loops that run round a point at which the map is singular.

use symplint::verdict::{Advice, DomainFinding, Finding};
use symplint::{Circle, Diagnostic, PerSample, TimeAdvance, Verdict, VerdictKind};

fn verdict(map: &dyn TimeAdvance, circle: &Circle) -> Verdict {
    Diagnostic::halving(-1, -4)
        .run(map, circle)
        .unwrap()
        .verdict
}

/// A kick along the gradient of the angle round an axis at (0.2, −0.1) of the plane of positions: a closed field of forces
/// that no potential of one value has. Then a drift.
fn vortex(strength: f64) -> impl TimeAdvance {
    vortices([[0.2, -0.1, strength]])
}

/// The same with axes at x, y, each of its strength.
fn vortices<const N: usize>(axes: [[f64; 3]; N]) -> impl TimeAdvance {
    PerSample::new(2, move |h: f64, q: &mut [f64], p: &mut [f64]| {
        let (mut along_x, mut along_y) = (-q[0], -q[1]);
        for [x, y, strength] in axes {
            let (x, y) = (q[0] - x, q[1] - y);
            let squared = x * x + y * y;
            along_x -= strength * y / squared;
            along_y += strength * x / squared;
        }
        p[0] += h * along_x;
        p[1] += h * along_y;
        q[0] += h * p[0];
        q[1] += h * p[1];
    })
}

/// A circle in the plane of positions, of which the momenta follow.
fn circle(q0: Vec<f64>) -> Circle {
    Circle::new(q0, vec![0.3, -0.2], 1.0)
        .unwrap()
        .with_phases(symplint::Phases::Random { seed: 4 })
}

#[test]
fn a_closed_kick_round_an_axis_does_not_decide() {
    for strength in [1.0, 1e-3] {
        let around = verdict(&vortex(strength), &circle(vec![0.1, 0.0]));
        assert_eq!(around.kind, VerdictKind::Undecided, "{around}");
        let Finding::Domain(DomainFinding::ChangesAtAPoint {
            contraction,
            change,
            ..
        }) = &around.findings[0]
        else {
            panic!("{around}");
        };
        assert!(
            contraction.area < 1e-3 && change.signed.abs() > 1e-5,
            "{around}"
        );
        assert_eq!(around.advice, [Advice::LoopBesidePoint]);
        // Following the advice decides.
        let beside = verdict(&vortex(strength), &circle(vec![4.0, 0.0]));
        assert_eq!(beside.kind, VerdictKind::Symplectic, "{beside}");
    }
}

#[test]
fn without_a_jacobian_one_point_of_it_spares_the_contraction() {
    let alone = Diagnostic {
        jacobian: false,
        loops: 1,
        budget: Some(200_000),
        ..Diagnostic::halving(-1, -4)
    };
    let around = alone.run(&vortex(1.0), &circle(vec![0.1, 0.0])).unwrap();
    assert_eq!(
        around.verdict.kind,
        VerdictKind::Undecided,
        "{}",
        around.verdict
    );
    // The explicit Euler method on a spring has a defect everywhere.
    let euler = PerSample::new(2, |h: f64, q: &mut [f64], p: &mut [f64]| {
        for (q, p) in q.iter_mut().zip(p) {
            (*q, *p) = (*q + h * *p, *p - h * *q);
        }
    });
    let found = alone.run(&euler, &circle(vec![0.1, 0.0])).unwrap();
    assert_eq!(
        found.verdict.kind,
        VerdictKind::NotSymplectic,
        "{}",
        found.verdict
    );
    assert_eq!(found.evidence.contraction.map(|found| found.points), None);
}

#[test]
fn several_axes_do_not_decide_in_any_budget() {
    let two = vortices([[0.4, 0.0, 1.0], [-0.4, 0.1, 0.7]]);
    let opposite = vortices([[0.4, 0.0, 1.0], [-0.4, 0.1, -0.5]]);
    let maps: [&dyn TimeAdvance; 3] = [&vortex(1.0), &two, &opposite];
    for map in maps {
        for budget in [200, 500, 1_000, 2_000, 5_000, 20_000, 200_000] {
            let diagnostic = Diagnostic {
                budget: Some(budget),
                ..Diagnostic::halving(-1, -4)
            };
            let found = diagnostic.run(map, &circle(vec![0.1, 0.0])).unwrap();
            let verdict = found.verdict;
            assert_eq!(verdict.kind, VerdictKind::Undecided, "{budget}: {verdict}");
            let said = matches!(
                verdict.findings[0],
                Finding::Domain(DomainFinding::ChangesAtAPoint { .. })
            );
            assert_eq!(said, budget == 200_000, "{budget}: {verdict}");
            // Both the budget and another loop would decide.
            assert!(
                verdict.advice.contains(&Advice::LoopBesidePoint),
                "{budget}: {verdict}"
            );
        }
    }
}

/// A curl that is spread over the disc, and one that is narrow, but no point.
#[test]
fn a_defect_of_an_area_is_a_defect() {
    for width in [3.0, 0.3] {
        let map = PerSample::new(2, move |h: f64, q: &mut [f64], p: &mut [f64]| {
            let (x, y) = (q[0] - 0.2, q[1] + 0.1);
            let swirl = (-(x * x + y * y) / (width * width)).exp();
            p[0] -= h * (q[0] + swirl * y);
            p[1] -= h * (q[1] - swirl * x);
            q[0] += h * p[0];
            q[1] += h * p[1];
        });
        let found = verdict(&map, &circle(vec![0.1, 0.0]));
        assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    }
}
