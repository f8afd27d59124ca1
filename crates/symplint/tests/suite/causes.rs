//! The causes of failures: each is named for the maps that have it, with the numbers of the map, and its remedy decides.

mod breaks;
mod matrix;

use symplint::map::{Capabilities, Substeps};
use symplint::verdict::{Advice, Cause, CauseKind};
use symplint::{
    Block, Circle, Diagnosis, Diagnostic, PerSample, StepFailure, TimeAdvance, Verdict, VerdictKind,
};

fn diagnose(map: &dyn TimeAdvance, q0: &[f64], p0: &[f64], radius: f64) -> Diagnosis {
    let circle = Circle::new(q0.to_vec(), p0.to_vec(), radius).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::halving(-1, -5)
    };
    diagnostic.run(map, &circle).unwrap()
}

fn verdict(map: &dyn TimeAdvance, q0: &[f64], p0: &[f64], radius: f64) -> Verdict {
    diagnose(map, q0, p0, radius).verdict
}

/// The cause, which has to be of this kind and to say all of this.
fn cause(verdict: &Verdict, kind: CauseKind, words: &[&str]) -> Cause {
    let cause = verdict.cause.clone().unwrap_or_else(|| panic!("{verdict}"));
    assert_eq!(cause.kind, kind, "{}", cause.text);
    for word in words {
        assert!(cause.text.contains(word), "{word}: {}", cause.text);
    }
    assert_eq!(verdict.advice()[0], cause.remedy);
    cause
}

/// A leapfrog step of two degrees of freedom.
fn leapfrog(h: f64, q: &mut [f64], p: &mut [f64], force: &impl Fn(&[f64]) -> [f64; 2]) {
    let kick = |q: &[f64], p: &mut [f64]| {
        let force = force(q);
        (0..2).for_each(|i| p[i] += 0.5 * h * force[i]);
    };
    kick(q, p);
    (0..2).for_each(|i| q[i] += h * p[i]);
    kick(q, p);
}

#[test]
fn uniform_friction_is_told_from_friction_of_one_degree_of_freedom() {
    let damped = |factors: [f64; 2]| {
        PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            for i in 0..2 {
                q[i] += h * p[i];
            }
            let between = (q[0] - q[1]).sin();
            p[0] = (p[0] - h * between) * (-factors[0] * h).exp();
            p[1] = (p[1] + h * between) * (-factors[1] * h).exp();
        })
    };
    let found = verdict(&damped([0.2, 0.2]), &[0.3, 1.0], &[0.2, -0.1], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    cause(
        &found,
        CauseKind::Friction,
        &["γ = 0.2", "Uniform friction"],
    );
    let found = verdict(&damped([0.2, 0.0]), &[0.3, 1.0], &[0.2, -0.1], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    let kind = found.cause.map(|cause| cause.kind);
    assert_ne!(kind, Some(CauseKind::Friction));
}

#[test]
fn a_factor_that_only_loops_resolve_is_named() {
    let damped = |rate: f64, power: i32| {
        PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            for i in 0..2 {
                q[i] += h * p[i];
            }
            let between = (q[0] - q[1]).sin();
            p[0] = (p[0] - h * between) * (1.0 - rate * h.powi(power));
            p[1] = (p[1] + h * between) * (1.0 - rate * h.powi(power));
        })
    };
    let found = verdict(&damped(2e-11, 1), &[0.3, 1.0], &[0.2, -0.1], 0.5);
    let words = ["on all loops, by 1 − 1.00", "Uniform friction", "γ = 2.00"];
    let friction = cause(&found, CauseKind::Friction, &words);
    assert!(!friction.text.contains("Jacobian"), "{}", friction.text);
    // A change in proportion to h² is not friction.
    let found = verdict(&damped(4e-11, 2), &[0.3, 1.0], &[0.2, -0.1], 0.5);
    let found = cause(&found, CauseKind::Friction, &["falls faster than h"]);
    assert!(
        found.remedy.contains("Check the method"),
        "{}",
        found.remedy
    );
    let found = verdict(&damped(0.0, 1), &[0.3, 1.0], &[0.2, -0.1], 0.5);
    assert_eq!(found.kind, VerdictKind::Symplectic, "{found}");
    // A method changes loops by factors that differ.
    let found = verdict(&runge_kutta(1.0), &[0.3], &[0.4], 0.5);
    assert_ne!(
        found.cause.map(|cause| cause.kind),
        Some(CauseKind::Friction)
    );
    let circle = Circle::new(vec![0.3], vec![0.4], 0.5).unwrap();
    let steps = Diagnostic::halving(-5, -9).run(&runge_kutta(1.0), &circle);
    let found = steps.unwrap().verdict;
    assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    assert_eq!(found.cause.map(|cause| cause.text), None);
}

