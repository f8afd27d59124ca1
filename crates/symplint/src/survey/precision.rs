//! Whether a map returns states of few digits: what it stores in single precision, rounds, or reads from print.
//!
//! Such a map is symplectic to its rounding at best, which a verdict of few digits does not explain.

use crate::evidence::{OutputFormat, OutputPrecision};
use crate::map::Grain;
use crate::signal::{BITS_OF_SINGLE, Digits, Format};
use crate::state::Ensemble;

/// The coarsest coordinate of a map whose numbers have no short format, or too few values to show one.
pub(crate) fn of_grain(grain: &Grain) -> Option<OutputPrecision> {
    let (c, unit) = grain.coarsest()?;
    Some(OutputPrecision {
        coordinate: ['q', 'p'][c / grain.dof()],
        dof: c % grain.dof(),
        format: OutputFormat::Multiples,
        unit,
    })
}

/// The digits of the coordinates of a few samples before and after a step.
pub(super) struct Precision {
    digits: Vec<[Digits; 4]>,
}

impl Precision {
    /// No samples yet.
    pub fn new(dof: usize) -> Self {
        Precision {
            digits: vec![[Digits::default(); 4]; dof],
        }
    }

    /// Takes in samples before and after the step.
    pub fn add(&mut self, before: &Ensemble, after: &Ensemble) {
        for (i, digits) in self.digits.iter_mut().enumerate() {
            let rows = [
                before.q().row(i),
                before.p().row(i),
                after.q().row(i),
                after.p().row(i),
            ];
            for (digits, row) in digits.iter_mut().zip(rows) {
                row.iter().for_each(|&value| digits.add(value));
            }
        }
    }

    /// Whether all samples came out at one state.
    pub fn is_one_state(&self) -> bool {
        let all = |digits: &[Digits; 4]| digits[2..].iter().all(Digits::is_one_value);
        self.digits.iter().all(all)
    }

    /// How coarsely the map rounds what it returns, if it does and no coordinate of the loop is like that: few
    /// digits before the step may make few after it.
    pub fn value(&self) -> Option<OutputPrecision> {
        let few_before =
            |digits: &[Digits; 4]| digits[..2].iter().any(|digits| digits.few().is_some());
        if self.digits.iter().any(few_before) {
            return None;
        }
        self.digits.iter().enumerate().find_map(|(dof, digits)| {
            let of = |c: usize| {
                let (format, unit) = digits[2 + c].few()?;
                Some(OutputPrecision {
                    coordinate: ['q', 'p'][c],
                    dof,
                    format: match format {
                        Format::Decimal(digits) => OutputFormat::Decimal { digits },
                        Format::Binary(BITS_OF_SINGLE) => OutputFormat::Single,
                        Format::Binary(digits) => OutputFormat::Binary { digits },
                    },
                    unit,
                })
            };
            of(1).or_else(|| of(0))
        })
    }
}
