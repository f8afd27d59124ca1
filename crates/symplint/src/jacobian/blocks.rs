//! Which coordinates the defect of a Jacobian concerns.

use super::derivative::Derivative;
use super::evidence::{BlockDefects, DefectBlocks, JacobianMethod, TangentDefect};
use super::frame::Frame;
use super::volume::PointVolume;
use crate::signal::UNIT_ROUNDOFF;

/// An entry of an antisymmetric matrix: its two coordinates, its size if it is significant or else 0, and its bound.
type Entry = ([usize; 2], f64, f64);

/// The defect at one point, the form before and the brackets after the step.
#[derive(Clone)]
pub(super) struct PointBlocks([Vec<Entry>; 2]);

impl PointBlocks {
    /// From the derivatives along all unit vectors, and the changes of the form on pairs of them.
    pub fn new(
        method: JacobianMethod,
        derivatives: &[Derivative],
        changes: &[((usize, usize), TangentDefect)],
        frame: &Frame,
    ) -> Self {
        let entry = |pair: (usize, usize), defect: &TangentDefect| {
            let size = match defect.is_significant(method) {
                true => defect.magnitude(),
                false => 0.0,
            };
            ([pair.0, pair.1], size, defect.bound())
        };
        let columns: Vec<Column<'_>> = (derivatives.iter())
            .map(|of| (&of.value[..], &of.error[..]))
            .collect();
        let form = changes.iter().map(|(pair, change)| entry(*pair, change));
        let brackets = changes.iter().map(|&((a, b), of_form)| {
            let (signed, uncertainty) = bracket(&columns, [a, b], frame);
            let defect = TangentDefect {
                signed,
                uncertainty,
                ..of_form
            };
            entry((a, b), &defect)
        });
        PointBlocks([form.collect(), brackets.collect()])
    }
}

/// A column of the Jacobian, and the errors of its components.
pub(super) type Column<'a> = (&'a [f64], &'a [f64]);

/// The Poisson bracket of two coordinates after the step, less what it was before; divided by √|areas|, as a symplectic map has columns
/// of this length. And its uncertainty.
pub(super) fn bracket(columns: &[Column<'_>], [a, b]: [usize; 2], frame: &Frame) -> (f64, f64) {
    let dof = columns.len() / 2;
    let value = |c: usize, k: usize| columns[k].0[c];
    let error = |c: usize, k: usize| columns[k].1[c];
    let mut sum = match b == a + dof {
        true => -1.0 / frame.area(a),
        false => 0.0,
    };
    let mut uncertainty = 4.0 * UNIT_ROUNDOFF * sum.abs();
    for i in 0..dof {
        for (k, l, area) in [(i, dof + i, frame.area(i)), (dof + i, i, -frame.area(i))] {
            let (x, y) = (value(a, k), value(b, l));
            sum += x * y / area;
            let of_product = error(a, k) * y.abs() + (x.abs() + error(a, k)) * error(b, l);
            uncertainty += (of_product + 4.0 * UNIT_ROUNDOFF * (x * y).abs()) / area.abs();
        }
    }
    let unit = (frame.area(a % dof) * frame.area(b % dof)).abs().sqrt();
    (unit * sum, unit * uncertainty)
}

/// What all points show together. `None` if no entry is significant, or there is one degree of freedom.
pub(super) fn together(points: &[PointVolume], dof: usize) -> Option<DefectBlocks> {
    let side = |side: usize| {
        let entries = || points.iter().flat_map(|point| &point.blocks.0[side]);
        let block = |pair: &[usize; 2]| pair.iter().filter(|&&c| c >= dof).count();
        let largest = |of: &dyn Fn(&Entry) -> f64, wanted: &dyn Fn(&[usize; 2]) -> bool| {
            let found = entries().filter(|entry| wanted(&entry.0)).map(of);
            found.fold(0.0, f64::max)
        };
        let moves = |pair: &[usize; 2], i: usize| pair.iter().any(|c| c % dof == i);
        let dofs: Vec<usize> = (0..dof)
            .filter(|&i| largest(&|entry| entry.1, &|pair| moves(pair, i)) > 0.0)
            .collect();
        let is_other = |pair: &[usize; 2]| pair.iter().any(|c| !dofs.contains(&(c % dof)));
        BlockDefects {
            sizes: std::array::from_fn(|k| largest(&|entry| entry.1, &|pair| block(pair) == k)),
            bounds: std::array::from_fn(|k| largest(&|entry| entry.2, &|pair| block(pair) == k)),
            bound_of_others: largest(&|entry| entry.2, &is_other),
            dofs,
        }
    };
    let found = DefectBlocks {
        before: side(0),
        after: side(1),
        across_time: None,
    };
    (dof > 1 && found.before.largest() > 0.0).then_some(found)
}