#[test]
fn a_method_for_linear_forces_is_no_friction() {
    let linear = PerSample::new(1, |h, q, p| {
        let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0]);
        (q[0], p[0]) = (q[0] + h * p_half, p[0] - h * q_half);
    });
    let found = verdict(&linear, &[0.3], &[0.4], 0.5);
    assert_eq!(found.order, Some(4.0), "{found}");
    let found = cause(
        &found,
        CauseKind::Friction,
        &["if the forces on the loops are linear"],
    );
    assert!(
        found.remedy.contains("Runge–Kutta method"),
        "{}",
        found.remedy
    );
}

#[test]
fn the_noise_of_a_solver_that_makes_a_small_defect_is_named() {
    // The midpoint rule, by iterations that begin at a state that depends on every digit, and stop at a tolerance.
    let midpoint = |tolerance: f64| {
        PerSample::new(1, move |h, q, p| {
            let digits = q[0].to_bits() ^ p[0].to_bits().rotate_left(21);
            let digits = (digits ^ (digits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let start = 1e-2 * ((digits >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
            let (mut q_middle, mut p_middle) = (q[0] + start, p[0] - 0.7 * start);
            for _ in 0..200 {
                let next = (q[0] + 0.5 * h * p_middle, p[0] - 0.5 * h * q_middle.sin());
                let moved = (next.0 - q_middle).abs().max((next.1 - p_middle).abs());
                (q_middle, p_middle) = next;
                if moved < tolerance {
                    break;
                }
            }
            (q[0], p[0]) = (2.0 * q_middle - q[0], 2.0 * p_middle - p[0]);
        })
    };
    let find = |tolerance: f64| {
        let circle = Circle::new(vec![0.1], vec![-0.2], 1.0).unwrap();
        let found = Diagnostic::halving(-1, -8).run(&midpoint(tolerance), &circle);
        found.unwrap().verdict
    };
    let found = find(1e-10);
    assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    let words = ["follows no power of h", "neighbouring states scatter by"];
    cause(&found, CauseKind::SolverTolerance, &words);
    // The remedy followed.
    let tight = find(0.0);
    assert_eq!(tight.kind, VerdictKind::Symplectic, "{tight}");
}

#[test]
fn light_bodies_by_a_method_that_is_not_symplectic_are_named() {
    // The integrals of your loop show the light body at the largest step size alone.
    let light = 1e-12;
    let bodies = |reaction: f64| {
        PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            // Heun's method for the light body in the field of the heavy one at rest, leapfrog for the heavy one.
            let force = |q1: f64, q0: f64| -light * (q1 + 0.2 * q1.powi(3) + 0.3 * (q1 - q0));
            let (x, u, at) = (q[1], p[1], q[0]);
            let (x_end, u_end) = (x + h * u / light, u + h * force(x, at));
            q[1] = x + 0.5 * h * (u + u_end) / light;
            p[1] = u + 0.5 * h * (force(x, at) + force(x_end, at));
            let from_light = reaction * light * (x + 0.5 * h * u / light - q[0]);
            q[0] += 0.5 * h * p[0];
            p[0] -= h * (q[0] + 0.1 * q[0].powi(3) - from_light);
            q[0] += 0.5 * h * p[0];
        })
    };
    let circle = || {
        Circle::with_radii(
            vec![0.2, -0.1],
            vec![0.1, 0.3 * light],
            vec![0.4, 0.5],
            vec![0.4, 0.4 * light],
        )
        .unwrap()
    };
    let diagnostic = Diagnostic::halving(-1, -10);
    let found = diagnostic.run(&bodies(0.3), &circle()).unwrap();
    let verdict = found.verdict;
    assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{verdict}");
    let decay = found.evidence.jacobian_decay.expect("a second step size");
    assert_eq!(decay.step_sizes, [0.5, 0.125]);
    cause(&verdict, CauseKind::FewIterations, &["qp 0.0", "pp 0 ("]);
    // Without the reaction of the heavy body, loops change in proportion to h: the blocks still belong to the method.
    let found = diagnostic.run(&bodies(0.0), &circle()).unwrap();
    cause(
        &found.verdict,
        CauseKind::FewIterations,
        &["qp 0.0", "pp 0 ("],
    );
}

#[test]
fn a_step_that_projects_is_named_with_its_rank() {
    // Two particles on a spring, of which the momentum of the centre of mass is removed.
    let map = PerSample::new(2, |h, q, p| {
        let force = (q[0] - q[1]).sin();
        (p[0], p[1]) = (p[0] - h * force, p[1] + h * force);
        let mean = 0.5 * (p[0] + p[1]);
        for i in 0..2 {
            p[i] -= mean;
            q[i] += h * p[i];
        }
    });
    let found = verdict(&map, &[0.5, -0.3], &[0.2, 0.1], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    cause(&found, CauseKind::Projection, &["rank 3 of 4"]);
}

#[test]
fn every_map_that_is_not_symplectic_gets_advice() {
    let euler = PerSample::new(1, |h, q, p| {
        (q[0], p[0]) = (q[0] + h * p[0], p[0] - h * q[0].sin());
    });
    let midpoint = PerSample::new(1, |h, q, p| {
        let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0].sin());
        (q[0], p[0]) = (q[0] + h * p_half, p[0] - h * q_half.sin());
    });
    for (map, words) in [
        (&euler as &dyn TimeAdvance, "Runge–Kutta method of order 1,"),
        (&midpoint, "Runge–Kutta method of order 2,"),
    ] {
        let found = verdict(map, &[0.3], &[0.4], 0.5);
        assert_eq!(found.kind, VerdictKind::NotSymplectic);
        let advice = found.advice().concat();
        assert!(advice.contains(words), "{found}: {advice}");
    }
}

#[test]
fn mistakes_in_what_a_step_returns_are_named() {
    let swapped = PerSample::new(1, |h, q, p| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        (q[0], p[0]) = (p[0], q[0]);
    });
    let found = verdict(&swapped, &[0.3], &[0.4], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    cause(&found, CauseKind::Swapped, &["sign of all areas"]);
    let right_hand_side = PerSample::new(1, |_, q, p| (q[0], p[0]) = (p[0], -2.0 * q[0].sin()));
    let found = verdict(&right_hand_side, &[0.3], &[0.4], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    cause(
        &found,
        CauseKind::IgnoresStepSize,
        &["same result for every step size"],
    );
}

/// The method of Runge and Kutta of order 4 for a pendulum, with the force of the last stage at another position.
fn runge_kutta(last: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h, q, p| runge_kutta_step(last, h, q, p))
}

fn runge_kutta_step(last: f64, h: f64, q: &mut [f64], p: &mut [f64]) {
    let of = |q: f64, p: f64| (p, -q.sin());
    let (a, b) = of(q[0], p[0]);
    let (c, d) = of(q[0] + 0.5 * h * a, p[0] + 0.5 * h * b);
    let (e, f) = of(q[0] + 0.5 * h * c, p[0] + 0.5 * h * d);
    let (k, l) = of(q[0] + last * h * e, p[0] + h * f);
    q[0] += h / 6.0 * (a + 2.0 * c + 2.0 * e + k);
    p[0] += h / 6.0 * (b + 2.0 * d + 2.0 * f + l);
}

#[test]
fn a_defect_at_a_lower_order_than_the_method_has_is_named() {
    let kind = |map: &dyn TimeAdvance, order: Option<usize>| {
        let circle = Circle::new(vec![0.4], vec![0.3], 0.5).unwrap();
        let diagnostic = Diagnostic {
            order,
            ..Diagnostic::halving(-1, -6)
        };
        let found = diagnostic.run(map, &circle).unwrap().verdict;
        assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
        (
            found.order,
            found.cause.map(|cause| (cause.kind, cause.remedy)),
        )
    };
    let is_below = |map: &dyn TimeAdvance, order| {
        let (_, cause) = kind(map, order);
        cause.is_some_and(|(kind, remedy)| {
            kind == CauseKind::OrderBelowMethod && remedy.contains("check_force")
        })
    };
    let (right, wrong) = (runge_kutta(1.0), runge_kutta(0.0));
    let order = kind(&wrong, None).0.expect("a power law");
    assert!(order < 5.0, "{order}");
    assert!(is_below(&wrong, Some(4)) && !is_below(&wrong, None));
    assert!(!is_below(&wrong, Some(order as usize - 1)));
    assert!(!is_below(&right, Some(4)));
    // A force with curl, by a method of order 4: the defect goes as h.
    let with_curl = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        let of = |z: [f64; 4]| {
            let [x, y, u, v] = z;
            [
                u,
                v,
                -x.sin() - 0.1 * y - x * y,
                -y + 0.1 * x - 0.5 * x * x - 0.2 * y * y,
            ]
        };
        let z = [q[0], q[1], p[0], p[1]];
        let at = |k: [f64; 4], part: f64| std::array::from_fn(|i| z[i] + part * h * k[i]);
        let a = of(z);
        let b = of(at(a, 0.5));
        let c = of(at(b, 0.5));
        let d = of(at(c, 1.0));
        let change = |i: usize| h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        (0..2).for_each(|i| {
            q[i] += change(i);
            p[i] += change(i + 2);
        });
    });
    let circle = Circle::new(vec![0.1, 0.05], vec![0.1, 0.2], 0.2).unwrap();
    let diagnostic = Diagnostic {
        order: Some(4),
        ..Diagnostic::halving(-1, -6)
    };
    let found = diagnostic.run(&with_curl, &circle).unwrap().verdict;
    let found = found.cause.expect("a cause");
    let kinds = [CauseKind::OrderBelowMethod, CauseKind::ForceWithCurl];
    assert!(kinds.contains(&found.kind), "{}", found.text);
    assert!(found.remedy.contains("check_force"), "{}", found.remedy);
}

