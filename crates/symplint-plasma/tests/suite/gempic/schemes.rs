//! Schemes that are no splitting: the equations they solve, what they conserve, and the order of their defects.

use symplint::TimeAdvance;
use symplint::map::Parts;
use symplint_models::integrators::{Solver, StageSolver, Stop};
use symplint_models::{Model, ModelError, SplitHamiltonian};
use symplint_plasma::CATALOGUE;
use symplint_plasma::gempic::{Fields as Discretisation, Gempic, GempicConfig, PhysicalState};

use crate::common::{State, distance, stepped};
use crate::gempic::reference::{Fields, Plasma, config, gauss, random_state};

const DISCRETISATIONS: [Discretisation; 2] = [Discretisation::FiniteElement, Discretisation::Yee];

/// Particles and fields, weaker than those of other tests: a step of 0.4 resolves the plasma frequency.
pub fn plasma(degree: usize, fields: Discretisation) -> Gempic {
    let config = GempicConfig {
        fields,
        charge: -1.0,
        mass: 1.0,
        ..config(degree, 8, 4)
    };
    Gempic::new(config).unwrap()
}

/// The same by its definition.
pub fn reference(degree: usize, fields: Discretisation) -> Plasma {
    let mut plasma = Plasma::new(GempicConfig {
        charge: -1.0,
        mass: 1.0,
        ..config(degree, 8, 4)
    });
    if fields == Discretisation::Yee {
        let n = plasma.config.cells;
        let width = plasma.width();
        plasma.m0.fill_with_identity();
        plasma.m0 *= width;
        plasma.m1.fill_with_identity();
        plasma.m1 /= width;
        (plasma.inverse0, plasma.inverse1) = (
            nalgebra::DMatrix::identity(n, n) / width,
            nalgebra::DMatrix::identity(n, n) * width,
        );
    }
    plasma
}

fn build(gempic: &Gempic, name: &str, variant: Option<&str>) -> Box<dyn TimeAdvance> {
    let (solver, model) = (StageSolver::default(), Model::from(gempic.clone()));
    CATALOGUE.build(solver, name, variant, model).unwrap()
}

fn start(gempic: &Gempic, seed: usize) -> State {
    gempic.state(&random_state(gempic, seed)).unwrap()
}

const ENERGY_CONSERVING: [(&str, Option<&str>); 4] = [
    ("crank-nicolson", Some("midpoint")),
    ("crank-nicolson", Some("sub-stepped")),
    ("crank-nicolson", Some("orbit-averaged")),
    ("ecsim", None),
];

#[test]
fn energy_is_conserved_to_round_off() {
    for fields in DISCRETISATIONS {
        for degree in 2..=5 {
            let gempic = plasma(degree, fields);
            for (name, variant) in ENERGY_CONSERVING {
                let map = build(&gempic, name, variant);
                for h in [0.4, 0.2, 0.1, 0.05] {
                    let state = start(&gempic, 5);
                    let energy = |(q, p): &State| {
                        let parts = gempic.energies(q, p);
                        parts.kinetic_along
                            + parts.kinetic_across
                            + parts.electric_along
                            + parts.electric_across
                            + parts.magnetic
                    };
                    let change = energy(&stepped(&*map, h, &state)) / energy(&state) - 1.0;
                    assert!(
                        change.abs() < 1e-14,
                        "{name}, {variant:?}, {fields:?}, degree {degree}, h = {h}: {change:e}"
                    );
                }
            }
        }
    }
}

/// The mean over the straight way from x to x', of a function of the place, by its definition.
fn mean_along(plasma: &Plasma, x: f64, end: f64, of: impl Fn(f64) -> f64) -> f64 {
    let width = plasma.width();
    let (low, high) = (x.min(end), x.max(end));
    let mut sum = 0.0;
    for cell in (low / width).floor() as i64..=(high / width).floor() as i64 {
        let from = (cell as f64 * width).max(low);
        let to = ((cell + 1) as f64 * width).min(high);
        for (node, weight) in gauss() {
            sum += weight * (to - from) * of(from + node * (to - from));
        }
    }
    sum / (high - low)
}

