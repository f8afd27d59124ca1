//! Tests your map: here one step of a pendulum by the leapfrog method.

use symplint::{Circle, Diagnostic, PerSample};

fn main() -> Result<(), symplint::Error> {
    // One degree of freedom: advance the state (q, p) by one step of size h, in place.
    let map = PerSample::new(1, |h, q, p| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * q[0].sin();
        q[0] += 0.5 * h * p[0];
    });
    // A circle of radius 1 around (q, p) = (2, ½), and the step sizes 2^-1, 2^-2, …, 2^-8.
    let circle = Circle::new(vec![2.0], vec![0.5], 1.0)?;
    let diagnosis = Diagnostic::halving(-1, -8).run(&map, &circle)?;
    println!("{}", diagnosis.verdict);
    Ok(())
}
