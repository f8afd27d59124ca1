//! A line of the table, and whether the diagnosis agrees with it.

use std::fmt::Write;
use std::sync::Arc;

use symplint::{
    Circle, Diagnosis, Diagnostic, Evidence, FourierLoop, Loop, TimeAdvance, Verdict, VerdictKind,
    judge,
};
use symplint_models::Model;
use symplint_models::integrators::catalogue::build;
use symplint_truth::kept;
use symplint_truth::scaled::ScalingAdapter;

/// The right answer.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// Symplectic; round-off and quadrature leave at least this number of digits.
    Symplectic { digits: f64 },
    /// Not symplectic, with a defect of this order.
    Defect(Order),
    /// The map is discontinuous on the loop, or on those tried with it.
    Broken {
        /// Whether loops keep their integral once their breaks are closed, if that is known.
        closed: Option<bool>,
    },
}

/// The order k of a defect of size h^k.
#[derive(Clone, Copy, Debug)]
pub enum Order {
    Exactly(f64),
    /// One of these, or none is stated: the term of the first order is small on most loops, and local slopes lie between the two.
    IfAny([f64; 2]),
    /// Of methods so accurate that few steps show it.
    AtLeast(f64),
    /// Theory gives none, or terms of several orders are of a size.
    Unstated,
}

pub const SYMPLECTIC: Truth = Truth::Symplectic { digits: 13.0 };
pub const BROKEN: Truth = Truth::Broken { closed: None };
pub const BROKEN_AND_CLOSED: Truth = Truth::Broken { closed: Some(true) };
pub const BROKEN_AND_CHANGED: Truth = Truth::Broken {
    closed: Some(false),
};
pub const NOT_SYMPLECTIC: Truth = Truth::Defect(Order::Unstated);

pub const fn symplectic_to(digits: f64) -> Truth {
    Truth::Symplectic { digits }
}

pub const fn of_order(order: f64) -> Truth {
    Truth::Defect(Order::Exactly(order))
}

pub const fn of_order_at_least(order: f64) -> Truth {
    Truth::Defect(Order::AtLeast(order))
}

/// A loop and what to call it.
#[derive(Clone)]
pub struct Named {
    name: String,
    phase_loop: Arc<dyn Loop>,
}

impl Named {
    pub fn new(name: impl Into<String>, phase_loop: impl Loop + 'static) -> Self {
        Named {
            name: name.into(),
            phase_loop: Arc::new(phase_loop),
        }
    }
}

fn centre(q: &[f64], p: &[f64]) -> String {
    match q {
        [q] => format!("round ({q:.3}, {:.3})", p[0]),
        _ => format!("in {} planes", q.len()),
    }
}

/// The circle of the paper.
pub fn circle(q: &[f64], p: &[f64], radius: f64) -> Named {
    let name = format!("circle r = {radius} {}", centre(q, p));
    let circle = Circle::new(q.to_vec(), p.to_vec(), radius).unwrap();
    Named::new(name, circle.with_phases(symplint::Phases::Equal))
}

/// A circle in some of the planes; the other degrees of freedom stay.
pub fn circle_on(dofs: &[usize], q: &[f64], p: &[f64], radius: f64) -> Named {
    let name = format!("circle r = {radius} in planes {dofs:?} of {}", q.len());
    let circle = Circle::new(q.to_vec(), p.to_vec(), radius).unwrap();
    Named::new(name, circle.on(dofs).unwrap())
}

/// Circles that are not in step.
pub fn phased(q: &[f64], p: &[f64], radius: f64) -> Named {
    let name = format!("circles out of step r = {radius} {}", centre(q, p));
    let circle = Circle::new(q.to_vec(), p.to_vec(), radius).unwrap();
    Named::new(
        name,
        circle.with_phases(symplint::Phases::Random { seed: 1 }),
    )
}

