//! The verdict, computed from the evidence.
//!
//! [`judge`] is the only place where anything is concluded. It calls no map.

mod advice;
mod cause;
mod diagnosis;
mod findings;
mod jacobian;
mod judge;
mod long_time;
mod order;
mod properties;
mod slope;
mod thresholds;

pub use crate::text::{plain_numbers, size as step_size_text};
pub use advice::Advice;
pub use cause::{Cause, CauseKind};
pub use diagnosis::{Diagnosis, measure};
pub use findings::*;
pub use jacobian::*;
pub use judge::judge;
pub use long_time::Growth;
pub use order::Fit;
pub use properties::{Property, PropertyName};

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// The four answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum VerdictKind {
    /// No defect was found, down to the stated number of digits.
    Symplectic,
    /// The map is discontinuous: it breaks loops.
    BrokenLoops,
    /// The loop integral changes significantly.
    NotSymplectic,
    /// The numbers do not decide.
    Undecided,
}

impl std::fmt::Display for VerdictKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            VerdictKind::Symplectic => "symplectic",
            VerdictKind::BrokenLoops => "broken-loops",
            VerdictKind::NotSymplectic => "not-symplectic",
            VerdictKind::Undecided => "undecided",
        })
    }
}

/// A verdict with the findings that led to it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Verdict {
    /// The answer.
    pub kind: VerdictKind,
    /// Digits to which the loop integral is conserved, if the verdict is symplectic.
    pub digits: Option<f64>,
    /// k of defect ~ h^k, if the defects have a trend that is a whole number within its uncertainty or 0.15.
    pub order: Option<f64>,
    /// Whether the loop integrals are conserved once breaks are closed, where loops are broken and that is
    /// known.
    pub conserved_once_closed: Option<bool>,
    /// The findings; the first decides.
    pub findings: Vec<Finding>,
    /// The likeliest cause, if the map fails and the evidence shows one.
    pub cause: Option<Cause>,
    /// What to do next.
    pub advice: Vec<Advice>,
    /// Power laws of the defects, loop by loop.
    pub fits: Vec<Fit>,
    /// Other properties of the map: those that were tested, or follow from the answer.
    pub properties: Vec<Property>,
}

/// A setting with more letters is not part of a headline. Conventional.
const MAX_LETTERS_OF_SETTING: usize = 60;

impl VerdictKind {
    /// The answer in words: `not symplectic`.
    pub fn words(self) -> &'static str {
        match self {
            VerdictKind::Symplectic => "symplectic",
            VerdictKind::BrokenLoops => "discontinuous",
            VerdictKind::NotSymplectic => "not symplectic",
            VerdictKind::Undecided => "inconclusive",
        }
    }
}

impl Verdict {
    /// The answer in a few words: `symplectic to 14.2 digits`, `not symplectic: ∮p·dq changes in proportion to h³`.
    pub fn headline(&self) -> String {
        let mut text = self.kind.words().to_owned();
        if let Some(cause) = &self.cause
            && let (Some(digits), Some(setting)) = (cause.digits, &cause.setting)
        {
            let setting = match setting.chars().count() > MAX_LETTERS_OF_SETTING {
                true if cause.kind == CauseKind::VelocitiesForMomenta => "other weights",
                true => "another form",
                false => setting,
            };
            return format!(
                "{text} in these variables, symplectic to {digits} digits with {setting}"
            );
        }
        if self.kind == VerdictKind::BrokenLoops {
            text += " (broken loops)";
        }
        if let Some(digits) = self.digits {
            text += &format!(" to {digits} digits");
        }
        match (self.kind, self.conserved_once_closed, self.order) {
            (VerdictKind::NotSymplectic, _, None) => text += ": ∮p·dq changes",
            (VerdictKind::NotSymplectic, _, Some(order)) => {
                let law = crate::text::power_of_h(order);
                text += &format!(": ∮p·dq changes in proportion to {law}");
            }
            (VerdictKind::BrokenLoops, Some(true), _) => {
                let straight = |finding: &Finding| {
                    matches!(
                        finding,
                        Finding::Breaks(BreakFinding::ClosedConserved { straight: true, .. })
                    )
                };
                text += match self.findings.iter().any(straight) {
                    true => ": ∮p·dq is conserved with breaks closed by chords",
                    false => ": ∮p·dq is conserved once breaks are closed",
                };
            }
            (VerdictKind::BrokenLoops, Some(false), _) => {
                text += ": ∮p·dq changes even with the breaks closed";
            }
            _ => {}
        }
        text
    }

    /// The deciding finding as a sentence.
    pub fn summary(&self) -> String {
        (self.findings.first()).map_or_else(String::new, Finding::to_string)
    }

    /// The other findings as sentences.
    pub fn sentences(&self) -> Vec<String> {
        self.findings
            .iter()
            .skip(1)
            .map(Finding::to_string)
            .collect()
    }

    /// The advice as sentences.
    pub fn advice(&self) -> Vec<String> {
        self.advice.iter().map(Advice::to_string).collect()
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}. {}", self.headline(), self.summary())
    }
}

/// A finding with its sentence, as reports carry it.
#[derive(Serialize)]
struct FindingWithText<'a> {
    #[serde(flatten)]
    finding: &'a Finding,
    text: String,
}

impl Serialize for Verdict {
    /// Findings with their numbers and sentences; `summary`, `sentences` and `advice` as sentences alone.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let findings: Vec<FindingWithText<'_>> = (self.findings.iter())
            .map(|finding| FindingWithText {
                finding,
                text: finding.to_string(),
            })
            .collect();
        let mut fields = serializer.serialize_struct("Verdict", 9)?;
        fields.serialize_field("kind", &self.kind)?;
        fields.serialize_field("digits", &self.digits)?;
        fields.serialize_field("order", &self.order)?;
        fields.serialize_field("conserved_once_closed", &self.conserved_once_closed)?;
        fields.serialize_field("summary", &self.summary())?;
        fields.serialize_field("findings", &findings)?;
        fields.serialize_field("sentences", &self.sentences())?;
        fields.serialize_field("cause", &self.cause)?;
        fields.serialize_field("advice", &self.advice())?;
        fields.end()
    }
}
