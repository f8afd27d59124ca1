//! Numbers that are hard to compute with.

use arbitrary::{Result, Unstructured};

/// Numbers at the borders of double precision, and round ones, which cancel.
const BORDERS: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    3.0,
    1e-3,
    1e-12,
    1e3,
    1e9,
    -1e9,
    1e-300,
    1e300,
    -1e300,
    5e-324,
    -5e-324,
    f64::MIN_POSITIVE,
    f64::MAX,
    f64::MIN,
    f64::EPSILON,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Any number: one of the borders, an ordinary one, or any bits.
pub fn any(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(match u.int_in_range(0..=3)? {
        0 => *u.choose(&BORDERS)?,
        1 => f64::from_bits(u.arbitrary()?),
        _ => ordinary(u)?,
    })
}

/// Between -4 and 4.
pub fn ordinary(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(f64::from(u.arbitrary::<i16>()?) / 8192.0)
}

/// Mostly an ordinary number, rarely any.
pub fn rarely_any(u: &mut Unstructured<'_>) -> Result<f64> {
    match u.ratio(1, 16)? {
        true => any(u),
        false => ordinary(u),
    }
}

/// So many of any numbers.
pub fn several(u: &mut Unstructured<'_>, count: usize) -> Result<Vec<f64>> {
    (0..count).map(|_| any(u)).collect()
}