/// Leapfrog in Hénon and Heiles' potential, with what is done to momenta before and after it.
fn between(
    before: fn(f64, &[f64], &mut [f64]),
    after: fn(f64, &[f64], &mut [f64]),
) -> impl TimeAdvance {
    PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
        before(h, q, p);
        (0..2).for_each(|i| q[i] += 0.5 * h * p[i]);
        p[0] -= h * (q[0] + 2.0 * q[0] * q[1]);
        p[1] -= h * (q[1] + q[0] * q[0] - q[1] * q[1]);
        (0..2).for_each(|i| q[i] += 0.5 * h * p[i]);
        after(h, q, p);
    })
}

#[test]
fn the_part_of_a_step_that_changes_areas_is_named() {
    let nothing: fn(f64, &[f64], &mut [f64]) = |_, _, _| {};
    // In closed form: the brackets {P0, P1} = h (0.1 + 0.2 q0) at the end, and {Q1, P1} = 1 − 0.1 h.
    let curl: fn(f64, &[f64], &mut [f64]) = |h, q, p| p[0] += h * q[1] * (0.1 + 0.2 * q[0]);
    let damped: fn(f64, &[f64], &mut [f64]) = |h, _, p| p[1] *= 1.0 - 0.1 * h;
    for (map, kind, words) in [
        (
            between(nothing, curl),
            CauseKind::ForceWithCurl,
            ["qq 0 (", "qp 0 (", "The step ends with a kick"],
        ),
        (
            between(curl, nothing),
            CauseKind::ForceWithCurl,
            ["qp 0 (", "pp 0 (", "The step begins with a kick"],
        ),
        (
            between(nothing, damped),
            CauseKind::PartialFriction,
            ["The step ends with friction", "qq 0 (", "qp 0.05, pp 0 ("],
        ),
        (
            between(damped, nothing),
            CauseKind::PartialFriction,
            [
                "The step begins with friction",
                "qp 0.05, pp 0 (",
                "all in q[1], p[1].",
            ],
        ),
    ] {
        let found = verdict(&map, &[0.1, 0.05], &[0.1, 0.2], 0.2);
        assert_eq!(found.kind, VerdictKind::NotSymplectic);
        cause(&found, kind, &words);
    }
    // In both kicks of a step, or between drifts, no block is 0.
    let kicks = PerSample::new(2, |h, q, p| {
        let kick = |q: &[f64], p: &mut [f64]| {
            let pair = (q[0] - q[1]).sin();
            p[0] -= 0.5 * h * (q[0].sin() + pair + 0.1 * q[1]);
            p[1] -= 0.5 * h * (q[1].sin() - pair - 0.1 * q[0]);
        };
        kick(q, p);
        (0..2).for_each(|i| q[i] += h * p[i]);
        kick(q, p);
    });
    let found = verdict(&kicks, &[0.1, 0.05], &[0.1, 0.2], 0.2);
    let found = cause(
        &found,
        CauseKind::ForceWithCurl,
        &["as with kicks by a force F(q)"],
    );
    assert!(found.remedy.contains("check_force"));
}

