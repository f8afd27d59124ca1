//! A member of the set: a map, a loop, and what is known of the two.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint::{Circle, Diagnostic, Loop, PerSample, TimeAdvance};

use crate::truth_set::rounding::Rounding;
use crate::truth_set::rows::Spacing;

/// One step of one state, as maps are written here.
pub type Step = Arc<dyn Fn(f64, &mut [f64], &mut [f64]) + Send + Sync>;

/// The map that a step makes.
pub fn map_of(dof: usize, step: Step) -> Arc<dyn TimeAdvance> {
    Arc::new(PerSample::new(
        dof,
        move |h, q: &mut [f64], p: &mut [f64]| {
            step(h, q, p);
        },
    ))
}

/// The right verdict.
#[derive(Clone, Copy, Debug)]
pub enum Expected {
    /// Symplectic; rounding allows at most this number of digits.
    Symplectic { most_digits: f64 },
    /// The loop integral changes.
    NotSymplectic,
    /// It changes by so little that only digits that are not too many are asked for where it is below
    /// [`FAINT`](crate::truth_set::outcome::FAINT).
    SmallDefect(f64),
    /// The loop integral changes by this much, in a feature so narrow that few samples meet it: a symplectic verdict is right if its digits
    /// are not too many.
    Hidden(f64),
    /// The map breaks loops. Once closed, they keep their integrals or do not, if that is known.
    Broken { closed: Option<bool> },
    /// Symplectic, with a period that is not the map's: symplectic, or an error that names it.
    WrongPeriod,
    /// A solver stops at a tolerance: loops break and their integrals change, both by little.
    Tolerance {
        /// Of the loop integral between the breaks, at the largest step, relative, at least.
        defect: f64,
        /// Breaks.
        breaks: usize,
        /// Whether the map is symplectic but for its breaks.
        whole: bool,
    },
    /// Symplectic with noise: random numbers, if it is large; else this number of digits at most.
    Noisy { most_digits: f64 },
    /// It is not a map: results depend on earlier calls or on the batch.
    Refused,
}

impl Expected {
    /// The right verdict of the same map without rounding, or solved to round-off.
    pub fn in_full_precision(self) -> Self {
        match self {
            Expected::Symplectic { .. } | Expected::Tolerance { .. } | Expected::Noisy { .. } => {
                SYMPLECTIC
            }
            other => other,
        }
    }
}

/// Symplectic to any number of digits.
pub const SYMPLECTIC: Expected = Expected::Symplectic {
    most_digits: f64::INFINITY,
};

/// A change (I(h) − I(0)) / I(0) in closed form, of the step size.
pub type ChangeLaw = Arc<dyn Fn(f64) -> f64 + Send + Sync>;

/// A break of the given loop after the largest step.
#[derive(Clone, Copy, Debug)]
pub struct KnownBreak {
    /// Where.
    pub s: f64,
    /// How far roundings of the state move it.
    pub rounding: f64,
}

/// The known answer.
#[derive(Clone)]
pub struct Truth {
    pub expected: Expected,
    /// Change of the integral of the given loop, of a broken one between its breaks, if it is known to round-off.
    pub change: Option<ChangeLaw>,
    /// Whether that is the change of every other loop, too.
    pub of_all_loops: bool,
    /// I(0) of the given loop.
    pub initial: Option<f64>,
    /// The order of the defect; several where terms of different order rule on different loops; none where theory gives none.
    pub orders: Vec<f64>,
    /// All breaks of the given loop after the largest step.
    pub breaks: Option<Vec<KnownBreak>>,
    /// The states at which the map is wrong are 1 in this number.
    pub one_in: Option<usize>,
}

impl Truth {
    /// Nothing but the verdict.
    pub fn of(expected: Expected) -> Self {
        Truth {
            expected,
            change: None,
            of_all_loops: false,
            initial: None,
            orders: Vec::new(),
            breaks: None,
            one_in: None,
        }
    }

    /// With the change of the integral of every loop.
    pub fn with_change(mut self, law: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        self.change = Some(Arc::new(law));
        self.of_all_loops = true;
        self
    }

    /// With the order of the defect, or several.
    pub fn with_orders(mut self, orders: &[f64]) -> Self {
        self.orders = orders.to_vec();
        self
    }
}

/// The diagnosed map.
#[derive(Clone)]
pub enum Subject {
    /// A map.
    Map {
        map: Arc<dyn TimeAdvance>,
        on: Arc<dyn Loop>,
        diagnostic: Box<Diagnostic>,
        /// The same map in double precision, if it works with fewer digits; solved to round-off, where a solver
        /// stops at a tolerance.
        full: Option<Arc<dyn TimeAdvance>>,
        /// The same map with a projection onto its manifold.
        projected: Option<Arc<dyn TimeAdvance>>,
    },
    /// Loops of another code, which are written with few digits.
    Samples {
        map: Arc<dyn TimeAdvance>,
        on: Arc<dyn Loop>,
        samples: usize,
        /// Where they are.
        spacing: Spacing,
        step_sizes: Vec<f64>,
        rounding: Rounding,
    },
}

/// A map, a loop, and what is known of the two.
#[derive(Clone)]
pub struct Member {
    pub label: String,
    pub subject: Subject,
    pub truth: Truth,
}

impl Member {
    /// A map that is diagnosed with the settings given.
    pub fn new(
        label: impl Into<String>,
        map: Arc<dyn TimeAdvance>,
        on: impl Loop + 'static,
        diagnostic: Diagnostic,
        truth: Truth,
    ) -> Self {
        Member {
            label: label.into(),
            subject: Subject::Map {
                map,
                on: Arc::new(on),
                diagnostic: Box::new(diagnostic),
                full: None,
                projected: None,
            },
            truth,
        }
    }

    /// With the same map, which names its manifold.
    pub fn on_manifold(mut self, same: Arc<dyn TimeAdvance>) -> Self {
        if let Subject::Map { projected, .. } = &mut self.subject {
            *projected = Some(same);
        }
        self
    }

    /// With the same map in double precision, or solved to round-off.
    pub fn in_full_precision(mut self, same: Arc<dyn TimeAdvance>) -> Self {
        if let Subject::Map { full, .. } = &mut self.subject {
            *full = Some(same);
        }
        self
    }
}

/// Ellipses in all planes, and their ∮ p·dq.
#[derive(Clone)]
pub struct Ellipses {
    pub q0: Vec<f64>,
    pub p0: Vec<f64>,
    pub radii_q: Vec<f64>,
    pub radii_p: Vec<f64>,
}

impl Ellipses {
    /// As a loop.
    pub fn circle(&self) -> Circle {
        let Ellipses {
            q0,
            p0,
            radii_q,
            radii_p,
        } = self.clone();
        Circle::with_radii(q0, p0, radii_q, radii_p).unwrap()
    }

    /// π a_i b_i of one degree of freedom.
    pub fn area(&self, i: usize) -> f64 {
        PI * self.radii_q[i] * self.radii_p[i]
    }

    /// ∮ p·dq.
    pub fn integral(&self) -> f64 {
        (0..self.q0.len()).map(|i| self.area(i)).sum()
    }
}

/// Step sizes h, h/2, h/4, …; everything else by default.
pub fn halvings(h: f64, count: i32) -> Diagnostic {
    Diagnostic {
        step_sizes: (0..count).map(|m| h * 0.5f64.powi(m)).collect(),
        ..Diagnostic::default()
    }
}
