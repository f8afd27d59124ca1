//! The causes of breaks: walls, clips, periods, step lengths, solvers, and forces that jump.

use std::f64::consts::TAU;

use symplint::verdict::CauseKind;
use symplint::{
    Circle, Coordinates, Diagnostic, Ensemble, PerSample, SampledLoop, TimeAdvance, VerdictKind,
};

use super::{cause, diagnose, leapfrog, verdict};

/// A free flight with what happens at a wall at q = 0.
fn at_a_wall(reflect: fn(&mut f64, &mut f64)) -> impl TimeAdvance {
    PerSample::new(1, move |h, q, p| {
        q[0] += 2.0 * h * p[0];
        if q[0] < 0.0 {
            reflect(&mut q[0], &mut p[0]);
        }
    })
}

#[test]
fn a_wall_is_named_and_a_loop_that_stays_off_it_decides() {
    let wall = at_a_wall(|q, p| (*q, *p) = (-*q, -*p));
    let found = verdict(&wall, &[0.5], &[-0.5], 0.4);
    assert_eq!(found.kind, VerdictKind::BrokenLoops);
    cause(
        &found,
        CauseKind::Wall,
        &["p[0] changes its sign", "q[0] = 0 "],
    );
    let beside = verdict(&wall, &[1.5], &[-0.5], 0.1);
    assert_eq!(beside.kind, VerdictKind::Symplectic, "{beside}");
    assert_eq!(beside.cause, None);
    // Reflected in the middle of a step that has forces, a particle is at the wall neither before nor after it.
    let inside = PerSample::new(1, |h, q, p| {
        q[0] += 0.5 * h * p[0];
        if q[0] > 1.0 {
            (q[0], p[0]) = (2.0 - q[0], -p[0]);
        }
        p[0] -= h * q[0].sin();
        q[0] += 0.5 * h * p[0];
    });
    let found = verdict(&inside, &[0.7], &[0.5], 0.29);
    cause(&found, CauseKind::Wall, &["p[0] changes its sign"]);
}

#[test]
fn clipped_and_stopped_particles_are_named_and_the_jacobian_shows_the_lost_area() {
    let clipped = at_a_wall(|q, p| (*q, *p) = (0.0, -*p));
    let stopped = PerSample::new(1, |h, q, p| {
        let moved = q[0] + 2.0 * h * p[0];
        (q[0], p[0]) = if moved < 0.0 {
            (q[0], 0.0)
        } else {
            (moved, p[0])
        };
    });
    for (map, name) in [
        (&clipped as &dyn TimeAdvance, "q[0] = 0 after the step"),
        (&stopped, "p[0] = 0 after the step"),
    ] {
        let found = verdict(map, &[0.5], &[-0.5], 0.4);
        assert_eq!(found.kind, VerdictKind::BrokenLoops);
        cause(&found, CauseKind::Clipped, &[name, "above s = "]);
        let text = found.sentences().concat();
        assert!(text.contains("between its jumps either"), "{text}");
        let away = verdict(map, &[1.5], &[-0.5], 0.1);
        assert_eq!(away.kind, VerdictKind::Symplectic, "{away}");
    }
}

#[test]
fn a_period_is_named_with_its_value_and_stating_it_decides() {
    for period in [1.0, TAU, 0.37] {
        let k = TAU / period;
        let map = PerSample::new(1, move |h, q, p| {
            q[0] = (q[0] + h * p[0]).rem_euclid(period);
            p[0] -= h * (k * q[0]).sin();
        });
        let found = verdict(&map, &[0.1 * period], &[0.1], 0.3 * period);
        assert_eq!(found.kind, VerdictKind::BrokenLoops);
        let found = cause(&found, CauseKind::Period, &["q[0] alone jumps"]);
        assert_eq!(found.setting, Some(format!("period = [{period}]")));
        let stated =
            map.with_coordinates(Coordinates::plain(1).with_periods(vec![period]).unwrap());
        let stated = verdict(&stated.unwrap(), &[0.1 * period], &[0.1], 0.3 * period);
        assert_eq!(stated.kind, VerdictKind::Symplectic, "{stated}");
    }
}

