//! Maps that are symplectic in other variables: the form that each preserves is named, and its setting makes the map symplectic.

use symplint::map::{NonCanonical, OneForm};
use symplint::verdict::{Cause, CauseKind};
use symplint::{
    Block, Circle, Coordinates, Diagnosis, Diagnostic, PerSample, TimeAdvance, VerdictKind,
};

const Q: [f64; 3] = [0.3, 1.0, 2.0];
const P: [f64; 3] = [0.2, -0.1, 0.4];

fn diagnose(map: &dyn TimeAdvance) -> Diagnosis {
    let dof = map.dof();
    let circle = Circle::new(Q[..dof].to_vec(), P[..dof].to_vec(), 0.5).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::halving(-1, -5)
    };
    diagnostic.run(map, &circle).unwrap()
}

/// The cause of a map that is not symplectic in its variables.
fn cause(map: &dyn TimeAdvance, kind: CauseKind) -> Cause {
    let found = diagnose(map);
    assert_eq!(
        found.verdict.kind,
        VerdictKind::NotSymplectic,
        "{}",
        found.verdict
    );
    let cause = (found.verdict.cause.clone())
        .unwrap_or_else(|| panic!("{}\n{:?}", found.verdict, found.evidence.preserved_form));
    assert_eq!(cause.kind, kind, "{}", cause.text);
    assert_eq!(found.verdict.advice()[0], cause.remedy);
    cause
}

/// Leapfrog of bodies with pair forces: `p` are velocities.
fn bodies(masses: [f64; 3]) -> impl Fn(f64, &mut [f64], &mut [f64]) {
    move |h, q, v| {
        (0..3).for_each(|i| q[i] += 0.5 * h * v[i]);
        for i in 0..3 {
            let pairs: f64 = (0..3).map(|j| masses[j] * (q[i] - q[j]).sin()).sum();
            v[i] -= h * (pairs + 0.5 * q[i].sin());
        }
        (0..3).for_each(|i| q[i] += 0.5 * h * v[i]);
    }
}

#[test]
fn forgotten_masses_are_named_and_make_the_map_symplectic() {
    let masses = [1.0, 1e-4, 1e-2];
    let cause = cause(
        &PerSample::new(3, bodies(masses)),
        CauseKind::VelocitiesForMomenta,
    );
    assert_eq!(cause.setting.as_deref(), Some("weight = [1, 0.0001, 0.01]"));
    assert!(cause.digits.unwrap() > 13.0);
    let coordinates = Coordinates::plain(3).with_weights(masses.to_vec()).unwrap();
    let map = PerSample::new(3, bodies(masses))
        .with_coordinates(coordinates)
        .unwrap();
    assert_eq!(diagnose(&map).verdict.kind, VerdictKind::Symplectic);
}

#[test]
fn weights_that_are_wrong_are_named_in_total() {
    let wrong = Coordinates::plain(3)
        .with_weights(vec![1.0, 1e-4, 3e-2])
        .unwrap();
    let map = PerSample::new(3, bodies([1.0, 1e-4, 1e-2]))
        .with_coordinates(wrong)
        .unwrap();
    let cause = cause(&map, CauseKind::VelocitiesForMomenta);
    assert_eq!(cause.setting.as_deref(), Some("weight = [1, 0.0001, 0.01]"));
}

fn two_pendula(h: f64, q: &mut [f64], p: &mut [f64], sign: f64) {
    let force = (q[0] - sign * q[1]).sin();
    p[0] -= h * (force + q[0].sin());
    p[1] += h * sign * sign * force;
    q[0] += h * p[0];
    q[1] += sign * h * p[1];
}

#[test]
fn a_pair_with_the_other_sign_is_named() {
    // q1 is minus the position.
    let map = PerSample::new(2, |h, q, p| two_pendula(h, q, p, -1.0));
    let cause = cause(&map, CauseKind::SignOfAPair);
    assert_eq!(cause.setting.as_deref(), Some("weight = [1, -1]"));
}

#[test]
fn permuted_pairs_are_named() {
    let map = PerSample::new(2, |h, q, p| {
        p.swap(0, 1);
        two_pendula(h, q, p, 1.0);
        p.swap(0, 1);
    });
    let swapped = cause(&map, CauseKind::PairsPermuted);
    assert_eq!(swapped.setting.as_deref(), Some("p = p[:, [1, 0]]"));
    // Pendula that are not coupled: each pair has its own factor.
    let map = PerSample::new(3, |h, q, p| {
        for i in 0..3 {
            p[(i + 1) % 3] -= h * q[i].sin();
            q[i] += h * p[(i + 1) % 3];
        }
    });
    let cause = cause(&map, CauseKind::PairsPermuted);
    assert_eq!(cause.setting.as_deref(), Some("p = p[:, [1, 2, 0]]"));
    assert!(cause.text.contains("3 groups"), "{}", cause.text);
}

