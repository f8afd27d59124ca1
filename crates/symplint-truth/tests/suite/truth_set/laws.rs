//! Defects whose law in the step size is known: mixed powers, constants, saturation, changes of sign, and defects without a law.

use std::sync::Arc;

use crate::truth_set::member::{Expected, Member, Step, Truth, halvings, map_of};
use crate::truth_set::methods::{leapfrog, runge_kutta, tableau};
use crate::truth_set::random::Random;
use crate::truth_set::systems::{self, System};

pub const COUNT: usize = 400;

/// Step sizes of a member.
const SIZES: i32 = 9;

/// Defects below this are not well above the round-off of a step.
const VISIBLE: f64 = 1e-13;

/// Of a defect without an order: every order that is stated is wrong.
const NO_ORDER: &[f64] = &[f64::INFINITY];

/// A change of every loop integral, of h / h₁ with the largest step h₁, and its orders.
struct Law {
    name: String,
    change: Arc<dyn Fn(f64) -> f64 + Send + Sync>,
    orders: Vec<f64>,
}

impl Law {
    fn new(
        name: String,
        orders: Vec<f64>,
        change: impl Fn(f64) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Law {
            name,
            change: Arc::new(change),
            orders,
        }
    }
}

fn constant(random: &mut Random, scale: f64, k: i32) -> Law {
    let e = random.sign() * random.log_between(1e-15, 1e-3);
    Law::new(
        format!("{scale:.0e} h^{k} + {e:.0e}"),
        vec![f64::from(k)],
        move |x| scale * x.powi(k) + e,
    )
}

/// The smallest step size that shows a defect.
fn smallest_visible(change: impl Fn(f64) -> f64, count: i32) -> f64 {
    let sizes = (0..count).map(|m| 0.5f64.powi(m));
    let visible = sizes.filter(|x| change(*x).abs() > VISIBLE);
    visible.fold(1.0, f64::min)
}

fn mixed(random: &mut Random, scale: f64, k: i32, count: i32) -> Law {
    let other = k + random.whole(1, 4) as i32;
    let crossing = random.log_between(1e-3, 3.0);
    let second = random.sign() * scale / crossing.powi(other - k);
    let change = move |x: f64| scale * x.powi(k) + second * x.powi(other);
    let mut orders = vec![f64::from(k)];
    // The lower power prevails only at smaller steps than those that show a defect.
    if smallest_visible(change, count) > crossing {
        orders.push(f64::from(other));
    }
    let name = format!("{scale:.0e} h^{k} + {second:.0e} h^{other}");
    Law::new(name, orders, change)
}

fn saturating(random: &mut Random, scale: f64, k: i32) -> Law {
    let at = random.log_between(1e-3, 3.0);
    let exponential = random.chance(0.5);
    Law::new(
        format!("{scale:.0e} h^{k}, saturating at {at:.0e}"),
        vec![f64::from(k)],
        move |x| {
            let power = (x / at).powi(k);
            scale
                * if exponential {
                    1.0 - (-power).exp()
                } else {
                    power / (1.0 + power)
                }
        },
    )
}

fn changing_sign(random: &mut Random, scale: f64, k: i32, count: i32) -> Law {
    let at = random.log_between(1e-2, 1.0);
    let second = random.between(0.0, 1.0);
    let change = move |x: f64| scale * x.powi(k) * (1.0 - x / at) * (1.0 - second * x);
    let mut orders = vec![f64::from(k)];
    // Beyond the change of sign the next power prevails.
    if smallest_visible(change, count) > at {
        orders.push(f64::from(k + 1));
    }
    Law::new(
        format!("{scale:.0e} h^{k} (1 − h/{at:.2}) …"),
        orders,
        change,
    )
}

/// Slopes between halvings that are given, the largest steps first.
fn of_slopes(name: &str, scale: f64, slopes: Vec<f64>) -> Law {
    Law::new(
        format!("{name} {scale:.0e} {slopes:.2?}"),
        NO_ORDER.to_vec(),
        move |x: f64| {
            let halvings = -x.log2();
            let parts = slopes.iter().enumerate();
            let exponent: f64 = parts
                .map(|(m, slope)| slope * (halvings - m as f64).clamp(0.0, 1.0))
                .sum();
            scale * 0.5f64.powf(exponent)
        },
    )
}

