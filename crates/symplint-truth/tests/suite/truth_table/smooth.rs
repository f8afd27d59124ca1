//! Every integrator on smooth systems with a potential.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint_models::Model;
use symplint_models::integrators::catalogue::CATALOGUE;
use symplint_models::systems::{
    AbsoluteValue, HenonHeiles, InterpolatedPendulum, Pendulum, PendulumArray, PendulumPotential,
};

use crate::truth_table::case::{Case, Named, circle, known};

/// All integrators there are for such a system.
fn all(system: &str, model: &Model, on: &Named) -> Vec<Case> {
    let known = known(model.dof());
    for info in CATALOGUE.iter().filter(|info| info.is_for(model)) {
        let named = known.iter().map(|(step, ..)| step.split(' ').next());
        let variants = named.filter(|name| *name == Some(info.name)).count();
        assert_eq!(variants, info.variants.len().max(1), "{}", info.name);
    }
    known
        .iter()
        .map(|&(step, truth, because)| Case::built(system, model, step, on.clone(), truth, because))
        .collect()
}

pub fn cases() -> Vec<Case> {
    let on = |q: f64, p: f64| circle(&[q], &[p], 1.0);
    let systems: [(&str, Model, Named); 6] = [
        (
            "pendulum",
            Arc::new(Pendulum::default()).into(),
            on(2.0, 0.5),
        ),
        (
            "pendulum, sin",
            Arc::new(Pendulum::new(PendulumPotential::Sin)).into(),
            on(0.5, 0.3),
        ),
        (
            "Hénon–Heiles",
            Arc::new(HenonHeiles).into(),
            circle(&[0.0, 0.1], &[0.2, 0.1], 0.3),
        ),
        (
            "√(q² + 0.3²)",
            Arc::new(AbsoluteValue::new(0.3).unwrap()).into(),
            on(0.2, 0.1),
        ),
        (
            "interpolated, degree 5",
            Arc::new(InterpolatedPendulum::new(5, 25).unwrap()).into(),
            on(PI, 0.5),
        ),
        (
            "not interpolated",
            Arc::new(InterpolatedPendulum::new(0, 25).unwrap()).into(),
            on(PI, 0.5),
        ),
    ];
    (systems.iter())
        .flat_map(|(name, model, on)| all(name, model, on))
        .collect()
}

pub fn arrays() -> Vec<Case> {
    let array = PendulumArray::new(8, 1.0, 1.0).unwrap();
    let (q, p) = array.uniform_state(3);
    all("array", &Arc::new(array).into(), &circle(&q, &p, 1.0))
}
