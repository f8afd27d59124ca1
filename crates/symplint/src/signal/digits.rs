//! How many digits some numbers have.

/// Formats of numbers with few digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Decimal numbers of this number of significant digits.
    Decimal(usize),
    /// Binary numbers of this number of significant digits: 24 are single precision.
    Binary(usize),
}

/// Binary digits of single precision.
pub(crate) const BITS_OF_SINGLE: usize = 24;

/// Two results for one state that are more than this many roundings of single precision apart do not differ by rounding of any arithmetic in
/// use, but by random numbers, or as a solver does that starts at random. Sums add up some roundings. Conventional.
pub(crate) const MAX_ROUNDINGS_OF_SINGLE: f64 = 4.0;

/// Decimal digits that doubles do not have by accident: of 64 random ones, none has so few.
const FEW_DIGITS: u8 = 10;

/// Binary digits that doubles do not have by accident: arithmetic of fewer digits gives no more than these.
pub(crate) const FEW_BITS: i32 = 40;

/// Different values that are needed to tell.
const MIN_VALUES: u32 = 16;

/// The digits of all values of a coordinate so far.
#[derive(Clone, Copy)]
pub(crate) struct Digits {
    /// Decimal digits that are enough for all of them; more than [`FEW_DIGITS`] if that is not so.
    decimal: u8,
    /// The exponent of the power of ten of which all of them are multiples, as far as it is above that of [`FEW_DIGITS`]
    /// digits of the largest, while those are enough.
    place: i16,
    /// Binary digits that are enough for all of them.
    bits: i16,
    /// The exponent of the power of two of which all of them are multiples.
    lowest: i16,
    largest: f64,
    /// One of 64 bits for each value, by its hash: as many different ones, at least. There may be millions of
    /// coordinates.
    seen: u64,
}

impl Default for Digits {
    fn default() -> Self {
        Digits {
            decimal: 1,
            place: i16::MAX,
            bits: 0,
            lowest: i16::MAX,
            largest: 0.0,
            seen: 0,
        }
    }
}

impl Digits {
    pub fn add(&mut self, value: f64) {
        if self.decimal <= FEW_DIGITS {
            self.add_decimal(value);
        }
        let (lowest, bits) = binary(value);
        self.lowest = self.lowest.min(lowest);
        self.bits = self.bits.max(bits);
        self.largest = self.largest.max(value.abs());
        // The fractional part of a multiple of the golden ratio spreads neighbours.
        self.seen |= 1 << (value.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 58);
    }

    fn add_decimal(&mut self, value: f64) {
        // Most doubles have more digits, which one test shows.
        if !has_digits(value, FEW_DIGITS.into()) {
            self.decimal = FEW_DIGITS + 1;
            return;
        }
        while !has_digits(value, self.decimal.into()) {
            self.decimal += 1;
        }
        if value != 0.0 {
            let size = value.abs().log10().floor() as i16;
            self.place = self.place.min(size);
            while self.place > size - i16::from(FEW_DIGITS) && !is_multiple(value, self.place) {
                self.place -= 1;
            }
        }
    }

    /// The format, and how far apart neighbouring values are, if their digits are few.
    pub fn few(&self) -> Option<(Format, f64)> {
        if !(self.largest > 0.0 && self.largest.is_finite()) {
            return None;
        }
        if self.seen.count_ones() < MIN_VALUES {
            return None;
        }
        let first = self.largest.log10().floor() as i16;
        // A fixed number of decimals has as many digits as are needed in its largest number, and no more.
        let fixed = i64::from(first) + 1 - i64::from(self.place);
        if self.decimal <= FEW_DIGITS && (1..=i64::from(self.decimal)).contains(&fixed) {
            let unit = 10f64.powi(self.place.into());
            return Some((Format::Decimal(fixed as usize), unit));
        }
        if self.decimal <= FEW_DIGITS {
            let digits = usize::from(self.decimal);
            let unit = 10f64.powi(i32::from(first) + 1 - digits as i32);
            return Some((Format::Decimal(digits), unit));
        }
        // As of decimals: numbers on a lattice have as many digits as the largest one needs.
        let on_lattice = i64::from(first_bit(self.largest)) + 1 - i64::from(self.lowest);
        let (digits, unit) = match on_lattice <= i64::from(self.bits) {
            true => (on_lattice, 2f64.powi(self.lowest.into())),
            false => {
                let bits = i32::from(self.bits);
                (i64::from(bits), self.largest * 2f64.powi(1 - bits))
            }
        };
        (1..=i64::from(FEW_BITS))
            .contains(&digits)
            .then_some((Format::Binary(digits as usize), unit))
    }

