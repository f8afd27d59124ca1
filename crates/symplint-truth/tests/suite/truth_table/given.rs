//! Maps that are given by a formula.

use symplint::map::Capabilities;
use symplint::{Block, Coordinates, PerSample, StepFailure, TimeAdvance};
use symplint_models::discrete::{HenonMap, StandardMap};
use symplint_models::maps::SinglePrecision;

use crate::truth_table::case::{
    BROKEN, BROKEN_AND_CLOSED, Case, NOT_SYMPLECTIC, Named, SYMPLECTIC, Truth, circle, of_order,
    symplectic_to,
};

pub fn cases() -> Vec<Case> {
    let mut cases = henon();
    cases.extend(plane());
    cases.extend(discontinuous());
    cases.extend(pairs());
    cases.extend(forces());
    cases.extend(hundreds());
    cases
}

/// Symplectic Euler, kick first, with a force of q alone.
fn kicked(
    system: &str,
    force: impl Fn(f64) -> f64 + Send + Sync + 'static,
    truth: Truth,
    because: &'static str,
) -> Case {
    let step = move |h: f64, q: &mut f64, p: &mut f64| {
        *p -= h * force(*q);
        *q += h * *p;
    };
    one(system, step, truth, because).steps(-1, -5)
}

/// Forces that are narrow, steep, or rough.
fn forces() -> Vec<Case> {
    let shear = "a continuous force of q alone: a shear";
    let jump = "the force jumps at q = 0.31; the segment along p that closes it is sent on";
    vec![
        kicked(
            "force tanh, 1e-3 wide",
            |q| ((q - 0.31) / 1e-3).tanh(),
            SYMPLECTIC,
            shear,
        ),
        kicked(
            "force tanh, 1e-5 wide",
            |q| ((q - 0.31) / 1e-5).tanh(),
            symplectic_to(8.0),
            shear,
        ),
        kicked(
            "force tanh, 1e-7 wide",
            |q| ((q - 0.31) / 1e-7).tanh(),
            symplectic_to(6.5),
            shear,
        ),
        kicked(
            "force tanh, 1e-10 wide",
            |q| ((q - 0.31) / 1e-10).tanh(),
            SYMPLECTIC,
            shear,
        )
        .undecided("so narrow that doubles on the loop resolve it to three digits"),
        kicked(
            "force √|q|",
            |q| (q - 0.31).abs().sqrt(),
            symplectic_to(6.0),
            shear,
        )
        .undecided("of infinite slope at q = 0.31: pieces halve down to it and do not converge"),
        kicked(
            "force a bump",
            |q| (-((q - 0.31) / 1e-3).powi(2)).exp(),
            SYMPLECTIC,
            shear,
        ),
        kicked(
            "force sin 100 q",
            |q| (100.0 * q).sin(),
            symplectic_to(12.0),
            shear,
        ),
        kicked(
            "force sin 1000 q",
            |q| (1000.0 * q).sin(),
            symplectic_to(10.0),
            shear,
        ),
        kicked(
            "force |q| q",
            |q| (q - 0.31).abs() * (q - 0.31),
            symplectic_to(11.0),
            shear,
        ),
        kicked(
            "force with a jump of 1e-3",
            |q| q.sin() + if q > 0.31 { 1e-3 } else { 0.0 },
            BROKEN,
            jump,
        ),
        kicked(
            "force with a jump of 1e-6",
            |q| q.sin() + if q > 0.31 { 1e-6 } else { 0.0 },
            BROKEN,
            jump,
        ),
        one(
            "a fold, q → |q|",
            |h, q, p| {
                *p -= h * q.sin();
                *q = q.abs();
                *q += h * *p;
            },
            NOT_SYMPLECTIC,
            "det = −1 where q < 0, a kink where they meet: no shear",
        ),
    ]
}

