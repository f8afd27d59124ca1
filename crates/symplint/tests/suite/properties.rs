//! Properties of maps whose properties are known: in closed form, from papers, or by construction.

use symplint::map::Capabilities;
use symplint::verdict::{CauseKind, Growth, Property, PropertyName};
use symplint::{
    Block, Circle, Diagnostic, PerSample, StepFailure, TimeAdvance, Verdict, VerdictKind,
};

fn verdict(map: &dyn TimeAdvance, symmetric: bool) -> Verdict {
    let dof = map.dof();
    let centre = |a: f64| (0..dof).map(|i| a + 0.17 * i as f64).collect::<Vec<f64>>();
    let circle = Circle::new(centre(0.3), centre(0.5), 0.8).unwrap();
    let diagnostic = Diagnostic {
        symmetric,
        ..Diagnostic::halving(-2, -7)
    };
    diagnostic.run(map, &circle).unwrap().verdict
}

fn property(verdict: &Verdict, name: PropertyName) -> &Property {
    let mut properties = verdict.properties.iter();
    properties.find(|found| found.name == name).unwrap()
}

fn holds(verdict: &Verdict, name: PropertyName) -> Option<bool> {
    property(verdict, name).holds
}

/// The Boris push of Hénon and Heiles' potential in two dimensions, in a magnetic field B(x): positions at half steps.
fn boris(field: fn(&[f64]) -> f64) -> impl TimeAdvance {
    PerSample::new(2, move |h, x: &mut [f64], v: &mut [f64]| {
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
        let kick = [-x[0] - 2.0 * x[0] * x[1], -x[1] - x[0] * x[0] + x[1] * x[1]];
        (0..2).for_each(|i| v[i] += 0.5 * h * kick[i]);
        let t = 0.5 * h * field(x);
        let s = 2.0 * t / (1.0 + t * t);
        let turned = [v[0] + t * v[1], v[1] - t * v[0]];
        (v[0], v[1]) = (v[0] + s * turned[1], v[1] - s * turned[0]);
        (0..2).for_each(|i| v[i] += 0.5 * h * kick[i]);
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
    })
}

#[test]
fn the_boris_push_preserves_volume_and_is_symmetric_but_not_symplectic_in_velocities() {
    // Qin, Zhang, Xiao, Liu, Sun & Tang, Phys. Plasmas 20, 084503 (2013).
    for field in [|_: &[f64]| 0.7, |x: &[f64]| 0.7 + 0.3 * x[0] - 0.2 * x[1]] {
        let found = verdict(&boris(field), true);
        assert_eq!(found.kind, VerdictKind::NotSymplectic);
        assert_eq!(holds(&found, PropertyName::Symplectic), Some(false));
        assert_eq!(holds(&found, PropertyName::Volume), Some(true));
        assert_eq!(holds(&found, PropertyName::Symmetric), Some(true));
        // Time reversal changes the sign of B, too.
        assert_eq!(holds(&found, PropertyName::Reversible), Some(false));
        assert!(
            found
                .properties
                .iter()
                .all(|of| of.name != PropertyName::Conformal || of.holds == Some(false))
        );
    }
}

/// The momentum after a step of size h: of h, the momentum u and the fields e and b.
type Push = fn(f64, [f64; 3], [f64; 3], [f64; 3]) -> [f64; 3];

/// A push of a relativistic velocity u = γv in the fields E and B at the place, between half drifts, with m = e = c = 1.
fn relativistic(push: Push) -> impl TimeAdvance {
    PerSample::new(3, move |h, x: &mut [f64], u: &mut [f64]| {
        let drift = |x: &mut [f64], u: &[f64]| {
            let gamma = (1.0 + u.iter().map(|u| u * u).sum::<f64>()).sqrt();
            (0..3).for_each(|i| x[i] += 0.5 * h * u[i] / gamma);
        };
        drift(x, u);
        let e = [-x[0] - 0.3 * x[1] * x[2], -x[1], 0.5 * x[0] * x[1] - x[2]];
        let b = [0.3 * x[1], 0.2 * x[2], 0.7 + 0.3 * x[0]];
        u.copy_from_slice(&push(h, [u[0], u[1], u[2]], e, b));
        drift(x, u);
    })
}

