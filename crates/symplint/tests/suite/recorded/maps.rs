//! Maps of many kinds, each with a loop. Forces are made of sums, products and quotients where they can be: the last bit
//! of a sine depends on the processor.

use std::f64::consts::{PI, TAU};

use symplint::map::{Capabilities, Substeps};
use symplint::{
    Block, Circle, Coordinates, FourierLoop, Loop, PerSample, StepFailure, TimeAdvance,
};

/// A map with a loop and a step size for it.
pub struct Case {
    pub name: &'static str,
    pub map: Box<dyn TimeAdvance>,
    pub phase_loop: Box<dyn Loop>,
    pub h: f64,
}

/// The parts of a step as closures `part(h, q, p)`, each a substep.
struct Parts {
    coordinates: Coordinates,
    parts: Vec<Part>,
}

type Part = Box<dyn Fn(f64, &mut [f64], &mut [f64]) + Send + Sync>;

impl TimeAdvance for Parts {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.substeps()).try_for_each(|k| self.advance_substep(k, h, block))
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            ..Capabilities::of_coordinates(self.coordinates.clone())
        }
    }
}

impl Substeps for Parts {
    fn substeps(&self) -> usize {
        self.parts.len()
    }

    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let part = &self.parts[k];
        PerSample::new(self.dof(), |h, q: &mut [f64], p: &mut [f64]| part(h, q, p))
            .advance(h, block)
    }
}

/// One at 0, and nothing far from there.
fn bump(x: f64) -> f64 {
    let square = |x: f64| x * x;
    square(square(square(1.0 / (1.0 + x * x))))
}

/// Drift, kick, drift in coordinates that may have periods and a grid.
fn strang(
    coordinates: Coordinates,
    force: impl Fn(&[f64], usize) -> f64 + Send + Sync + 'static,
) -> Box<dyn TimeAdvance> {
    let drift = || -> Part {
        Box::new(|h, q, p| q.iter_mut().zip(p).for_each(|(q, p)| *q += 0.5 * h * *p))
    };
    let kick: Part = Box::new(move |h, q, p| {
        (0..p.len()).for_each(|i| p[i] += h * force(q, i));
    });
    Box::new(Parts {
        coordinates,
        parts: vec![drift(), kick, drift()],
    })
}

/// About sin(x) for |x| < 2.
fn sine(x: f64) -> f64 {
    x * (1.0 - x * x / 6.0 * (1.0 - x * x / 20.0))
}

fn plain(force: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Box<dyn TimeAdvance> {
    strang(Coordinates::plain(1), move |q, _| force(q[0]))
}

/// A step in one degree of freedom that is one whole.
fn whole(step: impl Fn(f64, f64, f64) -> [f64; 2] + Send + Sync + 'static) -> Box<dyn TimeAdvance> {
    Box::new(PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        [q[0], p[0]] = step(h, q[0], p[0]);
    }))
}

fn symplectic_euler(force: fn(f64) -> f64) -> impl Fn(f64, f64, f64) -> [f64; 2] {
    move |h, q, p| {
        let p = p + h * force(q);
        [q + h * p, p]
    }
}

fn heun(force: fn(f64) -> f64) -> impl Fn(f64, f64, f64) -> [f64; 2] {
    move |h, q, p| {
        let (f, v) = (force(q), p);
        let (q1, p1) = (q + h * p, p + h * f);
        [q + 0.5 * h * (v + p1), p + 0.5 * h * (f + force(q1))]
    }
}

/// The implicit midpoint rule of a pendulum by fixed-point iteration that stops at a tolerance.
fn midpoint(tolerance: f64) -> Box<dyn TimeAdvance> {
    whole(move |h, q, p| {
        let (mut x, mut y) = (q, p);
        for _ in 0..100 {
            let before = (x, y);
            x = q + 0.5 * h * y;
            y = p - 0.5 * h * sine(x);
            if (x - before.0).abs() + (y - before.1).abs() < tolerance {
                break;
            }
        }
        [2.0 * x - q, 2.0 * y - p]
    })
}

