//! Maps on a constraint manifold: RATTLE for rods in Cartesian coordinates, with a projection and without.

use symplint::map::ProjectedLoop;
use symplint::verdict::{Advice, Agreement, DomainFinding, Finding, JacobianVerdict, RunFinding};
use symplint::{
    Circle, Diagnosis, Diagnostic, JacobianTest, Loop, PerSample, TimeAdvance, VerdictKind,
};

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A force on the end of a rod of length 1: gravity, and a spring off the axes.
fn kick(tau: f64, q: &[f64], p: &mut [f64]) {
    let last = p.len() - 1;
    p[last] -= tau;
    for i in 0..p.len() {
        p[i] -= tau * 0.7 * (q[i] - 0.2 * (i + 1) as f64);
    }
}

/// A unit mass at the end of a rod of length 1 by RATTLE (H. C. Andersen, J. Comput. Phys. 52, 1983).
fn rattle(h: f64, q: &mut [f64], p: &mut [f64]) {
    let before = q.to_vec();
    kick(0.5 * h, q, p);
    (0..q.len()).for_each(|i| q[i] += h * p[i]);
    let (a, b) = (dot(&before, &before), dot(q, &before));
    let pull = (-b + (b * b - a * (dot(q, q) - 1.0)).sqrt()) / a;
    for i in 0..q.len() {
        q[i] += pull * before[i];
        p[i] += pull / h * before[i];
    }
    kick(0.5 * h, q, p);
    onto_tangent(q, p);
}

fn onto_tangent(q: &[f64], p: &mut [f64]) {
    let along = dot(q, p) / dot(q, q);
    (0..q.len()).for_each(|i| p[i] -= along * q[i]);
}

fn onto_rod(q: &mut [f64], p: &mut [f64]) {
    let length = dot(q, q).sqrt();
    q.iter_mut().for_each(|q| *q /= length);
    onto_tangent(q, p);
}

/// The same rod by Heun's method, projected after the step: on the manifold, and not symplectic there.
fn projected_heun(h: f64, q: &mut [f64], p: &mut [f64]) {
    let field = |q: &[f64], p: &[f64]| {
        let mut force = vec![0.0; p.len()];
        kick(1.0, q, &mut force);
        let pull = -(dot(&force, q) + dot(p, p)) / dot(q, q);
        (0..q.len()).for_each(|i| force[i] += pull * q[i]);
        (p.to_vec(), force)
    };
    let (dq, dp) = field(q, p);
    let ahead = |x: &[f64], dx: &[f64]| -> Vec<f64> {
        x.iter().zip(dx).map(|(x, dx)| x + h * dx).collect()
    };
    let (next_dq, next_dp) = field(&ahead(q, &dq), &ahead(p, &dp));
    for i in 0..q.len() {
        q[i] += 0.5 * h * (dq[i] + next_dq[i]);
        p[i] += 0.5 * h * (dp[i] + next_dp[i]);
    }
    onto_rod(q, p);
}

fn map(dof: usize, step: fn(f64, &mut [f64], &mut [f64])) -> impl TimeAdvance {
    PerSample::new(dof, step)
}

fn on_rod(dof: usize, step: fn(f64, &mut [f64], &mut [f64])) -> impl TimeAdvance {
    PerSample::new(dof, step).with_projection(onto_rod)
}

/// A circle in all coordinates, put on the manifold.
fn given(map: &dyn TimeAdvance) -> impl Loop + '_ {
    let (q0, p0) = match map.dof() {
        2 => (vec![0.6, -0.8], vec![0.4, 0.3]),
        _ => (vec![0.6, -0.6, 0.5], vec![0.4, 0.3, -0.2]),
    };
    let circle = Circle::new(q0, p0, 0.3)
        .unwrap()
        .with_phases(symplint::Phases::Random { seed: 5 });
    ProjectedLoop::new(circle, map)
}

fn diagnose(map: &dyn TimeAdvance, manifold: &dyn TimeAdvance) -> Diagnosis {
    let diagnosis = Diagnostic::halving(-1, -6)
        .run(map, &given(manifold))
        .unwrap();
    let made = diagnosis.evidence.evaluations.made;
    assert!(made < 50_000, "{made}");
    diagnosis
}

#[test]
fn on_its_manifold_rattle_is_symplectic() {
    for dof in [2, 3] {
        let rattle = on_rod(dof, rattle);
        let diagnosis = diagnose(&rattle, &rattle);
        let verdict = &diagnosis.verdict;
        assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict}");
        assert!(verdict.digits.unwrap() > 12.5, "{verdict}");
        let jacobian = diagnosis.evidence.jacobian.as_ref().unwrap();
        assert!(jacobian.projected && jacobian.full);
        assert!(jacobian.bound.unwrap() < 1e-9, "{jacobian:?}");
        let agree = |finding: &Finding| matches!(finding, Finding::Run(RunFinding::Jacobian { finding }) if finding.agreement == Agreement::Symplectic);
        assert!(verdict.findings.iter().any(agree), "{verdict}");
    }
}