fn plus(a: [f64; 3], factor: f64, b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn relativistic_boris(h: f64, u: [f64; 3], e: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let u = plus(u, 0.5 * h, e);
    let t = plus([0.0; 3], 0.5 * h / (1.0 + dot(u, u)).sqrt(), b);
    let prime = plus(u, 1.0, cross(u, t));
    let turned = plus(u, 2.0 / (1.0 + dot(t, t)), cross(prime, t));
    plus(turned, 0.5 * h, e)
}

/// The rotation of Vay, and of Higuera and Cary, with the factor γ that solves their quadratic equation.
fn rotated(u: [f64; 3], tau: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let sigma = 1.0 + dot(u, u) - dot(tau, tau);
    let along = dot(u, tau);
    let root = (sigma * sigma + 4.0 * (dot(tau, tau) + along * along)).sqrt();
    let t = plus([0.0; 3], 1.0 / (0.5 * (sigma + root)).sqrt(), tau);
    let sum = plus(plus(u, dot(u, t), t), 1.0, cross(u, t));
    (plus([0.0; 3], 1.0 / (1.0 + dot(t, t)), sum), t)
}

fn vay(h: f64, u: [f64; 3], e: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let v = plus([0.0; 3], 1.0 / (1.0 + dot(u, u)).sqrt(), u);
    let half = plus(plus(u, 0.5 * h, e), 0.5 * h, cross(v, b));
    rotated(plus(half, 0.5 * h, e), plus([0.0; 3], 0.5 * h, b)).0
}

fn higuera_cary(h: f64, u: [f64; 3], e: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let (turned, t) = rotated(plus(u, 0.5 * h, e), plus([0.0; 3], 0.5 * h, b));
    plus(plus(turned, 0.5 * h, e), 1.0, cross(turned, t))
}

#[test]
fn relativistic_pushers_preserve_volume_as_published() {
    // J.-L. Vay, Phys. Plasmas 15, 056701 (2008); A. V. Higuera & J. R. Cary, Phys. Plasmas 24, 052104 (2017), which shows that Boris's
    // push and the new one preserve volume, and that Vay's does not.
    for (push, preserves_volume) in [
        (
            relativistic_boris as fn(f64, [f64; 3], [f64; 3], [f64; 3]) -> [f64; 3],
            true,
        ),
        (vay, false),
        (higuera_cary, true),
    ] {
        let found = verdict(&relativistic(push), true);
        assert_eq!(found.kind, VerdictKind::NotSymplectic);
        assert_eq!(
            holds(&found, PropertyName::Volume),
            Some(preserves_volume),
            "{found:?}"
        );
        assert_eq!(holds(&found, PropertyName::Symmetric), Some(true));
        assert_eq!(holds(&found, PropertyName::Conformal), Some(false));
    }
}

#[test]
fn the_push_of_boris_has_order_three_in_canonical_momenta() {
    // B = 0.7 + 0.3 x − 0.2 y of A = (0, 0.7 x + 0.15 x² − 0.2 x y).
    let map = PerSample::new(2, |h, x: &mut [f64], p: &mut [f64]| {
        let potential = |x: &[f64]| 0.7 * x[0] + 0.15 * x[0] * x[0] - 0.2 * x[0] * x[1];
        let mut v = [p[0], p[1] - potential(x)];
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
        let kick = [-x[0] - 2.0 * x[0] * x[1], -x[1] - x[0] * x[0] + x[1] * x[1]];
        (0..2).for_each(|i| v[i] += 0.5 * h * kick[i]);
        let t = 0.5 * h * (0.7 + 0.3 * x[0] - 0.2 * x[1]);
        let s = 2.0 * t / (1.0 + t * t);
        let turned = [v[0] + t * v[1], v[1] - t * v[0]];
        v = [v[0] + s * turned[1], v[1] - s * turned[0]];
        (0..2).for_each(|i| v[i] += 0.5 * h * kick[i]);
        (0..2).for_each(|i| x[i] += 0.5 * h * v[i]);
        (p[0], p[1]) = (v[0], v[1] + potential(x));
    });
    let found = verdict(&map, true);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    assert_eq!(found.order, Some(3.0), "{found}");
    assert_eq!(holds(&found, PropertyName::Volume), Some(true));
    assert_eq!(holds(&found, PropertyName::Symmetric), Some(true));
}

#[test]
fn langevin_dynamics_without_noise_are_conformal_with_the_friction_to_twelve_digits() {
    // BAOAB of Leimkuhler and Matthews at temperature 0.
    let gamma = 0.3;
    let map = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
        let kick = |q: &[f64], p: &mut [f64]| {
            p[0] -= 0.5 * h * (q[0].sin() + (q[0] - q[1]).sin());
            p[1] -= 0.5 * h * (q[1] - (q[0] - q[1]).sin());
        };
        kick(q, p);
        (0..2).for_each(|i| q[i] += 0.5 * h * p[i]);
        p.iter_mut().for_each(|p| *p *= (-gamma * h).exp());
        (0..2).for_each(|i| q[i] += 0.5 * h * p[i]);
        kick(q, p);
    });
    let found = verdict(&map, false);
    let [rate, uncertainty] = property(&found, PropertyName::Conformal).rate.unwrap();
    assert!(
        (rate - gamma).abs() <= uncertainty && uncertainty < 1e-12,
        "{rate} ± {uncertainty:e}"
    );
}