#[test]
fn a_step_that_chooses_its_length_is_named() {
    // An accurate flow for a time that depends on the momentum.
    let map = PerSample::new(1, |h, q, p| {
        let time = if p[0].abs() > 0.5 { h } else { 0.7 * h };
        let part = time / 64.0;
        for _ in 0..64 {
            q[0] += 0.5 * part * p[0];
            p[0] -= part * q[0].sin();
            q[0] += 0.5 * part * p[0];
        }
    });
    let found = verdict(&map, &[0.1], &[0.5], 0.6);
    assert_eq!(found.kind, VerdictKind::BrokenLoops);
    cause(
        &found,
        CauseKind::ChosenStepLength,
        &["lie on one trajectory", "0.4285"],
    );
}

#[test]
fn numbers_of_substeps_that_differ_are_named() {
    let map = PerSample::new(1, |h, q, p| {
        let count = if p[0].abs() > 0.5 { 2 } else { 1 };
        let part = h / f64::from(count);
        for _ in 0..count {
            q[0] += 0.5 * part * p[0];
            p[0] -= part * q[0].sin();
            q[0] += 0.5 * part * p[0];
        }
    });
    let found = verdict(&map, &[0.1], &[0.5], 0.6);
    assert_eq!(found.kind, VerdictKind::BrokenLoops);
    cause(
        &found,
        CauseKind::ChoiceInside,
        &["h^3.0", "number of substeps"],
    );
}

#[test]
fn a_break_that_is_next_to_another_one_hides_no_cause() {
    // |q| = 0 at one state of the loop alone, up to rounding.
    let map = PerSample::new(1, |h, q, p| {
        let count = (1.0 + 4.0 * q[0].abs()).ceil();
        let h = h / count;
        for _ in 0..count as usize {
            q[0] += 0.5 * h * p[0];
            p[0] -= h * q[0].sin();
            q[0] += 0.5 * h * p[0];
        }
    });
    let found = verdict(&map, &[1.0], &[0.5], 1.0);
    assert_eq!(found.kind, VerdictKind::BrokenLoops);
    cause(&found, CauseKind::ChoiceInside, &["number of substeps"]);
}

#[test]
fn forces_that_jump_are_named_with_the_place() {
    let stairs = |q: f64| 0.25 * (q / 0.25).floor();
    let kick_first = PerSample::new(1, move |h, q, p| {
        p[0] -= h * stairs(q[0]);
        q[0] += h * p[0];
    });
    let found = verdict(&kick_first, &[0.1], &[0.1], 0.6);
    let words = [
        "p[0] jumps in proportion to h (q follows)",
        "multiples of 0.25 in q[0] before",
    ];
    cause(&found, CauseKind::ForceJump, &words);
    let drift_first = PerSample::new(1, move |h, q, p| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * stairs(q[0]);
        q[0] += 0.5 * h * p[0];
    });
    let found = verdict(&drift_first, &[0.1], &[0.1], 0.6);
    cause(
        &found,
        CauseKind::ForceJump,
        &["multiples of 0.25 in q[0] + h/2·p[0] before"],
    );
    // A single place.
    let switch = PerSample::new(1, |h, q, p| {
        p[0] -= h * if q[0] < 0.3 { q[0] } else { 1.5 };
        q[0] += h * p[0];
    });
    let found = verdict(&switch, &[0.1], &[0.1], 0.6);
    cause(
        &found,
        CauseKind::ForceJump,
        &["at q[0] = 0.3 before the step:"],
    );
    // Two evaluations of the force: in the second one, at the middle of the step, the momentum alone jumps.
    let midpoint = PerSample::new(1, |h, q, p| {
        let force = |q: f64| -q.signum();
        let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] + 0.5 * h * force(q[0]));
        p[0] += h * force(q_half);
        q[0] += h * p_half;
    });
    let found = verdict(&midpoint, &[0.0], &[0.0], 1.0);
    cause(
        &found,
        CauseKind::ForceJump,
        &["p[0] alone jumps", "at q[0] + h/2·p[0] = 0 before the step"],
    );
}

