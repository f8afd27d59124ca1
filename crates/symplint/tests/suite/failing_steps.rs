//! Steps that fail at some states or step sizes, or that do not return what they advanced.

use symplint::map::PerSample;
use symplint::verdict::{Advice, VerdictKind};
use symplint::{Circle, Diagnosis, Diagnostic, Error, TimeAdvance};

fn step(advance: impl Fn(f64, &mut f64, &mut f64) + Send + Sync) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        advance(h, &mut q[0], &mut p[0]);
    })
}

fn pendulum(h: f64, q: &mut f64, p: &mut f64) {
    *p -= h * q.sin();
    *q += h * *p;
}

fn run(map: &dyn TimeAdvance, radius: f64) -> Result<Diagnosis, Error> {
    let diagnostic = Diagnostic {
        step_sizes: vec![0.5, 0.25, 0.125],
        ..Diagnostic::default()
    };
    diagnostic.run(map, &Circle::new(vec![0.3], vec![0.5], radius)?)
}

#[test]
fn the_summary_counts_the_step_sizes_at_which_the_map_failed() {
    let fails_above = |limit: f64| {
        step(move |h, q, p| match h > limit {
            true => *q = f64::NAN,
            false => pendulum(h, q, p),
        })
    };
    for (limit, told) in [
        (0.3, "(the map failed at another one)"),
        (0.2, "(the map failed at 2 others)"),
    ] {
        let verdict = run(&fails_above(limit), 1.0).unwrap().verdict;
        assert_eq!(verdict.kind, VerdictKind::Symplectic);
        assert!(verdict.summary().contains(told), "{}", verdict.summary());
    }
    assert!(
        !run(&fails_above(1.0), 1.0)
            .unwrap()
            .verdict
            .summary()
            .contains("failed")
    );
}

#[test]
fn a_step_that_fails_at_the_largest_and_the_smallest_size_is_not_tried_at_others() {
    let tried = std::sync::Mutex::new(Vec::new());
    let fails = step(|h, q, _| {
        tried.lock().unwrap().push(h);
        *q = f64::NAN;
    });
    let error = run(&fails, 1.0).unwrap_err();
    assert!(error.to_string().contains("h = 0.5"), "{error}");
    let tried = tried.lock().unwrap();
    assert!(!tried.contains(&0.25), "{tried:?}");
    // One state at the smallest size.
    assert_eq!(tried.iter().filter(|h| **h == 0.125).count(), 1);
}

#[test]
fn the_error_of_a_step_is_not_hidden_by_a_small_budget() {
    for (budget, limit) in [200, 300, 500, 700, 1000, 20_000]
        .into_iter()
        .flat_map(|budget| [(budget, 0.0), (budget, 0.01)])
    {
        let map = PerSample::new(2, move |h, _: &mut [f64], _: &mut [f64]| match h > limit {
            true => Err("cannot open restart.dat"),
            false => Ok(()),
        });
        let diagnostic = Diagnostic {
            budget: Some(budget),
            ..Diagnostic::default()
        };
        let circle = Circle::new(vec![1.0, 2.0], vec![0.5, 0.1], 1.0).unwrap();
        let told = match diagnostic.run(&map, &circle) {
            Ok(found) => format!("{:?}", found.verdict.findings),
            Err(error) => error.to_string(),
        };
        assert!(told.contains("cannot open restart.dat"), "{budget}: {told}");
        assert!(told.contains("h = 0.5"), "{budget}: {told}");
    }
}

#[test]
fn a_step_that_fails_between_the_samples_of_the_loop_fails() {
    // A state off the samples of the given loop, where it is looked whether the map has a memory.
    let s = 0.31 / 16.0 * std::f64::consts::TAU;
    let fails = step(move |h, q, p| {
        let at = [0.3 + s.cos(), 0.5 + s.sin()];
        let is_there = |sign: f64| f64::hypot(*q - at[0], *p - (0.5 + sign * s.sin())) < 5e-4;
        match h > 0.3 && (is_there(1.0) || is_there(-1.0)) {
            true => *q = f64::NAN,
            false => pendulum(h, q, p),
        }
    });
    let verdict = run(&fails, 1.0).unwrap().verdict;
    let told = verdict.summary();
    assert!(told.contains("(the map failed at another one)"), "{told}");
}

#[test]
fn a_step_that_returns_what_it_got_is_told_so() {
    let verdict = run(&step(|_, _, _| {}), 1.0).unwrap().verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided);
    assert_eq!(verdict.advice[0], Advice::ReturnStates);
}

#[test]
fn a_step_to_one_state_is_not_symplectic_unless_that_may_be_rounding() {
    let to = |state: [f64; 2]| step(move |_, q, p| [*q, *p] = state);
    let collapsed = run(&to([1.5, 0.25]), 1.0).unwrap().verdict;
    assert_eq!(
        collapsed.kind,
        VerdictKind::NotSymplectic,
        "{}",
        collapsed.summary()
    );
    // Three decimals on a small loop.
    for (state, radius) in [([0.0, 0.0], 1.0), ([0.3, 0.5], 1e-4)] {
        let verdict = run(&to(state), radius).unwrap().verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::Undecided,
            "{}",
            verdict.summary()
        );
        assert!(
            verdict.summary().contains("one state for all samples"),
            "{}",
            verdict.summary()
        );
    }
}