/// Leapfrog in Hénon and Heiles' potential, with factors that multiply the momenta.
fn damped(rates: [f64; 2]) -> impl TimeAdvance {
    PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
        let damp = |p: &mut [f64]| (0..2).for_each(|i| p[i] *= (-0.5 * h * rates[i]).exp());
        damp(p);
        let kick = |q: &[f64], p: &mut [f64]| {
            p[0] -= 0.5 * h * (q[0] + 2.0 * q[0] * q[1]);
            p[1] -= 0.5 * h * (q[1] + q[0] * q[0] - q[1] * q[1]);
        };
        kick(q, p);
        (0..2).for_each(|i| q[i] += h * p[i]);
        kick(q, p);
        damp(p);
    })
}

#[test]
fn uniform_damping_is_conformal_with_its_rate() {
    let found = verdict(&damped([0.2, 0.2]), false);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    assert_eq!(holds(&found, PropertyName::Volume), Some(false));
    let conformal = property(&found, PropertyName::Conformal);
    assert_eq!(conformal.holds, Some(true));
    let [rate, uncertainty] = conformal.rate.unwrap();
    assert!(
        (rate - 0.2).abs() <= uncertainty && uncertainty < 1e-8,
        "{rate} {uncertainty}"
    );
    let [factor, uncertainty] = conformal.factor.unwrap();
    assert!((factor - (-0.05f64).exp()).abs() <= uncertainty);
    assert_eq!(holds(&found, PropertyName::Reversible), Some(false));
}

#[test]
fn uniform_damping_of_many_degrees_of_freedom_is_conformal_by_its_loops() {
    let ring = |damped: usize| {
        PerSample::new(12, move |h, q: &mut [f64], p: &mut [f64]| {
            (0..12).for_each(|i| q[i] += h * p[i]);
            for i in 0..12 {
                p[i] -=
                    h * (q[i] + (q[i] - q[(i + 1) % 12]).sin() + (q[i] - q[(i + 11) % 12]).sin());
            }
            p[..damped].iter_mut().for_each(|p| *p *= (-0.2 * h).exp());
        })
    };
    let found = verdict(&ring(12), false);
    let [rate, uncertainty] = property(&found, PropertyName::Conformal).rate.unwrap();
    assert!(
        (rate - 0.2).abs() <= uncertainty && uncertainty < 1e-11,
        "{rate} ± {uncertainty:e}"
    );
    let cause = found.cause.unwrap();
    assert_eq!(cause.kind, CauseKind::Friction);
    assert!(cause.text.contains("on all loops,"), "{}", cause.text);
    for damped in [1, 11] {
        let found = verdict(&ring(damped), false);
        assert_eq!(found.kind, VerdictKind::NotSymplectic);
        assert_eq!(
            holds(&found, PropertyName::Conformal),
            Some(false),
            "{damped}"
        );
    }
}

#[test]
fn one_damped_momentum_of_two_is_neither_conformal_nor_volume_preserving() {
    let found = verdict(&damped([0.2, 0.0]), false);
    for name in [
        PropertyName::Conformal,
        PropertyName::Volume,
        PropertyName::Reversible,
    ] {
        assert_eq!(holds(&found, name), Some(false), "{name}");
    }
    // What one loses the other gains: volume is preserved, and areas are not.
    let found = verdict(&damped([0.2, -0.2]), false);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    assert_eq!(holds(&found, PropertyName::Volume), Some(true));
    assert_eq!(holds(&found, PropertyName::Conformal), Some(false));
}