/// One degree of freedom of a hundred has a fault.
fn hundreds() -> Vec<Case> {
    const MANY: usize = 100;
    let with =
        |what: &str, fault: fn(f64, &mut f64, &mut f64), truth: Truth, because: &'static str| {
            let map = PerSample::new(MANY, move |h, q: &mut [f64], p: &mut [f64]| {
                for i in 0..MANY {
                    p[i] -= h * q[i].sin();
                    q[i] += h * p[i];
                }
                fault(h, &mut q[57], &mut p[57]);
            });
            let on = circle(&[0.4; MANY], &[0.7; MANY], 1.0);
            Case::new("a hundred pendula", what, map, on, truth, because).steps(-1, -5)
        };
    vec![
        with("no fault", |_, _, _| (), SYMPLECTIC, "exact flows"),
        with(
            "one is damped at 1e-6",
            |h, _, p| *p *= 1.0 - 1e-6 * h,
            of_order(1.0),
            "one plane of a hundred shrinks",
        ),
        with(
            "one is torn",
            |h, q, p| {
                if *q > 0.31 {
                    *p += 1e-3 * h;
                }
            },
            BROKEN,
            "one degree of freedom of a hundred has a force that jumps",
        ),
        with(
            "one has a wrong sign",
            |h, q, p| *q -= 2.0 * h * *p,
            SYMPLECTIC,
            "drifting backwards is a shear, too",
        ),
    ]
}

fn henon() -> Vec<Case> {
    let on = || circle(&[0.0], &[0.1], 0.3);
    let map = |b| HenonMap::new(1.33, b).unwrap();
    let shears = "a shear and a rotation";
    let det = "det = b^h";
    vec![
        Case::new("Hénon map", "b = 1", map(1.0), on(), SYMPLECTIC, shears).steps(0, -6),
        Case::new("Hénon map", "b = 0.9", map(0.9), on(), of_order(1.0), det).steps(0, -6),
        Case::new("Hénon map", "b = 0.3", map(0.3), on(), of_order(1.0), det).steps(0, -8),
        Case::new("Hénon map", "b = 1.1", map(1.1), on(), of_order(1.0), det).steps(0, -6),
        Case::new(
            "Hénon map",
            "b = 1 − 1e-9",
            map(1.0 - 1e-9),
            on(),
            of_order(1.0),
            det,
        )
        .steps(0, -6),
        Case::new(
            "Hénon map",
            "b = 1, single precision",
            SinglePrecision(map(1.0)),
            on(),
            symplectic_to(6.0),
            "symplectic but for rounding to 6e-8",
        )
        .steps(0, -6),
        Case::new(
            "standard map",
            "single precision",
            SinglePrecision(StandardMap::new(0.97).unwrap()),
            circle(&[2.0], &[0.1], 1.0),
            symplectic_to(6.0),
            "symplectic but for rounding to 6e-8",
        )
        .steps(0, -6),
    ]
}

fn one(
    system: &str,
    step: impl Fn(f64, &mut f64, &mut f64) + Send + Sync + 'static,
    truth: Truth,
    because: &'static str,
) -> Case {
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        step(h, &mut q[0], &mut p[0]);
    });
    Case::new(
        "formula",
        system,
        map,
        circle(&[0.4], &[0.7], 1.0),
        truth,
        because,
    )
}

/// Turns (q, p) by an angle.
fn turn(angle: f64, q: &mut f64, p: &mut f64) {
    let (sin, cos) = angle.sin_cos();
    (*q, *p) = (cos * *q + sin * *p, cos * *p - sin * *q);
}