/// A random Fourier loop.
pub fn fourier(q: &[f64], p: &[f64], radius: f64, seed: u64) -> Named {
    let name = format!("random loop {seed} r = {radius} {}", centre(q, p));
    let radii = vec![radius; q.len()];
    let found = FourierLoop::random(q.to_vec(), p.to_vec(), &radii, &radii, seed);
    Named::new(name, found.unwrap())
}

/// A map, a loop, and what is known of the two.
pub struct Case {
    system: String,
    step: String,
    map: Box<dyn TimeAdvance>,
    on: Named,
    diagnostic: Diagnostic,
    truth: Truth,
    because: &'static str,
    /// Why the diagnosis cannot decide it.
    pub undecided: Option<&'static str>,
}

impl Case {
    pub fn new(
        system: impl Into<String>,
        step: impl Into<String>,
        map: impl TimeAdvance + 'static,
        on: Named,
        truth: Truth,
        because: &'static str,
    ) -> Self {
        Case {
            system: system.into(),
            step: step.into(),
            map: Box::new(map),
            on,
            diagnostic: Diagnostic::default(),
            truth,
            because,
            undecided: None,
        }
    }

    /// An integrator of the catalogue: `name`, or `name variant`.
    pub fn built(
        system: impl Into<String>,
        model: &Model,
        step: &str,
        on: Named,
        truth: Truth,
        because: &'static str,
    ) -> Self {
        let (name, variant) = match step.split_once(' ') {
            None => (step, None),
            Some((name, variant)) => (name, Some(variant)),
        };
        let map = build(name, variant, model.clone()).unwrap();
        Case::new(system, step, map, on, truth, because)
    }

    /// With step sizes 2^from … 2^to.
    pub fn steps(mut self, from: i32, to: i32) -> Self {
        self.diagnostic.step_sizes = Diagnostic::halving(from, to).step_sizes;
        self
    }

    /// On the given loop only.
    pub fn alone(mut self) -> Self {
        self.diagnostic.loops = 1;
        self
    }

    /// With the reason why the diagnosis leaves it open.
    pub fn undecided(mut self, why: &'static str) -> Self {
        self.undecided = Some(why);
        self
    }

    /// Whether the verdict stays, and its digits to one, in units of length from 2^-30 to 2^30 times as large, of each
    /// degree of freedom apart; else what it is then.
    fn in_other_units(&self, verdict: &Verdict) -> Result<(), String> {
        let coordinates = self.map.capabilities().coordinates;
        let exponent = |i: usize| match i % 4 {
            // A grid has one unit.
            _ if coordinates.grid_spacing() > 0.0 => -30,
            0 => 30,
            1 => -30,
            2 => -17,
            _ => 9,
        };
        let factors: Vec<f64> = (0..coordinates.dof())
            .map(|i| 2f64.powi(exponent(i)))
            .collect();
        let map = ScalingAdapter::new(&*self.map as &dyn TimeAdvance, factors.clone());
        let phase_loop = ScalingAdapter::new(&*self.on.phase_loop as &dyn Loop, factors);
        let other = (self.diagnostic.run(&map, &phase_loop)).map_err(|error| error.to_string())?;
        let digits = [verdict, &other.verdict].map(|verdict| verdict.digits.unwrap_or(0.0));
        match other.verdict.kind == verdict.kind && (digits[0] - digits[1]).abs() < 1.0 {
            true => Ok(()),
            false => Err(format!(
                "{} in other units, {} in these; {}",
                other.verdict.headline(),
                verdict.headline(),
                other.verdict
            )),
        }
    }

    fn title(&self) -> String {
        format!("{} · {} · {}", self.system, self.step, self.on.name)
    }

