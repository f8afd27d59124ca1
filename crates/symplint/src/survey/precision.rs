//! Whether a map returns states of few digits: what it stores in single precision, rounds, or reads from print.
//!
//! Such a map is symplectic to its rounding at best, which a verdict of few digits does not explain.

use crate::evidence::{OutputFormat, OutputPrecision};
use crate::state::Ensemble;

/// Decimal digits that doubles do not have by accident: of 64 random ones, none has so few.
const FEW: u8 = 10;

/// Different values that are needed to tell.
const ENOUGH: u32 = 16;

/// The digits of all values of a coordinate so far.
#[derive(Clone, Copy)]
struct Digits {
    /// Decimal digits that are enough for all of them; more than [`FEW`] if that is not so.
    decimal: u8,
    /// Whether all are numbers of single precision.
    single: bool,
    largest: f64,
    /// One of 64 bits for each value, by its hash: as many different ones, at least. There may be millions of
    /// coordinates.
    seen: u64,
}

impl Default for Digits {
    fn default() -> Self {
        Digits {
            decimal: 1,
            single: true,
            largest: 0.0,
            seen: 0,
        }
    }
}

impl Digits {
    fn add(&mut self, value: f64) {
        while self.decimal <= FEW && !has_digits(value, self.decimal.into()) {
            self.decimal += 1;
        }
        self.single &= f64::from(value as f32) == value;
        self.largest = self.largest.max(value.abs());
        // The fractional part of a multiple of the golden ratio spreads neighbours.
        self.seen |= 1 << (value.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 58);
    }

    /// The format, and how far apart neighbouring values are, if their digits are few.
    fn few(&self) -> Option<(OutputFormat, f64)> {
        if self.seen.count_ones() < ENOUGH {
            return None;
        }
        if self.decimal <= FEW {
            let digits = usize::from(self.decimal);
            let unit = 10f64.powi(self.largest.log10().floor() as i32 + 1 - digits as i32);
            return Some((OutputFormat::Decimal { digits }, unit));
        }
        let unit = self.largest * f64::from(f32::EPSILON);
        self.single.then_some((OutputFormat::Single, unit))
    }
}

/// Whether a number is a decimal of so many digits, but for the rounding of a product or quotient.
fn has_digits(value: f64, digits: usize) -> bool {
    let rounded: f64 = format!("{value:.*e}", digits - 1)
        .parse()
        .unwrap_or(f64::NAN);
    (rounded - value).abs() <= 2.0 * f64::EPSILON * value.abs()
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
                    format,
                    unit,
                })
            };
            of(1).or_else(|| of(0))
        })
    }
}
