//! Cardinal B-splines of degree 0 to 5 on a uniform grid, seen from one cell.
//!
//! The spline of degree p that starts at node m is B_m, positive on the p + 1 cells from
//! node m to node m + p + 1 (Barham & Burby, section 4.3). On the cell between nodes i and i + 1
//! the p + 1 splines B_{i−p}, …, B_i do not vanish, and sum to 1. The functions here give the
//! values of those, in this order, at the fraction x of the cell, 0 ≤ x ≤ 1; entries beyond
//! the first p + 1 are 0. At x = 1 the values are the limits from inside the cell.
//!
//! All knots are nodes, for even degrees as for odd ones.

/// The highest degree provided.
pub const MAX_DEGREE: usize = 5;

/// One value for each of the splines on a cell.
pub type CellWeights = [f64; MAX_DEGREE + 1];

/// Values at `x` of the splines of one cell: entry j belongs to B_{i−p+j}.
///
/// By the Cox–de Boor recursion, whose terms are all positive for 0 ≤ x ≤ 1, so the values have
/// full relative accuracy (C. de Boor, A Practical Guide to Splines, chapter X).
///
/// ```
/// // A cubic spline over a node: 1/6, 4/6, 1/6.
/// let weights = symplint_models::bspline::weights(3, 0.0);
/// assert!((weights[1] - 4.0 / 6.0).abs() < 1e-15);
/// ```
///
/// # Panics
/// If `degree` exceeds [`MAX_DEGREE`].
#[inline]
pub fn weights(degree: usize, x: f64) -> CellWeights {
    match degree {
        0 => weights_of::<0>(x),
        1 => weights_of::<1>(x),
        2 => weights_of::<2>(x),
        3 => weights_of::<3>(x),
        4 => weights_of::<4>(x),
        5 => weights_of::<5>(x),
        _ => panic!("splines go up to degree {MAX_DEGREE}, not {degree}"),
    }
}

/// The recursion with a degree that the compiler can unroll. The factors 1/k of its steps are
/// taken out: one product with 1/p! at the end instead of a division for every term.
#[inline(always)]
fn weights_of<const P: usize>(x: f64) -> CellWeights {
    const INVERSE_FACTORIALS: CellWeights =
        [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0];
    let mut weights = [0.0; MAX_DEGREE + 1];
    weights[0] = INVERSE_FACTORIALS[P];
    // Inclusive ranges are not unrolled.
    for k in 1..P + 1 {
        // Downwards, because entry j takes entries j − 1 and j of the degree below.
        for j in (1..k + 1).rev() {
            let rising = (x + (k - j) as f64) * weights[j - 1];
            let falling = ((j + 1) as f64 - x) * weights[j];
            weights[j] = rising + falling;
        }
        weights[0] *= 1.0 - x;
    }
    weights
}

/// Derivatives of the given `order` at `x` of the splines of one cell, with respect to x: divide
/// by the cell's width once for each order.
///
/// A derivative of B_m is the difference B_m − B_{m+1} of splines one degree lower. Zero where
/// `order` exceeds `degree`.
///
/// # Panics
/// If `degree` exceeds [`MAX_DEGREE`].
#[inline]
pub fn derivative_weights(degree: usize, order: usize, x: f64) -> CellWeights {
    assert!(
        degree <= MAX_DEGREE,
        "splines go up to degree {MAX_DEGREE}, not {degree}"
    );
    if order > degree {
        return [0.0; MAX_DEGREE + 1];
    }
    let lowest = degree - order;
    let mut weights = weights(lowest, x);
    for k in lowest + 1..=degree {
        for j in (1..=k).rev() {
            weights[j] = weights[j - 1] - weights[j];
        }
        weights[0] = -weights[0];
    }
    weights
}

