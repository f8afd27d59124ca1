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
    /// Cannot be told with these settings: they do not cover what the claim is about, or the samples do not
    /// resolve the loops.
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

    /// This judgement where the numbers can carry one.
    pub fn if_resolved(self, resolved: bool) -> Self {
        if resolved {
            self
        } else {
            Judgement::Unresolved
        }
    }

    /// Holds if all of the interval lies within the `wanted` one, does not if nothing of it does, and
    /// cannot be judged if a part does or an end is not a number.
    pub fn of_interval((low, high): (f64, f64), wanted: (f64, f64)) -> Self {
        if low >= wanted.0 && high <= wanted.1 {
            Judgement::Holds
        } else if high < wanted.0 || low > wanted.1 {
            Judgement::DoesNotHold
        } else {
            Judgement::Unresolved
        }
    }

    /// This judgement, or where it says no, what is found of the claim with a correction.
    pub fn or_corrected(self, corrected: Self) -> Self {
        match (self, corrected) {
            (Judgement::DoesNotHold, Judgement::Holds) => Judgement::HoldsCorrected,
            (Judgement::DoesNotHold, other) => other,
            (said, _) => said,
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

/// Who claims it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The paper.
    Paper,
    /// Nobody: a check of this program that the paper does not make.
    Beyond,
}

/// A quantitative claim.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// Item that judged it.
    pub item: &'static str,
    /// Who claims it.
    pub origin: Origin,
    /// The place of the statement.
    pub place: &'static str,
    /// The statement.
    pub says: String,
    /// The measured value, and how it was measured.
    pub measured: String,
    /// The judgement.
    pub judgement: Judgement,
}

impl Claim {
    /// A claim of the paper.
    pub fn of_paper(
        item: &'static str,
        place: &'static str,
        says: impl Into<String>,
        measured: impl Into<String>,
        judgement: Judgement,
    ) -> Self {
        Claim {
            item,
            origin: Origin::Paper,
            place,
            says: says.into(),
            measured: measured.into(),
            judgement,
        }
    }

    /// This claim, judged only where the measured numbers can carry a judgement.
    pub fn resolved_if(self, resolved: bool) -> Self {
        Claim {
            judgement: self.judgement.if_resolved(resolved),
            ..self
        }
    }
}

/// The tables: what they list, their titles in Markdown and their names on the terminal.
const TABLES: [(Origin, &str, &str); 2] = [
    (Origin::Paper, "Claims of the paper", "claims"),
    (
        Origin::Beyond,
        "Checks beyond the paper",
        "checks beyond the paper",
    ),
];

/// All claims as Markdown tables, the paper's before the checks beyond it.
pub fn claims_markdown(claims: &[Claim]) -> String {
    let mut text = String::new();
    for (origin, title, _) in TABLES {
        let rows: Vec<&Claim> = (claims.iter()).filter(|c| c.origin == origin).collect();
        if rows.is_empty() {
            continue;
        }
        if !text.is_empty() {
            text.push('\n');
        }
        let _ = write!(
            text,
            "# {title}\n\n| item | where | what it says | measured | judgement |\n|---|---|---|---|---|\n"
        );
        for claim in rows {
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
    }
    text
}

/// Text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A summary for the terminal: the number of claims by judgement and, unless `counts_only`, the claims that do not hold as they are
/// stated.
pub fn claims_summary(claims: &[Claim], counts_only: bool) -> String {
    let mut lines = Vec::new();
    for (origin, _, name) in TABLES {
        let rows: Vec<&Claim> = (claims.iter()).filter(|c| c.origin == origin).collect();
        if rows.is_empty() {
            continue;
        }
        let count = |judgement| rows.iter().filter(|c| c.judgement == judgement).count();
        lines.push(format!(
            "{name}: {}; hold: {}, with a correction: {}, fail: {}, not resolved: {}",
            rows.len(),
            count(Judgement::Holds),
            count(Judgement::HoldsCorrected),
            count(Judgement::DoesNotHold),
            count(Judgement::Unresolved)
        ));
        let is_told = |claim: &&&Claim| !counts_only && claim.judgement != Judgement::Holds;
        for claim in rows.iter().filter(is_told) {
            lines.push(format!(
                "  · {} ({}): {}\n    measured: {}",
                claim.judgement.text(),
                claim.place,
                claim.says,
                claim.measured
            ));
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_reach_over_an_end_decide_nothing() {
        let of = |low, high| Judgement::of_interval((low, high), (1.0, 10.0));
        assert_eq!(of(2.0, 3.0), Judgement::Holds);
        assert_eq!(of(11.0, f64::INFINITY), Judgement::DoesNotHold);
        assert_eq!(of(9.0, 11.0), Judgement::Unresolved);
        assert_eq!(of(f64::NAN, f64::NAN), Judgement::Unresolved);
        let no = Judgement::DoesNotHold;
        assert_eq!(no.or_corrected(of(2.0, 3.0)), Judgement::HoldsCorrected);
        assert_eq!(no.or_corrected(of(0.0, 3.0)), Judgement::Unresolved);
        assert_eq!(of(0.0, 3.0).or_corrected(no), Judgement::Unresolved);
    }

    #[test]
    fn checks_beyond_the_paper_have_their_own_table() {
        let of = |origin, says: &str| Claim {
            origin,
            ..Claim::of_paper("fig1", "here", says, "1 | 2", Judgement::Holds)
        };
        let text = claims_markdown(&[of(Origin::Beyond, "ours"), of(Origin::Paper, "theirs")]);
        let (theirs, title) = (text.find("theirs"), text.find("# Checks beyond the paper"));
        assert!(theirs < title && title < text.find("ours"), "{text}");
        assert!(text.contains("1 \\| 2"), "{text}");
        let only = claims_markdown(&[of(Origin::Paper, "theirs")]);
        assert!(!only.contains("beyond"), "{only}");
    }
}
