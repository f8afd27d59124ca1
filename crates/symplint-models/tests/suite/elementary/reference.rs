//! Sines and cosines to about 100 bits, for |x| up to 2^21: double-double sums, Taylor's series.

/// An unevaluated sum of two doubles.
#[derive(Clone, Copy)]
pub struct Double {
    pub high: f64,
    pub low: f64,
}

fn two_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let part = high - a;
    let low = (a - (high - part)) + (b - part);
    Double { high, low }
}

fn two_product(a: f64, b: f64) -> Double {
    let high = a * b;
    let low = a.mul_add(b, -high);
    Double { high, low }
}

impl Double {
    fn plus(self, other: Double) -> Double {
        let (high, low) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let high = two_sum(high.high, high.low + low.high);
        two_sum(high.high, high.low + low.low)
    }

    fn times(self, other: Double) -> Double {
        let product = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        two_sum(product.high, product.low + cross)
    }

    fn over(self, divisor: f64) -> Double {
        let high = self.high / divisor;
        let back = two_product(-high, divisor);
        let rest = self.plus(back);
        two_sum(high, (rest.high + rest.low) / divisor)
    }

    fn negative(self) -> Double {
        Double {
            high: -self.high,
            low: -self.low,
        }
    }

    /// How far `value` is from this, in units in the last place of this.
    pub fn ulps_to(self, value: f64) -> f64 {
        let exponent = (self.high.abs().to_bits() >> 52).max(1);
        let ulp = f64::from_bits(exponent << 52) * f64::EPSILON;
        ((value - self.high) - self.low) / ulp
    }
}

/// π/2 as a sum of four doubles.
const HALF_PI: [f64; 4] = [
    std::f64::consts::FRAC_PI_2,
    6.123_233_995_736_766e-17,
    -1.497_384_904_859_169_8e-33,
    5.562_271_104_316_826e-50,
];

/// x − n π/2, and n.
fn reduced(x: f64) -> (Double, i64) {
    let n = (x / HALF_PI[0]).round();
    let mut rest = Double { high: x, low: 0.0 };
    for part in HALF_PI {
        rest = rest.plus(two_product(-n, part));
    }
    (rest, n as i64)
}

/// y^first / first! − y^(first + 2) / (first + 2)! + …
fn series(y: Double, first: u32) -> Double {
    let square = y.times(y).negative();
    let one = Double {
        high: 1.0,
        low: 0.0,
    };
    let mut term = if first == 0 { one } else { y };
    let mut sum = term;
    for k in (first + 2..30).step_by(2) {
        term = term.times(square).over(f64::from(k * (k - 1)));
        sum = sum.plus(term);
    }
    sum
}

/// sin x and cos x.
pub fn sin_cos(x: f64) -> (Double, Double) {
    let (y, n) = reduced(x);
    let (sin, cos) = (series(y, 1), series(y, 0));
    match n.rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, sin.negative()),
        2 => (sin.negative(), cos.negative()),
        _ => (cos.negative(), sin),
    }
}