/// A rotation of the velocity by a uniform field between two kicks in a potential.
fn boris(h: f64, x: &mut [f64], v: &mut [f64], field: f64) {
    let kick = |x: &[f64], v: &mut [f64]| {
        v[0] -= 0.5 * h * (x[0] + 2.0 * x[0] * x[1]);
        v[1] -= 0.5 * h * (x[1] + x[0] * x[0] - x[1] * x[1]);
    };
    x[0] += 0.5 * h * v[0];
    x[1] += 0.5 * h * v[1];
    kick(x, v);
    let t = 0.5 * h * field;
    let s = 2.0 * t / (1.0 + t * t);
    let prime = [v[0] + t * v[1], v[1] - t * v[0]];
    (v[0], v[1]) = (v[0] + s * prime[1], v[1] - s * prime[0]);
    kick(x, v);
    x[0] += 0.5 * h * v[0];
    x[1] += 0.5 * h * v[1];
}

struct Form(Vec<(usize, usize, f64)>, usize);

impl OneForm for Form {
    fn dimension(&self) -> usize {
        self.1
    }
    fn evaluate(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            for b in 0..self.1 {
                let terms = self.0.iter().filter(|entry| entry.1 == b);
                let value: f64 = terms.map(|(a, _, x)| x * block.q.row(*a)[k]).sum();
                block.p.row_mut(b)[k] = value;
            }
        }
    }
}

#[test]
fn kinetic_momenta_in_a_uniform_field_are_named_and_the_form_makes_the_map_symplectic() {
    let map = || PerSample::new(2, |h, x: &mut [f64], v: &mut [f64]| boris(h, x, v, 0.7));
    let found = diagnose(&map());
    let cause = cause(&map(), CauseKind::KineticMomenta);
    assert!(cause.text.contains("dq0∧dq1"), "{}", cause.text);
    let form = found.evidence.preserved_form.unwrap();
    let entries = form.entries.iter();
    let entries = entries.map(|of| (of.coordinates[0], of.coordinates[1], of.value));
    let map = NonCanonical::new(map(), Form(entries.collect(), 4)).unwrap();
    let circle = Circle::new(Q[..2].to_vec(), P[..2].to_vec(), 0.5).unwrap();
    let diagnostic = Diagnostic {
        step_sizes: vec![0.5],
        ..Diagnostic::default()
    };
    let verdict = diagnostic.run(&map, &map.loop_of(circle)).unwrap().verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict}");
    // Exact splitting with the field in the kick: no entry of momenta.
    let map = PerSample::new(2, |h, x, v| {
        x[0] += h * v[0];
        v[1] -= 0.7 * h * v[0];
        x[1] += h * v[1];
        v[0] += 0.7 * h * v[1];
        v[0] -= h * (x[0] + 2.0 * x[0] * x[1]);
        v[1] -= h * (x[1] + x[0] * x[0]);
    });
    let of_splitting = self::cause(&map, CauseKind::KineticMomenta);
    assert_eq!(
        of_splitting.setting.as_deref(),
        Some("p = (p[0] − 0.35 q[1], p[1] + 0.35 q[0])")
    );
}

#[test]
fn fields_of_yee_preserve_another_form() {
    let map = PerSample::new(6, |h, e, b| {
        let n = e.len();
        (0..n).for_each(|i| b[i] -= h * (e[(i + 1) % n] - e[i]));
        let old = b.to_vec();
        (0..n).for_each(|i| e[i] -= h * (old[i] - old[(i + n - 1) % n]));
    });
    let circle = Circle::new(vec![0.0; 6], vec![1.0; 6], 0.5).unwrap();
    let found = Diagnostic::halving(-1, -5).run(&map, &circle).unwrap();
    let cause = found.verdict.cause.unwrap();
    assert_eq!(cause.kind, CauseKind::Fields, "{}", cause.text);
    assert!(
        cause.remedy.contains("vector potential") && cause.remedy.contains("steps of 0.5 alone"),
        "{}",
        cause.remedy
    );
}

