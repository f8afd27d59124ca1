//! Maps made of maps, and maps with a fault.

use std::sync::Arc;

use symplint::TimeAdvance;
use symplint::map::Repeat;
use symplint_models::Separable;
use symplint_models::discrete::StandardMap;
use symplint_models::integrators::catalogue::build;
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_models::maps::{Adjoint, Compose, DampedMap, Inverse, SinglePrecision};
use symplint_models::systems::{HenonHeiles, Pendulum};

use crate::truth_table::case::{
    Case, NOT_SYMPLECTIC, Named, SYMPLECTIC, Truth, circle, of_order, symplectic_to,
};

fn off_centre() -> Named {
    circle(&[2.0], &[0.5], 1.0)
}

fn strang() -> Splitting<Pendulum> {
    let method = splitting_methods::strang(Variant::PositionFirst);
    Splitting::new(method, Pendulum::default())
}

fn mclachlan() -> Splitting<HenonHeiles> {
    Splitting::new(
        splitting_methods::mclachlan4(Variant::MomentumFirst),
        HenonHeiles,
    )
}

fn step(name: &str, variant: Option<&str>) -> Box<dyn TimeAdvance> {
    let system: Arc<dyn Separable> = Arc::new(Pendulum::default());
    build(name, variant, system).unwrap()
}

fn pendulum(
    what: &str,
    map: impl TimeAdvance + 'static,
    truth: Truth,
    because: &'static str,
) -> Case {
    Case::new("pendulum", what, map, off_centre(), truth, because)
}

pub fn cases() -> Vec<Case> {
    let mut cases = composed();
    cases.extend(damped());
    cases.extend(rounded());
    cases
}

fn composed() -> Vec<Case> {
    let jump = 1.0 / (2.0 - 2f64.cbrt());
    let jumps = |name: &str, variant: &str| {
        let variant = Some(variant);
        Compose::new(vec![
            (jump, step(name, variant)),
            (1.0 - 2.0 * jump, step(name, variant)),
            (jump, step(name, variant)),
        ])
        .unwrap()
    };
    let heiles = || circle(&[0.0, 0.1], &[0.2, 0.1], 0.3);
    vec![
        pendulum(
            "five Strang steps",
            Repeat::new(strang(), 5).unwrap(),
            symplectic_to(12.5),
            "symplectic maps are a group",
        )
        .steps(-2, -8),
        pendulum(
            "a Strang step undone",
            Inverse(strang()),
            SYMPLECTIC,
            "symplectic maps are a group",
        ),
        pendulum(
            "Strang and a step of another size undone",
            Compose::new(vec![
                (1.0, Box::new(strang()) as Box<dyn TimeAdvance>),
                (0.3, Box::new(Inverse(strang()))),
            ])
            .unwrap(),
            SYMPLECTIC,
            "symplectic maps are a group",
        ),
        pendulum(
            "Strang, then implicit midpoint",
            Compose::new(vec![
                (0.5, step("strang", None)),
                (0.5, step("implicit-midpoint", None)),
            ])
            .unwrap(),
            SYMPLECTIC,
            "symplectic maps are a group",
        ),
        pendulum(
            "triple jump of Strang",
            jumps("strang", "position-first"),
            SYMPLECTIC,
            "Yoshida's",
        ),
        pendulum(
            "triple jump of the explicit midpoint rule",
            jumps("rk2", "midpoint"),
            of_order(4.0),
            "its sum of cubes vanishes and takes the h³ term away; h⁴ is left",
        ),
        pendulum(
            "triple jump of Heun's method",
            jumps("rk2", "heun"),
            of_order(4.0),
            "the h⁴ term comes with a sum of fourth powers, which is positive",
        ),
        pendulum(
            "three steps of the explicit midpoint rule",
            Repeat::new(step("rk2", Some("midpoint")), 3).unwrap(),
            of_order(3.0),
            "the h³ of each step add up",
        )
        .steps(-2, -9),
        pendulum(
            "Strang, then the explicit midpoint rule",
            Compose::new(vec![
                (1.0, step("strang", None)),
                (1.0, step("rk2", Some("midpoint"))),
            ])
            .unwrap(),
            of_order(3.0),
            "one part that is not symplectic is enough",
        )
        .steps(-2, -9),
        Case::new(
            "Hénon–Heiles",
            "a hundred steps of McLachlan's method",
            Repeat::new(mclachlan(), 100).unwrap(),
            circle(&[0.0, 0.1], &[0.1, 0.0], 0.15),
            symplectic_to(11.0),
            "symplectic maps are a group",
        )
        .steps(-2, -4),
        Case::new(
            "standard map, K = 5",
            "three steps",
            Repeat::new(StandardMap::new(5.0).unwrap(), 3).unwrap(),
            circle(&[0.0], &[0.1], 1.0),
            symplectic_to(11.0),
            "symplectic maps are a group, chaotic ones, too",
        )
        .steps(0, -3),
        Case::new(
            "Hénon–Heiles",
            "the adjoint of McLachlan's method",
            Adjoint(mclachlan()),
            heiles(),
            SYMPLECTIC,
            "the adjoint of a symplectic map is one",
        ),
        Case::new(
            "Hénon–Heiles",
            "McLachlan's method undone",
            Inverse(mclachlan()),
            heiles(),
            SYMPLECTIC,
            "symplectic maps are a group",
        ),
    ]
}

fn damped() -> Vec<Case> {
    let because = "damping multiplies every loop integral by e^{−γh}";
    let mut cases: Vec<Case> = [0.5, 0.1, -0.1, 1e-3, 1e-6, 1e-9, 1e-11]
        .into_iter()
        .map(|rate| {
            let map = DampedMap::new(strang(), rate).unwrap();
            pendulum(
                &format!("strang, damped at {rate:e}"),
                map,
                of_order(1.0),
                because,
            )
        })
        .collect();
    let map = DampedMap::new(mclachlan(), 0.05).unwrap();
    let on = circle(&[0.0, 0.1], &[0.2, 0.1], 0.3);
    cases.push(Case::new(
        "Hénon–Heiles",
        "damped",
        map,
        on,
        of_order(1.0),
        because,
    ));
    let map = DampedMap::new(step("rk4", None), 1e-4).unwrap();
    cases.push(pendulum("rk4, damped at 1e-4", map, of_order(1.0), because));
    cases
}

fn rounded() -> Vec<Case> {
    let single = "symplectic but for rounding to 6e-8";
    let heiles = circle(&[0.0, 0.1], &[0.2, 0.1], 0.3);
    vec![
        pendulum(
            "strang, single precision",
            SinglePrecision(strang()),
            symplectic_to(6.0),
            single,
        ),
        pendulum(
            "yoshida4, single precision",
            SinglePrecision(step("yoshida4", None)),
            symplectic_to(6.0),
            single,
        ),
        Case::new(
            "Hénon–Heiles",
            "mclachlan4, single precision",
            SinglePrecision(mclachlan()),
            heiles,
            symplectic_to(6.0),
            single,
        ),
        pendulum(
            "explicit midpoint rule, single precision",
            SinglePrecision(step("rk2", Some("midpoint"))),
            NOT_SYMPLECTIC,
            "its h³ is far above rounding at large steps",
        ),
        pendulum(
            "strang in f32 throughout",
            symplint::PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                let (mut x, mut y, h) = (q[0] as f32, p[0] as f32, h as f32);
                x += 0.5 * h * y;
                y += h * x.sin();
                x += 0.5 * h * y;
                (q[0], p[0]) = (f64::from(x), f64::from(y));
            }),
            symplectic_to(6.0),
            single,
        ),
    ]
}