/// A number between −1 and 1 that is as good as random.
fn scattered(x: f64) -> f64 {
    let mut bits = x.to_bits();
    for _ in 0..3 {
        bits ^= bits >> 33;
        bits = bits.wrapping_mul(0xff51_afd7_ed55_8ccd);
    }
    2.0 * ((bits >> 11) as f64 / (1u64 << 53) as f64) - 1.0
}

fn circle(q: f64, p: f64, radius: f64) -> Box<dyn Loop> {
    Box::new(Circle::new(vec![q], vec![p], radius).unwrap())
}

/// A periodic force of one hill and one valley.
fn parabola(x: f64) -> f64 {
    let half = x % 0.5;
    let hill = 16.0 * half * (0.5 - half);
    if x < 0.5 { hill } else { -hill }
}

/// Zero and first order interpolation of that force from a grid of `cells` cells.
fn interpolated(cells: f64, degree: u8) -> Box<dyn TimeAdvance> {
    let coordinates = Coordinates::plain(1).with_periods(vec![1.0]).unwrap();
    let coordinates = coordinates.with_grid_spacing(1.0 / cells).unwrap();
    strang(coordinates, move |q, _| {
        let x = q[0] * cells;
        let at = |cell: f64| parabola((cell / cells).rem_euclid(1.0));
        match degree {
            0 => -at(x.floor() + 0.5),
            _ => -at(x.floor()) * (1.0 - x + x.floor()) - at(x.floor() + 1.0) * (x - x.floor()),
        }
    })
}

fn ring(dof: usize, loop_seed: u64) -> Box<dyn Loop> {
    let (zero, radius) = (vec![0.0; dof], vec![0.5; dof]);
    Box::new(FourierLoop::random(zero.clone(), zero, &radius, &radius, loop_seed).unwrap())
}

/// A loop round the period of the interpolated forces.
fn winding() -> Box<dyn Loop> {
    let around = FourierLoop::random(vec![0.4], vec![2.0], &[0.1], &[0.3], 2).unwrap();
    Box::new(around.winding(0, 1.0).unwrap())
}

/// Springs between neighbours in a chain, the one in the middle with a gap that closes at once.
fn chain(dof: usize, jump: f64) -> Box<dyn TimeAdvance> {
    strang(Coordinates::plain(dof), move |q, i| {
        let spring = |x: f64| x + 0.3 * x * x;
        let left = if i > 0 { q[i] - q[i - 1] } else { q[0] };
        let right = if i + 1 < q.len() {
            q[i + 1] - q[i]
        } else {
            -q[i]
        };
        let gap = if i == dof / 2 {
            jump * (q[i] - 0.1).signum()
        } else {
            0.0
        };
        spring(right) - spring(left) - gap
    })
}

fn case(name: &'static str, map: Box<dyn TimeAdvance>, phase_loop: Box<dyn Loop>, h: f64) -> Case {
    Case {
        name,
        map,
        phase_loop,
        h,
    }
}

