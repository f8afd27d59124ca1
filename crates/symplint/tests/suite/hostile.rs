//! Arguments that are given by mistake, found by fuzzing: an error says what is wrong with them.

use symplint::{Circle, Diagnostic, Error, PerSample, TimeAdvance, judge};

/// A unit mass on a unit spring, by symplectic Euler.
fn spring() -> impl TimeAdvance {
    PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0];
        q[0] += h * p[0];
    })
}

fn circle() -> Circle {
    Circle::new(vec![0.1], vec![0.2], 1.0).unwrap()
}

#[test]
fn no_loop_at_all_is_refused() {
    let diagnostic = Diagnostic {
        loops: 0,
        ..Diagnostic::default()
    };
    let error = diagnostic.run(&spring(), &circle()).unwrap_err();
    let Error::OutOfRange { what, remedy, .. } = error else {
        panic!("{error}");
    };
    assert_eq!((what, remedy), ("number of loops", "give 1 to 10,000"));
}

#[test]
fn a_typical_step_that_cannot_be_halved_is_refused() {
    let diagnostic = Diagnostic {
        budget: Some(300),
        ..Diagnostic::around(5e-324)
    };
    let error = diagnostic.run(&spring(), &circle()).unwrap_err();
    let Error::OutOfRange { what, .. } = error else {
        panic!("{error}");
    };
    assert_eq!(what, "typical step size");
}

/// In a report that was changed by hand. Debug builds check for overflow.
#[test]
fn the_largest_number_of_a_substep_can_be_written() {
    let kick = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].signum();
        q[0] += h * p[0];
    });
    let diagnosis = Diagnostic::halving(-1, -2).run(&kick, &circle()).unwrap();
    let mut evidence = diagnosis.evidence;
    for found in evidence.loops.iter_mut().flat_map(|found| &mut found.steps) {
        if let Some(jump) = &mut found.jump {
            jump.substep = Some(usize::MAX);
        }
    }
    for found in &mut evidence.breaks {
        found.found.substep = Some(usize::MAX);
    }
    let verdict = judge(&evidence).sentences().join(" ");
    assert!(
        verdict.contains("substep 18446744073709551615"),
        "{verdict}"
    );
}