    fn expected(&self) -> String {
        match self.truth {
            Truth::Symplectic { digits } => format!("symplectic to {digits} digits or more"),
            Truth::Defect(Order::Exactly(order)) => format!("not-symplectic, h^{order}"),
            Truth::Defect(Order::IfAny([low, high])) => {
                format!("not-symplectic, h^{low}, h^{high} or no order")
            }
            Truth::Defect(Order::AtLeast(order)) => {
                format!("not-symplectic, h^{order} or steeper")
            }
            Truth::Defect(Order::Unstated) => "not-symplectic".into(),
            Truth::Broken { closed: None } => "broken-loops".into(),
            Truth::Broken { closed: Some(true) } => "broken-loops, conserved once closed".into(),
            Truth::Broken {
                closed: Some(false),
            } => "broken-loops, changed even if closed".into(),
        }
    }

    /// Whether a verdict is the right one. Undecided cases lie on an edge, where the last bit of a
    /// sine can tip it over to the right side; to the wrong side it never may.
    fn agrees(&self, verdict: &Verdict) -> bool {
        if self.undecided.is_some() && verdict.kind == VerdictKind::Undecided {
            return true;
        }
        match (self.truth, verdict.kind) {
            (Truth::Symplectic { digits }, VerdictKind::Symplectic) => {
                verdict.digits >= Some(digits)
            }
            (Truth::Defect(order), VerdictKind::NotSymplectic) => match order {
                Order::Exactly(order) => verdict.order == Some(order),
                Order::IfAny(orders) => verdict.order.is_none_or(|found| orders.contains(&found)),
                Order::AtLeast(order) => verdict.order.is_none_or(|found| found >= order - 0.1),
                Order::Unstated => true,
            },
            (Truth::Broken { closed }, VerdictKind::BrokenLoops) => {
                let says = |text: &str| verdict.summary().contains(text);
                match closed {
                    // Substeps are not known, and straight chords are not evidence.
                    None => !says("change even with the breaks closed"),
                    Some(true) => says("closed its loop integrals are conserved"),
                    Some(false) => says("change even with the breaks closed"),
                }
            }
            _ => false,
        }
    }
}

/// Diagnoses all cases and prints the table.
pub fn check(theme: &str, cases: &[Case]) {
    let (mut table, mut wrong) = (String::new(), String::new());
    for case in cases {
        let started = std::time::Instant::now();
        let phase_loop = &*case.on.phase_loop;
        let verdict = match case.diagnostic.run(&*case.map, phase_loop) {
            Ok(diagnosis) => {
                kept::keep(&case.title(), &diagnosis.evidence, &diagnosis.verdict);
                judged_again(diagnosis)
            }
            Err(error) => {
                let title = case.title();
                writeln!(
                    wrong,
                    "ERROR  {title}\n       expected {}; {error}",
                    case.expected()
                )
                .unwrap();
                continue;
            }
        };
        if let Err(found) = case.in_other_units(&verdict) {
            writeln!(wrong, "UNITS  {}: {found}", case.title()).unwrap();
        }
        let mark = match (case.agrees(&verdict), case.undecided) {
            (false, _) => "WRONG",
            (true, None) => "right",
            (true, Some(_)) => "open",
        };
        let line = format!(
            "{mark:5}  {:72}  {:38}  {}{}",
            case.title(),
            verdict.headline(),
            case.because,
            case.undecided
                .map_or(String::new(), |why| format!("; undecided: {why}"))
        );
        writeln!(table, "{line}  [{:.1} s]", started.elapsed().as_secs_f64()).unwrap();
        if mark == "WRONG" {
            let expected = case.expected();
            writeln!(wrong, "{line}\n       expected {expected}; {verdict:?}").unwrap();
        }
    }
    println!("{theme}: {} cases\n{table}", cases.len());
    assert!(wrong.is_empty(), "{theme}:\n{wrong}\n\nof\n{table}");
}

