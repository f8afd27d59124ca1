//! Maps whose inner solver stops at a tolerance: the loop breaks wherever the number of iterations changes, by about
//! the tolerance, and rounding decides about it in a zone that is far wider than the rounding of s.

mod advice;
mod breaks;
mod midpoint;
mod small_jumps;
mod truth;

use symplint::{Diagnosis, Diagnostic, Rule};

use midpoint::{Field, map};
use truth::Circle;

/// The evidence of the given loop in one step.
fn diagnose<F: Field>(circle: &Circle, h: f64, tolerance: f64, rule: Rule) -> Diagnosis {
    let diagnostic = Diagnostic {
        rule,
        step_sizes: vec![h],
        loops: 1,
        jacobian: false,
        localise: false,
        budget: Some(50_000),
        ..Diagnostic::default()
    };
    let map = map::<F>(tolerance);
    diagnostic.run(&*map, &circle.of_library()).unwrap()
}