/// Two particles in three dimensions, x, y and z of one and then of the other, with a spring that ends at the distance 1.
/// Jumps at one step size are all alike, as a period is.
#[test]
fn a_force_that_jumps_at_one_step_size_is_no_period() {
    let force = |q: &[f64]| {
        let coupling = 0.3 * (q[1] - q[0]).sin();
        let jumps = |q: f64| -q.sin() + 1e-4 * f64::from(q > 0.15);
        [jumps(q[0]) + coupling, jumps(q[1]) - coupling]
    };
    let map = PerSample::new(2, move |h, q, p| {
        leapfrog(h, q, p, &force);
    });
    let circle = Circle::new(vec![-0.2, -0.2], vec![0.3, 0.5], 0.1).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::default()
    };
    let found = diagnostic.run(&map, &circle).unwrap().verdict;
    cause(&found, CauseKind::ForceJump, &["jumps"]);
}

#[test]
fn a_cut_off_between_particles_is_named_with_their_distance() {
    let map = PerSample::new(6, |h, q, p| {
        let distance = (0..3)
            .map(|i| (q[i] - q[i + 3]).powi(2))
            .sum::<f64>()
            .sqrt();
        if distance < 1.0 {
            for i in 0..3 {
                let force = q[i + 3] - q[i];
                p[i] += h * force;
                p[i + 3] -= h * force;
            }
        }
        (q.iter_mut().zip(p)).for_each(|(q, p)| *q += h * *p);
    });
    let (q0, p0) = (
        [0.4, 0.3, 0.1, -0.3, -0.2, 0.0],
        [0.1, 0.0, 0.2, -0.1, 0.1, 0.0],
    );
    let found = verdict(&map, &q0, &p0, 0.3);
    assert_eq!(found.kind, VerdictKind::BrokenLoops);
    cause(
        &found,
        CauseKind::ForceJump,
        &["by opposite amounts", "a distance of 1 before"],
    );
}

#[test]
fn coordinates_that_are_clipped_without_a_break_are_named() {
    // Both sides of a clip are the same state: the loop has a kink there, and a stretch without area.
    let clipped = |most: f64| {
        PerSample::new(2, move |h, q, p| {
            leapfrog(h, q, p, &|q| [-q[0].sin(), -q[1].sin()]);
            p[0] = p[0].clamp(-most, most);
        })
    };
    for (most, part) in [(1.0, 0.05..0.7), (0.9, 0.2..0.9)] {
        let map = clipped(most);
        let found = diagnose(&map, &[0.3, 0.1], &[1.1, 0.2], 0.3);
        assert_eq!(found.verdict.kind, VerdictKind::NotSymplectic);
        let name = format!("p[0] = {most} after the largest step");
        cause(&found.verdict, CauseKind::Clipped, &[&name, "your loop"]);
        let held = found.evidence.survey.held.unwrap();
        assert!(part.contains(&held.part), "{held:?}");
        assert_eq!((held.coordinate, held.dof, held.value), ('p', 0, most));
        let below = verdict(&map, &[0.3, 0.1], &[0.4, 0.2], 0.3);
        assert_eq!(below.kind, VerdictKind::Symplectic, "{below}");
    }
    // Rounded results have neighbours that are equal, and are not clipped.
    let rounded = PerSample::new(2, |h, q, p| {
        leapfrog(h, q, p, &|q| [-q[0].sin(), -q[1].sin()]);
        p.iter_mut()
            .for_each(|p| *p = (*p * 50.0).round() / 50.0 * 0.9);
    });
    let found = verdict(&rounded, &[0.3, 0.1], &[1.1, 0.2], 0.3);
    assert_ne!(found.cause.map(|of| of.kind), Some(CauseKind::Clipped));
}

/// A leapfrog step of three pendula, and what happens to each state at its end.
fn three_pendula(wrap: fn(&mut f64, &mut f64)) -> PerSample<impl Fn(f64, &mut [f64], &mut [f64])> {
    PerSample::new(3, move |h, q: &mut [f64], p: &mut [f64]| {
        for (q, p) in q.iter_mut().zip(p) {
            *p -= 0.5 * h * q.sin();
            *q += h * *p;
            *p -= 0.5 * h * q.sin();
            wrap(q, p);
        }
    })
}

