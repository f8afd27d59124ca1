//! The rules that configurations may name.

use symplint::Rule;
use symplint::rules::{Cutoffs, Piecewise, Streaming};

/// A rule that configurations may name.
pub struct RuleInfo {
    /// Its name, that of its kind.
    pub name: &'static str,
    /// What `symplint list rules` says of it.
    pub summary: &'static str,
    /// The rule with the settings of `[diagnostic]`.
    pub make: fn(&RuleSettings) -> Rule,
}

/// What `[diagnostic]` says about rules.
pub struct RuleSettings {
    /// cutoff_q, cutoff_p.
    pub cutoffs: Cutoffs,
    /// tolerance, closure.
    pub piecewise: Piecewise,
    /// half_width.
    pub streaming: Streaming,
}

/// Every rule, the default first.
pub const RULES: &[RuleInfo] = &[
    RuleInfo {
        name: "auto",
        summary: "Pseudospectral; piecewise where the advanced loop is broken or has kinks; streaming where ensembles \
                  do not fit into memory. The default.",
        make: |_| Rule::Auto,
    },
    RuleInfo {
        name: "pseudospectral",
        summary: "Differentiates q by Fourier transform (paper, section 2.3 and appendix A). Exact to round-off on \
                  smooth loops; on loops with kinks the error is a power of the number of samples.",
        make: |_| Rule::Pseudospectral,
    },
    RuleInfo {
        name: "piecewise",
        summary: "Chebyshev interpolation between the breaks, each of which is located and closed. For broken loops \
                  and loops with kinks, nearly to round-off.",
        make: |settings| Rule::Piecewise(settings.piecewise),
    },
    RuleInfo {
        name: "streaming",
        summary: "Differences of order 20 along the loop, of samples that are made, advanced and dropped one after \
                  another. For ensembles that do not fit into memory: a few dozen states are kept.",
        make: |settings| Rule::Streaming(settings.streaming),
    },
    RuleInfo {
        name: "finite-difference",
        summary: "Increments of q over the cells that the cut-offs keep (paper, appendix B). For broken loops as in \
                  the paper, to a few digits.",
        make: |settings| Rule::FiniteDifference(settings.cutoffs),
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::KEYS;

    #[test]
    fn each_has_the_name_of_its_kind_and_stands_in_the_key() {
        let key = KEYS.iter().find(|key| key.name == "rule").unwrap();
        for info in RULES {
            let settings = RuleSettings {
                cutoffs: Cutoffs::none(),
                piecewise: Piecewise::default(),
                streaming: Streaming::default(),
            };
            assert_eq!((info.make)(&settings).kind().name(), info.name);
            assert!(
                key.help.contains(&format!("\"{}\"", info.name)),
                "{}",
                info.name
            );
        }
    }
}