/// How far two states are from being linked by Crank–Nicolson with fields from `mean(of, x, x')`.
fn crank_nicolson_residual(
    plasma: &Plasma,
    h: f64,
    before: &Fields,
    after: &Fields,
    mean: impl Fn(&dyn Fn(f64) -> f64, f64, f64) -> f64,
) -> f64 {
    let half = |a: &nalgebra::DVector<f64>, b: &nalgebra::DVector<f64>| (a + b) * 0.5;
    let (e1, e2) = (half(&before.e1, &after.e1), half(&before.e2, &after.e2));
    let b = half(&before.b, &after.b);
    let ratio = plasma.config.charge / plasma.config.mass;
    let mut worst = 0f64;
    let mut note = |residual: f64| worst = worst.max(residual.abs());
    let mut current1 = &e1 * 0.0;
    let mut current2 = &e2 * 0.0;
    for a in 0..before.x.len() {
        let (x, end) = (before.x[a], after.x[a]);
        let v1 = 0.5 * (before.v1[a] + after.v1[a]);
        let v2 = 0.5 * (before.v2[a] + after.v2[a]);
        let of_e1 = mean(&|x| plasma.one(x).dot(&e1), x, end);
        let of_e2 = mean(&|x| plasma.zero(x).dot(&e2), x, end);
        let of_b = mean(&|x| plasma.one(x).dot(&b), x, end);
        note(end - x - h * v1);
        note(after.y[a] - before.y[a] - h * v2);
        note(after.v1[a] - before.v1[a] - h * ratio * (of_e1 + v2 * of_b));
        note(after.v2[a] - before.v2[a] - h * ratio * (of_e2 - v1 * of_b));
        let charge = h * plasma.config.charge * plasma.weights[a];
        for j in 0..e1.len() {
            current1[j] += charge * v1 * mean(&|x| plasma.one(x)[j], x, end);
            current2[j] += charge * v2 * mean(&|x| plasma.zero(x)[j], x, end);
        }
    }
    let curl = plasma.c.transpose() * (&plasma.m1 * &b) * h;
    note((&plasma.m1 * (&after.e1 - &before.e1) + current1).amax());
    note((&plasma.m0 * (&after.e2 - &before.e2) + current2 - curl).amax());
    note((&after.a1 - &before.a1 + &e1 * h).amax());
    note((&after.a2 - &before.a2 + &e2 * h).amax());
    note((&after.b - &before.b + &plasma.c * &e2 * h).amax());
    worst
}

#[test]
fn crank_nicolson_solves_its_equations() {
    const H: f64 = 0.4;
    for fields in DISCRETISATIONS {
        for degree in 2..=5 {
            let (gempic, plasma) = (plasma(degree, fields), reference(degree, fields));
            let state = start(&gempic, 6);
            let of = |state: &State| plasma.fields(&gempic.physical(&state.0, &state.1));
            let before = of(&state);
            let after = |variant| {
                let map = build(&gempic, "crank-nicolson", Some(variant));
                of(&stepped(&*map, H, &state))
            };
            let in_middle = |of: &dyn Fn(f64) -> f64, x: f64, end: f64| of(0.5 * (x + end));
            let averaged =
                |of: &dyn Fn(f64) -> f64, x: f64, end: f64| mean_along(&plasma, x, end, of);
            let found = crank_nicolson_residual(&plasma, H, &before, &after("midpoint"), in_middle);
            assert!(found < 1e-13, "{fields:?}, degree {degree}: {found:e}");
            let found =
                crank_nicolson_residual(&plasma, H, &before, &after("orbit-averaged"), averaged);
            assert!(
                found < 1e-13,
                "averaged, {fields:?}, degree {degree}: {found:e}"
            );
        }
    }
}

