//! Patches of the disc within a loop.
//!
//! The loop bounds a disc, the fan of segments from a centre to the loop. Cut into patches, the loop integrals of their
//! boundaries add up to that of the loop, before the step and after, as inner sides cancel. So do their changes.

use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator};
use crate::rules::{Identity, Piecewise, Subject};
use crate::state::Block;

/// A patch of the disc: parts of the loop parameter and of the way from the centre (0) to the loop (1).
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub s: [f64; 2],
    pub r: [f64; 2],
}

impl Patch {
    /// Its boundary is smooth between this number of corners. A sector has three.
    pub fn sides(&self) -> usize {
        if self.r[0] == 0.0 { 3 } else { 4 }
    }

    /// The way from the centre and the loop parameter at t, which counts sides: outward, along the loop, inward, and
    /// back.
    fn at(&self, t: f64) -> (f64, f64) {
        let between = |[from, to]: [f64; 2], t: f64| from + t.clamp(0.0, 1.0) * (to - from);
        match t {
            0.0..1.0 => (between(self.r, t), self.s[0]),
            1.0..2.0 => (self.r[1], between(self.s, t - 1.0)),
            2.0..3.0 => (between(self.r, 3.0 - t), self.s[1]),
            _ => (self.r[0], between(self.s, 4.0 - t)),
        }
    }
}

/// The boundary of a patch.
struct Boundary<'a> {
    phase_loop: &'a dyn Loop,
    /// q and p of the centre.
    centre: &'a [Vec<f64>; 2],
    patch: Patch,
}

impl Loop for Boundary<'_> {
    fn dof(&self) -> usize {
        self.phase_loop.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let sides = self.patch.sides() as f64;
        let (outward, on_loop): (Vec<f64>, Vec<f64>) =
            s.iter().map(|&t| self.patch.at(sides * t)).unzip();
        self.phase_loop.sample(&on_loop, block);
        for i in 0..self.dof() {
            let rows = [block.q.row_mut(i), block.p.row_mut(i)];
            for (row, centre) in rows.into_iter().zip(self.centre) {
                for (value, outward) in row.iter_mut().zip(&outward) {
                    *value = centre[i] * (1.0 - outward) + *value * outward;
                }
            }
        }
    }
}

/// The loop integral of a boundary before a step, and its change.
pub(super) struct PatchChange {
    pub before: f64,
    pub change: f64,
    pub uncertainty: Option<f64>,
}

/// Integrates round patches before and after steps.
pub(super) struct Patches<'a> {
    pub subject: Subject<'a>,
    pub centre: [Vec<f64>; 2],
    pub rule: Piecewise,
    pub h: f64,
}

impl Patches<'_> {
    /// The change of the loop integral of a boundary.
    ///
    /// # Errors
    /// Those of the map within the loop.
    pub fn change(&self, patch: Patch) -> Result<PatchChange, Error> {
        let evaluator = self.subject.evaluator;
        let rule = Piecewise {
            pieces: patch.sides(),
            ..self.rule
        };
        let boundary = evaluator.on_manifold(Boundary {
            phase_loop: self.subject.phase_loop,
            centre: &self.centre,
            patch,
        });
        let rest = Identity(self.subject.coordinates());
        let unmoved = EvaluationCount::unlimited();
        let rest = Evaluator::new(&rest, &unmoved)?;
        let before = rule
            .integrate_beside(&rest, &boundary, self.h, None)?
            .continuous;
        let after = rule
            .integrate_beside(evaluator, &boundary, self.h, None)
            .map_err(Error::in_sector)?
            .closed();
        let errors = before.quadrature_error.zip(after.quadrature_error);
        Ok(PatchChange {
            before: before.value,
            change: after.value - before.value,
            uncertainty: errors.map(|(a, b)| a + b + before.roundoff + after.roundoff),
        })
    }
}
