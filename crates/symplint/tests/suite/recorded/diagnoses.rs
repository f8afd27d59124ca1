//! Whole diagnoses: words and the numbers behind them.

use symplint::diagnosis::SampleCount;
use symplint::rules::{Cutoffs, Streaming};
use symplint::verdict::{BoundFinding, Finding};
use symplint::{Diagnostic, Evidence, Rule, Verdict};

use crate::recorded::maps::cases;
use crate::recorded::record::{ROUND_OFF, check};

/// The verdict with its sentences, and a line for each step of each loop.
pub fn write(text: &mut String, heading: &str, verdict: &Verdict, evidence: &Evidence) {
    *text += &format!("== {heading}\n{verdict}\n");
    // Which loop bounds a defect at round-off is chance.
    let chance = |finding: &&Finding| matches!(finding, Finding::Bounds(BoundFinding::Bound { measured, .. }) if *measured < ROUND_OFF);
    for finding in verdict
        .findings
        .iter()
        .skip(1)
        .filter(|finding| !chance(finding))
    {
        *text += &format!("{finding}\n");
    }
    if let Some(cause) = &verdict.cause {
        *text += &format!("Cause: {}\n", cause.text);
    }
    for sentence in verdict.advice() {
        *text += &format!("{sentence}\n");
    }
    for found in &evidence.loops {
        for step in &found.steps {
            let h = step.step_size.map_or("no h".into(), |h| format!("h {h}"));
            let breaks = step.closing.map_or(0, |closing| closing.breaks);
            *text += &format!(
                "loop {} {h} {} samples: {:.3e} ± {:.1e}, {breaks} breaks, {} evaluations\n",
                found.index,
                step.samples,
                step.defect.signed,
                step.defect.uncertainty(),
                step.evaluations
            );
        }
    }
}

fn diagnose(diagnostic: &Diagnostic, what: &str, file: &str) {
    let mut text = String::new();
    // Rounding decides in how many breaks of a solver it shows.
    let cases = cases().into_iter();
    for case in cases.filter(|case| !case.name.starts_with("solver")) {
        match diagnostic.run(&*case.map, &*case.phase_loop) {
            Ok(found) => {
                let heading = format!("{}, {what}", case.name);
                write(&mut text, &heading, &found.verdict, &found.evidence);
            }
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

#[test]
fn by_finite_differences() {
    let diagnostic = Diagnostic {
        rule: Rule::FiniteDifference(Cutoffs::relative(20.0)),
        samples: SampleCount::Fixed(400),
        loops: 2,
        budget: Some(20_000),
        ..Diagnostic::halving(-1, -2)
    };
    diagnose(&diagnostic, "finite differences", "by_finite_differences");
}

#[test]
fn by_streaming() {
    let diagnostic = Diagnostic {
        rule: Rule::Streaming(Streaming::default()),
        loops: 2,
        budget: Some(20_000),
        ..Diagnostic::halving(-1, -2)
    };
    diagnose(&diagnostic, "streaming", "by_streaming");
}