/// A splitting in a field B(x) along the third axis, exact in each of its parts: ∂F/∂x0 = B, ∂G/∂x1 = B.
fn splitting_in_a_field(f: fn(&[f64]) -> f64, g: fn(&[f64]) -> f64) -> impl TimeAdvance {
    PerSample::new(2, move |h, x: &mut [f64], v: &mut [f64]| {
        let before = f(x);
        x[0] += h * v[0];
        v[1] -= f(x) - before;
        let before = g(x);
        x[1] += h * v[1];
        v[0] += g(x) - before;
        v[0] -= h * (x[0] + 2.0 * x[0] * x[1]);
        v[1] -= h * (x[1] + x[0] * x[0]);
    })
}

#[test]
fn kinetic_momenta_in_a_field_that_varies_are_named_with_the_field() {
    let linear = splitting_in_a_field(
        |x| 0.7 * x[0] + 0.15 * x[0] * x[0] - 0.2 * x[0] * x[1],
        |x| 0.7 * x[1] + 0.3 * x[0] * x[1] - 0.1 * x[1] * x[1],
    );
    let found = cause(&linear, CauseKind::KineticMomenta);
    let form = "dq0∧dp0 + dq1∧dp1 + (−0.7 − 0.3 q0 + 0.2 q1) dq0∧dq1";
    assert!(found.text.contains(form), "{}", found.text);
    // The canonical momenta that it states make the map symplectic.
    assert_eq!(
        found.setting.as_deref(),
        Some("p = (p[0], p[1] + 0.7 q[0] − 0.2 q[0] q[1] + 0.15 q[0]²)")
    );
    assert!(found.digits.unwrap() > 12.0);
    let potential = |x: &[f64]| 0.7 * x[0] + 0.15 * x[0] * x[0] - 0.2 * x[0] * x[1];
    let canonical = PerSample::new(2, move |h, x: &mut [f64], p: &mut [f64]| {
        let f = |x: &[f64]| 0.7 * x[0] + 0.15 * x[0] * x[0] - 0.2 * x[0] * x[1];
        let g = |x: &[f64]| 0.7 * x[1] + 0.3 * x[0] * x[1] - 0.1 * x[1] * x[1];
        let mut v = [p[0], p[1] - potential(x)];
        let before = f(x);
        x[0] += h * v[0];
        v[1] -= f(x) - before;
        let before = g(x);
        x[1] += h * v[1];
        v[0] += g(x) - before;
        v[0] -= h * (x[0] + 2.0 * x[0] * x[1]);
        v[1] -= h * (x[1] + x[0] * x[0]);
        (p[0], p[1]) = (v[0], v[1] + potential(x));
    });
    assert_eq!(diagnose(&canonical).verdict.kind, VerdictKind::Symplectic);
    let quadratic = splitting_in_a_field(
        |x| 0.5 * x[0] + 0.1 * x[0].powi(3) + 0.25 * x[0] * x[0] * x[1],
        |x| 0.5 * x[1] + 0.3 * x[0] * x[0] * x[1] + 0.25 * x[0] * x[1] * x[1],
    );
    let found = cause(&quadratic, CauseKind::KineticMomenta);
    let field = "(−0.5 − 0.3 q0² − 0.5 q0 q1) dq0∧dq1";
    assert!(found.text.contains(field), "{}", found.text);
}

#[test]
fn a_field_in_three_dimensions_is_named_and_is_closed() {
    // B = (0.4 z, 0.3 x, 0.7 + 0.2 y): each velocity drifts alone, and the field turns the other two exactly.
    let map = PerSample::new(3, |h, x: &mut [f64], v: &mut [f64]| {
        let d = h * v[0];
        v[1] -= (0.7 + 0.2 * x[1]) * d;
        v[2] += 0.3 * (x[0] * d + 0.5 * d * d);
        x[0] += d;
        let d = h * v[1];
        v[0] += 0.7 * d + 0.2 * (x[1] * d + 0.5 * d * d);
        v[2] -= 0.4 * x[2] * d;
        x[1] += d;
        let d = h * v[2];
        v[0] -= 0.3 * x[0] * d;
        v[1] += 0.4 * (x[2] * d + 0.5 * d * d);
        x[2] += d;
        for i in 0..3 {
            v[i] -=
                h * (x[i].sin() + (x[i] - x[(i + 1) % 3]).sin() + (x[i] - x[(i + 2) % 3]).sin());
        }
    });
    let found = cause(&map, CauseKind::KineticMomenta);
    for field in [
        "(−0.7 − 0.2 q1) dq0∧dq1",
        "(0.3 q0) dq0∧dq2",
        "(−0.4 q2) dq1∧dq2",
    ] {
        assert!(found.text.contains(field), "{field}: {}", found.text);
    }
    // The push of Boris in a field that varies preserves no such form.
    let map = PerSample::new(2, |h, x: &mut [f64], v: &mut [f64]| {
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
        let field = 0.7 + 0.3 * x[0] - 0.2 * x[1];
        let half = [x[0], x[1]];
        let mut still = half;
        boris(h, &mut still, v, field);
        x.copy_from_slice(&half);
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
    });
    let kind = diagnose(&map).verdict.cause.map(|cause| cause.kind);
    assert!(
        !matches!(kind, Some(CauseKind::KineticMomenta | CauseKind::OtherForm)),
        "{kind:?}"
    );
}