fn plane() -> Vec<Case> {
    vec![
        one(
            "rotation by h",
            turn,
            SYMPLECTIC,
            "the exact flow of an oscillator",
        ),
        one(
            "q e^h, p e^{−h}",
            |h, q, p| (*q, *p) = (*q * h.exp(), *p * (-h).exp()),
            SYMPLECTIC,
            "the exact flow of H = qp",
        ),
        one(
            "rotation by h (1 + (q² + p²)/2)",
            |h, q, p| turn(h * (1.0 + 0.5 * (*q * *q + *p * *p)), q, p),
            SYMPLECTIC,
            "a step that depends on the conserved energy alone is the flow of a function of it",
        ),
        one(
            "rotation by h (1 + 0.3 q)",
            |h, q, p| turn(h * (1.0 + 0.3 * *q), q, p),
            of_order(1.0),
            "a step that depends on q: div = 0.3 {q, H} = 0.3 p",
        ),
        one(
            "rotation by 90°, whatever h",
            |_, q, p| (*q, *p) = (*p, -*q),
            SYMPLECTIC,
            "(q, p) → (p, −q) is linear of determinant 1",
        ),
        one(
            "q and p exchanged",
            |_, q, p| (*q, *p) = (*p, *q),
            NOT_SYMPLECTIC,
            "det = −1: the loop integral changes its sign, at every h",
        ),
        one(
            "reversal of time in a step",
            |h, q, p| {
                *q += h * *p;
                *p = -*p;
            },
            NOT_SYMPLECTIC,
            "p → −p is antisymplectic",
        ),
        one(
            "kick alone",
            |h, q, p| *p -= h * 2.0 * q.sin(),
            SYMPLECTIC,
            "a shear",
        ),
        one(
            "kick of the wrong sign",
            |h, q, p| {
                *p += h * q.sin();
                *q += h * *p;
            },
            SYMPLECTIC,
            "the wrong physics, and two shears",
        ),
        one(
            "drift with the wrong mass, relativistic",
            |h, q, p| {
                *p -= h * q.sin();
                *q += h * *p / (7.0 * *p * *p + 1.0).sqrt();
            },
            SYMPLECTIC,
            "any drift that depends on p alone is a shear",
        ),
        one(
            "explicit Euler",
            |h, q, p| {
                let force = -q.sin();
                *q += h * *p;
                *p += h * force;
            },
            of_order(2.0),
            "det = 1 + h²V''",
        ),
        one(
            "friction in the kick",
            |h, q, p| {
                *p -= h * (q.sin() + 0.1 * *p);
                *q += h * *p;
            },
            of_order(1.0),
            "det = 1 − 0.1 h",
        ),
        one(
            "friction where q > −2 fades out",
            |h, q, p| {
                *p -= h * (q.sin() + 0.1 * *p / (1.0 + (-4.0 * *q).exp()));
                *q += h * *p;
            },
            of_order(1.0),
            "the friction acts on a part of the loop only",
        ),
        one(
            "shrinking that knows no h",
            |h, q, p| {
                *q += h * *p;
                *p *= 0.999;
            },
            NOT_SYMPLECTIC,
            "det = 0.999 at every h",
        ),
        one(
            "momenta that are clipped",
            |h, q, p| {
                *p -= h * q.sin();
                *p = p.clamp(-1.2, 1.2);
                *q += h * *p;
            },
            NOT_SYMPLECTIC,
            "what is above the limit is pressed onto a line: area is lost; kinks, no breaks",
        ),
        Case::new(
            "formula",
            "p += h p², drift",
            PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                p[0] += h * p[0] * p[0];
                q[0] += h * p[0];
            }),
            circle(&[0.0], &[0.0], 0.5),
            of_order(1.0),
            "det = 1 + 2hp: odd in p, and hidden on the circle round p = 0; random loops show it",
        ),
    ]
}

fn discontinuous() -> Vec<Case> {
    vec![
        one(
            "an elastic wall at q = 0",
            |h, q, p| {
                *q += h * *p;
                if *q < 0.0 {
                    (*q, *p) = (-*q, -*p);
                }
            },
            BROKEN_AND_CLOSED,
            "p jumps to −p where the loop meets the wall, at one q: that carries no p dq, and both \
             sides are symplectic",
        ),
        one(
            "a jump of 1e-5 at small h",
            |h, q, p| {
                *p -= h * q.sin();
                if h < 0.1 && *q > 0.3 {
                    *p += 1e-5;
                }
                *q += h * *p;
            },
            BROKEN,
            "the force jumps at q = 0.3",
        ),
        one(
            "a jump of 1e-9",
            |h, q, p| {
                *p -= h * q.sin();
                *q += h * *p;
                if *q > 0.3 {
                    *p += 1e-9;
                }
            },
            BROKEN_AND_CLOSED,
            "p jumps at one q: a segment that carries no p dq",
        ),
        one(
            "a kick on a thousandth of the loop",
            |h, q, p| {
                if (*q - 0.31).abs() < 2e-3 {
                    *p += h;
                }
                *q += h * *p;
            },
            BROKEN,
            "the force jumps at the ends of a narrow stretch",
        ),
        one(
            "a table of forces, nearest entry",
            |h, q, p| {
                *p -= h * ((*q * 8.0).round() / 8.0).sin();
                *q += h * *p;
            },
            BROKEN,
            "the force is a staircase",
        ),
        one(
            "a table of forces, joined by lines",
            |h, q, p| {
                let (low, part) = ((*q * 8.0).floor(), (*q * 8.0).fract());
                let part = if part < 0.0 { part + 1.0 } else { part };
                let force = (1.0 - part) * (low / 8.0).sin() + part * ((low + 1.0) / 8.0).sin();
                *p -= h * force;
                *q += h * *p;
            },
            symplectic_to(9.0),
            "a continuous force of q alone: a shear with kinks",
        ),
    ]
}

