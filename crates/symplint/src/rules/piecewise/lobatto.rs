//! Chebyshev–Lobatto interpolation on [−1, 1], and what a break does to its coefficients.

use std::sync::LazyLock;

use multiversion::multiversion;

use super::limits::{CHECKS, DEGREES, FIRST_SMALL, FULL_LEVEL, MAX_TERMS};

/// The highest degree of the interpolants.
pub(super) const DEGREE: usize = DEGREES[FULL_LEVEL];

/// Their nodes, both ends among them.
pub(super) const NODES: usize = DEGREE + 1;

/// States of a piece that are examined: nodes, then checks.
pub(super) const POINTS: usize = NODES + CHECKS.len();

/// Number of the coefficients that are small on a smooth piece.
const TAIL: usize = NODES - FIRST_SMALL;

/// Values at the nodes, or coefficients of the Chebyshev polynomials T_0 … T_12.
pub(super) type Values = [f64; NODES];

/// The columns of a matrix that makes values of values, filled up with zeros to whole vector registers.
type Columns = [[f64; LANES]; NODES];

/// Numbers in these registers.
const LANES: usize = 16;

/// Everything that depends on the degree alone.
pub(super) struct Lobatto {
    /// −cos(πj/12), rising.
    pub nodes: Values,
    /// For each level, coefficients from values: 0 for points that are not nodes of the level, and for coefficients beyond its degree.
    transforms: [Columns; DEGREES.len()],
    /// For each level, the interpolant at all points from its values at the nodes of the level.
    at_points: [Columns; DEGREES.len()],
    /// For each level, the slopes of the interpolant at −1 and at 1 from values at the nodes.
    slopes: [[Values; 2]; DEGREES.len()],
    /// ∫ P Q' = Σ p_j area_jk q_k for the interpolants of p and q.
    area: Columns,
    /// A break between nodes i and i + 1.
    pub gaps: [Gap; DEGREE],
    /// The bases of the tails of all gaps, [`MAX_TERMS`] numbers for each gap: one column for each coefficient of a tail.
    tails: [GapColumn; TAIL],
}

/// Numbers for each term of each gap, filled up with zeros to whole vector registers.
type GapColumn = [f64; NUMBERS_OF_GAPS];

const NUMBERS_OF_GAPS: usize = (DEGREE * MAX_TERMS).next_multiple_of(LANES);

/// The one table of these.
pub(super) static LOBATTO: LazyLock<Lobatto> = LazyLock::new(Lobatto::new);

impl Lobatto {
    fn new() -> Self {
        let angle = |j: usize| std::f64::consts::PI * j as f64 / DEGREE as f64;
        let mut nodes = Values::default();
        for j in 0..=DEGREE / 2 {
            nodes[j] = -angle(j).cos();
            nodes[DEGREE - j] = -nodes[j];
        }
        nodes[DEGREE / 2] = 0.0;
        // T_k(x_j) = (−1)^k cos(kπj/n); the sums over the nodes halve the ends.
        let polynomial = |k: usize, j: usize| {
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * angle((k * j) % (2 * DEGREE)).cos()
        };
        let transforms = DEGREES.map(|degree| {
            let stride = DEGREE / degree;
            let half_at_ends = |j: usize| if j == 0 || j == degree { 0.5 } else { 1.0 };
            std::array::from_fn(|k| {
                std::array::from_fn(|j| {
                    if k > degree || !j.is_multiple_of(stride) {
                        return 0.0;
                    }
                    let halves = half_at_ends(k) * half_at_ends(j / stride);
                    2.0 / degree as f64 * halves * polynomial(k, j)
                })
            })
        });
        let transform: &[Values; NODES] = &transforms[FULL_LEVEL];
        // ∫ T_j T_k': T_k' is 2k times the sum of T_{k−1}, T_{k−3}, …, with T_0 halved.
        let product = |j: usize, k: usize| {
            let lower = (0..k).rev().step_by(2).map(|m| {
                let weight = if m == 0 { 0.5 } else { 1.0 };
                weight * 0.5 * (integral_of(j + m) + integral_of(j.abs_diff(m)))
            });
            2.0 * k as f64 * lower.sum::<f64>()
        };
        let products: [Values; NODES] =
            std::array::from_fn(|j| std::array::from_fn(|k| product(j, k)));
        let area: [Values; NODES] = std::array::from_fn(|j| {
            std::array::from_fn(|k| {
                let mut sum = 0.0;
                for a in 0..NODES {
                    for b in 0..NODES {
                        sum += transform[a][j] * products[a][b] * transform[b][k];
                    }
                }
                sum
            })
        });
        let gaps = std::array::from_fn(|i| Gap::new(i, &nodes, transform));
        let tails = std::array::from_fn(|k| {
            let mut column = [0.0; NUMBERS_OF_GAPS];
            for (numbers, gap) in column.chunks_mut(MAX_TERMS).zip(&gaps as &[Gap; DEGREE]) {
                let entries = gap.basis.iter().map(|unit| unit[k]);
                (numbers.iter_mut().zip(entries)).for_each(|(number, entry)| *number = entry);
            }
            column
        });
        let slopes = transforms.each_ref().map(|rows: &[Values; NODES]| {
            let of_node = |j: usize| derivative(&rows.map(|row| row[j]));
            let slopes: [Values; NODES] = std::array::from_fn(of_node);
            [-1.0, 1.0].map(|end| slopes.map(|slopes| evaluate(&slopes, end)))
        });
        let at_points = transforms.each_ref().map(|rows: &[Values; NODES]| {
            std::array::from_fn(|j| {
                let of_node = rows.map(|row| row[j]);
                let mut column = [0.0; LANES];
                for (value, x) in column.iter_mut().zip(nodes.iter().chain(&CHECKS)) {
                    *value = evaluate(&of_node, *x);
                }
                column
            })
        });
        Lobatto {
            nodes,
            slopes,
            at_points,
            transforms: transforms.map(|rows| columns(&rows)),
            area: columns(&area),
            gaps,
            tails,
        }
    }