/// The part between the drifts of ECSIM: Crank–Nicolson with positions held and the magnetic field from before in the
/// force.
#[test]
fn ecsim_solves_its_equations() {
    const H: f64 = 0.4;
    for fields in DISCRETISATIONS {
        for degree in 2..=5 {
            let (gempic, plasma) = (plasma(degree, fields), reference(degree, fields));
            let map = build(&gempic, "ecsim", None);
            let (mut q, mut p) = start(&gempic, 7);
            let of = |q: &[f64], p: &[f64]| plasma.fields(&gempic.physical(q, p));
            let before = of(&q, &p);
            crate::gempic::flows::with_block(&mut q, &mut p, |block| {
                Parts::of(&map).advance(1, H, block).unwrap();
            });
            let after = of(&q, &p);
            assert_eq!((&before.x, &before.y), (&after.x, &after.y));
            let ratio = plasma.config.charge / plasma.config.mass;
            let (e1, e2) = (
                (&before.e1 + &after.e1) * 0.5,
                (&before.e2 + &after.e2) * 0.5,
            );
            let (mut current1, mut current2) = (&e1 * 0.0, &e2 * 0.0);
            let mut worst = 0f64;
            for a in 0..before.x.len() {
                let x = before.x[a];
                let v1 = 0.5 * (before.v1[a] + after.v1[a]);
                let v2 = 0.5 * (before.v2[a] + after.v2[a]);
                let b = plasma.one(x).dot(&before.b);
                let kick1 = H * ratio * (plasma.one(x).dot(&e1) + v2 * b);
                let kick2 = H * ratio * (plasma.zero(x).dot(&e2) - v1 * b);
                worst = worst.max((after.v1[a] - before.v1[a] - kick1).abs());
                worst = worst.max((after.v2[a] - before.v2[a] - kick2).abs());
                let charge = H * plasma.config.charge * plasma.weights[a];
                current1 += plasma.one(x) * (charge * v1);
                current2 += plasma.zero(x) * (charge * v2);
            }
            let b = (&before.b + &after.b) * 0.5;
            let curl = plasma.c.transpose() * (&plasma.m1 * &b) * H;
            worst = worst.max((&plasma.m1 * (&after.e1 - &before.e1) + current1).amax());
            worst = worst.max((&plasma.m0 * (&after.e2 - &before.e2) + current2 - curl).amax());
            worst = worst.max((&after.b - &before.b + &plasma.c * &e2 * H).amax());
            assert!(worst < 1e-13, "{fields:?}, degree {degree}: {worst:e}");
        }
    }
}

/// A step of Boris with leapfrog fields, in physical variables and with dense matrices.
fn boris_by_definition(plasma: &Plasma, h: f64, state: &mut Fields, variant: &str) {
    let half = 0.5 * h * plasma.config.charge / plasma.config.mass;
    let staggered = variant == "staggered";
    let kick = |state: &mut Fields, electric: f64, angle: f64, first: bool| {
        for a in 0..state.x.len() {
            let x = state.x[a];
            let (e1, b) = match variant {
                "nodal" => {
                    let zero = plasma.zero(x);
                    let n = zero.len();
                    let node = |edges: &nalgebra::DVector<f64>, j: usize| {
                        0.5 * (edges[j] + edges[(j + 1) % n]) / plasma.width()
                    };
                    let sum = |edges| (0..n).map(|j| zero[j] * node(edges, j)).sum::<f64>();
                    (sum(&state.e1), sum(&state.b))
                }
                _ => (plasma.one(x).dot(&state.e1), plasma.one(x).dot(&state.b)),
            };
            let push = [
                half * electric * e1,
                half * electric * plasma.zero(x).dot(&state.e2),
            ];
            // By the angle itself.
            let turn = angle * 2.0 * (half * b).atan();
            let rotated = |v: [f64; 2]| {
                let (sin, cos) = turn.sin_cos();
                [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0]]
            };
            let added = |v: [f64; 2]| [v[0] + push[0], v[1] + push[1]];
            let v = [state.v1[a], state.v2[a]];
            let v = match (staggered, first) {
                (true, _) => added(rotated(added(v))),
                (false, true) => added(rotated(v)),
                (false, false) => rotated(added(v)),
            };
            [state.v1[a], state.v2[a]] = v;
        }
    };
    let faraday = |state: &mut Fields| {
        state.a1 -= &state.e1 * (0.5 * h);
        state.a2 -= &state.e2 * (0.5 * h);
        state.b -= &plasma.c * &state.e2 * (0.5 * h);
    };
    let angle = if staggered { 1.0 } else { 0.5 };
    kick(state, 1.0, angle, true);
    faraday(state);
    for a in 0..state.x.len() {
        let (x, charge) = (state.x[a], plasma.weights[a] * plasma.config.charge);
        let end = x + h * state.v1[a];
        let n = state.e1.len();
        let along = nalgebra::DVector::from_fn(n, |j, _| match variant {
            "direct" => plasma.one(0.5 * (x + end))[j],
            _ => mean_along(plasma, x, end, |x| plasma.one(x)[j]),
        });
        state.e1 -= &plasma.inverse1 * along * (charge * (end - x));
        let across = plasma.zero(0.5 * (x + end)) * (charge * h * state.v2[a]);
        state.e2 -= &plasma.inverse0 * across;
        state.x[a] = end;
        state.y[a] += h * state.v2[a];
    }
    state.e2 += &plasma.inverse0 * (plasma.c.transpose() * (&plasma.m1 * &state.b)) * h;
    faraday(state);
    if !staggered {
        kick(state, 1.0, angle, false);
    }
}

