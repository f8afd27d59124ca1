//! Transfer matrices that were written with few digits.

use symplint::verdict::CauseKind;
use symplint::{Circle, Diagnostic, PerSample, Verdict, VerdictKind};

use super::cause;

/// One turn of a ring by a matrix for (q0, q1, p0, p1).
fn turn(matrix: [[f64; 4]; 4]) -> Verdict {
    let map = PerSample::new(2, move |_, q, p| {
        let z = [q[0], q[1], p[0], p[1]];
        let row = |i: usize| matrix[i].iter().zip(z).map(|(m, z)| m * z).sum();
        (q[0], q[1], p[0], p[1]) = (row(0), row(1), row(2), row(3));
    });
    let circle = Circle::new(vec![0.1, 0.1], vec![0.02, -0.01], 0.1).unwrap();
    let diagnostic = Diagnostic {
        has_step_size: false,
        ..Diagnostic::default()
    };
    diagnostic.run(&map, &circle).unwrap().verdict
}

/// A cell of focusing and defocusing lenses, rotated by 0.3 in the plane of q.
fn cell() -> [[f64; 4]; 4] {
    let (sin, cos) = 0.3f64.sin_cos();
    let rotation = |sin: f64| {
        [
            [cos, sin, 0.0, 0.0],
            [-sin, cos, 0.0, 0.0],
            [0.0, 0.0, cos, sin],
            [0.0, 0.0, -sin, cos],
        ]
    };
    let element = |length: f64, strength: f64| {
        [
            [1.0, 0.0, length, 0.0],
            [0.0, 1.0, 0.0, length],
            [-strength, 0.0, 1.0, 0.0],
            [0.0, strength, 0.0, 1.0],
        ]
    };
    let product = |a: [[f64; 4]; 4], b: [[f64; 4]; 4]| {
        let entry = |i: usize, j: usize| (0..4).map(|k| a[i][k] * b[k][j]).sum::<f64>();
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    };
    let parts = [
        rotation(-sin),
        element(0.0, 0.29),
        element(0.9, 0.0),
        element(0.0, -0.58),
        element(0.9, 0.0),
        element(0.0, 0.29),
        rotation(sin),
    ];
    parts.into_iter().reduce(product).unwrap()
}

#[test]
fn a_transfer_matrix_that_was_rounded_is_named_and_all_its_digits_make_it_symplectic() {
    assert_eq!(turn(cell()).kind, VerdictKind::Symplectic);
    for digits in [4, 6, 9] {
        let decimals = |x: f64| format!("{x:.digits$}").parse::<f64>().unwrap();
        let significant = |x: f64| format!("{x:.*e}", digits - 1).parse::<f64>().unwrap();
        for (round, words) in [
            (&decimals as &dyn Fn(f64) -> f64, "digits after the point"),
            (&significant, "significant digits"),
        ] {
            let found = turn(cell().map(|row| row.map(round)));
            let words = format!("its matrix has at most {digits} {words}");
            cause(&found, CauseKind::RoundedMatrix, &[&words]);
        }
    }
}

#[test]
fn entries_of_different_sizes_share_significant_digits() {
    // Three digits after the point hold all entries, but cannot explain the determinant.
    let found = turn([
        [12.3, 0.0, 4.57, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.234, 0.0, 0.169, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let words = "its matrix has at most 3 significant digits";
    cause(&found, CauseKind::RoundedMatrix, &[words]);
}

#[test]
fn a_matrix_that_preserves_another_form_is_not_called_rounded() {
    // Weights 1 and 2.
    let found = turn([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [-100.0, -0.1, 1.0, 0.0],
        [-0.05, 0.0, 0.0, 1.0],
    ]);
    cause(&found, CauseKind::VelocitiesForMomenta, &["2 dq1"]);
}

#[test]
fn a_damped_matrix_is_not_called_rounded() {
    let damped = |matrix: [[f64; 4]; 4], factor: f64| {
        let [q0, q1, p0, p1] = matrix;
        [q0, q1, p0.map(|m| factor * m), p1.map(|m| factor * m)]
    };
    // All digits of a double, and numbers of few digits that a person chose.
    let chosen = [
        [0.7, 0.0, 0.3, 0.0],
        [0.0, 1.0, 0.0, 0.25],
        [-1.7, 0.0, 0.7, 0.0],
        [0.0, -0.4, 0.0, 0.9],
    ];
    // Zeros are exact, whatever they are multiplied by.
    let drift = [
        [1.0, 0.0, 1000.0, 0.0],
        [0.0, 1.0, 0.0, 1000.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    for matrix in [
        damped(cell(), 1.0 - 1e-6),
        damped(chosen, 0.9),
        damped(drift, 0.6),
    ] {
        cause(
            &turn(matrix),
            CauseKind::Friction,
            &["multiplies all areas"],
        );
    }
}
