//! scratch
use std::f64::consts::{PI, TAU};
use symplint::*;
fn main() {
    let map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        let s = (q[0].atan2(p[0] - 100.0) / TAU).rem_euclid(1.0);
        p[0] += f64::from(s >= 0.1) + f64::from(s >= 0.1 + 6e-12);
        q[0] += 0.3 * f64::from(s >= 0.1 + 3e-12);
    });
    let found = Piecewise::default()
        .integrate(
            &map,
            &Circle::new(vec![0.0], vec![100.0], 1.0).unwrap(),
            1.0,
        )
        .unwrap();
    println!("{:?} exact {}", found, PI - 2.0 * (TAU * 0.1).sin());
}