#[test]
fn boris_is_its_definition() {
    const H: f64 = 0.3;
    for fields in DISCRETISATIONS {
        for degree in 1..=5 {
            let (gempic, plasma) = (plasma(degree, fields), reference(degree, fields));
            let state = start(&gempic, 8);
            for variant in ["synchronised", "staggered", "nodal", "direct"] {
                let map = build(&gempic, "boris-pic", Some(variant));
                let (q, p) = stepped(&*map, H, &state);
                let mut expected = plasma.fields(&gempic.physical(&state.0, &state.1));
                boris_by_definition(&plasma, H, &mut expected, variant);
                let found = plasma.distance(&expected, &gempic.physical(&q, &p));
                assert!(
                    found < 1e-12,
                    "{variant}, {fields:?}, degree {degree}: {found:e}"
                );
            }
        }
    }
}

#[test]
fn schemes_that_say_so_conserve_gauss_law() {
    for fields in DISCRETISATIONS {
        let gempic = plasma(3, fields);
        let mut physical = random_state(&gempic, 9);
        physical.e1 = gempic.electrostatic_field(&physical.x);
        let begin = gempic.state(&physical).unwrap();
        for (name, variant, conserves) in [
            ("crank-nicolson", Some("midpoint"), false),
            ("crank-nicolson", Some("sub-stepped"), false),
            ("crank-nicolson", Some("orbit-averaged"), true),
            ("ecsim", None, false),
            ("boris-pic", Some("synchronised"), true),
            ("boris-pic", Some("staggered"), true),
            ("boris-pic", Some("nodal"), true),
            ("boris-pic", Some("direct"), false),
        ] {
            let map = build(&gempic, name, variant);
            let mut state = begin.clone();
            for _ in 0..300 {
                state = stepped(&*map, 0.1, &state);
            }
            let residual = gempic.gauss_residual(&state.0, &state.1);
            assert_eq!(
                residual < 1e-13,
                conserves,
                "{name}, {variant:?}: {residual:e}"
            );
            assert!(
                conserves || residual > 1e-6,
                "{name}, {variant:?}: {residual:e}"
            );
        }
    }
}

/// Towards the exact solution, by dop853 in canonical variables; staggered velocities are of another time.
#[test]
fn schemes_have_their_orders() {
    for fields in DISCRETISATIONS {
        let gempic = plasma(5, fields);
        let mut physical = random_state(&gempic, 10);
        check_orders(&gempic, &gempic.state(&physical).unwrap(), 1.0);
        // Without transverse motion the magnetic field vanishes.
        for rest in [&mut physical.v2, &mut physical.a2, &mut physical.e2] {
            rest.fill(0.0);
        }
        let along = gempic.state(&physical).unwrap();
        check_orders(&gempic, &along, 2.0);
    }
}