#[test]
fn loops_off_the_manifold_do_not_decide_without_a_projection() {
    for dof in [2, 3] {
        let (rattle, manifold) = (map(dof, rattle), on_rod(dof, rattle));
        let diagnosis = diagnose(&rattle, &manifold);
        let verdict = &diagnosis.verdict;
        assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict}");
        let Finding::Domain(DomainFinding::Projects {
            smallest,
            given: Some(bound),
            beside: Some((_, defect)),
        }) = verdict.findings[0]
        else {
            panic!("{verdict}");
        };
        assert!(
            smallest < 1e-6 && bound < 1e-12 && defect > 1e-2,
            "{verdict}"
        );
        assert_eq!(verdict.advice, [Advice::Project]);
        assert!(diagnosis.evidence.localisation.is_none());

        let alone = Diagnostic {
            loops: 1,
            jacobian: false,
            ..Diagnostic::halving(-1, -6)
        };
        let verdict = alone.run(&rattle, &given(&manifold)).unwrap().verdict;
        assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict}");
    }
}

#[test]
fn the_given_loop_shows_that_a_projected_method_is_not_symplectic() {
    for dof in [2, 3] {
        let manifold = on_rod(dof, projected_heun);
        let bare = map(dof, projected_heun);
        for heun in [&manifold as &dyn TimeAdvance, &bare] {
            let verdict = diagnose(heun, &manifold).verdict;
            assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{verdict}");
        }
        let verdict = JacobianTest::default()
            .run(&manifold, &given(&manifold), 0.5)
            .unwrap()
            .verdict();
        let JacobianVerdict::NotSymplectic { worst } = verdict else {
            panic!("{verdict}");
        };
        assert_eq!(worst.dofs, None);
    }
}

/// Twenty rods side by side: random tangent vectors, projected.
#[test]
fn many_constraints() {
    fn each(step: impl Fn(&mut [f64], &mut [f64]), q: &mut [f64], p: &mut [f64]) {
        for (q, p) in q.chunks_mut(2).zip(p.chunks_mut(2)) {
            step(q, p);
        }
    }
    for (step, kind) in [
        (
            rattle as fn(f64, &mut [f64], &mut [f64]),
            VerdictKind::Symplectic,
        ),
        (projected_heun, VerdictKind::NotSymplectic),
    ] {
        let advance = move |h: f64, q: &mut [f64], p: &mut [f64]| each(|q, p| step(h, q, p), q, p);
        let rods = PerSample::new(40, advance).with_projection(|q, p| each(onto_rod, q, p));
        let centre = |x: [f64; 2]| x.repeat(20);
        let circle = Circle::new(centre([0.6, -0.8]), centre([0.4, 0.3]), 0.3)
            .unwrap()
            .with_phases(symplint::Phases::Random { seed: 5 });
        let given = ProjectedLoop::new(circle, &rods);
        let diagnosis = Diagnostic::halving(-1, -4).run(&rods, &given).unwrap();
        assert_eq!(diagnosis.verdict.kind, kind, "{}", diagnosis.verdict);
        let jacobian = diagnosis.evidence.jacobian.unwrap();
        assert!(jacobian.projected && !jacobian.full);
        if kind == VerdictKind::Symplectic {
            assert!(jacobian.bound.unwrap() < 1e-9, "{jacobian:?}");
        }
        let bare = PerSample::new(40, advance);
        let verdict = Diagnostic::halving(-1, -4)
            .run(&bare, &given)
            .unwrap()
            .verdict;
        let without = match kind {
            VerdictKind::Symplectic => VerdictKind::Undecided,
            kind => kind,
        };
        assert_eq!(verdict.kind, without, "{verdict}");
    }
}

/// For a map that is not singular, a random loop still shows a defect, however strong its friction: here the given loop lies in a
/// plane that the map keeps.
#[test]
fn a_random_loop_elsewhere_decides_that_a_map_is_not_symplectic() {
    for friction in [0.95, 1e-2, 1e-4] {
        let map = PerSample::new(2, move |h, q, p| {
            for i in 0..2 {
                p[i] -= h * q[i].sin();
                q[i] += h * p[i];
            }
            p[1] *= friction;
        });
        let none = vec![1.0, 0.0];
        let circle = Circle::with_radii(vec![0.3, 0.0], vec![0.2, 0.0], none.clone(), none);
        let diagnosis = Diagnostic::halving(-1, -4).run(&map, &circle.unwrap());
        let verdict = diagnosis.unwrap().verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::NotSymplectic,
            "{friction}: {verdict}"
        );
    }
}

#[test]
fn a_loop_beside_the_manifold_is_told() {
    let circle = Circle::new(vec![0.6, -0.8], vec![0.4, 0.3], 0.3).unwrap();
    let verdict = Diagnostic::halving(-1, -4)
        .run(&on_rod(2, rattle), &circle)
        .unwrap()
        .verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict}");
    let verdict = Diagnostic::halving(-1, -4)
        .run(&map(2, rattle), &circle)
        .unwrap()
        .verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict}");
    let Finding::Domain(DomainFinding::LoopBesideManifold { first, second, .. }) =
        verdict.findings[0]
    else {
        panic!("{verdict}");
    };
    assert!(first > 1e-2 && second < 1e-12, "{verdict}");
    assert_eq!(verdict.advice, [Advice::LoopOnManifold]);

    // On the manifold this one changes it, too.
    let verdict = Diagnostic::halving(-1, -4)
        .run(&map(2, projected_heun), &circle)
        .unwrap()
        .verdict;
    assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{verdict}");
}
