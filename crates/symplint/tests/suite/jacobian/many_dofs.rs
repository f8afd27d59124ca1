//! Random tangent vectors in many degrees of freedom.

use symplint::PerSample;

use crate::jacobian::{assert_symplectic, circle, pendula, run, worst_of};

#[test]
fn the_degrees_of_freedom_that_carry_the_defect_are_named() {
    for (dof, i, j) in [(8, 5, 2), (100, 37, 71)] {
        let phase_loop = circle(dof).with_phases(symplint::Phases::Random { seed: 3 });
        assert_symplectic(&run(&pendula(dof, |_, _, _| {}), &phase_loop, 0.3), 11.0);

        // One momentum is damped by 1 − h/100: ω of its plane shrinks by that, and no pair of unit
        // norms has more. A random pair that is not conjugate has less.
        let damped = pendula(dof, move |h, _, p| p[i] *= 1.0 - 0.01 * h);
        let worst = worst_of(&run(&damped, &phase_loop, 0.3));
        assert_eq!(worst.dofs, Some((i, i)));
        if dof == 8 {
            assert!((worst.signed + 0.003).abs() <= worst.uncertainty);
        }
        assert!(worst.magnitude() <= 0.003 + worst.uncertainty);
        assert!(worst.magnitude() > 0.001 && worst.uncertainty < 1e-11);

        // A force of j on i without its reaction.
        let one_sided = PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
            p[i] += 0.5 * h * q[j];
            for i in 0..q.len() {
                p[i] -= h * q[i].sin();
            }
        });
        let report = run(&one_sided, &phase_loop, 0.3);
        let worst = worst_of(&report);
        let dofs = worst.dofs.unwrap();
        assert!(dofs == (i, j) || dofs == (j, i), "{dofs:?}");
        // (ω(DΦ ∂_qj, DΦ ∂_qi) − 0) / (1 · 1) = −h/2, and no pair of unit norms has more.
        assert!(worst.magnitude() <= 0.15 + worst.uncertainty);
        assert_eq!(report.full, dof == 8);
        if report.full {
            assert!((worst.magnitude() - 0.15).abs() <= worst.uncertainty);
        }
        assert!(worst.uncertainty < 1e-11);
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let map = pendula(60, |h, _, p| p[11] *= 1.0 - h);
    let phase_loop = circle(60).with_phases(symplint::Phases::Random { seed: 5 });
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| run(&map, &phase_loop, 0.3))
    };
    assert_eq!(on(1), on(3));
}
