//! Sentences about where a map is tested: on its manifold, round a singular point, in groups of degrees of freedom.

use std::fmt::{Formatter, Result};

use crate::evidence::{Contraction, Rank};
use crate::verdict::finding::{Change, Step};
use crate::verdict::number::loop_name;

pub(super) fn at_a_point(
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
         near s = {:.3}, {:.0} % of the way from the centre. A map that is singular there may change it, and be \
         symplectic everywhere else: the loop cannot be contracted in its domain.",
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

pub(super) fn contraction_unknown(
    f: &mut Formatter<'_>,
    loop_index: usize,
    change: &Change,
    step: &Step,
    bound: f64,
) -> Result {
    write!(
        f,
        "The integral of {} changes by {change} {step}, but the Jacobian is symplectic to {bound:.1e} at all points that were \
         tried. Both are right for a map that is singular at a point within the loop; whether the change comes from one was \
         not found out.",
        loop_name(loop_index)
    )
}

pub(super) fn manifold_unknown(
    f: &mut Formatter<'_>,
    loop_index: usize,
    change: &Change,
    step: &Step,
) -> Result {
    write!(
        f,
        "The integral of {} changes by {change} {step}, and that of the given loop does not. If the map projects onto a \
         constraint manifold, loops beside it prove nothing; whether it does was not found out.",
        loop_name(loop_index)
    )
}

pub(super) fn beside_manifold(
    f: &mut Formatter<'_>,
    smallest: f64,
    [first, second]: [f64; 2],
) -> Result {
    write!(
        f,
        "The map projects onto a manifold: its Jacobian is singular at the loop (a direction shrinks to {smallest:.1e}), \
         and the loop does not lie on the manifold. Its integral changes by {first:.1e} in the step that takes it there, \
         and by less than {second:.1e} in the next one."
    )
}

pub(super) fn projects(
    f: &mut Formatter<'_>,
    smallest: f64,
    given: Option<f64>,
    beside: Option<(usize, f64)>,
) -> Result {
    write!(
        f,
        "The map projects onto a manifold: its Jacobian is singular at the loop (a direction shrinks to {smallest:.1e}). "
    )?;
    match given {
        Some(bound) => write!(f, "The given loop is conserved to {bound:.1e}")?,
        None => f.write_str("The defect of the given loop is not bounded")?,
    }
    match beside {
        Some((loop_index, defect)) => write!(
            f,
            "; {}, which leaves the manifold, changes by {defect:.1e}, which proves nothing.",
            loop_name(loop_index)
        ),
        None => f.write_str("; what leaves the manifold proves nothing."),
    }
}

pub(super) fn degenerate_form(
    f: &mut Formatter<'_>,
    Rank { rank, of }: Rank,
    given: Option<f64>,
) -> Result {
    write!(
        f,
        "The form is degenerate: rank {rank} of {of}. A map that is symplectic on every leaf need not conserve the integrals of \
         loops that leave the leaf, nor the form on such tangent vectors: the changes that were found prove nothing"
    )?;
    match given {
        Some(bound) => write!(f, "; the given loop is conserved to {bound:.1e}."),
        None => f.write_str("."),
    }
}

pub(super) fn group(
    f: &mut Formatter<'_>,
    [index, of]: [usize; 2],
    dofs: &[usize],
    action: f64,
    (loops, by_loops): (usize, Option<f64>),
    by_jacobian: Option<f64>,
) -> Result {
    write!(
        f,
        "Group {} of {of}, {}, ",
        index + 1,
        degrees_of_freedom(dofs)
    )?;
    match index {
        0 => f.write_str("with the largest actions: ")?,
        _ => write!(f, "whose actions are {action:.0e} of the largest or less: ")?,
    }
    match by_loops {
        Some(bound) => write!(f, "|E| ≤ {bound:.1e} on {loops} loops")?,
        None => f.write_str("no loop bounds its defect")?,
    }
    match by_jacobian {
        Some(bound) => write!(f, ", and ≤ {bound:.1e} by the Jacobian."),
        None => f.write_str("."),
    }
}

/// Some of them by number.
pub(super) fn degrees_of_freedom(dofs: &[usize]) -> String {
    const NAMED: usize = 4;
    let named: Vec<String> = dofs.iter().take(NAMED).map(usize::to_string).collect();
    let further = match dofs.len().checked_sub(NAMED + 1) {
        Some(_) => format!(" and {} more", dofs.len() - NAMED),
        None => String::new(),
    };
    let plural = if dofs.len() == 1 { "degree" } else { "degrees" };
    format!("{plural} of freedom {}{further}", named.join(", "))
}
