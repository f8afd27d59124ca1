//! Many degrees of freedom, many threads.

use std::sync::Arc;

use symplint::{Diagnostic, PerSample, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::PendulumArray;

use crate::verdicts::{circle, diagnose};

#[test]
fn threads_do_not_change_a_bit() {
    let array = PendulumArray::new(37, 1.0, 1.0).unwrap();
    let (q0, p0) = array.uniform_state(1);
    let map = build("rk4", None, Arc::new(array) as Arc<dyn Separable>).unwrap();
    let phase_loop = circle(&q0, &p0, 1.0);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| diagnose(&Diagnostic::halving(-1, -4), &*map, &phase_loop).points())
    };
    let one = run(1);
    for threads in [2, 3, 5] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn breaks_in_very_many_coordinates_are_sorted_out() {
    const DOF: usize = 2000;
    let map = PerSample::new(DOF, |h, q: &mut [f64], p: &mut [f64]| {
        for i in 0..DOF {
            p[i] += h * (q[(i + 1) % DOF] + q[7 * i % DOF]).sin();
            if q[i] > (i as f64).sin() {
                p[i] += 0.1 * h;
            }
        }
        for i in 0..DOF {
            q[i] += h * p[i];
        }
    });
    let phase_loop = circle(&[0.0; DOF], &[0.5; DOF], 1.0);
    let diagnostic = Diagnostic {
        loops: 1,
        jacobian: false,
        ..Diagnostic::halving(-1, -2)
    };
    let verdict = diagnose(&diagnostic, &map, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::BrokenLoops);
}
