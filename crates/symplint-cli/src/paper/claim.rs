//! Claims of the paper, judged from measured numbers.

use std::fmt::Write;

use serde::Serialize;

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
    /// Cannot be told with these settings: the samples do not resolve the loops.
    Unresolved,
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
            Judgement::Unresolved => "not resolved",
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

/// A summary for the terminal: how many hold, and which do not as they are said.
pub fn claims_summary(claims: &[Claim]) -> String {
    let count = |judgement| {
        claims
            .iter()
            .filter(|claim| claim.judgement == judgement)
            .count()
    };
    let mut text = format!(
        "claims: {}; hold: {}, with a correction: {}, do not: {}, not resolved: {}",
        claims.len(),
        count(Judgement::Holds),
        count(Judgement::HoldsCorrected),
        count(Judgement::DoesNotHold),
        count(Judgement::Unresolved)
    );
    for claim in claims
        .iter()
        .filter(|claim| claim.judgement != Judgement::Holds)
    {
        let _ = write!(
            text,
            "\n  · {} ({}): {}\n    measured: {}",
            claim.judgement.text(),
            claim.place,
            claim.says,
            claim.measured
        );
    }
    text
}