/// All of them.
pub fn cases() -> Vec<Case> {
    let torus = Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
    let torus = torus.with_momentum_periods(vec![TAU]).unwrap();
    let standard_map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        p[0] = (p[0] + 0.9 * q[0].sin()).rem_euclid(TAU);
        q[0] = (q[0] + p[0]).rem_euclid(TAU);
    });
    let weighted = Coordinates::plain(3)
        .with_weights(vec![2.0, -0.5, 1.0])
        .unwrap();
    let mut cases = vec![
        case("pendulum", plain(|q| -sine(q)), circle(0.4, 0.6, 1.0), 0.5),
        case(
            "heun",
            whole(heun(|q| -sine(q))),
            circle(0.4, 0.6, 1.0),
            0.5,
        ),
        case("jump", plain(|q| -q.signum()), circle(0.3, 0.1, 1.0), 0.5),
        case(
            "jump of a whole step",
            whole(symplectic_euler(|q| if q < 0.2 { 1.0 } else { -1.0 - q })),
            circle(0.3, 0.1, 1.0),
            0.5,
        ),
        case(
            "small jump",
            plain(|q| -q - 1e-7 * (q - 0.3).signum()),
            circle(0.0, 0.2, 1.0),
            0.5,
        ),
        case(
            "kink",
            plain(|q| -(q - 0.2).abs()),
            circle(0.1, 0.0, 1.0),
            0.5,
        ),
        case(
            "narrow force",
            plain(|q| (1.0 + ((q - 0.3) / 0.01).powi(2)).recip().powi(2)),
            circle(0.1, 0.2, 1.0),
            0.5,
        ),
        case(
            "steep force",
            plain(|q| -q / (q * q + 1e-10).sqrt()),
            circle(0.1, 0.2, 1.0),
            0.5,
        ),
        case(
            "many jumps",
            plain(|q| -(20.0 * q).floor() / 20.0),
            circle(0.01, 0.2, 1.0),
            0.5,
        ),
        case(
            "grazed threshold",
            plain(|q| -f64::from(q > 0.3 + 1.0 - 1e-9)),
            circle(0.3, 0.0, 1.0),
            1e-3,
        ),
        case(
            "noise",
            whole(|h, q, p| {
                let p = p - h * (sine(q) + 1e-8 * scattered(q));
                [q + h * p, p]
            }),
            circle(0.4, 0.6, 1.0),
            0.5,
        ),
        case(
            "noise on a part",
            whole(|h, q, p| {
                let noise = if q > 0.8 { 1e-7 * scattered(q) } else { 0.0 };
                let p = p - h * (sine(q) + noise);
                [q + h * p, p]
            }),
            circle(0.4, 0.6, 1.0),
            0.5,
        ),
        case(
            "single precision",
            whole(|h, q, p| {
                let p = p as f32 - h as f32 * sine(q) as f32;
                [f64::from(q as f32 + h as f32 * p), f64::from(p)]
            }),
            circle(0.4, 0.6, 1.0),
            0.5,
        ),
        case(
            "rounded output",
            whole(|h, q, p| {
                let p = p - h * sine(q);
                [q + h * p, p].map(|x| (x * 1e4).round() / 1e4)
            }),
            circle(0.4, 0.6, 1.0),
            0.5,
        ),
        case(
            "friction",
            whole(|h, q, p| {
                let p = 0.99 * p - h * q.signum();
                [q + h * p, p]
            }),
            circle(0.1, 0.2, 1.0),
            0.5,
        ),
        case(
            "nearest grid point",
            interpolated(8.0, 0),
            circle(0.4, 0.3, 0.3),
            0.5,
        ),
        case(
            "linear interpolation",
            interpolated(8.0, 1),
            circle(0.4, 0.3, 0.3),
            0.5,
        ),
        case(
            "torus",
            Box::new(standard_map.with_coordinates(torus).unwrap()),
            circle(PI - 0.2, 5.9, 1.0),
            1.0,
        ),
        case(
            "winding, nearest grid point",
            interpolated(8.0, 0),
            winding(),
            0.5,
        ),
        case("chain", chain(5, 0.0), ring(5, 3), 0.5),
        case("chain with a gap", chain(5, 0.05), ring(5, 3), 0.5),
        case(
            "weights",
            strang(weighted, |q, i| {
                -q[i] - q[0] * q[1] - 0.02 * (q[2] - 0.05).signum()
            }),
            ring(3, 5),
            0.25,
        ),
    ];
    for (name, width) in [
        ("a narrow bump beside a kink", 1e-3),
        ("a narrower bump beside a kink", 3e-5),
    ] {
        cases.push(case(
            name,
            plain(move |q| -q.abs() - bump((q - 0.3) / width)),
            circle(0.1, 0.2, 1.0),
            0.5,
        ));
    }
    for (name, tolerance) in [
        ("solver to 1e-4", 1e-4),
        ("solver to 1e-6", 1e-6),
        ("solver to 1e-9", 1e-9),
    ] {
        cases.push(case(name, midpoint(tolerance), circle(0.4, 0.6, 1.0), 0.25));
    }
    cases
}