#[test]
fn maps_that_preserve_no_form_say_so() {
    let curl = PerSample::new(2, |h, q, p| {
        q[0] += h * p[0];
        q[1] += h * p[1];
        p[0] -= h * (q[0].sin() + (q[0] - q[1]).sin() + 0.1 * q[1]);
        p[1] -= h * (q[1].sin() + (q[1] - q[0]).sin() - 0.1 * q[0]);
    });
    // No setting helps either, but the part of the step is known.
    let none = |map: &dyn TimeAdvance| diagnose(map).evidence.preserved_form.unwrap().exists;
    cause(&curl, CauseKind::ForceWithCurl);
    assert_eq!(none(&curl), Some(false));
    let friction = PerSample::new(2, |h, q, p| {
        two_pendula(h, q, p, 1.0);
        p[0] *= 1.0 - 0.1 * h;
    });
    cause(&friction, CauseKind::PartialFriction);
    assert_eq!(none(&friction), Some(false));
    let uniform = PerSample::new(2, |h, q, p| {
        two_pendula(h, q, p, 1.0);
        p.iter_mut().for_each(|p| *p *= 1.0 - 0.1 * h);
    });
    cause(&uniform, CauseKind::Friction);
    let runge_kutta = PerSample::new(2, |h, q, p| {
        let f = |z: &[f64]| {
            let force = (z[0] - z[1]).sin();
            vec![z[2], z[3], -force - z[0].sin(), force]
        };
        let z = [q[0], q[1], p[0], p[1]];
        let at = |k: &[f64], part: f64| -> Vec<f64> {
            z.iter().zip(k).map(|(z, k)| z + part * h * k).collect()
        };
        let k1 = f(&z);
        let k2 = f(&at(&k1, 0.5));
        let k3 = f(&at(&k2, 0.5));
        let k4 = f(&at(&k3, 1.0));
        for c in 0..4 {
            let sum = h / 6.0 * (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]);
            if c < 2 { q[c] += sum } else { p[c - 2] += sum }
        }
    });
    cause(&runge_kutta, CauseKind::NoForm);
}

#[test]
fn the_search_costs_a_symplectic_map_nothing_and_others_little() {
    use symplint::evidence::Check;
    let symplectic = PerSample::new(2, |h, q, p| two_pendula(h, q, p, 1.0));
    let found = diagnose(&symplectic);
    assert_eq!(found.verdict.kind, VerdictKind::Symplectic);
    assert_eq!(found.evidence.evaluations.of(Check::PreservedForm), 0);
    assert_eq!(found.evidence.preserved_form, None);
    let found = diagnose(&PerSample::new(3, bodies([1.0, 3.0, 2.0])));
    let made = found.evidence.evaluations.of(Check::PreservedForm);
    assert!((1..=256).contains(&made), "{made}");
}

#[test]
fn a_form_that_the_method_makes_is_no_sign_of_wrong_variables() {
    // A particle in a uniform field and a parabolic potential, in canonical momenta p = v + A: the push of Boris.
    let map = PerSample::new(2, |h, x, p| {
        let potential = |x: &[f64]| [0.35 * x[1], -0.35 * x[0]];
        let a = potential(x);
        let mut v = [p[0] + a[0], p[1] + a[1]];
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
        let kick = [-0.5 * h * x[0], -0.25 * h * x[1]];
        (0..2).for_each(|i| v[i] += kick[i]);
        let t = 0.35 * h;
        let s = 2.0 * t / (1.0 + t * t);
        let prime = [v[0] + t * v[1], v[1] - t * v[0]];
        v = [v[0] + s * prime[1], v[1] - s * prime[0]];
        (0..2).for_each(|i| v[i] += kick[i]);
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
        let a = potential(x);
        (0..2).for_each(|i| p[i] = v[i] - a[i]);
    });
    let found = cause(&map, CauseKind::OtherForm);
    assert_eq!((found.setting, found.digits), (None, None));
    assert!(found.text.contains("proportional to h^3"), "{}", found.text);
    let headline = diagnose(&map).verdict.headline();
    assert_eq!(
        headline,
        "not symplectic: ∮p·dq changes in proportion to h³"
    );
}
