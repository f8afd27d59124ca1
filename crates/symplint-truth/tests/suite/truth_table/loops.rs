//! One map, many loops.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use symplint::{Block, Loop};
use symplint_models::Model;
use symplint_models::discrete::StandardMap;
use symplint_models::maps::DampedMap;
use symplint_models::systems::{HenonHeiles, Pendulum};

use crate::truth_table::case::{
    Case, Named, Order, SYMPLECTIC, Truth, circle, fourier, of_order, phased, symplectic_to,
};

/// A loop run backwards, whose integral is negative.
struct Backwards<L>(L);

impl<L: Loop> Loop for Backwards<L> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let turned: Vec<f64> = s.iter().map(|s| (1.0 - s).rem_euclid(1.0)).collect();
        self.0.sample(&turned, block);
    }
}

/// Once round the cylinder: q = 2πs, p = p₀ + a sin 2πs.
pub struct Around {
    pub height: f64,
    pub wave: f64,
}

impl Loop for Around {
    fn dof(&self) -> usize {
        1
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for (k, s) in s.iter().enumerate() {
            block.q.row_mut(0)[k] = TAU * s;
            block.p.row_mut(0)[k] = self.height + self.wave * (TAU * s).sin();
        }
    }
}

const FLOWS: &str = "a composition of exact flows of T and V, on every loop";
const ODD: &str = "order 2, and its h³ term, odd in p, is no Hamiltonian's";
const HEUN: &str = "−h²/4 (dk₁−dk₂)∧(dk₁−dk₂), on every loop";

pub fn cases() -> Vec<Case> {
    let mut cases = pendulum();
    cases.extend(two_planes());
    cases.extend(cylinder());
    cases
}

fn pendulum() -> Vec<Case> {
    let model: Model = Arc::new(Pendulum::default()).into();
    let symmetric = "a loop symmetric about p = 0 hides the h³ term; random ones have little of it";
    let backwards = symplint::Circle::new(vec![2.0], vec![0.5], 1.0).unwrap();
    let mut loops: Vec<(Named, Truth, &'static str)> = vec![
        (circle(&[PI], &[0.0], 1.0), SYMPLECTIC, symmetric),
        (circle(&[0.0], &[0.0], 1.0), SYMPLECTIC, symmetric),
        (circle(&[2.0], &[0.5], 0.1), SYMPLECTIC, ODD),
        (circle(&[2.0], &[0.5], 3.0), SYMPLECTIC, ODD),
        (circle(&[2.0], &[0.5], 1e-3), symplectic_to(10.0), ODD),
        (circle(&[100.0], &[0.5], 1.0), symplectic_to(11.0), ODD),
        (
            Named::new("circle, backwards", Backwards(backwards)),
            SYMPLECTIC,
            ODD,
        ),
    ];
    for seed in [11, 12, 13, 14] {
        loops.push((fourier(&[1.0], &[0.4], 1.2, seed), SYMPLECTIC, ODD));
    }
    let mut cases = Vec::new();
    for (on, truth, of_rk2) in loops {
        let case = |step, truth, because| {
            Case::built("pendulum", &model, step, on.clone(), truth, because).steps(-1, -8)
        };
        cases.push(case("strang", truth, FLOWS));
        let of_rk2_order = match of_rk2 == symmetric {
            true => Truth::Defect(Order::IfAny([3.0, 3.0])),
            false => of_order(3.0),
        };
        cases.push(case("rk2 midpoint", of_rk2_order, of_rk2));
        cases.push(case("rk2 heun", of_order(4.0), HEUN));
    }
    cases
}

fn two_planes() -> Vec<Case> {
    let model: Model = Arc::new(HenonHeiles).into();
    let (q, p) = ([0.0, 0.1], [0.2, 0.1]);
    let mut cases = Vec::new();
    for on in [
        fourier(&q, &p, 0.3, 21),
        fourier(&q, &p, 0.3, 22),
        phased(&q, &p, 0.2),
        circle(&q, &p, 0.05),
    ] {
        let case = |step, truth, because| {
            Case::built("Hénon–Heiles", &model, step, on.clone(), truth, because).steps(-1, -8)
        };
        cases.push(case("yoshida4", symplectic_to(12.5), FLOWS));
        cases.push(case("rk2 heun", of_order(4.0), HEUN));
    }
    cases
}

fn cylinder() -> Vec<Case> {
    let map = || StandardMap::new(0.971_635).unwrap();
    let exact = "p = const. keeps its height on average: the kick is the gradient of a periodic \
                 potential";
    let seam = "kick and drift are shears; the seam at q = 0 is in the stated period";
    let around = |height, wave| {
        let name = format!("once round the cylinder, p = {height} + {wave} sin q");
        Named::new(name, Around { height, wave })
    };
    let mut cases: Vec<Case> = vec![
        Case::new(
            "standard map",
            "K = 0.97",
            map(),
            circle(&[0.0], &[0.1], 1.0),
            SYMPLECTIC,
            seam,
        ),
        Case::new(
            "standard map",
            "K = 0.97",
            map(),
            circle(&[3.0], &[2.0], 0.5),
            SYMPLECTIC,
            seam,
        ),
        // Random loops have no more height than this one, and it has none.
        Case::new(
            "standard map",
            "K = 0.97",
            map(),
            around(1.0, 0.0),
            SYMPLECTIC,
            exact,
        )
        .alone(),
        Case::new(
            "standard map",
            "K = 0.97",
            map(),
            around(0.3, 0.5),
            SYMPLECTIC,
            exact,
        ),
        Case::new(
            "standard map",
            "K = 0.97",
            map(),
            around(-2.0, 1.0),
            SYMPLECTIC,
            exact,
        ),
    ];
    let strong = StandardMap::new(5.0).unwrap();
    let on = circle(&[0.0], &[0.1], 1.0);
    cases.push(Case::new(
        "standard map",
        "K = 5",
        strong,
        on,
        symplectic_to(12.0),
        seam,
    ));
    let damping = "momenta, and with them all loop integrals, shrink by e^{−γh}";
    for on in [
        circle(&[0.0], &[0.1], 1.0),
        around(1.0, 0.2),
        around(0.5, 0.5),
    ] {
        let damped = DampedMap::new(map(), 0.1).unwrap();
        let order = of_order(1.0);
        cases.push(Case::new(
            "standard map",
            "damped at 0.1",
            damped,
            on,
            order,
            damping,
        ));
    }
    cases.into_iter().map(|case| case.steps(0, -6)).collect()
}
