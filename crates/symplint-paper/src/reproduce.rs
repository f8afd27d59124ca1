//! Running items in parallel, and the tables of their claims.

use rayon::prelude::*;
use symplint::verdict::plain_numbers;
use symplint_report::provenance::Run;
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, claims_markdown};
use super::error::PaperError;
use super::item::Item;
use super::settings::Settings;

/// What happens while items are reproduced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The item of this name begins.
    Started(&'static str),
    /// It has ended.
    Finished(&'static str),
}

/// Reproduces items with their settings: figures and data, `claims.json` and `claims.md` go into the folder.
/// The second ends with the provenance of `run`.
///
/// `progress` is called from several threads.
///
/// # Errors
/// The first failure of an item. What other items had written is left there.
pub fn reproduce(
    items: &[(&'static Item, Settings)],
    folder: &RunFolder,
    run: &Run,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Vec<Claim>, PaperError> {
    // Beside each other: drawing and writing of one fill the gaps of another.
    let claims: Vec<Vec<Claim>> = (items.par_iter())
        .map(|(item, settings)| {
            progress(Progress::Started(item.id));
            let mut claims = (item.run)(settings, folder)?;
            for claim in &mut claims {
                claim.measured = plain_numbers(&claim.measured);
            }
            progress(Progress::Finished(item.id));
            Ok(claims)
        })
        .collect::<Result<_, PaperError>>()?;
    let claims = claims.concat();
    folder.write_json("claims.json", &claims)?;
    let mut provenance = run.provenance(rayon::current_num_threads());
    for (item, settings) in items {
        if item.keys.iter().any(|key| key.name == "seed") {
            let seed = settings.whole("seed");
            provenance.seeds.insert(format!("{}.seed", item.id), seed);
        }
    }
    let text = format!(
        "{}\n# Provenance\n\n{}",
        claims_markdown(&claims),
        provenance.markdown()
    );
    folder.write_text("claims.md", &text)?;
    Ok(claims)
}
