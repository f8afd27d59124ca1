//! Budgets of evaluations: kept in every case, and enough for the right verdict.

use std::collections::HashSet;
use std::sync::Mutex;

use symplint::jacobian::{JacobianEvidence, JacobianMethod};
use symplint::map::Capabilities;
use symplint::verdict::{Agreement, InconclusiveReason, JacobianVerdict, compare_jacobian};
use symplint::{Block, JacobianTest, StepFailure, TimeAdvance, VerdictKind};

use crate::dual::{Method, Step, System};
use crate::jacobian::{Bare, circle, kick_drift, pendula, run, single_precision};

/// The evidence within a budget, of which no evaluation is too many.
fn within(map: &dyn TimeAdvance, budget: usize) -> Option<JacobianEvidence> {
    let test = JacobianTest::within(budget, map.dof(), map.capabilities().tangent.is_some())?;
    let phase_loop = circle(map.dof()).with_phases(symplint::Phases::Random { seed: 3 });
    let evidence = test.run(map, &phase_loop, 0.5).unwrap();
    assert!(
        evidence.evaluations <= budget,
        "{} of {budget}",
        evidence.evaluations
    );
    Some(evidence)
}

#[test]
fn small_budgets_are_enough_for_the_right_verdict() {
    let mut cases: Vec<(Box<dyn TimeAdvance>, bool, usize, usize)> = Vec::new();
    for (method, symplectic) in [
        (Method::SymplecticEuler, true),
        (Method::Strang, true),
        (Method::Heun, false),
    ] {
        let pendulum = Step(System::Pendulum, method);
        cases.push((Box::new(pendulum), symplectic, 39, 1));
        cases.push((Box::new(Bare(pendulum)), symplectic, 37, 1));
        cases.push((Box::new(Bare(pendulum)), symplectic, 150, 4));
        let henon_heiles = Step(System::HenonHeiles, method);
        cases.push((Box::new(henon_heiles), symplectic, 106, 2));
        cases.push((Box::new(Bare(henon_heiles)), symplectic, 122, 2));
        cases.push((Box::new(Bare(henon_heiles)), symplectic, 60, 1));
    }
    for damping in [0.0, 0.01] {
        let chain = || pendula(100, move |h, _, p| p[37] *= 1.0 - damping * h);
        for (budget, points) in [(60, 1), (120, 2), (400, 6)] {
            cases.push((Box::new(chain()), damping == 0.0, budget, points));
        }
    }
    for (k, (map, symplectic, budget, points)) in cases.into_iter().enumerate() {
        let evidence = within(&*map, budget).unwrap();
        let verdict = evidence.verdict();
        assert_eq!(evidence.points.len(), points, "case {k}");
        match verdict {
            JacobianVerdict::SymplecticAlmostEverywhere { digits } => {
                assert!(symplectic && digits >= 10.0, "case {k}: {verdict}");
            }
            JacobianVerdict::NotSymplectic { .. } => assert!(!symplectic, "case {k}: {verdict}"),
            JacobianVerdict::Undecided { .. } => panic!("case {k}: {verdict}"),
        }
    }
}

#[test]
fn no_budget_is_exceeded_and_no_test_is_larger_than_the_default() {
    let default = JacobianTest::default();
    for dof in [1, 2, 3, 8, 9, 100] {
        for has_tangent in [false, true] {
            let most = default.evaluations(dof, has_tangent);
            let mut before = 0;
            for budget in 0..most + 100 {
                let Some(test) = JacobianTest::within(budget, dof, has_tangent) else {
                    assert!(budget < 40, "{budget} for {dof}");
                    continue;
                };
                let cost = test.evaluations(dof, has_tangent);
                assert!(cost <= budget.min(most) && test.points <= default.points);
                before = before.max(cost);
            }
            assert_eq!(before, most);
        }
    }
    // Maps that need more than the plain ones: a defect to be traced, coarse output, many breaks.
    let maps: [Box<dyn TimeAdvance>; 5] = [
        Box::new(pendula(100, |_, _, p| p[37] *= 0.99)),
        Box::new(single_precision(1.0)),
        Box::new(kick_drift(|x| -(1e3 * x).floor() * 1e-3)),
        Box::new(kick_drift(|x| -(x - 0.1).abs())),
        Box::new(kick_drift(|x| (300.0 * x).sin())),
    ];
    for map in &maps {
        for budget in (0..400).step_by(7).chain([1000, 10_000]) {
            within(&**map, budget);
        }
    }
}