#[test]
fn momenta_in_another_order_are_no_friction() {
    let reversed = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        leapfrog(h, q, p, &|q| [-q[0].sin(), -q[1].sin()]);
        p.reverse();
    });
    let found = verdict(&reversed, &[1.0, 0.2], &[0.5, 0.1], 1.0);
    let found = cause(
        &found,
        CauseKind::IndependentOfStepSize,
        &["about the same"],
    );
    assert!(
        found.remedy.contains("in another order"),
        "{}",
        found.remedy
    );
}

/// At the state of the Jacobian, the largest step is beyond the first term of its defect; loops show that it is of order 1.
#[test]
fn drag_in_a_steep_field_is_friction_and_no_iteration() {
    let force = |q: &[f64]| {
        let square = q[0] * q[0] + q[1] * q[1] + 0.04;
        [0, 1].map(|i| -q[i] / (square * square.sqrt()))
    };
    let drag = PerSample::new(2, move |h, q, p| {
        leapfrog(h, q, p, &force);
        let factor = 1.0 - 0.01 * h * p[0].hypot(p[1]);
        (0..2).for_each(|i| p[i] *= factor);
    });
    let circle = Circle::new(vec![1.0, 0.0], vec![0.0, 1.0], 1.0).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::default()
    };
    let found = diagnostic.run(&drag, &circle).unwrap().verdict;
    assert_eq!(found.order, Some(1.0), "{found}");
    cause(&found, CauseKind::PartialFriction, &["friction"]);
}