    /// Whether all of them are one number, as far as hashes show it.
    pub fn is_one_value(&self) -> bool {
        self.seen.count_ones() <= 1
    }
}

/// The exponent of the first binary digit of a number that is not 0.
fn first_bit(value: f64) -> i16 {
    let (lowest, digits) = binary(value);
    lowest.saturating_add(digits - 1)
}

/// Binary digits of a number; 0 of 0.
pub(crate) fn binary_digits(value: f64) -> i32 {
    binary(value).1.into()
}

/// The exponent of the last binary digit of a number that is not 0, and how many digits it has.
fn binary(value: f64) -> (i16, i16) {
    if value == 0.0 || !value.is_finite() {
        return (i16::MAX, 0);
    }
    let bits = value.to_bits();
    let (exponent, fraction) = ((bits >> 52 & 0x7FF) as i16, bits & ((1 << 52) - 1));
    let (exponent, significand) = match exponent {
        0 => (-1074, fraction),
        _ => (exponent - 1075, fraction | 1 << 52),
    };
    let zeros = significand.trailing_zeros() as i16;
    let digits = 64 - significand.leading_zeros() as i16 - zeros;
    (exponent + zeros, digits)
}

/// Whether a number is a multiple of a power of ten, but for rounding.
fn is_multiple(value: f64, place: i16) -> bool {
    let unit = 10f64.powi(place.into());
    ((value / unit).round() * unit - value).abs() <= 2.0 * f64::EPSILON * value.abs()
}

/// Whether a number is a decimal of `digits` digits, but for the rounding of a product or quotient.
fn has_digits(value: f64, digits: usize) -> bool {
    let rounded: f64 = format!("{value:.*e}", digits - 1)
        .parse()
        .unwrap_or(f64::NAN);
    (rounded - value).abs() <= 2.0 * f64::EPSILON * value.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn few(of: impl Fn(f64) -> f64) -> Option<(Format, f64)> {
        let mut digits = Digits::default();
        (0..64).for_each(|k| digits.add(of((0.37 * f64::from(k)).sin())));
        digits.few()
    }

    #[test]
    fn formats_are_told_with_their_units() {
        let close = |found: Option<(Format, f64)>, format: Format, unit: f64| {
            let (is, of) = found.expect("few digits");
            assert!(
                is == format && (of / unit - 1.0).abs() < 0.01,
                "{is:?} {of:e}"
            );
        };
        let fixed = |x: f64| format!("{x:.3}").parse().unwrap();
        close(few(fixed), Format::Decimal(3), 1e-3);
        // One is written with as many decimals.
        close(few(|x| fixed(1.1 * x)), Format::Decimal(4), 1e-3);
        close(few(|x| 1e6 * fixed(x)), Format::Decimal(3), 1e3);
        close(few(|x| fixed(50.0 + x)), Format::Decimal(5), 1e-3);
        let printed = |x: f64| format!("{:.5e}", x * x * x).parse().unwrap();
        close(few(printed), Format::Decimal(6), 1e-6);
        close(
            few(|x| f64::from((3.0 * x) as f32)),
            Format::Binary(24),
            3.0 * f64::from(f32::EPSILON),
        );
        // Half precision, bfloat16, and fixed-point numbers.
        let to_bits = |x: f64, bits: i32| {
            // Of 0, too.
            let exponent = x.abs().log2().floor().max(-100.0) as i32;
            let unit = 2f64.powi(exponent + 1 - bits);
            (x / unit).round() * unit
        };
        close(
            few(|x| to_bits(3.0 * x, 11)),
            Format::Binary(11),
            3.0 * 2f64.powi(-10),
        );
        close(
            few(|x| to_bits(3.0 * x, 8)),
            Format::Binary(8),
            3.0 * 2f64.powi(-7),
        );
        let lattice = |x: f64| (3.0 * x * 2f64.powi(20)).round() / 2f64.powi(20);
        close(few(lattice), Format::Binary(22), 2f64.powi(-20));
        assert_eq!(few(|x| x), None);
        assert_eq!(few(|x| x.round()), None, "too few values");
    }
}
