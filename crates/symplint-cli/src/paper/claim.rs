//! Claims of the paper, judged from measured numbers.

use std::fmt::Write;

use serde::Serialize;

use crate::output::plain_table;

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// As the paper says.
    Holds,
    /// Not as it says, but with the correction given.
    HoldsCorrected,
    /// Not.
    DoesNotHold,
}

impl Judgement {
    /// Holds, or does not.
    pub fn of(holds: bool) -> Self {
        if holds {
            Judgement::Holds
        } else {
            Judgement::DoesNotHold
        }
    }

    /// Holds as said; or else with a correction; or else not.
    pub fn with_correction(as_said: bool, corrected: bool) -> Self {
        match (as_said, corrected) {
            (true, _) => Judgement::Holds,
            (false, true) => Judgement::HoldsCorrected,
            (false, false) => Judgement::DoesNotHold,
        }
    }

    fn text(self) -> &'static str {
        match self {
            Judgement::Holds => "holds",
            Judgement::HoldsCorrected => "holds, corrected",
            Judgement::DoesNotHold => "does not hold",
        }
    }
}

/// A quantitative claim.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// Item that judged it.
    pub item: &'static str,
    /// Where the paper says it.
    pub place: &'static str,
    /// What it says.
    pub says: String,
    /// What was measured, and how.
    pub measured: String,
    /// The judgement.
    pub judgement: Judgement,
}

/// All claims as a Markdown table.
pub fn claims_markdown(claims: &[Claim]) -> String {
    let mut text = String::from(
        "# Claims of the paper\n\n| item | where | what it says | measured | judgement |\n|---|---|---|---|---|\n",
    );
    let cell = |text: &str| text.replace('|', "\\|");
    for claim in claims {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} |",
            claim.item,
            claim.place,
            cell(&claim.says),
            cell(&claim.measured),
            claim.judgement.text()
        );
    }
    text
}

/// All claims for the terminal.
pub fn claims_table(claims: &[Claim]) -> String {
    let rows = (claims.iter())
        .map(|claim| {
            vec![
                claim.item.to_owned(),
                claim.says.clone(),
                claim.measured.clone(),
                claim.judgement.text().to_owned(),
            ]
        })
        .collect();
    plain_table(&["item", "the paper says", "measured", "judgement"], rows)
}