#[test]
fn the_henon_map_multiplies_all_areas_by_its_determinant() {
    // M. Hénon, Commun. Math. Phys. 50, 69 (1976): (x, y) → (1 − a x² + y, b x), det −b.
    let map = PerSample::new(1, |_, x: &mut [f64], y: &mut [f64]| {
        (x[0], y[0]) = (1.0 - 0.4 * x[0] * x[0] + y[0], -0.3 * x[0]);
    });
    let circle = Circle::new(vec![0.1], vec![0.1], 0.3).unwrap();
    let found = Diagnostic::without_step_size()
        .run(&map, &circle)
        .unwrap()
        .verdict;
    let conformal = property(&found, PropertyName::Conformal);
    assert_eq!(conformal.holds, Some(true), "{found}");
    let [factor, uncertainty] = conformal.factor.unwrap();
    assert!((factor - 0.3).abs() <= uncertainty && uncertainty < 1e-9);
    assert_eq!(conformal.rate, None);
}

#[test]
fn symplectic_maps_preserve_volume_and_need_not_be_reversible() {
    let leapfrog = verdict(&damped([0.0, 0.0]), true);
    assert_eq!(leapfrog.kind, VerdictKind::Symplectic);
    for name in [
        PropertyName::Symplectic,
        PropertyName::Volume,
        PropertyName::Conformal,
        PropertyName::Reversible,
        PropertyName::Symmetric,
    ] {
        assert_eq!(holds(&leapfrog, name), Some(true), "{name}");
    }
    let euler = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    });
    let found = verdict(&euler, true);
    assert_eq!(found.kind, VerdictKind::Symplectic);
    assert_eq!(holds(&found, PropertyName::Reversible), Some(false));
    assert_eq!(holds(&found, PropertyName::Symmetric), Some(false));
}

#[test]
fn steps_that_round_are_reversible_to_their_rounding() {
    let single = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        let (mut x, mut v, h) = (q[0] as f32, p[0] as f32, h as f32);
        v -= 0.5 * h * x.sin();
        x += h * v;
        v -= 0.5 * h * x.sin();
        (q[0], p[0]) = (f64::from(x), f64::from(v));
    });
    let found = verdict(&single, true);
    let reversible = property(&found, PropertyName::Reversible);
    assert_ne!(reversible.holds, Some(false), "{reversible}");
    assert!(reversible.defect.unwrap() > 1e-9);
}

#[test]
fn signs_of_a_reversal_are_checked_and_used() {
    // A rotation in q and p that the flip of all momenta reverses, and the flip of all positions does, too.
    let map = damped([0.0, 0.0]);
    let circle = Circle::new(vec![0.1, 0.2], vec![0.3, 0.1], 0.5).unwrap();
    let with = |signs: Vec<f64>| Diagnostic {
        reversal: Some(signs),
        ..Diagnostic::halving(-2, -5)
    };
    let error = with(vec![1.0, -1.0]).run(&map, &circle).unwrap_err();
    assert_eq!(
        error.to_string(),
        "number of signs of the reversal is 2; give 1 or -1 for each position, then for each momentum"
    );
    let error = with(vec![1.0, -1.0, 0.0, 1.0])
        .run(&map, &circle)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "a sign of the reversal is 0; give 1 or -1"
    );
    let none = with(vec![1.0; 4]).run(&map, &circle).unwrap().verdict;
    assert_eq!(holds(&none, PropertyName::Reversible), Some(false));
    // The potential is even in x.
    let other = with(vec![-1.0, 1.0, 1.0, -1.0])
        .run(&map, &circle)
        .unwrap()
        .verdict;
    assert_eq!(holds(&other, PropertyName::Reversible), Some(true));
}

/// A map with its own reversal.
struct Reversed<M>(M, fn(&mut Block<'_>));

impl<M: TimeAdvance> TimeAdvance for Reversed<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            reversal: Some(Box::new(self.1)),
            ..self.0.capabilities()
        }
    }
}

/// The reflection of both coordinates in a diagonal of the plane, with p → −p.
fn reflect(block: &mut Block<'_>) {
    for k in 0..block.len() {
        let [x, y] = [0, 1].map(|i| block.q.row(i)[k]);
        let [u, v] = [0, 1].map(|i| block.p.row(i)[k]);
        (block.q.row_mut(0)[k], block.q.row_mut(1)[k]) = (y, x);
        (block.p.row_mut(0)[k], block.p.row_mut(1)[k]) = (-v, -u);
    }
}