    /// Chebyshev coefficients of the interpolant of the nodes of a level.
    #[inline(always)] // Into what is compiled for several processors.
    pub fn coefficients(&self, values: &Values, level: usize) -> Values {
        *first_of(&times(&self.transforms[level], values))
    }

    /// The interpolant of the nodes of a level at all points.
    #[inline(always)]
    pub fn interpolate(&self, values: &Values, level: usize) -> [f64; POINTS] {
        *first_of(&times(&self.at_points[level], values))
    }

    /// Whether the interpolant of the nodes of a level rises at one end and falls at the other.
    pub fn turns(&self, values: &Values, level: usize) -> bool {
        let [low, high] = self.slopes[level].each_ref();
        (dot(low, values) > 0.0) != (dot(high, values) > 0.0)
    }

    /// ∫ P dQ over the piece, whatever its length.
    #[inline(always)]
    pub fn area(&self, p: &Values, q: &Values) -> f64 {
        dot(p, first_of(&times(&self.area, q)))
    }
}

/// The parts of the tails of some coefficients that a break in each gap explains, squared, weighted and added up.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn explained<'a>(
    weighted: &mut dyn Iterator<Item = (f64, &'a Values)>,
) -> [f64; DEGREE] {
    let mut sums = [0.0; NUMBERS_OF_GAPS];
    for (weight, coefficients) in weighted {
        let mut along = [0.0; NUMBERS_OF_GAPS];
        for (column, a) in LOBATTO.tails.iter().zip(&coefficients[FIRST_SMALL..]) {
            for k in 0..NUMBERS_OF_GAPS {
                along[k] += column[k] * a;
            }
        }
        for k in 0..NUMBERS_OF_GAPS {
            sums[k] += weight * along[k] * along[k];
        }
    }
    std::array::from_fn(|i| sums[i * MAX_TERMS..][..MAX_TERMS].iter().sum())
}

/// The columns of a matrix from its rows.
fn columns(rows: &[Values; NODES]) -> Columns {
    let entry = |row: usize, column: usize| rows.get(row).map_or(0.0, |row| row[column]);
    std::array::from_fn(|column| std::array::from_fn(|row| entry(row, column)))
}

/// A matrix times values, each entry summed in the order of the columns.
#[inline(always)]
fn times(columns: &Columns, values: &Values) -> [f64; LANES] {
    let mut sums = [0.0; LANES];
    for (column, value) in columns.iter().zip(values) {
        for lane in 0..LANES {
            sums[lane] += column[lane] * value;
        }
    }
    sums
}

/// The first numbers of whole registers.
#[inline(always)]
fn first_of<const N: usize>(lanes: &[f64; LANES]) -> &[f64; N] {
    lanes
        .first_chunk()
        .expect("there are more lanes than points")
}

/// The largest absolute value.
#[inline(always)]
pub(super) fn largest(values: &Values) -> f64 {
    let (groups, rest) = values.as_chunks::<4>();
    let mut lanes = [0.0f64; 4];
    for group in groups {
        for lane in 0..4 {
            lanes[lane] = lanes[lane].max(group[lane].abs());
        }
    }
    let rest = rest.iter().map(|value| value.abs());
    rest.chain(lanes).fold(0.0, f64::max)
}