#[test]
fn a_defect_is_traced_as_far_as_the_budget_allows() {
    let map = pendula(100, |_, _, p| p[37] *= 0.99);
    // Two points cost 13 + 12 · 4 each; tracing takes 2 + log₂ 128 pairs of derivatives of 12.
    let needed = 8 * (13 + 12 * 4) + 2 * 12 * (2 + 7);
    for (budget, dofs) in [(needed - 1, None), (needed, Some((37, 37)))] {
        let evidence = within(&map, budget).unwrap();
        let JacobianVerdict::NotSymplectic { worst } = evidence.verdict() else {
            panic!("{}", evidence.verdict());
        };
        assert_eq!((evidence.points.len(), worst.dofs), (8, dofs));
    }
}

#[test]
fn a_budget_that_a_wrong_tangent_map_used_up_leaves_no_verdict() {
    struct Wrong(Step);
    impl TimeAdvance for Wrong {
        fn dof(&self) -> usize {
            self.0.dof()
        }
        fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
            self.0.advance(2.0 * h, block)
        }

        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities {
                tangent: self.0.capabilities().tangent,
                ..Capabilities::plain(self.dof())
            }
        }
    }
    let map = Wrong(Step(System::Pendulum, Method::Strang));
    for (budget, points) in [(39, 0), (100, 2), (400, 8)] {
        let evidence = within(&map, budget).unwrap();
        assert!(matches!(
            evidence.method,
            JacobianMethod::CentralDifferences { rejected: Some(_) }
        ));
        assert_eq!(evidence.points.len(), points, "{budget}");
        let no_points = JacobianVerdict::Undecided {
            reason: InconclusiveReason::NoPoints,
        };
        assert_eq!(evidence.verdict() == no_points, points == 0);
        if points == 0 {
            let finding = compare_jacobian(&evidence, VerdictKind::Symplectic, Some(12.0));
            assert_eq!(finding.agreement, Agreement::JacobianUndecided);
        }
    }
}

#[test]
fn the_cost_is_known_beforehand() {
    let test = JacobianTest::default();
    for (dof, expected) in [
        (1, 8 * (13 + 12 * 2)),
        (2, 8 * (13 + 12 * 4)),
        (8, 8 * (13 + 12 * 16)),
        (9, 8 * (13 + 12 * 4)),
    ] {
        let made = run(&pendula(dof, |_, _, _| {}), &circle(dof), 0.3).evaluations;
        assert_eq!((made, test.evaluations(dof, false)), (expected, expected));
    }
}

/// Remembers every state that it is asked to advance.
struct Recorded<M> {
    map: M,
    states: Mutex<Vec<Vec<u64>>>,
}

impl<M: TimeAdvance> TimeAdvance for Recorded<M> {
    fn dof(&self) -> usize {
        self.map.dof()
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let mut states = self.states.lock().unwrap();
        for k in 0..block.len() {
            let rows = (0..block.dof()).flat_map(|i| [block.q.row(i)[k], block.p.row(i)[k]]);
            states.push(rows.map(f64::to_bits).collect());
        }
        drop(states);
        self.map.advance(h, block)
    }
}

#[test]
fn no_state_is_advanced_twice() {
    let maps: [Box<dyn TimeAdvance>; 4] = [
        Box::new(Bare(Step(System::Pendulum, Method::Heun))),
        Box::new(single_precision(1.0)),
        Box::new(kick_drift(|x| -(x - 0.1).abs())),
        Box::new(pendula(100, |_, _, p| p[37] *= 0.99)),
    ];
    for (k, map) in maps.into_iter().enumerate() {
        let recorded = Recorded {
            map,
            states: Mutex::new(Vec::new()),
        };
        let evidence = run(&recorded, &circle(recorded.dof()), 0.5);
        let states = recorded.states.into_inner().unwrap();
        assert_eq!(states.len(), evidence.evaluations);
        let different: HashSet<&Vec<u64>> = states.iter().collect();
        assert_eq!(different.len(), states.len(), "map {k}");
    }
}