/// The same functions as polynomials: for each power of the fraction of the cell, its factor in each of them.
///
/// # Panics
/// If `degree` exceeds [`MAX_DEGREE`].
pub fn powers(degree: usize) -> [CellWeights; MAX_DEGREE + 1] {
    let mut factorial = 1.0;
    std::array::from_fn(|n| {
        factorial *= n.max(1) as f64;
        derivative_weights(degree, n, 0.0).map(|weight| weight / factorial)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The centred cardinal B-spline by its formula in truncated powers,
    /// β(x) = Σ_k (−1)^k C(p+1, k) (x + (p+1)/2 − k)₊^p / p!.
    fn by_truncated_powers(degree: usize, x: f64) -> f64 {
        let n = degree as i32;
        let (mut sum, mut binomial) = (0.0, 1.0);
        for k in 0..=n + 1 {
            let base = x + f64::from(n + 1) / 2.0 - f64::from(k);
            if base >= 0.0 {
                sum += binomial * base.powi(n);
            }
            binomial *= -f64::from(n + 1 - k) / f64::from(k + 1);
        }
        sum / (1..=n).map(f64::from).product::<f64>()
    }

    #[test]
    fn weights_follow_the_truncated_power_formula() {
        for degree in 0..=MAX_DEGREE {
            for step in 0..32 {
                let x = f64::from(step) / 32.0;
                let weights = weights(degree, x);
                for (j, &weight) in weights.iter().enumerate() {
                    // B_m starts at m = j − p, so its centre is at m + (p + 1)/2.
                    let centre = j as f64 - degree as f64 + (degree + 1) as f64 / 2.0;
                    let expected = if j <= degree {
                        by_truncated_powers(degree, x - centre)
                    } else {
                        0.0
                    };
                    assert!(
                        (weight - expected).abs() < 1e-14,
                        "degree {degree}, x = {x}, spline {j}: {weight} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn weights_over_a_node_are_the_tabulated_fractions() {
        let table: [&[f64]; 6] = [
            &[1.0],
            &[1.0, 0.0],
            &[1.0 / 2.0, 1.0 / 2.0, 0.0],
            &[1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0],
            &[1.0 / 24.0, 11.0 / 24.0, 11.0 / 24.0, 1.0 / 24.0, 0.0],
            &[
                1.0 / 120.0,
                26.0 / 120.0,
                66.0 / 120.0,
                26.0 / 120.0,
                1.0 / 120.0,
                0.0,
            ],
        ];
        for (degree, expected) in table.iter().enumerate() {
            let weights = weights(degree, 0.0);
            for (weight, expected) in weights.iter().zip(*expected) {
                assert!(
                    (weight - expected).abs() < 2e-16,
                    "degree {degree}: {weights:?}"
                );
            }
        }
    }

    #[test]
    fn weights_sum_to_one_and_their_derivatives_to_zero() {
        for degree in 0..=MAX_DEGREE {
            for step in 0..=100 {
                let x = f64::from(step) / 100.0;
                assert!((weights(degree, x).iter().sum::<f64>() - 1.0).abs() < 4e-16);
                for order in 1..=MAX_DEGREE + 1 {
                    let sum: f64 = derivative_weights(degree, order, x).iter().sum();
                    assert!(sum.abs() < 1e-14, "degree {degree}, order {order}: {sum}");
                }
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        const STEP: f64 = 1e-3;
        for degree in 1..=MAX_DEGREE {
            for order in 1..=degree {
                for point in 1..10 {
                    let x = f64::from(point) / 10.0;
                    let at = |shift: f64| derivative_weights(degree, order - 1, x + shift * STEP);
                    let exact = derivative_weights(degree, order, x);
                    for (j, exact) in exact.iter().enumerate() {
                        let difference = (at(-2.0)[j] - 8.0 * at(-1.0)[j] + 8.0 * at(1.0)[j]
                            - at(2.0)[j])
                            / (12.0 * STEP);
                        assert!(
                            (difference - exact).abs() < 2e-11,
                            "degree {degree}, order {order}: {difference} for {exact}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn splines_and_their_derivatives_continue_into_the_next_cell() {
        for degree in 1..=MAX_DEGREE {
            for order in 0..degree {
                let end = derivative_weights(degree, order, 1.0);
                let start = derivative_weights(degree, order, 0.0);
                // The first spline of a cell ends with it; every other is the one before it in
                // the next cell.
                assert!(end[0].abs() < 1e-15);
                assert!(start[degree].abs() < 1e-15);
                for j in 1..=degree {
                    assert!((end[j] - start[j - 1]).abs() < 1e-14);
                }
            }
        }
    }
}