/// ∫ T_r over [−1, 1].
fn integral_of(r: usize) -> f64 {
    if r.is_multiple_of(2) {
        2.0 / (1.0 - (r * r) as f64)
    } else {
        0.0
    }
}

#[inline(always)]
fn dot(a: &Values, b: &Values) -> f64 {
    // In lanes, so that no sum waits for the one before.
    let mut lanes = [0.0; 4];
    for k in 0..NODES {
        lanes[k % 4] += a[k] * b[k];
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
}

/// Σ a_k T_k(x).
pub(super) fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    let [value] = evaluate_each(coefficients, &[x]);
    value
}

/// Σ a_k T_k at each of some parameters.
#[inline(always)] // Into what is compiled for several processors.
pub(super) fn evaluate_each<const N: usize>(coefficients: &[f64], x: &[f64; N]) -> [f64; N] {
    let (mut current, mut next) = ([0.0; N], [0.0; N]);
    for &a in coefficients.iter().skip(1).rev() {
        for k in 0..N {
            let above = a + 2.0 * x[k] * current[k] - next[k];
            (current[k], next[k]) = (above, current[k]);
        }
    }
    for k in 0..N {
        current[k] = coefficients[0] + x[k] * current[k] - next[k];
    }
    current
}

/// Coefficients of the derivative by x, the last of them 0.
pub(super) fn derivative(coefficients: &Values) -> Values {
    let mut slopes = Values::default();
    for k in (0..DEGREE).rev() {
        let above = slopes.get(k + 2).copied().unwrap_or(0.0);
        slopes[k] = above + 2.0 * (k + 1) as f64 * coefficients[k + 1];
    }
    slopes[0] *= 0.5;
    slopes
}

/// Coefficients of a function that jumps by a polynomial D(x) = D_0 + D_1 x + … between two
/// neighbouring nodes: it takes D from the right one on, and 0 before.
pub(super) struct Gap {
    /// Coefficients of (nothing, then x^l) for each term l.
    columns: Vec<Values>,
    /// An orthonormal basis of the tails of those.
    basis: Vec<[f64; TAIL]>,
    /// The tails in that basis: upper triangle, by columns.
    triangle: [[f64; MAX_TERMS]; MAX_TERMS],
}

impl Gap {
    fn new(left: usize, nodes: &Values, transform: &[Values; NODES]) -> Self {
        // No more terms than one of the sides has nodes to tell them apart.
        let terms = MAX_TERMS.min(left + 1).min(DEGREE - left);
        let mut gap = Gap {
            columns: Vec::new(),
            basis: Vec::new(),
            triangle: Default::default(),
        };
        for l in 0..terms {
            let stepped: Values = std::array::from_fn(|j| {
                if j > left {
                    nodes[j].powi(l as i32)
                } else {
                    0.0
                }
            });
            let column: Values = std::array::from_fn(|k| dot(&transform[k], &stepped));
            let mut rest: [f64; TAIL] = std::array::from_fn(|k| column[FIRST_SMALL + k]);
            // Twice is enough for an orthogonal basis.
            for _ in 0..2 {
                for (row, unit) in gap.basis.iter().enumerate() {
                    let along: f64 = unit.iter().zip(&rest).map(|(a, b)| a * b).sum();
                    gap.triangle[l][row] += along;
                    for (rest, unit) in rest.iter_mut().zip(unit) {
                        *rest -= along * unit;
                    }
                }
            }
            let norm = rest.iter().map(|r| r * r).sum::<f64>().sqrt();
            gap.triangle[l][l] = norm;
            gap.basis.push(rest.map(|r| r / norm));
            gap.columns.push(column);
        }
        gap
    }

    /// Number of coefficients of D that the nodes on the shorter side can tell apart.
    pub fn terms(&self) -> usize {
        self.basis.len()
    }

    fn along(&self, coefficients: &Values) -> [f64; MAX_TERMS] {
        let tail = &coefficients[FIRST_SMALL..];
        let mut along = [0.0; MAX_TERMS];
        for (along, unit) in along.iter_mut().zip(&self.basis) {
            *along = unit.iter().zip(tail).map(|(a, b)| a * b).sum();
        }
        along
    }

