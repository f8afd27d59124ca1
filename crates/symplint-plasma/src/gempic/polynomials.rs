//! Between coefficients of splines and polynomials on cells.
//!
//! On one cell, a spline is a polynomial of the fraction f of the cell. So a field is evaluated by one Horner
//! scheme, and a particle of charge w adds w, w f, … w f^p to the moments of its cell: what the functions get of
//! them is a fixed combination, taken once for each cell and not for each particle.
//!
//! `N` is p + 1 everywhere, the number of functions of V0 on a cell; entry n of a table belongs to the power n.

use symplint_models::bspline;

/// Splines of one degree on a periodic grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPolynomials<const N: usize> {
    /// Functions on a cell: N, or N − 1 for V1.
    functions: usize,
    /// For each power, its factor in each of the functions of a cell.
    powers: [[f64; N]; N],
}

impl<const N: usize> CellPolynomials<N> {
    /// The functions of V0, of degree N − 1.
    pub(super) fn of_zero() -> Self {
        Self::of_degree(N - 1, 1.0)
    }

    /// The functions of V1, of degree N − 2, over the cell width. The highest power has the factor 0.
    pub(super) fn of_one(width: f64) -> Self {
        Self::of_degree(N - 2, 1.0 / width)
    }

    fn of_degree(degree: usize, scale: f64) -> Self {
        let powers = bspline::powers(degree);
        CellPolynomials {
            functions: degree + 1,
            powers: std::array::from_fn(|n| std::array::from_fn(|j| scale * powers[n][j])),
        }
    }

    /// The function of the first spline on `cell`: those of a cell are in sequence round the circle.
    fn first(&self, cell: usize, cells: usize) -> usize {
        let before = (self.functions - 1) % cells;
        (cell + cells - before) % cells
    }

    /// Writes the polynomials of the spline with the given coefficients, one for each cell.
    pub(super) fn expand(&self, coefficients: &[f64], table: &mut [[f64; N]]) {
        let cells = coefficients.len();
        for (cell, polynomial) in table.iter_mut().enumerate() {
            let mut function = self.first(cell, cells);
            *polynomial = [0.0; N];
            for j in 0..self.functions {
                for (entry, row) in polynomial.iter_mut().zip(&self.powers) {
                    *entry += row[j] * coefficients[function];
                }
                function = next(function, cells);
            }
        }
    }

    /// Writes Σ_a w_a Λ_j(x_a) for every function j, from the moments of the cells.
    pub(super) fn collect(&self, moments: &[[f64; N]], sums: &mut [f64]) {
        let cells = sums.len();
        sums.fill(0.0);
        for (cell, moments) in moments.iter().enumerate() {
            let mut function = self.first(cell, cells);
            for j in 0..self.functions {
                let products = moments.iter().zip(&self.powers);
                sums[function] += products.map(|(moment, row)| moment * row[j]).sum::<f64>();
                function = next(function, cells);
            }
        }
    }
}

/// The next function round the circle.
fn next(function: usize, cells: usize) -> usize {
    if function + 1 == cells {
        0
    } else {
        function + 1
    }
}

/// Adds a particle of charge `weight` to the moments of its cell.
#[inline]
pub(super) fn add_moments<const N: usize>(moments: &mut [f64; N], weight: f64, fraction: f64) {
    let mut power = weight;
    for moment in moments {
        *moment += power;
        power *= fraction;
    }
}

/// The value of a polynomial of V0.
#[inline]
pub(super) fn value<const N: usize>(polynomial: &[f64; N], fraction: f64) -> f64 {
    let powers = polynomial.iter().rev();
    powers.fold(0.0, |sum, entry| sum * fraction + entry)
}

/// The value of a polynomial of V1, whose highest power is missing.
#[inline]
pub(super) fn value_of_one<const N: usize>(polynomial: &[f64; N], fraction: f64) -> f64 {
    let powers = (0..N - 1).rev();
    powers.fold(0.0, |sum, n| sum * fraction + polynomial[n])
}

/// The derivative of a polynomial by the fraction.
#[inline]
pub(super) fn slope<const N: usize>(polynomial: &[f64; N], fraction: f64) -> f64 {
    let powers = (1..N).rev();
    powers.fold(0.0, |sum, n| sum * fraction + n as f64 * polynomial[n])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Function j of `degree` at `x` in units of cells, as a sum over its periodic images.
    fn function(degree: usize, cells: usize, j: usize, x: f64) -> f64 {
        let images = (degree / cells + 2) as i32;
        let spline = |x: f64| {
            let cell = x.floor();
            if !(0.0..=degree as f64).contains(&cell) {
                return 0.0;
            }
            bspline::weights(degree, x - cell)[degree - cell as usize]
        };
        let image = |i: i32| spline(x - j as f64 + f64::from(i) * cells as f64);
        (-images..=images).map(image).sum()
    }

    fn check<const N: usize>() {
        const WIDTH: f64 = 0.3;
        for cells in [1, 2, 3, 5, 8] {
            let coefficients: Vec<f64> = (0..cells).map(|j| (0.7 + (j * j) as f64).sin()).collect();
            let (zero, one) = (
                CellPolynomials::<N>::of_zero(),
                CellPolynomials::<N>::of_one(WIDTH),
            );
            let mut tables = [vec![[0.0; N]; cells], vec![[0.0; N]; cells]];
            zero.expand(&coefficients, &mut tables[0]);
            one.expand(&coefficients, &mut tables[1]);
            let mut moments = vec![[0.0; N]; cells];
            let mut expected = [vec![0.0; cells], vec![0.0; cells]];
            for cell in 0..cells {
                for fraction in [0.0, 0.3, 0.9] {
                    let x = cell as f64 + fraction;
                    let sum = |degree: usize| -> f64 {
                        (0..cells)
                            .map(|j| coefficients[j] * function(degree, cells, j, x))
                            .sum()
                    };
                    let by_zero = value(&tables[0][cell], fraction);
                    let by_one = value_of_one(&tables[1][cell], fraction);
                    assert!((by_zero - sum(N - 1)).abs() < 2e-15, "{N}, {cells}");
                    assert!((by_one - sum(N - 2) / WIDTH).abs() < 1e-14, "{N}, {cells}");
                    // Λ⁰_j' = Λ¹_j − Λ¹_j+1.
                    let differences: f64 = (0..cells)
                        .map(|j| {
                            let [here, above] =
                                [j, (j + 1) % cells].map(|j| function(N - 2, cells, j, x));
                            coefficients[j] * (here - above)
                        })
                        .sum();
                    assert!((slope(&tables[0][cell], fraction) - differences).abs() < 1e-14);
                    let weight = (x * x).cos();
                    add_moments(&mut moments[cell], weight, fraction);
                    let [by_zero, by_one] = &mut expected;
                    for (j, (by_zero, by_one)) in by_zero.iter_mut().zip(by_one).enumerate() {
                        *by_zero += weight * function(N - 1, cells, j, x);
                        *by_one += weight * function(N - 2, cells, j, x) / WIDTH;
                    }
                }
            }
            let mut sums = vec![0.0; cells];
            for (space, expected) in [zero, one].iter().zip(&expected) {
                space.collect(&moments, &mut sums);
                for (got, expected) in sums.iter().zip(expected) {
                    assert!(
                        (got - expected).abs() < 1e-13,
                        "{N}, {cells}: {got} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn splines_are_sums_of_their_functions() {
        check::<2>();
        check::<3>();
        check::<4>();
        check::<5>();
        check::<6>();
    }
}
