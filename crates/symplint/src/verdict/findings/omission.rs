//! Omitted checks.

use std::fmt::{Display, Formatter, Result};

use super::plural;
use crate::evidence::{Check, Omission, Why};
use crate::text::{loop_name, size};

impl Display for Omission {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let missing = match (self.check, &self.why) {
            (Check::GivenLoop, Why::Budget { missing }) => Some(("step size", "", missing)),
            (Check::SampleSweep, Why::Budget { missing }) => {
                Some(("number", " of samples", missing))
            }
            (Check::RandomLoops, Why::Budget { missing }) => Some(("random loop", "", missing)),
            _ => None,
        };
        if let Some((what, of, missing)) = missing {
            let plural = plural(*missing);
            return write!(
                f,
                "The budget was spent before {missing} {what}{plural}{of} could be tried."
            );
        }
        let left_out = self.check.left_out();
        match &self.why {
            Why::Budget { .. } => write!(f, "{left_out}: the budget was spent."),
            Why::Unresolved => {
                let name = loop_name(0);
                write!(
                    f,
                    "The budget was spent before {name} was resolved to round-off."
                )
            }
            Why::Memory { samples } => {
                write!(
                    f,
                    "{left_out}: ensembles of {samples} samples would take more than 512 MiB."
                )
            }
            Why::Failed {
                step_size: Some(h),
                reason,
            } => write!(f, "The step size h = {} was left out: {reason}.", size(*h)),
            Why::Failed { reason, .. } => write!(f, "{left_out}: {reason}."),
        }
    }
}