    /// The best D: its coefficients.
    pub fn jump(&self, coefficients: &Values) -> [f64; MAX_TERMS] {
        let mut jump = self.along(coefficients);
        for l in (0..self.basis.len()).rev() {
            jump[l] /= self.triangle[l][l];
            for row in 0..l {
                jump[row] -= self.triangle[l][row] * jump[l];
            }
        }
        jump
    }

    /// The smooth part of the left side, when the right side has `jump` more.
    pub fn left(&self, coefficients: &Values, jump: &[f64; MAX_TERMS]) -> [f64; FIRST_SMALL] {
        std::array::from_fn(|k| {
            let stepped = self.columns.iter().zip(jump);
            coefficients[k] - stepped.map(|(column, d)| column[k] * d).sum::<f64>()
        })
    }
}

/// Sum of the squares of the tail.
#[inline(always)]
pub(super) fn tail_squared(coefficients: &Values) -> f64 {
    coefficients[FIRST_SMALL..].iter().map(|a| a * a).sum()
}

/// D(x).
pub(super) fn polynomial(terms: &[f64; MAX_TERMS], x: f64) -> f64 {
    terms.iter().rev().fold(0.0, |sum, d| sum * x + d)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(f: impl Fn(f64) -> f64) -> Values {
        LOBATTO.nodes.map(f)
    }

    #[test]
    fn interpolants_meet_what_they_interpolate() {
        let f = |x: f64| (2.0 * x).sin() + x;
        for (level, accuracy) in [0.2, 2e-3, 2e-9].into_iter().enumerate() {
            let mut at_nodes = values(f);
            for (j, value) in at_nodes.iter_mut().enumerate() {
                if j % (DEGREE / DEGREES[level]) != 0 {
                    *value = f64::NAN;
                }
            }
            // Points that are not nodes of the level do not count.
            let known = at_nodes.map(|v| if v.is_nan() { 1e9 } else { v });
            let a = LOBATTO.coefficients(&known, level);
            for step in -10..=10 {
                let x = f64::from(step) / 10.0;
                assert!((evaluate(&a, x) - f(x)).abs() < accuracy, "{level} at {x}");
            }
            for (x, value) in LOBATTO.nodes.iter().zip(at_nodes) {
                assert!(value.is_nan() || (evaluate(&a, *x) - value).abs() < 1e-14);
            }
        }
        let slopes = derivative(&LOBATTO.coefficients(&values(f), FULL_LEVEL));
        for step in -10..=10 {
            let x = f64::from(step) / 10.0;
            assert!((evaluate(&slopes, x) - 2.0 * (2.0 * x).cos() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn interpolants_turn_between_slopes_of_different_signs() {
        for level in 0..DEGREES.len() {
            for step in -9..=9 {
                let turning = f64::from(step) / 6.0 + 0.01;
                let parabola = values(|x| 3.0 - (x - turning).powi(2));
                assert_eq!(
                    LOBATTO.turns(&parabola, level),
                    turning.abs() < 1.0,
                    "{turning}"
                );
            }
        }
    }

    #[test]
    fn areas_are_exact_for_polynomials() {
        // ∫ x^a d(x^b) = b ∫ x^{a+b−1}.
        for a in 0..=12 {
            for b in 1..=12 {
                let power = a + b - 1;
                let expected = if power % 2 == 0 {
                    2.0 * f64::from(b) / f64::from(power + 1)
                } else {
                    0.0
                };
                let got = LOBATTO.area(&values(|x| x.powi(a)), &values(|x| x.powi(b)));
                assert!((got - expected).abs() < 1e-13, "{a} {b}: {got} {expected}");
            }
        }
    }

    #[test]
    fn a_break_is_found_in_its_gap_with_its_size() {
        for gap in 2..10 {
            let (left, right) = (LOBATTO.nodes[gap], LOBATTO.nodes[gap + 1]);
            let at = 0.3 * left + 0.7 * right;
            let jump = |x: f64| 0.2 + 0.1 * (x - at);
            let f = |x: f64| x.cos() + if x > at { jump(x) } else { 0.0 };
            let a = LOBATTO.coefficients(&values(f), FULL_LEVEL);
            let explained = explained(&mut std::iter::once((1.0, &a)));
            let best = (0..DEGREE).max_by(|&i, &j| explained[i].total_cmp(&explained[j]));
            let best = best.unwrap();
            assert_eq!(best, gap);
            let found = LOBATTO.gaps[gap].jump(&a);
            assert!((polynomial(&found, at) - 0.2).abs() < 1e-3, "{found:?}");
            let smooth = LOBATTO.gaps[gap].left(&a, &found);
            assert!((evaluate(&smooth, at) - at.cos()).abs() < 1e-3);
        }
    }
}