#[test]
fn few_fixed_point_iterations_are_named_by_the_block_that_is_zero() {
    for iterations in 1..=2 {
        let midpoint = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            let force = |q: &[f64]| [-q[0] - 2.0 * q[0] * q[1], -q[1] - q[0] * q[0] + q[1] * q[1]];
            let (q0, p0) = ([q[0], q[1]], [p[0], p[1]]);
            for _ in 0..iterations {
                let of_middle = force(&[0.5 * (q0[0] + q[0]), 0.5 * (q0[1] + q[1])]);
                for i in 0..2 {
                    q[i] = q0[i] + 0.5 * h * (p0[i] + p[i]);
                    p[i] = p0[i] + h * of_middle[i];
                }
            }
        });
        let found = verdict(&midpoint, &[0.1, 0.05], &[0.1, 0.2], 0.2);
        assert_eq!(found.kind, VerdictKind::NotSymplectic);
        let words = ["qq 0 (", "one to three iterations"];
        cause(&found, CauseKind::FewIterations, &words);
    }
}

#[test]
fn a_defect_that_is_the_same_at_all_step_sizes_is_no_friction() {
    let rescaled = PerSample::new(1, |h, q, p| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        p[0] *= 1.001;
    });
    let found = verdict(&rescaled, &[0.3], &[0.4], 0.5);
    let words = [
        "by 1.001 ± ",
        "at all step sizes, as if the step returns momenta",
    ];
    cause(&found, CauseKind::Friction, &words);
    // Of one momentum of two, and other things: no factor of all areas.
    let rounded = PerSample::new(2, |h, q, p| {
        q[0] += h * p[0];
        q[1] += h * p[1];
        let pair = (q[0] - q[1]).sin();
        p[0] -= h * (pair + q[0].sin()) - 3e-7 * q[0].sin() * p[1];
        p[1] += h * pair;
    });
    let found = verdict(&rounded, &[0.3, 1.0], &[0.4, -0.2], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    let found = found.cause.unwrap();
    let kinds = [CauseKind::SolverTolerance, CauseKind::PartialFriction];
    assert!(kinds.contains(&found.kind), "{}", found.text);
}

#[test]
fn a_factor_in_every_step_is_named_as_independent_of_its_size() {
    // Of two pairs that are not coupled, one loses a part of its area in every step.
    let damped = |part: f64| {
        PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            for i in 0..2 {
                q[i] += h * p[i];
                p[i] -= h * q[i].sin();
            }
            let turned = part * (1.0 + q[0] * q[0]) * (1.0 + p[0] * p[0]);
            (q[1], p[1]) = (q[1] - turned, p[1] * (1.0 - part));
        })
    };
    let found = verdict(&damped(0.01), &[0.3, 1.0], &[0.4, -0.2], 0.5);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    let words = ["about the same at all step sizes", "A step of size 0"];
    let found = cause(&found, CauseKind::IndependentOfStepSize, &words);
    assert!(found.remedy.contains("a step of a very small size"));
    // The remedy followed: without the part that does not depend on h, the step is symplectic.
    let without = verdict(&damped(0.0), &[0.3, 1.0], &[0.4, -0.2], 0.5);
    assert_eq!(without.kind, VerdictKind::Symplectic);
}

