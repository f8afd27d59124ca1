//! Whether the change of a loop integral sits at a few points of the disc within the loop: halves of the disc, and halves
//! of these.
//!
//! A map that has a symplectic derivative everywhere within a loop conserves its integral (Stokes). A closed kick with a
//! singular axis, p += h ∇φ(q) with φ the angle round it, changes that of loops that run round the axis, as these cannot be
//! contracted where the map is defined. All of the change is then that of small discs round the axes, however small,
//! where that of a map that is not symplectic is spread over an area.

use super::patch::{Patch, Patches};
use super::sectors::centre;
use crate::error::Error;
use crate::evidence::{Contraction, StepEvidence};
use crate::map::LoopSize;
use crate::rules::{Piecewise, Subject};

/// Halvings of the disc at most.
const MAX_HALVINGS: usize = 12;

/// Patches that change by this part of the whole change, or less, are left out: in twelve halvings of four patches
/// no more than a tenth of it.
const MAX_NEGLECTED_PART: f64 = 0.002;

/// Patches that carry the change at most. A defect that is spread over the disc doubles them with every halving.
const MAX_PATCHES: usize = 4;

/// The cut of a patch: not in the middle, where an axis may be.
const POSITION_OF_CUT: f64 = 0.437;

/// The centre of the disc is that of the loop, moved by this part of its size: an axis may be there, too.
const CENTRE_OFFSET: f64 = 0.0917;

/// Evaluations of one boundary at most: near a singular point they are many.
pub(crate) const MAX_BOUNDARY_EVALUATIONS: usize = 4_000;

/// Evaluations that the first halving takes, where boundaries are smooth.
pub(crate) const MIN_HALVING_EVALUATIONS: usize = 2 * (12 + 15 * 4);

/// Follows the parts of the disc that carry the change of the loop integral in `step`, of size `h`, as long as they are few. The change is
/// measured again if it is not known well enough. `None` if boundaries are not resolved.
///
/// # Errors
/// Those of the map within the loop.
pub(crate) fn contraction(
    subject: Subject<'_>,
    size: &LoopSize,
    h: f64,
    step: &StepEvidence,
) -> Result<Option<Contraction>, Error> {
    let mut centre = centre(subject.phase_loop)?;
    for (centre, radius) in centre.iter_mut().zip(&size.radius) {
        for (i, (centre, radius)) in centre.iter_mut().zip(radius).enumerate() {
            if !size.at_rest[i] {
                *centre += CENTRE_OFFSET * radius;
            }
        }
    }
    let patches = Patches {
        subject,
        centre,
        rule: Piecewise {
            most_evaluations: MAX_BOUNDARY_EVALUATIONS,
            ..Piecewise::default()
        },
        h,
    };
    let disc = Patch {
        s: [0.0, 1.0],
        r: [0.0, 1.0],
    };
    // The boundary of the disc is the loop.
    let is_known = step.defect.uncertainty() <= MAX_NEGLECTED_PART * step.defect.magnitude();
    let change = match is_known {
        true => step.advanced - step.initial,
        false => patches.change(disc)?.change,
    };
    let is_little = |part: f64| part.abs() <= MAX_NEGLECTED_PART * change.abs();
    let mut carrying = vec![Part {
        patch: disc,
        change,
        area: 1.0,
    }];
    'halvings: for halving in 0..MAX_HALVINGS {
        let mut halves = Vec::new();
        for (k, part) in carrying.iter().enumerate() {
            let [first, second] = part.patch.halves(halving);
            let found = patches.change(first)?;
            if !found.uncertainty.is_some_and(is_little) {
                return Ok(None);
            }
            // The change of the other half is what is left.
            for (patch, change, area) in [
                (first, found.change, POSITION_OF_CUT * part.area),
                (
                    second,
                    part.change - found.change,
                    (1.0 - POSITION_OF_CUT) * part.area,
                ),
            ] {
                if !is_little(change) {
                    halves.push(Part {
                        patch,
                        change,
                        area,
                    });
                }
            }
            // Parts that are still to be halved: if half of the change of one is not little, one of its halves is not.
            let others = carrying[k + 1..].iter();
            let others = others.filter(|part| !is_little(0.5 * part.change)).count();
            if halves.len() + others > MAX_PATCHES {
                break 'halvings;
            }
        }
        carrying = halves;
    }
    let area = carrying.iter().map(|part| part.area).sum();
    let largest = (carrying.iter()).max_by(|a, b| a.change.abs().total_cmp(&b.change.abs()));
    Ok(largest.map(|part| Contraction {
        s: part.patch.s,
        r: part.patch.r,
        points: carrying.len(),
        area,
    }))
}

/// A patch that carries a part of the change.
struct Part {
    patch: Patch,
    change: f64,
    area: f64,
}

impl Patch {
    /// Cut in s and in r by turns, in parts of one area each way.
    fn halves(self, halving: usize) -> [Patch; 2] {
        let ([s0, s1], [r0, r1]) = (self.s, self.r);
        if halving.is_multiple_of(2) {
            let cut = s0 + POSITION_OF_CUT * (s1 - s0);
            [[s0, cut], [cut, s1]].map(|s| Patch { s, ..self })
        } else {
            let cut = (r0 * r0 + POSITION_OF_CUT * (r1 * r1 - r0 * r0)).sqrt();
            [[r0, cut], [cut, r1]].map(|r| Patch { r, ..self })
        }
    }
}
