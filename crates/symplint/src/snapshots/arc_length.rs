//! ∮ p dq of rows in any spacing: polynomials in the arc length of the loop before the step.
//!
//! The parameter of the rows is not known, and the integral does not depend on it. Arc length is one in which a smooth loop
//! is smooth, so that interpolants of growing order converge, across lost rows as well as between neighbours. A map advances
//! rows and not parameters: the advanced loop is interpolated at the same arc lengths, by the same polynomials.

use crate::breaks::rounding;
use crate::error::Error;
use crate::rules::LoopIntegral;
use crate::signal::{CompensatedSum, Extent, SIGNIFICANT, UNIT_ROUNDOFF, unwrap_row};
use crate::state::{Coordinates, Ensemble, coordinate, in_parallel, period};

/// Rows through which a polynomial is laid, half of them on each side of a cell. The first order is for comparison only.
const ORDERS: [usize; 5] = [4, 6, 8, 10, 12];
/// The highest of these orders.
const MAX_ORDER: usize = ORDERS[ORDERS.len() - 1];

/// Rows of the polynomials that measure arc lengths, and how often they are measured again. Arc length is exact to the order of
/// the polynomials after three passes, as each gains two orders; wide gaps take more.
const ARC_ORDER: usize = 8;
const ARC_PASSES: usize = 6;

/// Rows of a polynomial are at least this part of the cell apart: nearer ones amplify rounding. Derived: nodes at distances of an
/// eighth of a gap amplify it by less than a thousand at order 12.
const MIN_DISTANCE: f64 = 0.125;

/// For each order and degree of freedom: the integral over some cells, the area between it and the order before, and absolute values.
type Sums = Vec<Vec<[f64; 3]>>;

/// Cells that are integrated together.
const CELLS_OF_CHUNK: usize = 256;

/// One coordinate round the loop.
struct Row {
    /// Unwrapped, relative to the first row, on three turns, of which the loop is the second.
    values: Vec<f64>,
    /// What one turn adds to it.
    gain: f64,
}

impl Row {
    fn new(values: &[f64], period: f64) -> Self {
        let mut values = values.to_vec();
        let gain = unwrap_row(&mut values, period) as f64 * period;
        let first = values[0];
        values.iter_mut().for_each(|value| *value -= first);
        let values = three_turns(&values, gain);
        Row { values, gain }
    }
}

/// `values` of a loop on the turn before it, on the loop and on the turn after it, if one turn adds `gain`.
fn three_turns(values: &[f64], gain: f64) -> Vec<f64> {
    let turn = |turns: f64| values.iter().map(move |value| value + gain * turns);
    [-1.0, 0.0, 1.0].into_iter().flat_map(turn).collect()
}

/// The arc length of the rows of a loop, in which every coordinate counts by its range.
pub(super) struct ArcLength {
    /// From the first row on, on three turns, of which the loop is the second.
    at: Vec<f64>,
    /// Of the loop.
    length: f64,
}

/// The integral of a loop by polynomials of each order, without those that there are too few rows for.
pub(super) type Integrals = [Option<LoopIntegral>; ORDERS.len() - 1];

/// The integrals of two loops by the order that leaves their errors smallest.
pub(super) fn best(before: &Integrals, after: &Integrals) -> Option<(LoopIntegral, LoopIntegral)> {
    let error = |(a, b): &(&LoopIntegral, &LoopIntegral)| {
        let errors = a.quadrature_error.zip(b.quadrature_error);
        errors.map_or(f64::INFINITY, |(a, b)| a + b)
    };
    (before.iter().zip(after))
        .filter_map(|(a, b)| a.as_ref().zip(b.as_ref()))
        .min_by(|a, b| error(a).total_cmp(&error(b)))
        .map(|(a, b)| (a.clone(), b.clone()))
}

/// Numbers that belong to the rows of a polynomial, zeros after the last. An array, because a loop has millions of them.
type RowWeights = [f64; MAX_ORDER];

/// A point of a cell at which a polynomial is evaluated.
struct Node {
    /// Of Gauss's quadrature.
    weight: f64,
    /// What each row contributes to the value there, and to the derivative.
    values: RowWeights,
    slopes: RowWeights,
}

/// The polynomials of one order on a cell.
struct Stencil {
    rows: Vec<usize>,
    nodes: Vec<Node>,
}

