//! Whether the change of a loop integral sits at one point of the disc within the loop: halves of the disc, and halves of
//! these.
//!
//! A map that has a symplectic derivative everywhere within a loop conserves its integral (Stokes). A closed kick with a
//! singular axis, p += h ∇φ(q) with φ the angle round it, changes that of loops that run round the axis, as these cannot be
//! contracted where the map is defined. All of the change is then that of a small disc round the axis, however small,
//! where that of a map that is not symplectic is spread over an area.

use super::patch::{Patch, Patches};
use super::sectors::centre;
use crate::error::Error;
use crate::evidence::Contraction;
use crate::map::LoopSize;
use crate::rules::{Piecewise, Subject};

/// Halvings of the disc at most.
const HALVINGS: usize = 12;

/// A patch that carries all of the change but this part of it, or less, carries it.
const REST: f64 = 0.1;

/// Where a patch is cut: not in the middle, where an axis may be.
const CUT: f64 = 0.437;

/// The centre of the disc is that of the loop, moved by this part of its size: an axis may be there, too.
const OFF_CENTRE: f64 = 0.0917;

/// Evaluations of one boundary at most: near a singular point they are many.
const MOST_EVALUATIONS: usize = 4_000;

/// Evaluations that the first halving takes, where boundaries are smooth.
pub(crate) const FEWEST_EVALUATIONS: usize = 2 * (12 + 15 * 4);

/// Follows the half of the disc that carries the change of the loop integral, as long as one does. `None` where
/// boundaries are not resolved.
///
/// # Errors
/// Those of the map within the loop.
pub(crate) fn contraction(
    subject: Subject<'_>,
    size: &LoopSize,
    h: f64,
) -> Result<Option<Contraction>, Error> {
    let mut centre = centre(subject.phase_loop)?;
    for (centre, radius) in centre.iter_mut().zip(&size.radius) {
        for (i, (centre, radius)) in centre.iter_mut().zip(radius).enumerate() {
            if !size.at_rest[i] {
                *centre += OFF_CENTRE * radius;
            }
        }
    }
    let patches = Patches {
        subject,
        centre,
        rule: Piecewise {
            most_evaluations: MOST_EVALUATIONS,
            ..Piecewise::default()
        },
        h,
    };
    let mut patch = Patch {
        s: [0.0, 1.0],
        r: [0.0, 1.0],
    };
    let whole = patches.change(patch)?;
    let is_little = |change: f64| change.abs() <= REST * whole.change.abs();
    let mut area = 1.0;
    for halving in 0..HALVINGS {
        let halves = patch.halves(halving);
        // The change of the other half is what is left.
        let first = patches.change(halves[0])?;
        if !first.uncertainty.is_some_and(is_little) {
            return Ok(None);
        }
        let rest = whole.change - first.change;
        let kept = match (is_little(rest), is_little(first.change)) {
            (true, false) => 0,
            (false, true) => 1,
            _ => break,
        };
        patch = halves[kept];
        area *= [CUT, 1.0 - CUT][kept];
    }
    Ok(Some(Contraction {
        s: patch.s,
        r: patch.r,
        area,
    }))
}

impl Patch {
    /// Cut in s and in r by turns, in parts of one area each way.
    fn halves(self, halving: usize) -> [Patch; 2] {
        let ([s0, s1], [r0, r1]) = (self.s, self.r);
        if halving.is_multiple_of(2) {
            let cut = s0 + CUT * (s1 - s0);
            [[s0, cut], [cut, s1]].map(|s| Patch { s, ..self })
        } else {
            let cut = (r0 * r0 + CUT * (r1 * r1 - r0 * r0)).sqrt();
            [[r0, cut], [cut, r1]].map(|r| Patch { r, ..self })
        }
    }
}
