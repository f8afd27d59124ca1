//! More digits of the entries of a form: its integrals round loops do not change, and loops have more digits than derivatives.

use nalgebra::{DMatrix, DVector};

use super::on_loops::Change;
use crate::evidence::FormEntry;

/// The entries that fit the changes of their integrals best, and are within their errors. `None` if that has no solution.
///
/// The unknowns are the relative corrections y_k of the entries, of which one in each group is kept: Σ_k D_k (1 + y_k) = 0 for the parts D_k of
/// the change round each loop, and y_k = 0, each divided by its error. Errors are those of the least squares.
pub(super) fn refined(entries: &[FormEntry], changes: &[Change]) -> Option<Vec<FormEntry>> {
    let (count, loops) = (entries.len(), changes.len());
    let is_kept = |k: usize| entries[..k].iter().all(|of| of.group != entries[k].group);
    let kept_error = |group: usize| {
        let kept = entries.iter().find(|of| of.group == group);
        kept.map_or(0.0, FormEntry::relative_error)
    };
    let error = |k: usize| match is_kept(k) {
        true => f64::EPSILON,
        false => entries[k].relative_error() + kept_error(entries[k].group),
    };
    let matrix = DMatrix::from_fn(loops + count, count, |r, k| match r.checked_sub(loops) {
        None => changes[r].parts[k] / changes[r].uncertainty,
        Some(row) if row == k => 1.0 / error(k),
        Some(_) => 0.0,
    });
    let right = DVector::from_fn(loops + count, |r, _| match changes.get(r) {
        Some(change) => -change.parts.iter().sum::<f64>() / change.uncertainty,
        None => 0.0,
    });
    // In units of the errors the unknowns are alike.
    let scaled = DMatrix::from_fn(loops + count, count, |r, k| matrix[(r, k)] * error(k));
    let qr = scaled.qr();
    let inverse = qr.r().try_inverse()?;
    let corrections = &inverse * (qr.q().transpose() * right);
    let refined = entries.iter().enumerate().map(|(k, entry)| FormEntry {
        value: entry.value * (1.0 + error(k) * corrections[k]),
        error: entry.value.abs() * error(k) * inverse.row(k).norm(),
        ..*entry
    });
    Some(refined.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_add_digits_to_the_entries_that_their_integrals_show() {
        let entry = |k: usize, value: f64, error: f64| FormEntry {
            coordinates: [k, 3 + k],
            powers: [0; 3],
            value,
            error,
            group: 0,
        };
        // 1 : 3 : -0.7, of which derivatives show six digits.
        let exact = [1.0, 3.0, -0.7];
        let entries = [
            entry(0, 1.0, 1e-7),
            entry(1, 3.000_001, 3e-6),
            entry(2, -0.699_999_5, 1e-6),
        ];
        // The changes of each entry round two loops: those of the exact form add up to 0.
        let change = |a: f64, b: f64| {
            let changes = [a, b, -(exact[0] * a + exact[1] * b) / exact[2]];
            Change {
                parts: (0..3).map(|k| changes[k] * entries[k].value).collect(),
                uncertainty: 1e-14,
                scale: 1.0,
            }
        };
        let one = refined(&entries, &[change(0.1, -0.02)]).unwrap();
        let two = refined(&entries, &[change(0.1, -0.02), change(0.03, 0.05)]).unwrap();
        for k in 0..3 {
            assert!((one[k].value - exact[k]).abs() < 3.0 * one[k].error.max(1e-15));
            assert!((two[k].value - exact[k]).abs() < 3.0 * two[k].error.max(1e-15));
            assert!(two[k].error < 1e-11, "{:e}", two[k].error);
        }
        assert!(one[1].error > 1e-8, "{:e}", one[1].error);
    }
}