#[test]
fn damped_light_bodies_around_a_heavy_one_are_named() {
    let light = 1e-9;
    let bodies = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
        p[1] *= 0.95;
        let masses = [1.0, light];
        (0..2).for_each(|i| q[i] += 0.5 * h * p[i] / masses[i]);
        let pull = 0.3 * light * (q[1] - q[0]);
        p[0] += h * (pull - q[0] - 0.1 * q[0].powi(3));
        p[1] -= h * (pull + light * (q[1] + 0.2 * q[1].powi(3)));
        (0..2).for_each(|i| q[i] += 0.5 * h * p[i] / masses[i]);
    });
    let circle = Circle::with_radii(
        vec![0.2, -0.1],
        vec![0.1, 0.3 * light],
        vec![0.4, 0.5],
        vec![0.4, 0.4 * light],
    );
    let diagnostic = Diagnostic::halving(-1, -8);
    let found = diagnostic.run(&bodies, &circle.unwrap()).unwrap().verdict;
    assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    let found = found.cause.expect("a cause");
    let kinds = [CauseKind::PartialFriction, CauseKind::IndependentOfStepSize];
    assert!(kinds.contains(&found.kind), "{}", found.text);
}

#[test]
fn the_substep_that_changes_areas_is_named() {
    struct Lattice;
    impl TimeAdvance for Lattice {
        fn dof(&self) -> usize {
            2
        }
        fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
            (0..60).try_for_each(|k| self.advance_substep(k, h, block))
        }
        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities {
                substeps: Some(self),
                ..Capabilities::plain(2)
            }
        }
    }
    impl Substeps for Lattice {
        fn substeps(&self) -> usize {
            60
        }
        fn substep_name(&self, substep: usize) -> String {
            format!("element {substep}")
        }
        fn advance_substep(
            &self,
            substep: usize,
            _: f64,
            block: &mut Block<'_>,
        ) -> Result<(), StepFailure> {
            let strength = if substep % 4 == 1 { 0.3 } else { -0.3 };
            for k in 0..block.len() {
                let [x, y] = [0, 1].map(|i| block.q.row(i)[k]);
                let [px, py] = [0, 1].map(|i| block.p.row(i)[k]);
                if substep.is_multiple_of(2) {
                    block.q.row_mut(0)[k] = x + 0.2 * px;
                    block.q.row_mut(1)[k] = y + 0.2 * py;
                } else {
                    // One fringe has the wrong sign in y.
                    let wrong = if substep == 37 { 1e-3 * x } else { 0.0 };
                    block.p.row_mut(0)[k] = px - strength * (x + 0.1 * x * x);
                    block.p.row_mut(1)[k] = py + strength * y + wrong * y;
                }
            }
            Ok(())
        }
    }
    let circle = Circle::new(vec![0.1, 0.05], vec![0.0, 0.1], 0.3).unwrap();
    let found = Diagnostic::without_step_size()
        .run(&Lattice, &circle)
        .unwrap()
        .verdict;
    assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    let words = [
        "Of the 60 substeps",
        "substep 38 (element 37)",
        "the others conserve it",
    ];
    cause(&found, CauseKind::Substep, &words);
}

#[test]
fn step_lengths_that_depend_smoothly_on_the_state_are_named() {
    let kepler = |q: &[f64]| {
        let cube = (q[0] * q[0] + q[1] * q[1]).powf(1.5);
        [-q[0] / cube, -q[1] / cube]
    };
    let map = PerSample::new(2, move |h, q, p| {
        let h = h * q[0].hypot(q[1]);
        leapfrog(h, q, p, &kepler);
    });
    let (q0, p0) = ([1.0, 0.1], [0.1, 1.1]);
    let found = diagnose(&map, &q0, &p0, 0.05);
    assert_eq!(found.verdict.kind, VerdictKind::NotSymplectic);
    cause(
        &found.verdict,
        CauseKind::ChosenStepLength,
        &["its own length of time"],
    );
    let blocks = |found: &Diagnosis| {
        let jacobian = found.evidence.jacobian.as_ref().unwrap();
        jacobian.blocks.as_ref().unwrap().across_time.unwrap()
    };
    assert!(blocks(&found) < 1e-7, "{:e}", blocks(&found));
    // Followed: H′ = |q| (H − H₀) in a time τ with h = |q| τ, by the implicit midpoint rule.
    let energy = 0.5 * (0.1f64.powi(2) + 1.1f64.powi(2)) - 1.0 / 1.0f64.hypot(0.1);
    let transformed = PerSample::new(2, move |h, q, p| {
        let rates = |z: [f64; 4]| {
            let r = z[0].hypot(z[1]);
            let excess = 0.5 * (z[2] * z[2] + z[3] * z[3]) - energy;
            // ∂/∂q of r (p²/2 − E₀) − 1.
            [r * z[2], r * z[3], -excess * z[0] / r, -excess * z[1] / r]
        };
        let start = [q[0], q[1], p[0], p[1]];
        let mut next = start;
        for _ in 0..60 {
            let rates = rates(std::array::from_fn(|k| 0.5 * (start[k] + next[k])));
            next = std::array::from_fn(|k| start[k] + h * rates[k]);
        }
        (q[0], q[1], p[0], p[1]) = (next[0], next[1], next[2], next[3]);
    });
    let followed = verdict(&transformed, &q0, &p0, 0.05);
    assert_eq!(followed.kind, VerdictKind::Symplectic, "{followed}");
    // Friction and methods change areas across the trajectories, too.
    let damped = PerSample::new(2, move |h, q, p| {
        leapfrog(h, q, p, &kepler);
        p[0] *= 1.0 - 0.1 * h;
    });
    assert!(blocks(&diagnose(&damped, &q0, &p0, 0.05)) > 0.1);
}

