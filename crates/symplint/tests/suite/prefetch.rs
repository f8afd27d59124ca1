//! Maps that get states beforehand: all of those states are requested later, in the same blocks, and each once.

use std::collections::HashMap;
use std::sync::Mutex;

use symplint::map::{Capabilities, Prefetch};
use symplint::{Block, Circle, Diagnosis, Diagnostic, Rule, StepFailure, TimeAdvance};

/// A step size and the states of a block, bit by bit.
type Call = Vec<u64>;

fn call(h: f64, block: &Block<'_>) -> Call {
    let rows = (0..block.dof()).flat_map(|i| [block.q.row(i), block.p.row(i)]);
    let numbers = rows.flatten().map(|x| x.to_bits());
    std::iter::once(h.to_bits()).chain(numbers).collect()
}

/// A step of h in one degree of freedom.
type Step = fn(f64, &mut f64, &mut f64);

/// Calls a function, and keeps count of what it was told of.
struct Told {
    step: Step,
    /// Of each call, how often it was announced and not asked for yet.
    pending: Mutex<HashMap<Call, usize>>,
    told: Mutex<usize>,
    asked: Mutex<usize>,
}

impl TimeAdvance for Told {
    fn dof(&self) -> usize {
        1
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        *self.asked.lock().unwrap() += block.len();
        let mut pending = self.pending.lock().unwrap();
        if let Some(left) = pending.get_mut(&call(h, block)) {
            *left = left.saturating_sub(1);
        }
        for (q, p) in (block.q.row_mut(0).iter_mut()).zip(block.p.row_mut(0)) {
            (self.step)(h, q, p);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            block_width: 100,
            prefetch: Some(self),
            ..Capabilities::plain(self.dof())
        }
    }
}

impl Prefetch for Told {
    fn begin(&self, h: f64, block: &Block<'_>) {
        *self.told.lock().unwrap() += block.len();
        *(self.pending.lock().unwrap().entry(call(h, block))).or_insert(0) += 1;
    }
}

/// The diagnosis, and the states that were told of beforehand and asked for in all.
fn told(step: Step, diagnostic: &Diagnostic) -> (Diagnosis, usize, usize) {
    let map = Told {
        step,
        pending: Mutex::default(),
        told: Mutex::default(),
        asked: Mutex::default(),
    };
    let circle = Circle::new(vec![0.3], vec![0.5], 1.0).unwrap();
    let diagnosis = diagnostic.run(&map, &circle).unwrap();
    let in_vain: usize = map.pending.into_inner().unwrap().into_values().sum();
    assert_eq!(in_vain, 0, "announced and not asked for, in {diagnostic:?}");
    let (told, asked) = (
        map.told.into_inner().unwrap(),
        map.asked.into_inner().unwrap(),
    );
    assert_eq!(asked, diagnosis.evidence.evaluations.made);
    (diagnosis, told, asked)
}

fn verlet(h: f64, q: &mut f64, p: &mut f64) {
    *p -= 0.5 * h * q.sin();
    *q += h * *p;
    *p -= 0.5 * h * q.sin();
}

fn heun(h: f64, q: &mut f64, p: &mut f64) {
    let (dq, dp) = (*p, -q.sin());
    let (to_q, to_p) = (*q + h * dq, *p + h * dp);
    *q += 0.5 * h * (dq + to_p);
    *p += 0.5 * h * (dp - to_q.sin());
}

/// A kick that begins at q = 0.8.
fn kicked(h: f64, q: &mut f64, p: &mut f64) {
    *p -= h * if *q > 0.8 { 0.5 } else { 0.0 };
    *q += h * *p;
}

/// Fails beyond steps of 1/4.
fn failing(h: f64, q: &mut f64, p: &mut f64) {
    verlet(h, q, p);
    if h > 0.25 && *q > 1.0 {
        *q = f64::NAN;
    }
}

#[test]
fn nothing_is_told_in_vain() {
    let rules = [Rule::Auto, Rule::Pseudospectral];
    for step in [verlet, heun, kicked, failing] {
        for rule in rules {
            for budget in [200, 300, 700, 1500, 4000, 20_000, 200_000] {
                let diagnostic = Diagnostic {
                    rule,
                    budget: Some(budget),
                    ..Diagnostic::halving(-1, -8)
                };
                told(step, &diagnostic);
            }
        }
    }
}

#[test]
fn most_states_of_a_smooth_map_are_told_of() {
    let diagnostic = Diagnostic {
        budget: Some(18_000),
        ..Diagnostic::halving(-1, -10)
    };
    let (_, told, asked) = told(verlet, &diagnostic);
    assert!(10 * told > 8 * asked, "{told} of {asked}");
}
