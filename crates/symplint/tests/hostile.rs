//! Arguments that no one means to give, found by fuzzing: an error says what is wrong with them.

use symplint::{Circle, Diagnostic, Error, PerSample, TimeAdvance};

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