#[test]
fn weights_that_are_nearly_short_numbers_have_all_digits_that_loops_show() {
    // 1 / 1.00001 = 0.9999900001 is 0.99999 to the errors of the Jacobian.
    let chain = PerSample::new(3, |h, q, p| {
        let kick = |q: &[f64], p: &mut [f64]| {
            let spring = |i: usize| 0.3 * (q[i + 1] - q[i]).sin();
            p[0] += 0.5 * h * (-q[0].sin() + spring(0));
            p[1] += 0.5 * h * (1.0 + 1e-5) * (-q[1].sin() - spring(0) + spring(1));
            p[2] += 0.5 * h * (-q[2].sin() - spring(1));
        };
        kick(q, p);
        (0..3).for_each(|i| q[i] += h * p[i]);
        kick(q, p);
    });
    let found = verdict(&chain, &[0.7, -0.4, 1.1], &[0.3, 0.5, -0.2], 0.3);
    let found = cause(&found, CauseKind::VelocitiesForMomenta, &[]);
    assert_eq!(
        found.setting.as_deref(),
        Some("weight = [1, 0.9999900001, 1]")
    );
    assert!(found.digits.unwrap() > 12.0, "{found:?}");
}

#[test]
fn a_drift_of_a_map_without_step_size_is_named() {
    // The exact longitudinal momentum of a lattice, without the slip of the other position.
    let drift = PerSample::new(2, |_, q, p| {
        let along = ((1.0 + p[1]).powi(2) - p[0] * p[0]).sqrt();
        q[0] += 2.0 * p[0] / along;
    });
    let circle = Circle::new(vec![0.0; 2], vec![0.01, 0.0], 0.1).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::without_step_size()
    };
    let found = diagnostic.run(&drift, &circle).unwrap().verdict;
    cause(
        &found,
        CauseKind::VelocityWithCurl,
        &["drift by a velocity v(p)"],
    );
}

#[test]
fn parts_of_a_step_of_many_degrees_of_freedom_are_named() {
    // A chain of pendula with one thing wrong. Random tangent vectors show the defect, and all unit vectors at one state its blocks.
    #[derive(Clone, Copy, PartialEq)]
    enum Wrong {
        Drag,
        Force,
        Velocity,
        Length,
    }
    let chain = |dof: usize, wrong: Wrong| {
        PerSample::new(dof, move |h, q, p| {
            let h = match wrong {
                Wrong::Length => h * (1.0 + 0.1 * q[0].cos()),
                _ => h,
            };
            let kick = |q: &[f64], p: &mut [f64]| {
                for i in 0..dof {
                    let spring = |a: usize, b: usize| 0.3 * (q[b] - q[a]).sin();
                    let left = if i > 0 { spring(i, i - 1) } else { 0.0 };
                    let right = if i + 1 < dof { spring(i, i + 1) } else { 0.0 };
                    p[i] += 0.5 * h * (left + right - q[i].sin());
                }
                if wrong == Wrong::Force {
                    p[0] += 0.05 * h * q[3].sin();
                }
            };
            kick(q, p);
            (0..dof).for_each(|i| q[i] += h * p[i]);
            if wrong == Wrong::Velocity {
                q[0] += 0.1 * h * p[3];
            }
            kick(q, p);
            if wrong == Wrong::Drag {
                p[5] *= 1.0 - 0.05 * h;
            }
        })
    };
    for dof in [12, 30] {
        let q0: Vec<f64> = (0..dof).map(|i| (1.3 * i as f64).sin()).collect();
        let p0: Vec<f64> = (0..dof).map(|i| 0.5 * (2.1 * i as f64).cos()).collect();
        for (wrong, kind) in [
            (Wrong::Drag, CauseKind::PartialFriction),
            (Wrong::Force, CauseKind::ForceWithCurl),
            (Wrong::Velocity, CauseKind::VelocityWithCurl),
            (Wrong::Length, CauseKind::ChosenStepLength),
        ] {
            let found = diagnose(&chain(dof, wrong), &q0, &p0, 0.3);
            cause(&found.verdict, kind, &[]);
            assert!(found.evidence.evaluations.made <= 20_000);
        }
    }
}

