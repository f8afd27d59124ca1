//! A pendulum whose potential is interpolated by B-splines.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint_models::Model;
use symplint_models::systems::InterpolatedPendulum;

use crate::truth_table::case::{
    BROKEN, BROKEN_AND_CLOSED, Case, NOT_SYMPLECTIC, SYMPLECTIC, circle, of_order, symplectic_to,
};

pub fn cases() -> Vec<Case> {
    let torn = "a degree-1 force jumps at every node of the grid";
    let kinks = "the force of degree 2 and above is continuous: kinks are no breaks";
    let mut cases = Vec::new();
    for degree in 0..=5 {
        let model: Model = Arc::new(InterpolatedPendulum::new(degree, 25).unwrap()).into();
        let rk2 = "explicit midpoint, not symplectic in any potential";
        let answers = match degree {
            0 => [SYMPLECTIC, symplectic_to(12.5), of_order(3.0)],
            1 => [BROKEN_AND_CLOSED, BROKEN_AND_CLOSED, BROKEN],
            _ => [symplectic_to(10.0), symplectic_to(9.0), NOT_SYMPLECTIC],
        };
        for (step, truth) in ["strang", "yoshida4", "rk2"].into_iter().zip(answers) {
            let because = match (degree, step) {
                (1, _) => torn,
                (_, "rk2") => rk2,
                (0, _) => "V itself, not interpolated: exact flows",
                _ => kinks,
            };
            let name = format!("interpolated, degree {degree}");
            let on = circle(&[PI], &[0.0], 1.0);
            let (from, to) = if degree == 0 { (-1, -10) } else { (-1, -5) };
            cases.push(Case::built(name, &model, step, on, truth, because).steps(from, to));
        }
    }
    let model: Model = Arc::new(InterpolatedPendulum::new(1, 25).unwrap()).into();
    // Nodes lie 0.2513 apart, the first at 0.
    let between = circle(&[0.1257], &[0.0], 0.05);
    cases.push(
        Case::built(
            "interpolated, degree 1",
            &model,
            "strang",
            between,
            SYMPLECTIC,
            "the force is constant between two nodes, and loop and drift stay there",
        )
        .steps(-1, -5),
    );
    cases
}