/// The catalogue's integrators for smooth systems, what is known of each, and why.
pub fn known(dof: usize) -> Vec<(&'static str, Truth, &'static str)> {
    let flows = "a composition of exact flows of T and V";
    let gauss = "b_i a_ij + b_j a_ji = b_i b_j: a symplectic method, solved to round-off";
    let classical = match dof {
        1 => Truth::Defect(Order::IfAny([6.0, 6.0])),
        _ => Truth::Defect(Order::IfAny([5.0, 6.0])),
    };
    let midpoint = match dof {
        1 => of_order(3.0),
        _ => Truth::Defect(Order::IfAny([3.0, 3.0])),
    };
    let symplectic = symplectic_to(11.0);
    let mut all: Vec<_> = [
        "lie-trotter position-first",
        "lie-trotter momentum-first",
        "strang position-first",
        "strang momentum-first",
        "mclachlan4 position-first",
        "mclachlan4 momentum-first",
        "yoshida4 position-first",
        "yoshida4 momentum-first",
        "yoshida6 position-first",
        "yoshida6 momentum-first",
        "yoshida8 position-first",
        "yoshida8 momentum-first",
    ]
    .into_iter()
    .map(|step| (step, symplectic, flows))
    .collect();
    for step in ["strang-position-first", "strang-momentum-first"] {
        let step = match step {
            "strang-position-first" => "partitioned-rk strang-position-first",
            _ => "partitioned-rk strang-momentum-first",
        };
        all.push((step, symplectic, "Strang splitting in another notation"));
    }
    for step in ["implicit-midpoint", "gauss4", "gauss6"] {
        all.push((step, symplectic, gauss));
    }
    all.extend(not_symplectic(midpoint, classical));
    for step in [
        "adaptive-strang position-first",
        "adaptive-strang momentum-first",
    ] {
        all.push((
            step,
            of_order(1.0),
            "the step size varies over phase space: its gradient times the flow is left over",
        ));
    }
    all.push((
        "wrong-sign-euler",
        of_order(2.0),
        "drifting with p − hF instead of p + hF: det = 1 − 2h²F' to leading order",
    ));
    all
}

/// The Runge–Kutta methods that are not symplectic, for Hamiltonians of any kind; the truth of the explicit midpoint rule and of the
/// classical method depends on the Hamiltonian.
pub fn not_symplectic(
    midpoint: Truth,
    classical: Truth,
) -> Vec<(&'static str, Truth, &'static str)> {
    vec![
        ("euler", of_order(2.0), "det = 1 + h²V'' in one plane"),
        (
            "rk2 midpoint",
            midpoint,
            "order 2, and its h³ term, odd in p, is no Hamiltonian's",
        ),
        (
            "rk2 heun",
            of_order(4.0),
            "what it leaves over is −h²/4 (dk₁−dk₂)∧(dk₁−dk₂), with k₁ − k₂ of order h",
        ),
        (
            "rk4",
            classical,
            "order 4: h⁵, whose term vanishes in one degree of freedom",
        ),
        ("rk45", of_order_at_least(6.0), "order 5, not symplectic"),
        ("dop853", of_order_at_least(9.0), "order 8, not symplectic"),
        (
            "trapezoidal",
            of_order(3.0),
            "conjugate to the midpoint rule by half an Euler step, whose own change of the two-form \
             is h²: their difference over a step is h³",
        ),
        (
            "averaged-vector-field",
            of_order(3.0),
            "conserves H; differs from the midpoint rule at h³, by no Hamiltonian field",
        ),
        (
            "discrete-gradient",
            of_order(3.0),
            "conserves H; differs from the midpoint rule at h³, by no Hamiltonian field",
        ),
    ]
}

/// The verdict, after it was reached again from the evidence as a report carries it.
fn judged_again(diagnosis: Diagnosis) -> Verdict {
    let text = serde_json::to_string(&diagnosis.evidence).unwrap();
    let evidence: Evidence = serde_json::from_str(&text).unwrap();
    assert_eq!(judge(&evidence), diagnosis.verdict);
    diagnosis.verdict
}