#[test]
fn a_reversal_is_a_map_that_is_its_own_inverse() {
    // In a uniform field B and a potential that is even under x ↔ y, a reflection takes B to −B, as the flip of momenta has to.
    let map = || {
        PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
            (0..2).for_each(|i| q[i] += 0.5 * h * p[i]);
            let force = [-q[0] - q[0] * q[1] * q[1], -q[1] - q[1] * q[0] * q[0]];
            (0..2).for_each(|i| p[i] += 0.5 * h * force[i]);
            let (sin, cos) = (0.7 * h).sin_cos();
            (p[0], p[1]) = (cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]);
            (0..2).for_each(|i| p[i] += 0.5 * h * force[i]);
            (0..2).for_each(|i| q[i] += 0.5 * h * p[i]);
        })
    };
    let of = |map: &dyn TimeAdvance| {
        let found = verdict(map, false);
        let text = property(&found, PropertyName::Reversible).to_string();
        (holds(&found, PropertyName::Reversible), text)
    };
    assert_eq!(of(&map()).0, Some(false));
    let (reversible, text) = of(&Reversed(map(), reflect));
    assert_eq!(reversible, Some(true), "{text}");
    assert!(text.contains("the given reversal"), "{text}");
    // Another function that is its own inverse, and one that is not.
    assert_eq!(of(&Reversed(map(), |_| {})).0, Some(false));
    let quarter_turn = Reversed(map(), |block| {
        for k in 0..block.len() {
            let (x, y) = (block.q.row(0)[k], block.q.row(1)[k]);
            (block.q.row_mut(0)[k], block.q.row_mut(1)[k]) = (-y, x);
        }
    });
    let circle = Circle::new(vec![0.1, 0.2], vec![0.3, 0.1], 0.5).unwrap();
    let error = (Diagnostic::halving(-2, -4).run(&quarter_turn, &circle)).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("is its own inverse"), "{text}");
}

#[test]
fn properties_are_said_in_one_line_each() {
    let texts: Vec<String> = (verdict(&damped([0.2, 0.2]), true).properties.iter())
        .map(Property::to_string)
        .collect();
    let begins = [
        "not symplectic",
        "conformally symplectic (a step multiplies all areas by 0.951229",
        "not volume preserving (|det M − 1| = 0.095)",
        "not time-reversible (step, p → −p, step: ",
        "symmetric (a step of h, then −h: back at the start to ",
    ];
    for (text, begin) in texts.iter().zip(begins) {
        assert!(text.starts_with(begin), "{text}");
    }
    assert_eq!(texts.len(), begins.len());
    assert!(
        texts[1].contains(": uniform damping e^(−γh), γ = "),
        "{texts:?}"
    );
}

#[test]
fn a_degree_of_freedom_at_rest_hides_no_other_one() {
    let map = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        for i in 0..2 {
            p[i] = (p[i] - h * q[i].sin()) * (-h).exp();
            q[i] += h * p[i];
        }
    });
    let circle = Circle::new(vec![0.0, 1.0], vec![0.0, 0.0], 0.5).unwrap();
    let one = Circle::with_radii(
        vec![0.0, 1.0],
        vec![0.0, 0.0],
        vec![0.0, 0.5],
        vec![0.0, 0.5],
    );
    for circle in [circle, one.unwrap()] {
        let found = Diagnostic::halving(-1, -5)
            .run(&map, &circle)
            .unwrap()
            .verdict;
        assert_eq!(holds(&found, PropertyName::Reversible), Some(false));
    }
}

#[test]
fn rounding_of_large_kicks_and_of_stages_is_no_defect() {
    for force in [1e3, 1e5] {
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= 0.5 * h * (force + q[0].sin());
            q[0] += h * p[0];
            p[0] -= 0.5 * h * (force + q[0].sin());
        });
        let found = verdict(&map, true);
        assert_eq!(
            holds(&found, PropertyName::Reversible),
            Some(true),
            "{force}: {found:?}"
        );
        assert_eq!(
            holds(&found, PropertyName::Symmetric),
            Some(true),
            "{force}: {found:?}"
        );
    }
}