#[test]
fn the_periods_of_several_particles_are_stated_at_once() {
    let boxed = three_pendula(|q, _| *q = q.rem_euclid(6.0));
    let (q0, p0) = ([0.02, 0.05, 5.9], [0.1, 0.2, 0.3]);
    let found = verdict(&boxed, &q0, &p0, 0.5);
    let found = cause(
        &found,
        CauseKind::Period,
        &["q[0], q[1], q[2] jump one by one, by 6"],
    );
    assert_eq!(found.setting.as_deref(), Some("period = [6, 6, 6]"));
    let periods = Coordinates::plain(3).with_periods(vec![6.0; 3]).unwrap();
    let stated = verdict(&boxed.with_coordinates(periods).unwrap(), &q0, &p0, 0.5);
    assert_eq!(stated.kind, VerdictKind::Symplectic, "{stated}");
}

#[test]
fn momenta_that_are_wrapped_are_reflected_at_no_wall() {
    // −1 and 1 are one momentum, and the sign of p changes without a jump of q, as at a wall.
    let map = three_pendula(|_, p| *p = (*p + 1.0).rem_euclid(2.0) - 1.0);
    let circle = Circle::new(vec![0.7, -0.4, 1.1], vec![0.3, 0.5, -0.2], 1.0).unwrap();
    for budget in [3000, 20_000] {
        let diagnostic = Diagnostic {
            budget: Some(budget),
            ..Diagnostic::halving(-1, -10)
        };
        let found = diagnostic.run(&map, &circle).unwrap().verdict;
        let found = cause(&found, CauseKind::Period, &["by 2 at every break"]);
        assert!(found.setting.unwrap().starts_with("momentum_period"));
    }
}

#[test]
fn periods_of_q_and_p_are_named_together() {
    // The standard map on a torus.
    let map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        p[0] += 0.9 * q[0].sin();
        q[0] = (q[0] + p[0]).rem_euclid(TAU);
        p[0] = p[0].rem_euclid(TAU);
    });
    let circle = Circle::new(vec![5.5], vec![0.5], 1.0).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::without_step_size()
    };
    let found = diagnostic.run(&map, &circle).unwrap().verdict;
    cause(&found, CauseKind::Period, &["by 6.28319 at every break"]);
}

#[test]
fn a_wall_that_takes_momentum_is_no_wall_alone() {
    for (kept, remedy) in [
        (0.9, "First find what changes areas next to the jump"),
        (1.0, "Move the loop away"),
    ] {
        let map = PerSample::new(1, move |h, q, p| {
            q[0] += 0.5 * h * p[0];
            p[0] -= h * q[0].sin();
            q[0] += 0.5 * h * p[0];
            if q[0] > 1.5 {
                (q[0], p[0]) = (3.0 - q[0], -kept * p[0]);
            }
        });
        let found = verdict(&map, &[1.0], &[0.5], 1.0);
        let found = cause(&found, CauseKind::Wall, &["p[0] changes its sign"]);
        assert!(found.remedy.starts_with(remedy), "{}", found.remedy);
    }
}

#[test]
fn a_solver_with_a_large_tolerance_is_told_from_a_force_by_its_ratios() {
    // The implicit midpoint rule, whose iteration stops at the tolerance.
    let solver = |tolerance: f64| {
        PerSample::new(1, move |h, q, p| {
            let (mut next_q, mut next_p) = (q[0], p[0]);
            loop {
                let new_q = q[0] + 0.5 * h * (p[0] + next_p);
                let new_p = p[0] - h * (0.5 * (q[0] + next_q)).sin();
                let moved = (new_q - next_q).abs().max((new_p - next_p).abs());
                (next_q, next_p) = (new_q, new_p);
                if moved <= tolerance {
                    break;
                }
            }
            (q[0], p[0]) = (next_q, next_p);
        })
    };
    for tolerance in [1e-2, 1e-3] {
        let found = verdict(&solver(tolerance), &[1.0], &[0.5], 1.0);
        let found = cause(&found, CauseKind::ChoiceInside, &["Δq/Δp up to"]);
        assert!(found.remedy.contains("tolerance"), "{}", found.remedy);
    }
    let found = verdict(&solver(1e-15), &[1.0], &[0.5], 1.0);
    assert_eq!(found.kind, VerdictKind::Symplectic, "{found}");
}

