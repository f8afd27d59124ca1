//! What the census says, as claims that numbers decide.

use symplint::VerdictKind;

use super::ITEM;
use super::judged::Judged;
use super::schemes::Family;
use crate::claim::{Claim, Judgement, Origin};

/// All of them.
pub fn claims(rows: &[Judged]) -> Vec<Claim> {
    let of = |family: Family| rows.iter().filter(move |row| row.family == family);
    let claim = |says: &str, measured: String, holds: bool| Claim {
        item: ITEM.id,
        origin: Origin::Beyond,
        place: "census",
        says: says.into(),
        measured,
        judgement: Judgement::of(holds),
    };
    let verdicts = |family: Family| {
        let of_degrees =
            of(family).map(|row| format!("{} {}", row.record.degree, row.record.verdict));
        of_degrees.collect::<Vec<_>>().join("; ")
    };
    let breaks_below = |family: Family, smooth: usize| {
        of(family).all(|row| match row.record.degree < smooth {
            true => {
                row.kind == VerdictKind::BrokenLoops && row.record.closed_conserved == Some(true)
            }
            false => row.kind == VerdictKind::Symplectic,
        })
    };
    let textbook = Family::Textbook;
    vec![
        claim(
            "the textbook momentum-conserving scheme is not symplectic, whatever the shape: its force is no gradient",
            verdicts(textbook),
            of(textbook).all(|row| match row.record.degree {
                0 => {
                    row.kind == VerdictKind::BrokenLoops
                        && row.record.closed_conserved != Some(true)
                }
                _ => {
                    row.kind == VerdictKind::NotSymplectic
                        && row
                            .record
                            .order
                            .is_some_and(|order| (order - 1.0).abs() < 0.3)
                }
            }),
        ),
        claim(
            "it conserves the momentum",
            format!(
                "to {:.0e}",
                worst(of(textbook), |row| row.record.momentum_change)
            ),
            worst(of(textbook), |row| row.record.momentum_change) < 1e-12,
        ),
        claim(
            "Lewis' scheme breaks loops with linear charges, whose force is that of the nearest grid point, and is \
             symplectic with quadratic and cubic ones",
            verdicts(Family::Lewis),
            breaks_below(Family::Lewis, 2),
        ),
        claim(
            "the geometric splitting breaks loops at p = 1 and is symplectic above",
            verdicts(Family::Geometric("strang")),
            breaks_below(Family::Geometric("strang"), 2),
        ),
    ]
}

fn worst<'a>(rows: impl Iterator<Item = &'a Judged>, of: impl Fn(&Judged) -> f64) -> f64 {
    rows.map(of).fold(0.0, f64::max)
}
