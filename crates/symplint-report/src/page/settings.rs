//! Settings that follow advice, ready to copy.

use symplint::Diagnosis;
use symplint::evidence::Origin;
use symplint::verdict::{Advice, step_size_text};

/// How a reader repeats the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeat<'a> {
    /// By this command, to which `--set` may be added.
    Command(&'a str),
    /// By the function `check` of Python with other arguments.
    Python,
    /// It measured files, which settings do not change.
    Files,
}

/// Step sizes of a suggested sweep.
const SUGGESTED_SIZES: i32 = 4;

impl Repeat<'_> {
    /// The run again as the advice says, as a command or an expression; `None` if the advice needs more than a setting.
    pub(super) fn with(self, advice: &Advice, diagnosis: &Diagnosis) -> Option<String> {
        if diagnosis.evidence.origin == Origin::Samples {
            return None;
        }
        let (section, key, value) = setting(advice, diagnosis)?;
        match self {
            Repeat::Command(command) => {
                let setting = format!("{section}.{key}={value}");
                let is_word = !setting.contains([' ', '[', '"']);
                let quote = if is_word { "" } else { "'" };
                Some(format!("{command} --set {quote}{setting}{quote}"))
            }
            Repeat::Python => Some(format!("symplint.check(…, {key}={value})")),
            Repeat::Files => None,
        }
    }
}

/// Section, key and value of the setting.
fn setting(advice: &Advice, diagnosis: &Diagnosis) -> Option<(&'static str, &'static str, String)> {
    match advice {
        Advice::MoreEvaluations { wanted } => {
            let budget = diagnosis.evidence.evaluations.budget;
            let enough = round_up(budget.saturating_add(*wanted));
            Some(("diagnostic", "budget", enough.to_string()))
        }
        Advice::ContractibleLoops | Advice::MoreLoops => Some(("diagnostic", "loops", "8".into())),
        Advice::RuleAuto => Some(("diagnostic", "rule", "\"auto\"".into())),
        Advice::BalancedRadii { .. } => Some(("loop", "radius", "\"auto\"".into())),
        Advice::LargerSteps {
            factor: Some(factor),
            step_size: Some(h),
        } => {
            let sizes = (0..SUGGESTED_SIZES).map(|k| step_size_text(factor * h / 2f64.powi(k)));
            let sizes: Vec<String> = sizes.collect();
            Some((
                "diagnostic",
                "step_sizes",
                format!("[{}]", sizes.join(", ")),
            ))
        }
        _ => None,
    }
}

/// The next number of two digits and zeros.
fn round_up(count: usize) -> usize {
    let unit = 10usize.pow(count.max(1).ilog10().saturating_sub(1));
    count.div_ceil(unit).saturating_mul(unit)
}

#[cfg(test)]
mod tests {
    use symplint::{Circle, Diagnostic, PerSample};

    use super::*;

    #[test]
    fn advice_is_a_command_or_an_argument() {
        let map = PerSample::new(1, |h, q, p| {
            p[0] -= h * q[0].sin();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.3], vec![0.2], 0.5).unwrap();
        let diagnostic = Diagnostic {
            budget: Some(2000),
            ..Diagnostic::halving(-1, -3)
        };
        let diagnosis = diagnostic.run(&map, &circle).unwrap();
        let command = Repeat::Command("symplint check c.toml");
        for (advice, expected, python) in [
            (
                Advice::MoreEvaluations { wanted: 1_234 },
                "symplint check c.toml --set diagnostic.budget=3300",
                "symplint.check(…, budget=3300)",
            ),
            (
                Advice::LargerSteps {
                    factor: Some(8.0),
                    step_size: Some(0.5),
                },
                "symplint check c.toml --set 'diagnostic.step_sizes=[4, 2, 1, 0.5]'",
                "symplint.check(…, step_sizes=[4, 2, 1, 0.5])",
            ),
            (
                Advice::BalancedRadii { imbalance: 9.0 },
                "symplint check c.toml --set 'loop.radius=\"auto\"'",
                "symplint.check(…, radius=\"auto\")",
            ),
        ] {
            assert_eq!(command.with(&advice, &diagnosis).unwrap(), expected);
            assert_eq!(Repeat::Python.with(&advice, &diagnosis).unwrap(), python);
            assert_eq!(Repeat::Files.with(&advice, &diagnosis), None);
        }
        assert_eq!(command.with(&Advice::MeasureLoop, &diagnosis), None);
    }

    #[test]
    fn budgets_have_two_digits() {
        assert_eq!(
            [1, 42, 1_001, 20_000, 123_456].map(round_up),
            [1, 42, 1_100, 20_000, 130_000]
        );
    }
}
