//! Whether a map returns states of few digits: what it stores in single precision, rounds, or reads from print.
//!
//! Such a map is symplectic to its rounding at best, and nobody would think of that from a verdict of few digits.

use crate::loops::Loop;
use crate::map::Evaluator;
use crate::state::Ensemble;
use crate::verdict::{Verdict, VerdictKind};

/// Decimal digits that nobody rounds to by chance: of 64 doubles, not one has so few.
const FEW: usize = 10;

/// Different values that it takes to tell.
const ENOUGH: u32 = 16;

/// The digits of all values of a coordinate so far.
#[derive(Clone, Copy)]
struct Digits {
    /// Decimal digits that are enough for all of them; more than [`FEW`] if that is not so.
    decimal: usize,
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
        while self.decimal <= FEW && !has_digits(value, self.decimal) {
            self.decimal += 1;
        }
        self.single &= f64::from(value as f32) == value;
        self.largest = self.largest.max(value.abs());
        // The fractional part of a multiple of the golden ratio spreads neighbours.
        self.seen |= 1 << (value.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 58);
    }

    /// In words, and how far apart neighbouring values are, if they are few.
    fn few(&self) -> Option<(String, f64)> {
        if self.seen.count_ones() < ENOUGH {
            return None;
        }
        if self.decimal <= FEW {
            let unit = 10f64.powi(self.largest.log10().floor() as i32 + 1 - self.decimal as i32);
            let text = format!("has no more than {} decimal digits", self.decimal);
            return Some((text, unit));
        }
        let text = "is a number of single precision";
        (self.single).then(|| (text.into(), self.largest * f64::from(f32::EPSILON)))
    }
}

/// Whether a number is a decimal of so many digits, but for the rounding of a product or quotient.
fn has_digits(value: f64, digits: usize) -> bool {
    let rounded: f64 = format!("{value:.*e}", digits - 1)
        .parse()
        .unwrap_or(f64::NAN);
    (rounded - value).abs() <= 2.0 * f64::EPSILON * value.abs()
}

/// Adds to the verdict that the map rounds what it returns, if it does and no coordinate of the loop is like
/// that: few digits before the step may make few after it.
///
/// A map that fails at one of the samples looked at, which need not be those of the verdict, is not accused.
pub(crate) fn own_up(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    verdict: &mut Verdict,
) {
    const SAMPLES: usize = 64;
    let dof = phase_loop.dof();
    let mut digits = vec![[Digits::default(); 4]; dof];
    let looked = Ensemble::in_parts(phase_loop, SAMPLES, |before| {
        let mut after = before.clone();
        evaluator.advance(&mut after, h)?;
        for (i, digits) in digits.iter_mut().enumerate() {
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
        Ok(())
    });
    let few_before = |digits: &[Digits; 4]| digits[..2].iter().any(|digits| digits.few().is_some());
    if looked.is_err() || digits.iter().any(few_before) {
        return;
    }
    let found = digits.iter().enumerate().find_map(|(i, digits)| {
        let of = |c: usize| Some((["q", "p"][c], i, digits[2 + c].few()?));
        of(1).or_else(|| of(0))
    });
    if let Some((name, dof, (what, unit))) = found {
        verdict.evidence.push(format!(
            "After the step {name} of degree of freedom {dof} {what}, at every sample: the map rounds what it \
             returns, to about {unit:.0e}. Its states are no better than that, whatever their average, the loop \
             integral, is good to."
        ));
        if verdict.kind != VerdictKind::NotSymplectic {
            verdict.advice.push(
                "Return states in double precision, unrounded (17 digits, if they are printed), to learn more."
                    .into(),
            );
        }
    }
}
