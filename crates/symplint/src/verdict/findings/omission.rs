//! Omitted checks.

use std::fmt::{Display, Formatter, Result};

use crate::evidence::{Check, Omission, OmissionReason};
use crate::text::{loop_name, size};

impl Display for Omission {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let missing = match (self.check, &self.why) {
            (Check::GivenLoop, OmissionReason::Budget { missing }) => {
                Some(("step size", "", missing))
            }
            (Check::SampleSweep, OmissionReason::Budget { missing }) => {
                Some(("number", " of samples", missing))
            }
            (Check::RandomLoops, OmissionReason::Budget { missing }) => {
                Some(("random loop", "", missing))
            }
            _ => None,
        };
        if let Some((what, of, missing)) = missing {
            let (plural, were) = match missing {
                1 => ("", "was"),
                _ => ("s", "were"),
            };
            return write!(
                f,
                "{missing} {what}{plural}{of} {were} not tried: the budget was too small."
            );
        }
        let left_out = self.check.left_out();
        match &self.why {
            OmissionReason::Budget { .. } => write!(f, "{left_out}: the budget was too small."),
            OmissionReason::Unresolved => {
                write!(
                    f,
                    "The samples do not resolve {} to rounding error: the budget was too small.",
                    loop_name(0)
                )
            }
            OmissionReason::Memory { samples } => {
                write!(
                    f,
                    "{left_out}: ensembles of {samples} samples would take more than 512 MiB."
                )
            }
            OmissionReason::Failed {
                step_size: Some(h),
                reason,
            } => write!(f, "The step size h = {} was left out: {reason}.", size(*h)),
            OmissionReason::Failed { reason, .. } => write!(f, "{left_out}: {reason}."),
        }
    }
}