#[test]
fn the_rate_of_damping_is_one_of_time_if_the_map_is_repeated() {
    let circle = Circle::new(vec![0.3, 0.2], vec![0.5, 0.4], 0.8).unwrap();
    let diagnostic = Diagnostic {
        repeat: 5,
        ..Diagnostic::halving(-3, -6)
    };
    let found = diagnostic
        .run(&damped([0.2, 0.2]), &circle)
        .unwrap()
        .verdict;
    let [rate, uncertainty] = property(&found, PropertyName::Conformal).rate.unwrap();
    assert!((rate - 0.2).abs() <= uncertainty, "{rate} ± {uncertainty}");
}

#[test]
fn a_map_without_a_step_size_is_not_asked_for_a_step_back() {
    let kick = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| p[0] -= q[0].sin());
    let circle = Circle::new(vec![0.3], vec![0.5], 0.8).unwrap();
    let diagnostic = Diagnostic {
        symmetric: true,
        ..Diagnostic::without_step_size()
    };
    let found = diagnostic.run(&kick, &circle).unwrap().verdict;
    let names: Vec<PropertyName> = found.properties.iter().map(|of| of.name).collect();
    assert!(!names.contains(&PropertyName::Symmetric));
    let none = Diagnostic {
        properties: false,
        ..Diagnostic::without_step_size()
    };
    let found = none.run(&kick, &circle).unwrap().verdict;
    assert_eq!(found.properties.len(), 1);
}

#[test]
fn a_step_back_that_fails_leaves_its_property_unknown() {
    let forward = PerSample::new(1, |h: f64, q: &mut [f64], p: &mut [f64]| {
        p[0] -= 0.5 * h * q[0].sin();
        q[0] += h * p[0] + h.min(0.0).sqrt();
        p[0] -= 0.5 * h * q[0].sin();
    });
    let found = verdict(&forward, true);
    assert_eq!(found.kind, VerdictKind::Symplectic);
    assert_eq!(holds(&found, PropertyName::Reversible), Some(true));
    assert_eq!(holds(&found, PropertyName::Symmetric), None);
    let said = found.sentences().join("\n");
    assert!(
        said.contains("Time reversal and symmetry were not tested: "),
        "{said}"
    );
}

/// A quartic oscillator, H = p²/2 + q⁴/4, by a step that also knows its energy.
struct Quartic(fn(f64, f64, f64) -> (f64, f64));

impl TimeAdvance for Quartic {
    fn dof(&self) -> usize {
        1
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            (*q, *p) = (self.0)(h, *q, *p);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            energy: Some(Box::new(|q, p, energies| {
                for ((energy, q), p) in energies.iter_mut().zip(q.row(0)).zip(p.row(0)) {
                    *energy = 0.5 * p * p + 0.25 * q.powi(4);
                }
            })),
            ..Capabilities::plain(self.dof())
        }
    }
}

/// The average vector field of Quispel and McLaren, J. Phys. A 41, 045206 (2008): ∫ V'(q₀ + s(q₁ − q₀)) ds is a mean of four products.
fn average_vector_field(h: f64, q0: f64, p0: f64) -> (f64, f64) {
    let (mut q, mut p) = (q0, p0);
    for _ in 0..60 {
        let force = -0.25 * (q0.powi(3) + q0 * q0 * q + q0 * q * q + q.powi(3));
        (q, p) = (q0 + 0.5 * h * (p0 + p), p0 + h * force);
    }
    (q, p)
}

#[test]
fn the_average_vector_field_conserves_energy_and_is_symmetric_but_not_symplectic() {
    let found = verdict(&Quartic(average_vector_field), true);
    assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    assert_eq!(holds(&found, PropertyName::Energy), Some(true), "{found}");
    assert_eq!(holds(&found, PropertyName::Symmetric), Some(true));
}