/// Neighbouring slopes differ by more than half an order.
fn without_order(random: &mut Random, scale: f64) -> Law {
    let mut slopes = vec![random.between(1.0, 4.0)];
    while slopes.len() < SIZES as usize {
        let last = slopes[slopes.len() - 1];
        let by = random.sign() * random.between(0.6, 2.0);
        slopes.push(if (0.6..5.0).contains(&(last + by)) {
            last + by
        } else {
            last - by
        });
    }
    of_slopes("slopes", scale, slopes)
}

/// As two loops of a code by Tao's method showed: slopes that drift away, by as much as there or less.
fn drifting(random: &mut Random, scale: f64) -> Law {
    let measured = match random.chance(0.5) {
        true => [2.89, 2.89, 2.75, 2.40, 1.98],
        false => [2.96, 3.03, 3.26, 4.92, 3.03],
    };
    let slopes = (0..SIZES as usize).map(|m| match measured.get(m) {
        Some(slope) => slope + random.between(-0.03, 0.03),
        None => random.between(1.0, 5.0),
    });
    of_slopes("drifting", scale, slopes.collect())
}

/// Momenta times 1 + d(h), then leapfrog.
fn of_law(system: &System, law: &Law, largest: f64) -> Step {
    let (leap, change) = (leapfrog(system), law.change.clone());
    Arc::new(move |h, q, p| {
        let factor = 1.0 + change(h / largest);
        p.iter_mut().for_each(|p| *p *= factor);
        leap(h, q, p);
    })
}

/// A classical method, then momenta times 1 − e: masses that are rounded, a tolerance.
fn classical(random: &mut Random) -> Member {
    let system = systems::pendulum(random);
    let method = tableau(random.pick(&["euler", "midpoint", "heun", "kutta3", "rk4"]));
    let e = random.log_between(1e-15, 1e-3);
    let step = runge_kutta(&system, method);
    let lossy: Step = Arc::new(move |h, q, p| {
        step(h, q, p);
        p[0] *= 1.0 - e;
    });
    let h = random.between(0.5, 1.0) / system.omega;
    // One more, of terms that this loop has in addition to the leading one.
    let order = method.orders(1)[0];
    let truth = Truth::of(Expected::NotSymplectic).with_orders(&[order, order + 1.0]);
    let label = format!("{}, then p × (1 − {e:.0e})", method.name);
    Member::new(
        label,
        map_of(1, lossy),
        system.on.circle(),
        halvings(h, 10),
        truth,
    )
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(31, index);
    if index % 8 == 7 {
        return classical(random);
    }
    let system = match random.chance(0.5) {
        true => systems::pendulum(random),
        false => {
            let dof = random.whole(1, 3);
            systems::chain(random, dof)
        }
    };
    let k = random.whole(1, 5) as i32;
    let scale = random.sign() * random.log_between(1e-3, 0.1);
    let count = random.whole(4, SIZES as usize) as i32;
    let law = match index % 8 {
        0 | 1 => constant(random, scale, k),
        2 => mixed(random, scale, k, count),
        3 => saturating(random, scale, k),
        4 => changing_sign(random, scale, k, count),
        5 => without_order(random, scale),
        _ => drifting(random, scale),
    };
    let h = random.between(0.5, 1.0) / system.omega;
    let step = of_law(&system, &law, h);
    let change = law.change.clone();
    // 1 + d rounded to doubles.
    let truth = Truth::of(Expected::NotSymplectic)
        .with_change(move |at| 1.0 + change(at / h) - 1.0)
        .with_orders(&law.orders);
    let label = format!(
        "{} d = {}, {}, {count} sizes",
        system.name,
        system.dof(),
        law.name
    );
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), halvings(h, count), truth)
}
