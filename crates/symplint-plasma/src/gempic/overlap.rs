//! Integrals of products of B-splines: the entries of mass matrices.

/// The cardinal B-spline of `degree` at the integers 0, …, degree + 1, by the Cox–de Boor recursion. All terms
/// are positive, so the values have full relative accuracy.
fn at_integers(degree: usize) -> Vec<f64> {
    let mut values = vec![0.0; degree + 2];
    // The spline of degree 0 belongs to the cell above a knot.
    values[0] = 1.0;
    for n in 1..=degree {
        for k in (0..=n + 1).rev() {
            let below = if k > 0 { values[k - 1] } else { 0.0 };
            values[k] = (k as f64 * values[k] + (n + 1 - k) as f64 * below) / n as f64;
        }
    }
    values
}

/// ∫ N(t) M(t − k) dt of the cardinal B-splines N of degree `p` and M of degree `q`, which start at 0, for
/// k = −q, …, p. Together they are the spline of degree p + q + 1 at the integers 1, …, p + q + 1.
///
/// M is symmetric about (q + 1)/2, so the integral is a convolution of p + q + 2 characteristic functions of
/// [0, 1] at the point q + 1 + k (C. de Boor, A Practical Guide to Splines, chapter X).
pub(super) fn overlaps(p: usize, q: usize) -> Vec<f64> {
    let degree = p + q + 1;
    at_integers(degree)[1..=degree].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use symplint_models::bspline;

    /// The cardinal B-spline anywhere, by the splines of one cell.
    fn spline(degree: usize, x: f64) -> f64 {
        let cell = x.floor();
        if !(0.0..=degree as f64).contains(&cell) {
            return 0.0;
        }
        bspline::weights(degree, x - cell)[degree - cell as usize]
    }

    /// Gauss–Legendre nodes and weights on [0, 1], exact for degree 11.
    const GAUSS: [(f64, f64); 3] = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ];

    #[test]
    fn overlaps_are_the_integrals() {
        for p in 0..=5 {
            for q in 0..=5 {
                for (i, &overlap) in overlaps(p, q).iter().enumerate() {
                    let shift = i as f64 - q as f64;
                    let mut integral = 0.0;
                    for cell in 0..=p {
                        for (node, weight) in GAUSS {
                            for node in [-node, node] {
                                let x = cell as f64 + 0.5 + 0.5 * node;
                                integral += 0.5 * weight * spline(p, x) * spline(q, x - shift);
                            }
                        }
                    }
                    assert!(
                        (overlap - integral).abs() < 1e-15,
                        "degrees {p} and {q}, shift {shift}: {overlap} for {integral}"
                    );
                }
            }
        }
    }
}