#[test]
fn leapfrog_changes_energy_by_what_its_formula_gives() {
    fn leapfrog(h: f64, q: f64, p: f64) -> (f64, f64) {
        let p = p - 0.5 * h * q.powi(3);
        let q = q + h * p;
        (q, p - 0.5 * h * q.powi(3))
    }
    let found = verdict(&Quartic(leapfrog), false);
    assert_eq!(found.kind, VerdictKind::Symplectic);
    let energy = property(&found, PropertyName::Energy);
    assert_eq!(energy.holds, Some(false));
    // In units of the range of the energy on the disc, by 10,000 states of it.
    let h_of = |q: f64, p: f64| 0.5 * p * p + 0.25 * q.powi(4);
    let disc =
        (0..100).flat_map(|a| (0..100).map(move |r| (0.0628 * f64::from(a), 0.008 * f64::from(r))));
    let states: Vec<(f64, f64)> = disc
        .map(|(a, r)| (0.3 + r * a.cos(), 0.5 + r * a.sin()))
        .collect();
    let change = |&(q, p): &(f64, f64)| {
        let (to_q, to_p) = leapfrog(0.25, q, p);
        (h_of(to_q, to_p) - h_of(q, p)).abs()
    };
    let largest = states.iter().map(change).fold(0.0, f64::max);
    let ends = states.iter().map(|&(q, p)| h_of(q, p));
    let range = ends.clone().fold(f64::MIN, f64::max) - ends.fold(f64::MAX, f64::min);
    let ratio = energy.defect.unwrap() / (largest / range);
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
    assert_eq!(energy.order, Some(3.0), "{energy}");
    assert!(
        energy
            .to_string()
            .starts_with("not energy conserving (a step changes the energy by up to")
    );
}

#[test]
fn many_steps_tell_a_bounded_energy_from_one_that_drifts() {
    fn leapfrog(h: f64, q: f64, p: f64) -> (f64, f64) {
        let p = p - 0.5 * h * q.powi(3);
        let q = q + h * p;
        (q, p - 0.5 * h * q.powi(3))
    }
    fn runge_kutta(h: f64, q: f64, p: f64) -> (f64, f64) {
        let (q_half, p_half) = (q + 0.5 * h * p, p - 0.5 * h * q.powi(3));
        (q + h * p_half, p - h * q_half.powi(3))
    }
    fn damped(h: f64, q: f64, p: f64) -> (f64, f64) {
        leapfrog(h, q, p * (-0.3 * h).exp())
    }
    for (step, growth, words) in [
        (
            leapfrog as fn(f64, f64, f64) -> (f64, f64),
            Growth::Bounded,
            "the change stays bounded",
        ),
        (average_vector_field, Growth::None, "it is conserved"),
        (runge_kutta, Growth::Grows, "the energy drifts"),
        // The energy is gone after a quarter of the steps, and stays away.
        (damped, Growth::Grows, "the energy drifts"),
    ] {
        let map = Quartic(step);
        let circle = Circle::new(vec![0.3], vec![0.5], 0.3).unwrap();
        let few = Diagnostic::halving(-2, -4);
        let many = Diagnostic {
            long_time: 400,
            ..few.clone()
        };
        let [few, many] = [few, many].map(|of| of.run(&map, &circle).unwrap());
        assert_eq!(property(&few.verdict, PropertyName::Energy).in_time, None);
        let energy = property(&many.verdict, PropertyName::Energy);
        let (found, of_energy) = energy.in_time.unwrap();
        assert_eq!(of_energy, growth, "{energy}: {found:?}");
        assert!(energy.to_string().contains(words), "{energy}");
        // The states of the loop are used, and no others: the evaluations are those of many steps without an energy.
        let without = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            (q[0], p[0]) = step(h, q[0], p[0]);
        });
        let many_without = Diagnostic {
            long_time: 400,
            ..Diagnostic::halving(-2, -4)
        };
        let without = many_without
            .run(&without, &circle)
            .unwrap()
            .evidence
            .evaluations;
        let of = |of: &symplint::evidence::Evaluations| of.of(symplint::evidence::Check::ManySteps);
        assert_eq!(of(&many.evidence.evaluations), of(&without));
    }
}

#[test]
fn an_energy_that_is_not_finite_is_named() {
    struct Singular;
    impl TimeAdvance for Singular {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
            Quartic(average_vector_field).advance(h, block)
        }

        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities {
                energy: Some(Box::new(|_, _, energies| energies.fill(f64::NAN))),
                ..Capabilities::plain(self.dof())
            }
        }
    }
    let found = verdict(&Singular, false);
    assert!(
        found
            .properties
            .iter()
            .all(|of| of.name != PropertyName::Energy)
    );
    let mut sentences = found.findings.iter().map(|finding| finding.to_string());
    assert!(sentences.any(|text| {
        text.contains("the energy of a state on the loop or after a step is not finite")
    }));
}