impl Stencil {
    /// The values of a coordinate at the rows, less that at row `first`, so that little is lost to rounding.
    fn values(&self, row: &Row, first: usize) -> RowWeights {
        let first = row.values[first];
        let mut values = RowWeights::default();
        for (value, &k) in values.iter_mut().zip(&self.rows) {
            *value = row.values[k] - first;
        }
        values
    }
}

fn dot(a: &RowWeights, b: &RowWeights) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl ArcLength {
    /// Of the rows of a loop before the step; `None` if they are too few, or all the same.
    pub fn of(states: &Ensemble, coordinates: &Coordinates) -> Option<Self> {
        let rows: Vec<Row> = (0..2 * states.dof())
            .filter_map(|c| {
                let range = Extent::of(coordinate(states, c)).length();
                let scaled: Vec<f64> = coordinate(states, c).iter().map(|x| x / range).collect();
                (range > 0.0).then(|| Row::new(&scaled, period(coordinates, c) / range))
            })
            .collect();
        let n = states.samples();
        let distance = |k: usize| {
            let squares = rows
                .iter()
                .map(|row| (row.values[k + 1] - row.values[k]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let quadrature = gauss_legendre(ARC_ORDER);
        let mut found = ArcLength::from_cells((n..2 * n).map(distance).collect())?;
        for _ in 0..ARC_PASSES {
            let speed = |node: &Node, values: &[RowWeights]| {
                let slopes = values.iter().map(|row| dot(&node.slopes, row).powi(2));
                node.weight * slopes.sum::<f64>().sqrt()
            };
            let of_cell = |cell: usize| {
                let stencil = found.stencil(cell, ARC_ORDER, &quadrature)?;
                let values: Vec<RowWeights> = (rows.iter())
                    .map(|row| stencil.values(row, n + cell))
                    .collect();
                Some(stencil.nodes.iter().map(|node| speed(node, &values)).sum())
            };
            let cells = in_parallel(0..n, MAX_ORDER * MAX_ORDER, of_cell);
            found = ArcLength::from_cells(cells.into_iter().collect::<Option<_>>()?)?;
        }
        Some(found)
    }

    fn from_cells(cells: Vec<f64>) -> Option<Self> {
        let mut length = 0.0;
        let mut at = Vec::with_capacity(cells.len());
        for cell in cells {
            at.push(length);
            length += cell;
        }
        (length.is_finite() && length > 0.0).then(|| ArcLength {
            at: three_turns(&at, length),
            length,
        })
    }

    /// The widest cell, as a part of the loop.
    pub fn widest(&self) -> f64 {
        let widths = (0..self.cells()).map(|cell| self.width(cell));
        widths.fold(0.0, f64::max) / self.length
    }

    /// The width of a cell.
    pub fn width(&self, cell: usize) -> f64 {
        let first = self.cells() + cell % self.cells();
        self.at[first + 1] - self.at[first]
    }

    /// Rows of the loop, and cells between them.
    fn cells(&self) -> usize {
        self.at.len() / 3
    }

    /// The polynomials through `order` rows around a cell at the nodes of a quadrature. They have none on a cell of no length; `None`
    /// if there are not as many rows.
    fn stencil(&self, cell: usize, order: usize, quadrature: &[(f64, f64)]) -> Option<Stencil> {
        let n = self.cells();
        let (first, last) = (n + cell, n + cell + 1);
        let (from, to) = (self.at[first], self.at[last]);
        let width = to - from;
        if width <= 0.0 {
            return Some(Stencil {
                rows: Vec::new(),
                nodes: Vec::new(),
            });
        }
        let least = MIN_DISTANCE * width;
        let mut rows = Vec::with_capacity(order);
        rows.push(first);
        let before = (last - n + 1..first).rev();
        for k in before {
            if rows.len() == order / 2 {
                break;
            }
            let nearest = self.at[rows[rows.len() - 1]];
            if nearest - self.at[k] >= least {
                rows.push(k);
            }
        }
        rows.reverse();
        rows.push(last);
        for k in last + 1..rows[0] + n {
            if rows.len() == order {
                break;
            }
            let nearest = self.at[rows[rows.len() - 1]];
            if self.at[k] - nearest >= least {
                rows.push(k);
            }
        }
        if rows.len() < order {
            return None;
        }
        // In units of the cell, so that products neither vanish nor overflow.
        let at: Vec<f64> = (rows.iter())
            .map(|&k| (self.at[k] - from) / width)
            .collect();
        let weights = barycentric_weights(&at);
        let nodes = (quadrature.iter())
            .map(|&(x, weight)| {
                let [values, slopes] = lagrange(&at, &weights, 0.5 * (1.0 + x));
                Node {
                    weight: 0.5 * weight,
                    values,
                    slopes,
                }
            })
            .collect();
        Some(Stencil { rows, nodes })
    }

    /// The integral of a loop by polynomials of each order but the first. The error is the area between them and the polynomials of
    /// the order before, which nothing cancels: the orders agree about the integral across a jump, but not about the loop.
    ///
    /// # Errors
    /// If it overflows.
    pub fn integrals(
        &self,
        states: &Ensemble,
        coordinates: &Coordinates,
    ) -> Result<Integrals, Error> {
        let dof = states.dof();
        let rows: Vec<[Row; 2]> = (0..dof)
            .map(|i| [i, dof + i].map(|c| Row::new(coordinate(states, c), period(coordinates, c))))
            .collect();
        let roundings: Vec<f64> = (0..2 * dof).map(|c| rounding_of(states, c)).collect();
        let n = states.samples();
        let quadrature = gauss_legendre(MAX_ORDER);
        // Of about the same size, so that each has enough cells for a median.
        let chunk = n.div_ceil(n.div_ceil(CELLS_OF_CHUNK));
        let of_cells = |first: usize| -> Sums {
            let cells = first..n.min(first + chunk);
            let stencils: Vec<[Option<Stencil>; ORDERS.len()]> = (cells.clone())
                .map(|cell| ORDERS.map(|order| self.stencil(cell, order, &quadrature)))
                .collect();
            let mut sums = vec![vec![[0.0; 3]; dof]; ORDERS.len()];
            for (i, row) in rows.iter().enumerate() {
                let mut jumps = Vec::with_capacity(cells.len());
                for (cell, stencils) in cells.clone().zip(&stencils) {
                    let mut before: Option<Polynomials> = None;
                    let mut distances = [[0.0; 2]; ORDERS.len()];
                    for (order, stencil) in stencils.iter().enumerate() {
                        let [sum, errors, scale] = &mut sums[order][i];
                        let Some(stencil) = stencil else {
                            *errors = f64::INFINITY;
                            continue;
                        };
                        let found = Polynomials::new(stencil, row, n + cell);
                        *sum += found.value;
                        *scale += found.value.abs();
                        if let Some(before) = &before {
                            let area;
                            (area, distances[order]) = found.distance(before, stencil);
                            *errors += area + (found.value - before.value).abs();
                        }
                        before = Some(found);
                    }
                    let momentum = row[1].values[n + cell] + coordinate(states, dof + i)[0];
                    jumps.push((distances, momentum.abs()));
                }
                let of_jumps = jumps_between(&jumps, [i, dof + i].map(|c| roundings[c]));
                sums.iter_mut().for_each(|sums| sums[i][1] += of_jumps);
            }
            sums
        };
        let firsts: Vec<usize> = (0..n).step_by(chunk).collect();
        let chunks = in_parallel(
            firsts,
            MAX_ORDER * MAX_ORDER * chunk * ORDERS.len(),
            of_cells,
        );
        let mut integrals = [const { None }; ORDERS.len() - 1];
        for (order, integral) in integrals.iter_mut().enumerate() {
            let (mut total, mut error, mut scale) = (CompensatedSum::default(), 0.0, 0.0);
            let mut contributions = Vec::with_capacity(dof);
            for (i, [q, p]) in rows.iter().enumerate() {
                if coordinates.momentum_period(i) > 0.0 && (q.gain != 0.0 || p.gain != 0.0) {
                    // ∮ p dq has no value on a torus.
                    error = f64::INFINITY;
                }
                let weight = coordinates.weight(i);
                let mut value = CompensatedSum::default();
                for chunk in &chunks {
                    let [sum, differences, absolute] = chunk[order + 1][i];
                    value.add(sum);
                    error += weight.abs() * differences;
                    scale += weight.abs() * absolute;
                }
                // Momenta are relative to their first value.
                let value = value.total() + coordinate(states, dof + i)[0] * q.gain;
                contributions.push(weight * value);
                total.add(weight * value);
            }
            let value = total.total();
            if !(value.abs() + scale).is_finite() {
                let dof = contributions.iter().position(|x| !x.is_finite());
                return Err(Error::Overflow {
                    dof: dof.unwrap_or(0),
                    value,
                });
            }
            *integral = error.is_finite().then_some(LoopIntegral {
                value,
                contributions,
                quadrature_error: Some(error),
                // As of the pseudospectral rule.
                roundoff: UNIT_ROUNDOFF * (n as f64).log2() * scale,
                scale,
                omitted: None,
                regularity: None,
            });
        }
        Ok(integrals)
    }
}

/// The polynomials of one order on a cell, relative to its first row.
struct Polynomials {
    /// q, p and their derivatives at the nodes.
    at: Vec<[f64; 4]>,
    /// ∫ p dq.
    value: f64,
}

impl Polynomials {
    /// Of the cell that begins with row `first` of three turns.
    fn new(stencil: &Stencil, row: &[Row; 2], first: usize) -> Self {
        let [q, p] = row.each_ref().map(|row| stencil.values(row, first));
        let at = |Node { values, slopes, .. }: &Node| {
            [
                dot(values, &q),
                dot(values, &p),
                dot(slopes, &q),
                dot(slopes, &p),
            ]
        };
        let at: Vec<[f64; 4]> = stencil.nodes.iter().map(at).collect();
        let terms = stencil.nodes.iter().zip(&at);
        let value: f64 = terms
            .map(|(node, [_, p, slope, _])| node.weight * p * slope)
            .sum();
        let [q, p] = row;
        Polynomials {
            at,
            value: value + p.values[first] * (q.values[first + 1] - q.values[first]),
        }
    }

    /// The area between these polynomials and other ones, and how far apart they are in q and in p.
    fn distance(&self, other: &Self, stencil: &Stencil) -> (f64, [f64; 2]) {
        let (mut area, mut furthest) = (0.0, [0.0f64; 2]);
        for ((node, at), other) in stencil.nodes.iter().zip(&self.at).zip(&other.at) {
            let [q, p] = [0, 1].map(|c| (at[c] - other[c]).abs());
            // An error of p makes ∫ δp dq. That of q makes ∫ p dδq = −∫ δq dp, as it vanishes at rows.
            area += node.weight * (p * at[2].abs() + q * at[3].abs());
            furthest = [furthest[0].max(q), furthest[1].max(p)];
        }
        (area, furthest)
    }
}

/// Polynomials of order 12 and 10 differ by a distance, and polynomials of order 8 and 6 by another. Across a jump the ratio of the
/// first to the second is at least this number. Derived: 0.39 in the cell of the jump, more in the cells next to it; less than 0.1 on
/// smooth loops that are resolved.
const MIN_RATIO_AT_JUMP: f64 = 0.35;

/// A jump is at most this many times as large as the polynomials of order 12 and 10 are apart in a cell next to it. Derived: 190.
const MAX_JUMP_OVER_DISTANCE: f64 = 200.0;

/// What jumps of one degree of freedom may contribute that rows in any spacing hide, from the distances of polynomials of each order
/// in each cell, and the momentum there. Their order of convergence shows them.
fn jumps_between(cells: &[([[f64; 2]; ORDERS.len()], f64)], roundings: [f64; 2]) -> f64 {
    let [eight, last] = [2, ORDERS.len() - 1];
    let medians = [0, 1].map(|c| {
        let mut all: Vec<f64> = cells.iter().map(|(at, _)| at[last][c]).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    let of_cell = |(at, momentum): &([[f64; 2]; ORDERS.len()], f64)| {
        let [jump_q, jump_p] = [0, 1].map(|c| {
            let distance = at[last][c];
            // Noise of the rows separates polynomials in all cells, a jump in few.
            let stays =
                distance > MIN_RATIO_AT_JUMP * at[eight][c] && distance > SIGNIFICANT * medians[c];
            match stays && distance > roundings[c] {
                true => MAX_JUMP_OVER_DISTANCE * distance,
                false => 0.0,
            }
        });
        momentum * jump_q + 0.5 * jump_q * jump_p
    };
    cells.iter().map(of_cell).sum()
}

/// Polynomials that are no further apart differ by rounding.
fn rounding_of(states: &Ensemble, c: usize) -> f64 {
    rounding(UNIT_ROUNDOFF * Extent::of(coordinate(states, c)).magnitude())
}

/// The weights of Lagrange interpolation in barycentric form.
fn barycentric_weights(nodes: &[f64]) -> RowWeights {
    let mut weights = RowWeights::default();
    for (j, weight) in weights.iter_mut().take(nodes.len()).enumerate() {
        let others = (0..nodes.len()).filter(|&i| i != j);
        *weight = 1.0 / others.map(|i| nodes[j] - nodes[i]).product::<f64>();
    }
    weights
}

/// The values of the Lagrange polynomials at `x`, which differs from all their nodes, and their derivatives.
fn lagrange(nodes: &[f64], weights: &RowWeights, x: f64) -> [RowWeights; 2] {
    let [mut values, mut slopes] = [RowWeights::default(); 2];
    let product: f64 = nodes.iter().map(|node| x - node).product();
    let mut inverses = RowWeights::default();
    for (inverse, node) in inverses.iter_mut().zip(nodes) {
        *inverse = 1.0 / (x - node);
    }
    let sum: f64 = inverses[..nodes.len()].iter().sum();
    for j in 0..inverses.len() {
        values[j] = product * weights[j] * inverses[j];
        slopes[j] = values[j] * (sum - inverses[j]);
    }
    [values, slopes]
}

/// Nodes and weights of Gauss's quadrature on (−1, 1), by Newton's method for the roots of Legendre's polynomial.
fn gauss_legendre(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    let node = |k: usize| {
        let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        // From this first guess, five are enough for all digits.
        for _ in 0..5 {
            let (mut before, mut value) = (1.0, x);
            for j in 2..=order {
                let j = j as f64;
                (before, value) = (
                    value,
                    ((2.0 * j - 1.0) * x * value - (j - 1.0) * before) / j,
                );
            }
            slope = n * (before - x * value) / (1.0 - x * x);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..order).map(node).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// Rows of an ellipse with its second harmonic at these parameters, of area 2π + π/5.
    fn rows(s: &[f64]) -> Ensemble {
        let mut states = Ensemble::zeros(1, s.len());
        let mut block = states.block();
        for (k, s) in s.iter().enumerate() {
            block.q.row_mut(0)[k] = 3.0 + 2.0 * (TAU * s).sin() - 0.5 * (2.0 * TAU * s).sin();
            block.p.row_mut(0)[k] = (TAU * s).cos() - 0.2 * (2.0 * TAU * s).cos();
        }
        states
    }

    fn integral(s: &[f64]) -> LoopIntegral {
        let (states, plain) = (rows(s), Coordinates::plain(1));
        let arcs = ArcLength::of(&states, &plain).unwrap();
        let found = arcs.integrals(&states, &plain).unwrap();
        best(&found, &found).unwrap().0
    }

    #[test]
    fn integrals_of_rows_in_any_spacing_are_exact_within_their_errors() {
        for n in [48, 64, 200, 1000] {
            let equal: Vec<f64> = (0..n).map(|k| k as f64 / n as f64).collect();
            let lost: Vec<f64> = equal
                .iter()
                .copied()
                .filter(|s| (s - 0.3).abs() > 0.02)
                .collect();
            let every: Vec<f64> = (0..n)
                .filter(|k| k % 7 != 3)
                .map(|k| k as f64 / n as f64)
                .collect();
            let uneven: Vec<f64> = (equal.iter().enumerate())
                .map(|(k, s)| s + 0.4 * ((k * k) as f64).sin() / n as f64)
                .collect();
            for (s, what) in [
                (&equal, "equal"),
                (&lost, "lost"),
                (&every, "every"),
                (&uneven, "uneven"),
            ] {
                let found = integral(s);
                let error = found.quadrature_error.unwrap() + found.roundoff;
                let off = (found.value - (2.0 * PI + 0.2 * PI)).abs();
                assert!(off <= error, "{n} {what}: {off:e} {error:e}");
                assert!(error < 2e3 / (n as f64).powi(4), "{n} {what}: {error:e}");
            }
        }
    }

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        for order in [2, 4, 8, 12] {
            for power in 0..2 * order as i32 {
                let sum: f64 = gauss_legendre(order)
                    .iter()
                    .map(|(x, w)| w * x.powi(power))
                    .sum();
                let exact = if power % 2 == 0 {
                    2.0 / f64::from(power + 1)
                } else {
                    0.0
                };
                assert!((sum - exact).abs() < 1e-14, "{order} {power}: {sum}");
            }
        }
    }

    #[test]
    fn too_few_rows_have_no_integral() {
        let states = rows(&[0.0, 0.2, 0.4, 0.6, 0.8]);
        assert!(ArcLength::of(&states, &Coordinates::plain(1)).is_none());
        let constant = Ensemble::zeros(1, 64);
        assert!(ArcLength::of(&constant, &Coordinates::plain(1)).is_none());
    }
}
