//! Forces from small networks in single precision: V(q) = Σ c_j S(w_j·q + b_j), with S' = tanh or ReLU.

use std::sync::Arc;

use symplint::Circle;

use crate::truth_set::member::Step;
use crate::truth_set::random::Random;

/// Neurons.
const WIDTH: usize = 12;

/// A kick by a network and a drift, in both precisions.
pub struct Network {
    pub label: String,
    pub dof: usize,
    pub single: Step,
    pub double: Step,
    /// Whether the force is a gradient, and nothing is damped.
    pub symplectic: bool,
    pub on: Circle,
}

/// Its fault.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    None,
    /// The weights of the last layer are not those of the first one: the force is not a gradient.
    NoGradient,
    /// Momenta are damped by 5%.
    Damped,
}

pub fn random(random: &mut Random) -> Network {
    let dof = random.whole(1, 3);
    let relu = random.chance(0.5);
    let fault = match random.whole(0, 4) {
        0 if dof > 1 => Fault::NoGradient,
        1 => Fault::Damped,
        _ => Fault::None,
    };
    let weights = random.row(WIDTH * dof, -1.0, 1.0);
    let out = match fault {
        Fault::NoGradient => random.row(WIDTH * dof, -1.0, 1.0),
        _ => weights.clone(),
    };
    let (biases, scales) = (random.row(WIDTH, -1.0, 1.0), random.row(WIDTH, -0.6, 0.8));
    macro_rules! step {
        ($float:ident) => {{
            let cast = |x: &[f64]| -> Vec<$float> { x.iter().map(|&x| x as $float).collect() };
            let (weights, out) = (cast(&weights), cast(&out));
            let (biases, scales) = (cast(&biases), cast(&scales));
            let step: Step = Arc::new(move |h, q, p| {
                let mut force = [0.0 as $float; 3];
                for j in 0..WIDTH {
                    let row = j * dof..(j + 1) * dof;
                    let sum: $float = (weights[row.clone()].iter().zip(&*q))
                        .map(|(w, q)| w * *q as $float)
                        .sum();
                    let x = sum + biases[j];
                    let value = scales[j] * if relu { x.max(0.0) } else { x.tanh() };
                    for (f, w) in force.iter_mut().zip(&out[row]) {
                        *f -= value * w;
                    }
                }
                for i in 0..dof {
                    let kicked = p[i] as $float + h as $float * (force[i] - q[i] as $float);
                    let kicked = match fault {
                        Fault::Damped => 0.95 * kicked,
                        _ => kicked,
                    };
                    p[i] = f64::from(kicked);
                    q[i] = f64::from(q[i] as $float + h as $float * kicked);
                }
            });
            step
        }};
    }
    let (single, double) = (step!(f32), step!(f64));
    let what = match fault {
        Fault::None => "",
        Fault::NoGradient => ", no gradient",
        Fault::Damped => ", damped",
    };
    Network {
        label: format!(
            "f32 network, {} d = {dof}{what}",
            if relu { "ReLU" } else { "tanh" }
        ),
        dof,
        single,
        double,
        symplectic: fault == Fault::None,
        on: Circle::new(random.row(dof, -0.3, 0.3), random.row(dof, -0.3, 0.3), 1.0).unwrap(),
    }
}