#[test]
fn jumps_of_one_length_are_no_period_if_values_spread_further() {
    // Wrapped, a coordinate lies in one period after the step.
    let force = PerSample::new(2, |h, q, p| {
        for (q, p) in q.iter_mut().zip(p) {
            *q += 0.5 * h * *p;
            *p -= h * q.sin();
            *q += 0.5 * h * *p;
            *p += if *q > 0.2 { 10.0 * h } else { 0.0 };
        }
    });
    let shift = PerSample::new(2, |_, q, _| {
        q.iter_mut()
            .for_each(|q| *q += if *q > 0.2 { 0.5 } else { 0.0 });
    });
    let circle = Circle::new(vec![0.2, 0.25], vec![0.3, 0.4], 0.4).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        step_sizes: vec![0.1],
        ..Diagnostic::default()
    };
    for map in [&force as &dyn TimeAdvance, &shift] {
        let found = diagnostic.run(map, &circle).unwrap().verdict;
        assert_eq!(found.kind, VerdictKind::BrokenLoops);
        assert_ne!(found.cause.map(|of| of.kind), Some(CauseKind::Period));
    }
}

#[test]
fn a_wall_is_named_from_one_step_size() {
    let map = PerSample::new(1, |h, q, p| {
        if q[0] > 0.8 {
            (q[0], p[0]) = (1.6 - q[0], -p[0]);
        }
        q[0] += h * p[0];
    });
    let circle = Circle::new(vec![0.7], vec![0.3], 0.3).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        step_sizes: vec![0.1],
        ..Diagnostic::default()
    };
    let found = diagnostic.run(&map, &circle).unwrap().verdict;
    cause(&found, CauseKind::Wall, &["p[0] changes its sign"]);
}

#[test]
fn an_edge_of_a_polygon_that_a_drift_makes_upright_is_not_clipped() {
    // On edges of slope −1/h, q + hp is constant to the last bit.
    let map = PerSample::new(1, |h, q, p| {
        q[0] += h * p[0];
        p[0] *= (-0.3 * h).exp();
    });
    let (mut q, mut p) = (Vec::new(), Vec::new());
    for edge in 0..4 {
        for k in 0..16 {
            let t = k as f64 / 16.0;
            let corner = [[t, 1.0 - t], [1.0 - t, -t], [-t, t - 1.0], [t - 1.0, t]][edge];
            q.push(0.5 + 0.25 * corner[0]);
            p.push(0.25 + 0.25 * corner[1]);
        }
    }
    let mut states = Ensemble::zeros(1, q.len());
    states.block().q.row_mut(0).copy_from_slice(&q);
    states.block().p.row_mut(0).copy_from_slice(&p);
    let diamond = SampledLoop::new(states, &Coordinates::plain(1)).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        step_sizes: vec![1.0, 0.5],
        ..Diagnostic::default()
    };
    let found = diagnostic.run(&map, &diamond).unwrap().verdict;
    assert_ne!(found.cause.map(|of| of.kind), Some(CauseKind::Clipped));
}

#[test]
fn the_part_of_a_loop_that_is_clipped_goes_round_its_end() {
    let map = PerSample::new(1, |h, q, p| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * q[0].sin();
        q[0] += 0.5 * h * p[0];
        p[0] = p[0].min(0.3);
    });
    let found = diagnose(&map, &[0.5], &[0.5], 0.3);
    let held = found.evidence.survey.held.unwrap();
    assert!(held.part > 0.4, "{held:?}");
    assert!(held.s < 0.25 || held.s > 0.75, "{held:?}");
}