fn check_orders(gempic: &Gempic, begin: &State, of_ecsim: f64) {
    const TIME: f64 = 0.4;
    let at_end = |map: &dyn TimeAdvance, steps: u32| {
        let h = TIME / f64::from(steps);
        (0..steps).fold(begin.clone(), |state, _| stepped(map, h, &state))
    };
    let exact = at_end(&*build(gempic, "dop853", None), 400);
    for (name, variant, expected) in [
        ("crank-nicolson", Some("midpoint"), 2.0),
        ("crank-nicolson", Some("sub-stepped"), 2.0),
        ("crank-nicolson", Some("orbit-averaged"), 2.0),
        ("ecsim", None, of_ecsim),
        ("boris-pic", Some("synchronised"), 2.0),
    ] {
        let map = build(gempic, name, variant);
        let [coarse, fine] = [8, 16].map(|steps| distance(&at_end(&*map, steps), &exact));
        let order = (coarse / fine).log2();
        assert!(
            (order - expected).abs() < 0.15,
            "{name}, {variant:?}: {coarse:e}, {fine:e}"
        );
        // There and back: a symmetric step undoes itself.
        let back = stepped(&*map, -0.1, &stepped(&*map, 0.1, begin));
        let is_symmetric = distance(&back, begin) < 1e-13;
        assert_eq!(is_symmetric, expected == 2.0, "{name}, {variant:?}");
    }
}

/// Without particles' charge, leapfrog fields have the dispersion relation of Yee: sin(ωh/2)/h = sin(kΔx/2)/Δx.
#[test]
fn light_obeys_the_dispersion_relation_of_yee() {
    let gempic = Gempic::new(GempicConfig {
        charge: 0.0,
        fields: Discretisation::Yee,
        ..config(2, 8, 1)
    });
    let gempic = gempic.unwrap();
    let map = build(&gempic, "boris-pic", None);
    let (h, width) = (0.3, gempic.length() / 8.0);
    let k = 2.0 * std::f64::consts::TAU / gempic.length();
    let mode: Vec<f64> = (0..8).map(|j| (k * width * f64::from(j)).cos()).collect();
    let mut physical = PhysicalState {
        e2: mode.clone(),
        ..random_state(&gempic, 0)
    };
    physical.a1.fill(0.0);
    physical.e1.fill(0.0);
    physical.a2.fill(0.0);
    let mut state = gempic.state(&physical).unwrap();
    let omega = 2.0 / h * (h / width * (0.5 * k * width).sin()).asin();
    for step in 1..=50 {
        state = stepped(&*map, h, &state);
        let e2 = gempic.physical(&state.0, &state.1).e2;
        let cosine = (omega * h * f64::from(step)).cos();
        for (found, mode) in e2.iter().zip(&mode) {
            assert!((found - cosine * mode).abs() < 1e-12, "step {step}");
        }
    }
}

#[test]
fn what_cannot_be_solved_is_refused() {
    let model = || Model::from(plasma(3, Discretisation::FiniteElement));
    let newton = StageSolver {
        solver: Solver::Newton,
        ..StageSolver::default()
    };
    for name in ["crank-nicolson", "ecsim"] {
        let refused = CATALOGUE.build(newton, name, None, model());
        assert!(
            matches!(refused, Err(ModelError::NoNewton { .. })),
            "{name}"
        );
        let none = StageSolver {
            stop: Stop::Iterations(0),
            ..StageSolver::default()
        };
        let refused = CATALOGUE.build(none, name, None, model());
        assert!(matches!(refused, Err(ModelError::NoIterations)), "{name}");
    }
    // One iteration is not enough for round-off, and the step reports it.
    let hasty = StageSolver {
        stop: Stop::Converged {
            tolerance: 1e-15,
            max_iterations: 2,
        },
        ..StageSolver::default()
    };
    let map = CATALOGUE
        .build(hasty, "crank-nicolson", None, model())
        .unwrap();
    let gempic = plasma(3, Discretisation::FiniteElement);
    let (mut q, mut p) = start(&gempic, 5);
    crate::gempic::flows::with_block(&mut q, &mut p, |block| {
        let failure = map.advance(0.4, block).unwrap_err();
        assert!(
            failure.reason.contains("did not converge in 2"),
            "{}",
            failure.reason
        );
    });
}

