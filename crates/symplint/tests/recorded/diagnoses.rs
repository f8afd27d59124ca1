//! Whole diagnoses: evidence, verdict and words.

use symplint::{Diagnosis, Diagnostic};

use crate::maps::cases;
use crate::record::check;

/// Coefficients of smoother loops reach round-off before they show how smooth these are, and those of noise show nothing.
const REGULARITY: [f64; 2] = [0.0, 6.0];

fn write(text: &mut String, name: &str, what: &str, found: &Diagnosis) {
    let mut evidence = found.evidence.clone();
    for step in (evidence.loops.iter_mut()).flat_map(|found| &mut found.steps) {
        step.regularity = step
            .regularity
            .map(|s| s.clamp(REGULARITY[0], REGULARITY[1]));
    }
    let evidence = serde_json::to_string_pretty(&evidence).unwrap();
    *text += &format!("== {name}, {what}\n{}\n{evidence}\n", found.verdict);
}

fn diagnose(diagnostic: &Diagnostic, what: &str, file: &str) {
    let mut text = String::new();
    // Rounding decides in how many breaks of a solver it shows.
    let cases = cases().into_iter();
    for case in cases.filter(|case| !case.name.starts_with("solver")) {
        match diagnostic.run(&*case.map, &*case.phase_loop) {
            Ok(found) => write(&mut text, case.name, what, &found),
            Err(error) => text += &format!("== {}, {what}\n{error}\n", case.name),
        }
    }
    check(file, &text);
}

#[test]
fn on_a_small_budget() {
    let diagnostic = Diagnostic {
        budget: Some(3_000),
        ..Diagnostic::halving(-1, -4)
    };
    diagnose(&diagnostic, "3,000 evaluations", "on_a_small_budget");
}

#[test]
fn on_the_default_budget() {
    let diagnostic = Diagnostic {
        loops: 3,
        budget: Some(60_000),
        long_time: 20,
        ..Diagnostic::halving(-1, -3)
    };
    diagnose(&diagnostic, "60,000 evaluations", "on_a_large_budget");
}
