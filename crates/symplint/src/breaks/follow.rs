//! Following a suspected jump down to the resolution of double precision.

use super::suspects::{Coordinate, OUTSTANDING, Suspect};
use super::{Break, fourth_difference};
use crate::error::Error;
use crate::loops::Loop;
use crate::map::Evaluator;

use crate::signal::unwrap_row;

/// Cells into which a stretch is cut at each turn.
const CELLS: usize = 24;

/// A stretch of this length in s cannot be cut into cells that doubles tell apart.
const RESOLUTION: f64 = 2e-13;

/// A jump loses nothing when looked at more closely; a smooth stretch loses much at every turn.
const STAYS: f64 = 0.5;

/// Evaluates the map on ever shorter stretches round the largest fourth difference.
///
/// Positions are unwrapped. Returns the break if the difference has not shrunk when the stretch is as short as double
/// precision can resolve, `None` if it fades: the loop is steep but continuous there.
pub(super) fn follow(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    suspect: &Suspect,
    samples: usize,
) -> Result<Option<Break>, Error> {
    let period = evaluator.coordinates().period(suspect.dof);
    let spacing = 1.0 / samples as f64;
    let mut start = suspect.first as f64 * spacing;
    let mut length = 4.0 * spacing;
    loop {
        let cell = length / CELLS as f64;
        let s: Vec<f64> = (0..=CELLS).map(|k| start + k as f64 * cell).collect();
        let mut states = evaluator.image(phase_loop, h, &s)?;
        // A wrap is no jump.
        unwrap_row(states.block().q.row_mut(suspect.dof), period);
        let row = match suspect.coordinate {
            Coordinate::Q => states.q(),
            Coordinate::P => states.p(),
        }
        .row(suspect.dof);
        let differences = row
            .windows(5)
            .map(|x| fourth_difference([x[0], x[1], x[2], x[3], x[4]]).abs());
        let (at, largest) =
            differences.enumerate().fold(
                (0, 0.0),
                |best, (k, d)| if d > best.1 { (k, d) } else { best },
            );
        if largest < STAYS * suspect.difference || largest < OUTSTANDING * suspect.noise {
            return Ok(None);
        }
        if length < RESOLUTION && largest < OUTSTANDING * median(row) {
            // The rounding of the map itself, which a large stretch can make larger than that of the states.
            return Ok(None);
        }
        if length < RESOLUTION {
            let (q, p) = (states.q().row(suspect.dof), states.p().row(suspect.dof));
            return Ok(Some(Break {
                s: s[at + 2].rem_euclid(1.0),
                dof: suspect.dof,
                jump_q: q[at + 4] - q[at],
                jump_p: p[at + 4] - p[at],
                substep: None,
            }));
        }
        start = s[at];
        length = 4.0 * cell;
    }
}

/// Median of the absolute fourth differences: that of the noise, where there is a jump or two.
fn median(row: &[f64]) -> f64 {
    let mut differences: Vec<f64> = (row.windows(5))
        .map(|x| fourth_difference([x[0], x[1], x[2], x[3], x[4]]).abs())
        .collect();
    differences.sort_by(f64::total_cmp);
    differences[differences.len() / 2]
}
