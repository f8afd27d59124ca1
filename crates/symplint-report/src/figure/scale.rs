//! From values to lengths.
//!
//! Each value is first *mapped*: itself on a linear axis, its logarithm on a logarithmic one.
//! Ranges and ticks live in mapped values; `Ruler` turns them into page units.

use super::Scale;

/// Largest value of a linear axis: differences of larger ones overflow.
const MAX_VALUE: f64 = 1e300;

impl Scale {
    /// The mapped value, if this scale can show it.
    pub(super) fn map(self, value: f64) -> Option<f64> {
        if !value.is_finite() {
            return None;
        }
        match self {
            Scale::Linear => (value.abs() <= MAX_VALUE).then_some(value),
            Scale::Log10 => (value > 0.0).then(|| value.log10()),
            Scale::Log2 => (value > 0.0).then(|| value.log2()),
        }
    }

    /// The value of a mapped value.
    pub(super) fn unmap(self, mapped: f64) -> f64 {
        match self {
            Scale::Linear => mapped,
            Scale::Log10 => 10.0_f64.powf(mapped),
            Scale::Log2 => mapped.exp2(),
        }
    }

    pub(super) fn is_log(self) -> bool {
        self != Scale::Linear
    }
}

/// The two ends of an axis in mapped values, `low < high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    pub low: f64,
    pub high: f64,
}

impl Span {
    pub fn length(&self) -> f64 {
        self.high - self.low
    }

    /// The span of another length around the same middle.
    pub fn with_length(&self, length: f64) -> Span {
        let middle = self.low + 0.5 * self.length();
        Span {
            low: middle - 0.5 * length,
            high: middle + 0.5 * length,
        }
    }
}

/// A scale laid along the page from `start` (the low end) to `end`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ruler {
    pub scale: Scale,
    pub span: Span,
    pub start: f64,
    pub end: f64,
}

impl Ruler {
    /// The place of a mapped value on the page; far outside of it, somewhere far outside, so
    /// that cutting lines at the frame never meets an infinity.
    pub fn place(&self, mapped: f64) -> f64 {
        let part = (mapped - self.span.low) / self.span.length();
        self.start + part.clamp(-1e9, 1e9) * (self.end - self.start)
    }

    /// The place of a value on the page, if the scale can show it.
    pub fn place_value(&self, value: f64) -> Option<f64> {
        self.scale.map(value).map(|mapped| self.place(mapped))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_exist_for_positive_finite_values_only() {
        for scale in [Scale::Log10, Scale::Log2] {
            for bad in [0.0, -0.0, -1.0, f64::NAN, f64::INFINITY] {
                assert_eq!(scale.map(bad), None, "{scale:?} of {bad}");
            }
        }
        assert_eq!(Scale::Log10.map(1e-16), Some(-16.0));
        assert_eq!(Scale::Log2.map(0.125), Some(-3.0));
        assert_eq!(Scale::Linear.map(f64::MAX), None);
    }

    #[test]
    fn a_ruler_meets_its_ends() {
        let ruler = Ruler {
            scale: Scale::Log10,
            span: Span {
                low: -4.0,
                high: 0.0,
            },
            start: 100.0,
            end: 20.0,
        };
        assert_eq!(ruler.place_value(1e-4), Some(100.0));
        assert_eq!(ruler.place_value(1.0), Some(20.0));
        assert_eq!(ruler.place_value(1e-2), Some(60.0));
        assert_eq!(ruler.place_value(0.0), None);
    }
}