/// A particle so far out that its place is rounded to more than a cell has no field: the numbers of its cells are no longer
/// told apart, and going through them would not end.
#[test]
fn places_that_are_rounded_to_more_than_a_cell_fail() {
    let gempic = plasma(4, Discretisation::Yee);
    let variants = ["midpoint", "sub-stepped", "orbit-averaged"].map(|v| ("crank-nicolson", v));
    let pushes = ["synchronised", "staggered", "nodal", "direct"].map(|v| ("boris-pic", v));
    for (name, variant) in variants.into_iter().chain(pushes) {
        let map = build(&gempic, name, Some(variant));
        let advance = |x: f64| {
            let mut physical = random_state(&gempic, 5);
            physical.x[1] = x;
            let (mut q, mut p) = gempic.state(&physical).unwrap();
            let mut outcome = Ok(());
            crate::gempic::flows::with_block(&mut q, &mut p, |block| {
                outcome = map.advance(0.1, block)
            });
            outcome.map_err(|failure| failure.reason)
        };
        for x in [1e17, -1e17, 1e300] {
            let reason = advance(x).unwrap_err();
            for part in ["particle 1", "rounding is", "inside the box"] {
                assert!(reason.contains(part), "{name}, {variant}: {reason}");
            }
        }
        // Rounded to 3e-4 of a cell.
        assert_eq!(advance(1e12), Ok(()), "{name}, {variant}");
    }
}

/// The kick by e and Faraday's law are one flow of the splitting; apart, neither is symplectic.
#[test]
fn electric_substeps_of_boris_are_flows_of_the_splitting() {
    const H: f64 = 0.3;
    for fields in DISCRETISATIONS {
        for degree in 1..=5 {
            let gempic = plasma(degree, fields);
            let begin = start(&gempic, 5);
            for (variant, substeps) in [
                ("synchronised", &[1, 4][..]),
                ("direct", &[1, 4]),
                ("staggered", &[2]),
            ] {
                let map = build(&gempic, "boris-pic", Some(variant));
                for &substep in substeps {
                    let mut expected = begin.clone();
                    crate::gempic::flows::with_block(&mut expected.0, &mut expected.1, |block| {
                        // H_E.
                        gempic.flow(0, 0.5 * H, block);
                    });
                    let mut found = begin.clone();
                    crate::gempic::flows::with_block(&mut found.0, &mut found.1, |block| {
                        Parts::of(&map).advance(substep, H, block).unwrap();
                    });
                    let off = distance(&found, &expected);
                    assert!(off < 1e-14, "{variant}, {fields:?}, {degree}: {off:e}");
                }
            }
        }
    }
}

/// Steps of any size end: particles that pass more cells than anybody wants are refused.
#[test]
fn huge_steps_fail() {
    let gempic = plasma(3, Discretisation::Yee);
    for (name, variant) in ENERGY_CONSERVING.into_iter().chain([
        ("boris-pic", Some("synchronised")),
        ("boris-pic", Some("staggered")),
    ]) {
        let map = build(&gempic, name, variant);
        for h in [1e9, 1e150, 1e300, -1e300] {
            let (mut q, mut p) = start(&gempic, 5);
            crate::gempic::flows::with_block(&mut q, &mut p, |block| {
                // Any result will do.
                let _ = map.advance(h, block);
            });
        }
    }
    let map = build(&gempic, "boris-pic", None);
    let (mut q, mut p) = start(&gempic, 5);
    crate::gempic::flows::with_block(&mut q, &mut p, |block| {
        let failure = map.advance(1e9, block).unwrap_err();
        assert!(failure.reason.contains("in one step"), "{}", failure.reason);
    });
}
