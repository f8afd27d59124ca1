//! Loops that do not lie in the domain of the map.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::{Change, Step};
use crate::evidence::{Contraction, Rank};
use crate::text::{capitalised, loop_name, two_digits};

/// Loops that do not lie in the domain of the map.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum DomainFinding {
    /// A loop integral changes, the Jacobian does not show why, and nine tenths of the change come from a few points, less
    /// than a thousandth of the disc within the loop.
    ChangesAtAPoint {
        /// Which loop.
        loop_index: usize,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
        /// Its place.
        contraction: Contraction,
    },
    /// A loop integral changes by much more than the Jacobian of the step allows, and whether the loop can be contracted in
    /// the domain of the map is not known.
    ContractionUnknown {
        /// Which loop.
        loop_index: usize,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
        /// What no defect of the Jacobian exceeds.
        bound: f64,
    },
    /// Only loops that were not given change, and whether the map projects onto a manifold, outside which that proves
    /// nothing, is not known.
    ManifoldUnknown {
        /// Which loop.
        loop_index: usize,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
    },
    /// The map projects onto a manifold (its Jacobian is singular at the loop), and your loop does not lie on it: its
    /// integral changes significantly in one step, and in the step after that it does not.
    LoopBesideManifold {
        /// The smallest singular value of the Jacobian.
        smallest: f64,
        /// Its largest defect in one step.
        first: f64,
        /// What its defect in another step does not exceed.
        second: f64,
    },
    /// The map projects onto a manifold (its Jacobian is singular at the loop), and only random loops or tangent vectors,
    /// which leave the manifold, have a defect.
    Projects {
        /// The smallest singular value of the Jacobian.
        smallest: f64,
        /// The bound on the defect of your loop.
        given: Option<f64>,
        /// The random loop with the largest defect, and this defect.
        beside: Option<(usize, f64)>,
    },
    /// A loop, or the Jacobian, shows a change in non-canonical coordinates whose symplectic form is degenerate: the rank of dϑ
    /// is below the dimension of the manifold to which the loops keep, at both points that were tested.
    DegenerateForm {
        /// The rank of the form, of the dimension of the manifold.
        rank: Rank,
        /// The bound on the defect of your loop.
        given: Option<f64>,
    },
    /// The Jacobian of the step is singular at the loop, and the symplectic form is degenerate on its image.
    LosesRank {
        /// The rank of the Jacobian, of all coordinates.
        rank: Rank,
    },
    /// A step moves states off the manifold, or the leaf, to which a projection keeps the loops.
    LeavesManifold {
        /// The largest distance, in units of the loop's radii.
        distance: f64,
    },
}

impl Display for DomainFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            DomainFinding::ChangesAtAPoint {
                loop_index,
                change,
                step,
                contraction,
            } => at_a_point(f, *loop_index, change, step, contraction),
            DomainFinding::ContractionUnknown {
                loop_index,
                change,
                step,
                bound,
            } => contraction_unknown(f, *loop_index, change, step, *bound),
            DomainFinding::ManifoldUnknown {
                loop_index,
                change,
                step,
            } => manifold_unknown(f, *loop_index, change, step),
            DomainFinding::LoopBesideManifold {
                smallest,
                first,
                second,
            } => beside_manifold(f, *smallest, [*first, *second]),
            DomainFinding::Projects {
                smallest,
                given,
                beside,
            } => projects(f, *smallest, *given, *beside),
            DomainFinding::DegenerateForm { rank, given } => degenerate_form(f, *rank, *given),
            DomainFinding::LeavesManifold { distance } => write!(
                f,
                "The step moves states off the manifold on which the loops lie, by up to {} radii. A step that is symplectic on this \
                 manifold keeps states there, and conserves all Casimir functions.",
                two_digits(*distance)
            ),
            DomainFinding::LosesRank { rank } => write!(
                f,
                "The step projects: its Jacobian has rank {} of {} at the loop. Such a step is not symplectic on the whole phase \
                 space; it may be on the manifold onto which it projects.",
                rank.rank, rank.of
            ),
        }
    }
}

fn at_a_point(
    f: &mut Formatter<'_>,
    loop_index: usize,
    change: &Change,
    step: &Step,
    contraction: &Contraction,
) -> Result {
    let middle = |[from, to]: [f64; 2]| 0.5 * (from + to);
    write!(
        f,
        "The integral of {} changes by {change} {step}, but all of the change comes from {} {:.0e} of the disc within it,{} \
         near s = {:.3}, {:.0} % of the way from the centre. If the map is singular there, it can change the integral and be symplectic everywhere else: then the loop cannot be contracted in its domain.",
        loop_name(loop_index),
        match contraction.points {
            1 => "a patch of".to_owned(),
            points => format!("{points} patches, together"),
        },
        contraction.area,
        match contraction.points {
            1 => "",
            _ => " most of it",
        },
        middle(contraction.s),
        100.0 * middle(contraction.r)
    )
}

fn contraction_unknown(
    f: &mut Formatter<'_>,
    loop_index: usize,
    change: &Change,
    step: &Step,
    bound: f64,
) -> Result {
    write!(
        f,
        "The integral of {} changes by {change} {step}, but the Jacobian is symplectic to {bound:.1e} at all points that were \
         tried. Both are right for a map that is singular at a point within the loop; it is not known whether \
         the change comes from one.",
        loop_name(loop_index)
    )
}

fn manifold_unknown(
    f: &mut Formatter<'_>,
    loop_index: usize,
    change: &Change,
    step: &Step,
) -> Result {
    write!(
        f,
        "The integral of {} changes by {change} {step}, and the integral of your loop does not. If the map projects onto a constraint \
         manifold, loops that leave the manifold do not count as evidence; whether the map projects was not tested.",
        loop_name(loop_index)
    )
}

fn beside_manifold(f: &mut Formatter<'_>, smallest: f64, [first, second]: [f64; 2]) -> Result {
    write!(
        f,
        "The map projects onto a manifold: its Jacobian is singular at the loop (a direction shrinks to {}), \
         and the loop does not lie on the manifold. Its integral changes by {first:.1e} in the step that takes it there, \
         and by less than {second:.1e} in the next one.",
        two_digits(smallest)
    )
}

fn projects(
    f: &mut Formatter<'_>,
    smallest: f64,
    given: Option<f64>,
    beside: Option<(usize, f64)>,
) -> Result {
    write!(
        f,
        "The map moves states onto a manifold: its Jacobian is singular at the loop (a direction shrinks to {}). ",
        two_digits(smallest)
    )?;
    match given {
        Some(bound) => write!(f, "Your loop is conserved to {bound:.1e}")?,
        None => f.write_str("The change of your loop has no bound")?,
    }
    match beside {
        Some((loop_index, defect)) => write!(
            f,
            ". {} changes by {defect:.1e}, but leaves the manifold, so this does not count as evidence.",
            capitalised(&loop_name(loop_index))
        ),
        None => f.write_str(". Loops that leave the manifold do not count as evidence."),
    }
}

fn degenerate_form(f: &mut Formatter<'_>, Rank { rank, of }: Rank, given: Option<f64>) -> Result {
    write!(
        f,
        "The form is degenerate: dϑ has rank {rank} of {of}. Changes of the other coordinates do not show, and loops that leave a leaf of the \
         form can change although the map is symplectic on every leaf. So these loops give no verdict"
    )?;
    match given {
        Some(bound) => write!(f, "; your loop is conserved to {bound:.1e}."),
        None => f.write_str("."),
    }
}
