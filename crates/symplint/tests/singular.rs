//! Loops that run round a point at which the map is singular.

use symplint::verdict::{Advice, Finding};
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
    PerSample::new(2, move |h: f64, q: &mut [f64], p: &mut [f64]| {
        let (x, y) = (q[0] - 0.2, q[1] + 0.1);
        let squared = x * x + y * y;
        p[0] -= h * (q[0] - strength * -y / squared);
        p[1] -= h * (q[1] - strength * x / squared);
        q[0] += h * p[0];
        q[1] += h * p[1];
    })
}

/// A circle in the plane of positions, of which the momenta follow.
fn circle(q0: Vec<f64>) -> Circle {
    Circle::new(q0, vec![0.3, -0.2], 1.0)
        .unwrap()
        .with_random_phases(4)
}

#[test]
fn a_closed_kick_round_an_axis_convicts_nobody() {
    for strength in [1.0, 1e-3] {
        let around = verdict(&vortex(strength), &circle(vec![0.1, 0.0]));
        assert_eq!(around.kind, VerdictKind::Undecided, "{around}");
        let Finding::ChangesAtAPoint {
            contraction,
            change,
            ..
        } = &around.findings[0]
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
