//! The conclusion: every C⁰ family of shapes breaks loops, whatever its degree; smoother ones do not.

use serde::Serialize;
use symplint::{Diagnostic, VerdictKind};
use symplint_plasma::pic::ShapeFamily;
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::pic::{MAX_PARTICLES, SEED, plasma};
use super::settings::{Key, Settings};
use super::sweep::step_of;

pub const ITEM: Item = Item {
    id: "families",
    title: "particle-in-cell: B-splines against C⁰ Lagrange shapes (conclusion)",
    cost: "1 s",
    keys: &[
        Key::whole_between("particles", 2, (1, MAX_PARTICLES), "number of particles"),
        SEED,
    ],
    check: None,
    run,
};

#[derive(Serialize)]
struct Row {
    family: &'static str,
    degree: usize,
    verdict: String,
    summary: String,
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let particles = settings.count("particles");
    let seed = settings.whole("seed");
    let mut rows = Vec::new();
    let mut wrong = 0;
    for (family, degrees) in [
        (ShapeFamily::BSpline, 1..=5),
        (ShapeFamily::Lagrange, 1..=3),
    ] {
        for degree in degrees {
            let plasma = plasma("two-stream", particles, family, degree, 0, seed)?;
            let map = step_of("strang", "position-first", &plasma.system)?;
            let diagnostic = Diagnostic::halving(-1, -4);
            let verdict = diagnostic.run(&*map, &plasma.circle)?.verdict;
            let smooth = family == ShapeFamily::BSpline && degree > 1;
            let expected = if smooth {
                VerdictKind::Symplectic
            } else {
                VerdictKind::BrokenLoops
            };
            wrong += usize::from(verdict.kind != expected);
            rows.push(Row {
                family: family.name(),
                degree,
                verdict: verdict.headline(),
                summary: verdict.summary(),
            });
        }
    }
    folder.write_csv("families.csv", &rows)?;
    let found: Vec<String> = (rows.iter())
        .map(|row| format!("{} {}: {}", row.family, row.degree, row.verdict))
        .collect();
    Ok(vec![Claim {
        item: "families",
        origin: Origin::Paper,
        place: "section 6",
        says: "shapes that are not C¹ break loops at any degree; B-splines of degree 2 and more do not".into(),
        measured: found.join("; "),
        judgement: Judgement::of(wrong == 0),
    }])
}