#[test]
fn a_forgotten_reaction_is_named() {
    let bodies = |reaction: f64| {
        PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            leapfrog(h, q, p, &|q| {
                let pair = 0.3 * (q[0] - q[1]);
                [-q[0].sin() - reaction * pair, -q[1].sin() + pair]
            });
        })
    };
    let found = diagnose(&bodies(0.0), &[0.4, 0.3], &[0.1, 0.2], 0.5);
    cause(&found.verdict, CauseKind::ForceWithCurl, &["qq 0."]);
    // Only degenerate forms are preserved.
    let form = found.evidence.preserved_form.as_ref().unwrap();
    assert_eq!((form.exists, form.change), (Some(false), None));
    // A weak reaction is one with other weights.
    let found = diagnose(&bodies(1e-4), &[0.4, 0.3], &[0.1, 0.2], 0.5);
    cause(&found.verdict, CauseKind::VelocitiesForMomenta, &[]);
}

#[test]
fn a_small_mass_is_no_forgotten_reaction() {
    // Velocities in another order, with a mass that the Jacobian does not show: the form is left open.
    let light: f64 = 1e-8;
    let masses = [1.0, light];
    let map = PerSample::new(2, move |h, q: &mut [f64], v: &mut [f64]| {
        let kick = |q: &[f64], v: &mut [f64]| {
            let pair = 0.3 * (q[0] - q[1]).sin();
            let force = [-q[0].sin() - pair, -light * q[1].sin() + pair];
            (0..2).for_each(|i| v[1 - i] += 0.5 * h * force[i] / masses[i]);
        };
        kick(q, v);
        (0..2).for_each(|i| q[i] += h * v[1 - i]);
        kick(q, v);
    });
    let circle = Circle::new(vec![0.4, 0.3], vec![0.1, 0.2], 0.3).unwrap();
    let diagnostic = Diagnostic {
        step_sizes: vec![5e-5, 2.5e-5],
        ..Diagnostic::default()
    };
    let found = diagnostic.run(&map, &circle).unwrap();
    let form = found.evidence.preserved_form.as_ref().unwrap();
    assert_eq!(form.exists, None);
    assert!(found.verdict.cause.is_none(), "{}", found.verdict);
}

#[test]
fn friction_is_not_suspected_if_the_step_preserves_volume() {
    // The loop passes the centre of a force that is not a gradient, so that the blocks of the Jacobian tell no cause.
    let map = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        leapfrog(h, q, p, &|q| {
            let r = q[0].hypot(q[1]);
            [-q[0] / r.powi(3), -q[1] / r.powi(2)]
        });
    });
    let found = verdict(&map, &[1.0, 0.0], &[0.0, 1.1], 1.0);
    assert_eq!(found.kind, VerdictKind::NotSymplectic);
    let advice = found.advice().concat();
    assert!(
        advice.starts_with("The step preserves volume"),
        "{found}: {advice}"
    );
}

#[test]
fn small_steps_that_cannot_be_larger_are_tested_together() {
    let map = PerSample::new(1, |h, q, p| {
        // The largest four sizes fail: a state is not finite.
        p[0] -= if h > 0.05 { f64::NAN } else { h * q[0].sin() };
        q[0] += h * p[0];
    });
    let circle = Circle::new(vec![1.0], vec![0.5], 1.0).unwrap();
    let diagnostic = Diagnostic::halving(-1, -10);
    let found = diagnostic.run(&map, &circle).unwrap().verdict;
    assert_eq!(found.kind, VerdictKind::Undecided, "{found}");
    let Some(&Advice::StepsAtOnce { repeat, .. }) = found.advice.first() else {
        panic!("{found}: {:?}", found.advice);
    };
    let followed = Diagnostic {
        step_sizes: vec![1.0 / 32.0, 1.0 / 64.0],
        repeat,
        ..Diagnostic::default()
    };
    let found = followed.run(&map, &circle).unwrap().verdict;
    assert_eq!(found.kind, VerdictKind::Symplectic, "{found}");
}

#[test]
fn a_short_step_that_ignores_h_is_not_symplectic_by_that() {
    // A fourth-order method with its own time step: the defect of one step is a rounding error.
    let fixed = PerSample::new(1, |_, q, p| runge_kutta_step(1.0, 0.01, q, p));
    let found = verdict(&fixed, &[1.0], &[0.5], 1.0);
    assert_eq!(found.kind, VerdictKind::Undecided, "{found}");
    assert_eq!(found.advice, [Advice::UseStepSize]);
}
