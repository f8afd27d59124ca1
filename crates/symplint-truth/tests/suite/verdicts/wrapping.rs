//! Positions that are stored in a period.

use std::f64::consts::PI;

use symplint::diagnosis::SampleCount;
use symplint::map::Capabilities;
use symplint::rules::Streaming;
use symplint::{Block, Coordinates, Diagnostic, Rule, StepFailure, TimeAdvance, VerdictKind};

use symplint_models::discrete::StandardMap;

use crate::verdicts::{circle, diagnose};

/// Strang on the pendulum by a code that keeps q in [0, 2π).
struct Wrapping {
    coordinates: Coordinates,
}

impl TimeAdvance for Wrapping {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            *q += 0.5 * h * *p;
            *p -= h * q.sin();
            *q = (*q + 0.5 * h * *p).rem_euclid(2.0 * PI);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(self.coordinates.clone())
    }
}

#[test]
fn wrapped_positions_need_their_period() {
    let phase_loop = circle(&[0.2], &[0.5], 1.0);
    let stated = Wrapping {
        coordinates: Coordinates::plain(1).with_periods(vec![2.0 * PI]).unwrap(),
    };
    let silent = Wrapping {
        coordinates: Coordinates::plain(1),
    };
    for rule in [Rule::Auto, Rule::Streaming(Streaming::default())] {
        let diagnostic = Diagnostic {
            rule,
            ..Diagnostic::default()
        };
        let verdict = diagnose(&diagnostic, &stated, &phase_loop).verdict;
        assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
        let verdict = diagnose(&diagnostic, &silent, &phase_loop).verdict;
        assert_eq!(verdict.kind, VerdictKind::BrokenLoops);
        assert!(verdict.advice().iter().any(|line| line.contains("period")));
    }
}

#[test]
fn steep_stretches_near_a_wrap_are_no_breaks() {
    struct Steep(f64);
    impl TimeAdvance for Steep {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
            for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
                *p -= h * 0.1 * ((2.0 * PI * *q).sin() / self.0).tanh();
                *q = (*q + h * *p).rem_euclid(1.0);
            }
            Ok(())
        }

        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities::of_coordinates(Coordinates::plain(1).with_periods(vec![1.0]).unwrap())
        }
    }
    for width in [1e-2, 1e-4] {
        for samples in [64, 100, 256, 1024] {
            let diagnostic = Diagnostic {
                samples: SampleCount::Fixed(samples),
                ..Diagnostic::halving(0, -4)
            };
            let verdict =
                diagnose(&diagnostic, &Steep(width), &circle(&[0.1], &[0.3], 0.3)).verdict;
            assert_ne!(
                verdict.kind,
                VerdictKind::BrokenLoops,
                "{width}, {samples}: {verdict:?}"
            );
            assert_ne!(
                verdict.kind,
                VerdictKind::NotSymplectic,
                "{width}, {samples}"
            );
        }
    }
}

#[test]
fn steps_that_stretch_a_loop_over_many_periods_make_no_false_verdict() {
    use symplint::map::Repeat;
    use symplint_models::discrete::StandardMap;
    // Symplectic, whatever the stretch: undecided at worst.
    let loop_of = circle(&[0.0], &[0.1], 1.0);
    let check = |map: &dyn TimeAdvance, from: i32, what: &str| {
        let verdict = diagnose(&Diagnostic::halving(from, from - 3), map, &loop_of).verdict;
        let fine = [VerdictKind::Symplectic, VerdictKind::Undecided];
        assert!(fine.contains(&verdict.kind), "{what}: {verdict:?}");
    };
    for from in [7, 8, 9] {
        check(&StandardMap::new(5.0).unwrap(), from, "K = 5, large steps");
        check(
            &StandardMap::new(0.97).unwrap(),
            from,
            "K = 0.97, large steps",
        );
    }
    for (strength, steps) in [(5.0, 5), (5.0, 6), (5.0, 10), (500.0, 2), (500.0, 3)] {
        let map = Repeat::new(StandardMap::new(strength).unwrap(), steps).unwrap();
        check(&map, 0, &format!("K = {strength}, {steps} steps"));
    }
}

#[test]
fn a_torque_on_the_cylinder_is_symplectic_but_not_exact() {
    struct Torque(f64);
    impl TimeAdvance for Torque {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
            for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
                *p += h * (q.sin() + self.0);
                *q = (*q + h * *p).rem_euclid(2.0 * PI);
            }
            Ok(())
        }

        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities::of_coordinates(
                Coordinates::plain(1).with_periods(vec![2.0 * PI]).unwrap(),
            )
        }
    }
    struct Around;
    impl symplint::Loop for Around {
        fn dof(&self) -> usize {
            1
        }
        fn sample(&self, s: &[f64], block: &mut Block<'_>) {
            for (k, s) in s.iter().enumerate() {
                block.q.row_mut(0)[k] = 2.0 * PI * s.rem_euclid(1.0);
                block.p.row_mut(0)[k] = 1.0 + 0.3 * (2.0 * PI * s).sin();
            }
        }
    }
    let says = |torque: f64, phase_loop: &dyn symplint::Loop| {
        let map = Torque(torque);
        let verdict = diagnose(&Diagnostic::halving(0, -5), &map, phase_loop).verdict;
        assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
        // The flux has no part in the digits.
        assert!(verdict.digits > Some(13.0), "{verdict:?}");
        let says = |words: &str| verdict.sentences().iter().any(|line| line.contains(words));
        assert!(says("no Hamiltonian with this period"), "{verdict:?}");
        assert!(!says("as by a map that a Hamiltonian"), "{verdict:?}");
    };
    says(0.1, &Around);
    // A loop that winds is tried where the given one does not.
    says(0.1, &circle(&[2.0], &[0.5], 1.0));
    says(1e-8, &circle(&[2.0], &[0.5], 1.0));
}

#[test]
fn the_standard_map_is_exact() {
    let map = StandardMap::new(0.7).unwrap();
    let found = diagnose(
        &Diagnostic::halving(0, -5),
        &map,
        &circle(&[2.0], &[0.5], 1.0),
    );
    let verdict = &found.verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
    let exact = (verdict.sentences().iter())
        .any(|line| line.contains("as by a map that a Hamiltonian with this period generates"));
    assert!(exact, "{verdict:?}");
    // ∮ p dq round the cylinder is 2π times a mean momentum, and not an area.
    let winding = found
        .points()
        .into_iter()
        .find(|point| point.loop_index == 8)
        .unwrap();
    assert!(winding.initial.abs() > 2.0, "{winding:?}");
}