/// Two particles on a spring, in velocities.
struct Pair(Coordinates);

const MASSES: [f64; 2] = [1.0, 3.0];

impl TimeAdvance for Pair {
    fn dof(&self) -> usize {
        2
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for k in 0..block.len() {
            let stretch = block.q.row(1)[k] - block.q.row(0)[k];
            for (i, sign) in [(0, 1.0), (1, -1.0)] {
                block.p.row_mut(i)[k] += sign * h * stretch.sin() / MASSES[i];
                let v = block.p.row(i)[k];
                block.q.row_mut(i)[k] += h * v;
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(self.0.clone())
    }
}

fn two(
    system: &str,
    step: impl Fn(f64, &mut [f64], &mut [f64]) + Send + Sync + 'static,
    truth: Truth,
    because: &'static str,
) -> Case {
    let on: Named = circle(&[0.2, -0.3], &[0.3, 0.1], 1.0);
    Case::new(
        "formula in two planes",
        system,
        PerSample::new(2, step),
        on,
        truth,
        because,
    )
}

fn pairs() -> Vec<Case> {
    let on = || circle(&[0.0, 1.0], &[0.2, -0.3], 0.8);
    let weighted = Coordinates::plain(2).with_weights(MASSES.to_vec()).unwrap();
    vec![
        Case::new(
            "two masses on a spring",
            "velocities, masses stated",
            Pair(weighted),
            on(),
            SYMPLECTIC,
            "canonical momenta are m v",
        ),
        Case::new(
            "two masses on a spring",
            "velocities, masses not stated",
            Pair(Coordinates::plain(2)),
            on(),
            of_order(1.0),
            "velocities of unequal masses are not canonical: ΔI = ±hF/m does not cancel",
        ),
        two(
            "one plane grows as the other shrinks",
            |h, q, p| {
                p[0] *= 1.0 + 0.1 * h;
                p[1] /= 1.0 + 0.1 * h;
                q[0] += h * p[0];
                q[1] += h * p[1];
            },
            of_order(1.0),
            "volume is conserved, areas are not; equal circles hide it to first order",
        ),
        two(
            "a mass matrix that is not symmetric",
            |h, q, p| {
                p[0] -= h * q[0].sin();
                p[1] -= h * q[1].sin();
                q[0] += h * (p[0] + 0.3 * p[1]);
                q[1] += h * p[1];
            },
            of_order(1.0),
            "a drift by A p is symplectic only for symmetric A",
        ),
        two(
            "a mass matrix that is symmetric",
            |h, q, p| {
                p[0] -= h * q[0].sin();
                p[1] -= h * q[1].sin();
                let (first, second) = (p[0] + 0.3 * p[1], p[1] + 0.3 * p[0]);
                q[0] += h * first;
                q[1] += h * second;
            },
            SYMPLECTIC,
            "a drift by A p with symmetric A is the flow of ½ pᵀAp",
        ),
        two(
            "a force that breaks Newton's third law",
            |h, q, p| {
                let pull = (q[1] - q[0]).sin();
                p[0] += h * pull;
                p[1] -= h * 0.9 * pull;
                q[0] += h * p[0];
                q[1] += h * p[1];
            },
            of_order(1.0),
            "∂F₁/∂q₂ ≠ ∂F₂/∂q₁: no potential",
        ),
        two(
            "coordinates updated one after the other",
            |h, q, p| {
                p[0] += h * (q[1] - q[0]).sin();
                q[0] += h * p[0];
                p[1] -= h * (q[1] - q[0]).sin();
                q[1] += h * p[1];
            },
            of_order(2.0),
            "the second kick sees the first position moved: h ∂²V/∂q₁∂q₂ (dq₁' − dq₁)∧dq₂ is left over",
        ),
        two(
            "friction in the second plane",
            |h, q, p| {
                p[0] -= h * q[0].sin();
                q[0] += h * p[0];
                p[1] -= 0.2 * h * p[1];
                q[1] += h * p[1];
            },
            of_order(1.0),
            "det = 1 − 0.2 h in one plane",
        ),
    ]
}
