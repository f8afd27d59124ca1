//! Each threshold of the judge, with hand-written evidence on both sides of it. No map is called.

use VerdictKind::{BrokenLoops, NotSymplectic, Symplectic, Undecided};
use symplint::breaks::Break;
use symplint::evidence::LongTime;
use symplint::evidence::{
    Check, ClosedBreaks, Contraction, DofGroup, Evidence, JumpingCells, LoopEvidence, LoopKind,
    Motion, Omission, OmissionReason, Origin, Rank, Reach, SingularJacobian, StepEvidence, Wrap,
};
use symplint::jacobian::{
    JacobianDecay, JacobianEvidence, JacobianMethod, JacobianPoint, TangentDefect,
};
use symplint::rules::RuleKind;
use symplint::verdict::{
    Advice, BoundFinding, BreakFinding, CauseKind, ChangeFinding, DomainFinding, Finding, Growth,
    MapFinding, RunFinding, SampleFinding, Step, Verdict,
};
use symplint::{Circle, Defect, Diagnostic, PerSample, VerdictKind, judge};

const JUMP: Break = Break {
    s: 0.25,
    uncertainty: 1e-15,
    dof: 0,
    jump_q: 0.1,
    jump_p: 0.2,
    substep: None,
};

fn defect(signed: f64, uncertainty: f64) -> Defect {
    Defect {
        signed,
        quadrature_error: Some(uncertainty),
        roundoff: 0.0,
    }
}

fn step(h: f64, signed: f64, uncertainty: f64) -> StepEvidence {
    let mut step = StepEvidence::default();
    step.step_size = Some(h);
    step.samples = 64;
    step.initial = 1.0;
    step.advanced = 1.0 + signed;
    step.defect = defect(signed, uncertainty);
    step
}

fn of_loop(index: usize, kind: LoopKind, steps: Vec<StepEvidence>) -> LoopEvidence {
    let mut found = LoopEvidence::new(index, kind);
    found.samples = 64;
    found.steps = steps;
    found
}

/// A map whose given loop has these steps, and whose random loop is conserved.
fn of_map(steps: Vec<StepEvidence>) -> Evidence {
    let mut evidence = Evidence::default();
    evidence.loops = vec![
        of_loop(0, LoopKind::Given, steps),
        of_loop(1, LoopKind::Random, vec![step(0.5, 0.0, 1e-15)]),
    ];
    evidence.loops[0].steps[0].motion = Some(motion(0.5));
    evidence
}

/// A step that advances the motions on its loop by `phase_advance` radians.
fn motion(phase_advance: f64) -> Motion {
    let mut motion = Motion::default();
    motion.phase_advance = phase_advance;
    motion.deformation = 1.0;
    motion
}

/// A kick alone that deforms its loop by this part of its size.
fn shear(deformation: f64) -> Motion {
    let mut motion = Motion::default();
    motion.deformation = deformation;
    motion.shear = true;
    motion
}

/// Loops of another code.
fn of_samples(steps: Vec<StepEvidence>) -> Evidence {
    let mut evidence = Evidence::default();
    evidence.origin = Origin::Samples;
    let mut given = of_loop(0, LoopKind::Given, steps);
    for step in &mut given.steps {
        step.motion = Some(motion(0.5));
    }
    evidence.loops = vec![given];
    evidence
}

fn kind(evidence: &Evidence) -> VerdictKind {
    judge(evidence).kind
}

/// What of a check the budget did not allow.
fn spent(check: Check, missing: usize) -> Omission {
    let why = OmissionReason::Budget { missing };
    Omission { check, why }
}

fn decides(evidence: &Evidence) -> Finding {
    judge(evidence).findings[0].clone()
}

#[test]
fn a_defect_counts_from_ten_times_its_uncertainty() {
    for (ratio, expected) in [
        (2.9, Symplectic),
        (3.1, Undecided),
        (9.9, Undecided),
        (10.1, NotSymplectic),
    ] {
        // Small enough to be conserved to 1e-6 with its uncertainty, and not below 1e-10.
        let evidence = of_map(vec![step(0.5, ratio * 1e-9, 1e-9)]);
        assert_eq!(kind(&evidence), expected, "{ratio} times the uncertainty");
    }
}

#[test]
fn a_small_defect_is_confirmed_by_a_second_step_size_or_by_far() {
    let ratio = |steps: &[(f64, f64)]| -> Vec<StepEvidence> {
        (steps.iter())
            .map(|&(h, ratio)| step(h, ratio * 1e-14, 1e-14))
            .collect()
    };
    let cases: [(&[(f64, f64)], VerdictKind); 5] = [
        (&[(0.5, 99.0)], Undecided),
        (&[(0.5, 101.0)], NotSymplectic),
        (&[(0.5, 20.0), (0.25, 9.0)], Undecided),
        (&[(0.5, 20.0), (0.25, 11.0)], NotSymplectic),
        // Not even significant: part of the bound.
        (&[(0.5, 9.0), (0.25, 9.0)], Symplectic),
    ];
    for (steps, expected) in cases {
        assert_eq!(kind(&of_map(ratio(steps))), expected, "{steps:?}");
    }
    // From 1e-10 on it needs no confirmation.
    assert_eq!(
        kind(&of_map(vec![step(0.5, 1.01e-10, 1e-11)])),
        NotSymplectic
    );
    assert_eq!(
        kind(&of_map(vec![step(0.5, 0.99e-10, 0.95e-11)])),
        Undecided
    );
}

#[test]
fn a_bound_counts_below_one_in_a_million() {
    for (uncertainty, expected) in [
        (0.9e-6, Symplectic),
        (1.1e-6, Undecided),
        (f64::NAN, Undecided),
    ] {
        let evidence = of_map(vec![step(0.5, 0.0, uncertainty)]);
        assert_eq!(kind(&evidence), expected, "{uncertainty:e}");
    }
    let mut unknown = of_map(vec![step(0.5, 0.0, 1e-15)]);
    unknown.loops[0].steps[0].defect.quadrature_error = None;
    assert_eq!(kind(&unknown), Undecided);
}

#[test]
fn a_feature_of_a_random_loop_has_to_be_resolved_on_one_loop() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    let mut featured = step(0.5, 0.0, 1e-3);
    (evidence.loops).push(of_loop(2, LoopKind::Random, vec![featured]));
    assert_eq!(kind(&evidence), Symplectic);
    featured.has_feature = true;
    evidence.loops[2].steps = vec![featured];
    assert_eq!(kind(&evidence), Undecided);
    // Pieces that resolve something else say nothing of it.
    evidence.loops[1].steps[0].rule = RuleKind::Piecewise;
    assert_eq!(kind(&evidence), Undecided);
    evidence.loops[1].steps[0].has_feature = true;
    assert_eq!(kind(&evidence), Symplectic);
}

#[test]
fn one_random_loop_has_to_be_bounded() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    evidence
        .loops
        .push(of_loop(2, LoopKind::Random, vec![step(0.5, 0.0, 1e-3)]));
    assert_eq!(
        kind(&evidence),
        Symplectic,
        "the other random loop is bounded"
    );
    evidence.loops.remove(1);
    assert_eq!(kind(&evidence), Undecided);
    evidence.loops[1].steps.clear();
    evidence.loops[1].failure = Some("the map failed".into());
    assert_eq!(
        decides(&evidence),
        Finding::Bounds(BoundFinding::RandomLoopsFail)
    );
}

#[test]
fn the_largest_step_has_to_advance_the_motions_by_a_twentieth_of_a_radian() {
    for (found, expected) in [
        (motion(0.049), Undecided),
        (motion(0.051), Symplectic),
        // A kick alone is not the approximation of any method: it has to deform the loop.
        (shear(0.19), Undecided),
        (shear(0.21), Symplectic),
    ] {
        for origin in [of_map, of_samples] {
            let mut evidence = origin(vec![step(0.5, 0.0, 1e-15)]);
            evidence.loops[0].steps[0].motion = Some(found);
            assert_eq!(kind(&evidence), expected, "{found:?}");
        }
    }
    // One loop is enough, and a shear in addition to it does no harm.
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    evidence.loops[0].steps[0].motion = Some(shear(0.3));
    evidence.loops[1].steps[0].motion = Some(motion(0.04));
    assert_eq!(kind(&evidence), Undecided);
    evidence.loops[1].steps[0].motion = Some(motion(0.3));
    assert_eq!(kind(&evidence), Symplectic);
    // A significant defect needs no motion.
    let mut evidence = of_map(vec![step(0.5, 1e-3, 1e-15)]);
    evidence.loops[0].steps[0].motion = Some(motion(0.01));
    assert_eq!(kind(&evidence), NotSymplectic);
}

#[test]
fn the_step_size_that_would_do_is_told() {
    for (found, h, told) in [
        (motion(7.25e-4), Some(0.5), "near 700:"),
        (motion(0.02), Some(1e-9), "near 5e-8:"),
        (motion(0.02), None, "about 50 times the present one:"),
        (shear(0.1), Some(0.5), "near 2:"),
        (motion(1e-7), Some(0.5), "a loop on which forces differ"),
        // Largest factor 1e6: what is slower has no forces.
        (motion(1.1e-6), Some(0.5), "near 5e5:"),
    ] {
        let mut evidence = of_samples(vec![step(0.5, 0.0, 1e-15)]);
        evidence.loops[0].steps[0].step_size = h;
        evidence.loops[0].steps[0].motion = Some(found);
        let advice = judge(&evidence).advice()[0].clone();
        assert!(advice.contains(told), "{found:?}: {advice}");
    }
}

#[test]
fn samples_have_to_be_half_a_cell_apart_or_nearer() {
    for (cells, signed, expected) in [
        (0.49, 1e-3, NotSymplectic),
        (0.51, 1e-3, Undecided),
        (0.49, 0.0, Symplectic),
        (0.51, 0.0, Undecided),
    ] {
        let mut evidence = of_map(vec![step(0.5, signed, 1e-15)]);
        evidence.loops[0].steps[0].cells_apart = cells;
        assert_eq!(kind(&evidence), expected, "{cells} cells, defect {signed}");
    }
}

#[test]
fn a_break_of_any_loop_breaks_and_closing_says_whether_that_is_all() {
    let closing = |signed: f64, uncertainty: f64, straight: bool| {
        let mut evidence = of_map(vec![step(0.5, -3.0, 1e-10)]);
        let step = &mut evidence.loops[0].steps[0];
        step.jump = Some(JUMP);
        step.closing = Some(ClosedBreaks {
            breaks: 2,
            chord: 3.0,
            closed: defect(signed, uncertainty),
            bend: 0.0,
            straight,
        });
        judge(&evidence)
    };
    for (signed, uncertainty, conserved) in [
        (0.0, 1e-14, Some(true)),
        (9e-14, 1e-14, Some(true)),
        (11e-14, 1e-14, Some(false)),
        (0.0, 0.9e-6, Some(true)),
        (0.0, 1.1e-6, None),
    ] {
        let verdict = closing(signed, uncertainty, false);
        assert_eq!(verdict.kind, BrokenLoops);
        assert_eq!(
            verdict.conserved_once_closed, conserved,
            "{signed:e} ± {uncertainty:e}"
        );
        let told = verdict
            .headline()
            .contains("conserved once breaks are closed");
        assert_eq!(told, conserved == Some(true));
    }
    // By straight chords across the whole step a change is not evidence.
    assert_eq!(closing(11e-14, 1e-14, true).conserved_once_closed, None);
    assert_eq!(
        closing(9e-14, 1e-14, true).conserved_once_closed,
        Some(true)
    );
    let mut random = of_map(vec![step(0.5, 0.0, 1e-15)]);
    random.loops[1].steps[0].jump = Some(JUMP);
    assert_eq!(kind(&random), BrokenLoops);
}

#[test]
fn a_closed_integral_changes_by_more_than_other_curves_could_make() {
    let closing = |signed: f64, bend: f64| ClosedBreaks {
        breaks: 1,
        chord: 1.0,
        closed: defect(signed, 1e-14),
        bend,
        straight: false,
    };
    let judged = |closings: &[ClosedBreaks]| {
        let steps = closings.iter().zip([0.5, 0.25]).map(|(&closing, h)| {
            let mut step = step(h, -3.0, 1e-10);
            (step.jump, step.closing) = (Some(JUMP), Some(closing));
            step
        });
        judge(&of_map(steps.collect()))
    };
    for (signed, bend, conserved) in [
        (0.11, 0.01, Some(false)),
        (-0.11, 0.01, Some(false)),
        (0.09, 0.01, None),
        // Conserved to round-off, however much other curves could have made.
        (9e-14, 0.1, Some(true)),
    ] {
        let verdict = judged(&[closing(signed, bend)]);
        assert_eq!(
            verdict.conserved_once_closed, conserved,
            "{signed} of {bend}"
        );
        let told = verdict.sentences().concat().contains("other curves");
        assert_eq!(told, conserved.is_none());
    }
    // A smaller change that proves something before a larger one that does not.
    let verdict = judged(&[closing(0.09, 0.01), closing(0.011, 1e-3)]);
    assert_eq!(verdict.conserved_once_closed, Some(false));
}

#[test]
fn the_given_loop_decides_on_a_step_that_loses_rank_and_the_cause_is_named() {
    let rank = Rank { rank: 5, of: 6 };
    let mut evidence = of_map(vec![step(0.5, 0.1, 1e-12)]);
    evidence.survey.singular = Some(SingularJacobian {
        s: 0.1,
        smallest: 1e-9,
        largest: 2.0,
        uncertainty: 1e-9,
        degenerate: Some(rank),
    });
    // Its image, which lies on the manifold, is conserved.
    let image = of_loop(9, LoopKind::Image, vec![step(0.5, 1e-13, 1e-12)]);
    evidence.loops.push(image);
    let verdict = judge(&evidence);
    assert_eq!(verdict.kind, NotSymplectic);
    assert!(
        verdict
            .findings
            .contains(&Finding::Domain(DomainFinding::LosesRank { rank }))
    );
    assert_eq!(verdict.advice, [Advice::LoopOnManifold]);
}

#[test]
fn loops_off_the_leaf_of_a_degenerate_form_do_not_decide() {
    let rank = Rank { rank: 2, of: 3 };
    for (given, of_given) in [(1.0, None), (0.0, Some(1e-14))] {
        let mut evidence = of_map(vec![step(0.5, given, 1e-14)]);
        evidence.loops[1].steps = vec![step(0.5, -1.0, 1e-12)];
        assert_eq!(kind(&evidence), NotSymplectic);
        evidence.survey.degenerate_form = Some(rank);
        let verdict = judge(&evidence);
        assert_eq!(verdict.kind, Undecided);
        let given = of_given;
        assert_eq!(
            verdict.findings[0],
            Finding::Domain(DomainFinding::DegenerateForm { rank, given })
        );
        assert_eq!(verdict.advice, [Advice::KeepToLeaf]);
    }
}

#[test]
fn loops_off_the_manifold_of_a_projection_do_not_decide() {
    let singular = SingularJacobian {
        s: 0.1,
        smallest: 1e-7,
        largest: 2.0,
        uncertainty: 1e-9,
        degenerate: None,
    };
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-14)]);
    evidence.loops[1].steps = vec![step(0.5, -1.0, 1e-12)];
    assert_eq!(kind(&evidence), NotSymplectic);
    evidence.survey.singular = Some(singular);
    assert_eq!(kind(&evidence), Undecided);
    assert_eq!(judge(&evidence).advice, [Advice::Project]);
    // A smaller one is rounding.
    for (value, smallest) in [(1e-7, 1e-7), (1e-9, 0.0)] {
        let mut evidence = evidence.clone();
        evidence.survey.singular = Some(SingularJacobian {
            smallest: value,
            ..singular
        });
        let expected = Finding::Domain(DomainFinding::Projects {
            smallest,
            given: Some(1e-14),
            beside: Some((1, 1.0)),
        });
        assert_eq!(decides(&evidence), expected);
    }

    // The given loop shows a defect of the map, unless what comes of it, which lies on the manifold, is conserved.
    let mut evidence = of_map(vec![step(0.5, 0.1, 1e-12)]);
    evidence.survey.singular = Some(singular);
    assert_eq!(kind(&evidence), NotSymplectic);
    for (second, expected) in [(0.05, NotSymplectic), (1e-13, Undecided)] {
        let image = of_loop(9, LoopKind::Image, vec![step(0.5, second, 1e-12)]);
        let mut evidence = evidence.clone();
        evidence.loops.push(image);
        assert_eq!(kind(&evidence), expected, "{second}");
        if expected == Undecided {
            let because = Finding::Domain(DomainFinding::LoopBesideManifold {
                smallest: 1e-7,
                first: 0.1,
                second: 1.1e-12,
            });
            assert_eq!(decides(&evidence), because);
        }
    }
    // A loop that bounds nothing does not change the verdict.
    let image = of_loop(9, LoopKind::Image, vec![step(0.5, 0.0, 1e-3)]);
    evidence.loops.push(image);
    assert_eq!(kind(&evidence), NotSymplectic);
}

#[test]
fn a_change_at_one_point_of_the_disc_does_not_decide() {
    let mut evidence = of_map(vec![step(0.5, 0.1, 1e-12)]);
    for (area, expected) in [(0.99e-3, Undecided), (1.01e-3, NotSymplectic)] {
        evidence.contraction = Some(Contraction {
            points: 1,
            s: [0.2, 0.21],
            r: [0.3, 0.31],
            area,
        });
        assert_eq!(kind(&evidence), expected, "{area}");
    }
}

#[test]
fn states_that_may_be_outside_the_domain_do_not_decide() {
    // Beside a manifold, of which nothing is known.
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-14)]);
    evidence.loops[1].steps = vec![step(0.5, -1.0, 1e-12)];
    evidence.omissions.push(spent(Check::Constraint, 1));
    evidence.evaluations.wanted = 480;
    assert_eq!(kind(&evidence), Undecided);
    assert!(matches!(
        decides(&evidence),
        Finding::Domain(DomainFinding::ManifoldUnknown { loop_index: 1, .. })
    ));
    assert_eq!(
        judge(&evidence).advice[0],
        Advice::MoreEvaluations { wanted: 480 }
    );
    evidence.loops[0].steps = vec![step(0.5, -1.0, 1e-12)];
    assert_eq!(kind(&evidence), NotSymplectic);

    // Round a point at which it may be singular: the Jacobian is symplectic to a digit more than the change, or not.
    for (signed, expected) in [(1.1e-6, Undecided), (0.9e-6, NotSymplectic)] {
        let mut evidence = of_map(vec![step(0.5, signed, 1e-12)]);
        evidence.omissions.push(spent(Check::Contraction, 1));
        assert_eq!(kind(&evidence), NotSymplectic);
        evidence.jacobian = Some(symplectic_jacobian(1e-7));
        assert_eq!(kind(&evidence), expected, "{signed}");
    }
}

/// A Jacobian without a defect above a bound.
fn symplectic_jacobian(bound: f64) -> JacobianEvidence {
    let worst = TangentDefect {
        s: 0.25,
        signed: 0.0,
        uncertainty: bound,
        dofs: None,
    };
    let point = JacobianPoint {
        s: worst.s,
        worst: Some(worst),
        bound: Some(bound),
    };
    JacobianEvidence {
        volume: None,
        blocks: None,
        step_size: Some(0.5),
        loop_index: 0,
        method: JacobianMethod::CentralDifferences { rejected: None },
        points: vec![point; 4],
        not_differentiable: 0,
        full: true,
        projected: false,
        worst: Some(worst),
        bound: Some(bound),
        bounds_of_groups: vec![Some(bound)],
        deformation: 1.0,
        noise: 1e-16,
        evaluations: 100,
    }
}

#[test]
fn every_group_of_degrees_of_freedom_has_to_be_bounded() {
    let group = |dofs: &[usize], action: f64| DofGroup {
        dofs: dofs.to_vec(),
        action,
    };
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-14)]);
    evidence.groups = vec![group(&[0, 1], 1.0), group(&[2, 3], 1e-15)];
    let decided = decides(&evidence);
    assert!(
        matches!(
            decided,
            Finding::Bounds(BoundFinding::Group {
                index: 1,
                by_loops: None,
                ..
            })
        ),
        "{decided:?}"
    );
    let told = judge(&evidence).findings;
    let of_group = |finding: &&Finding| {
        matches!(
            finding,
            Finding::Bounds(BoundFinding::Group { index: 1, .. })
        )
    };
    assert_eq!(told.iter().filter(of_group).count(), 1, "{told:?}");
    for (uncertainty, expected) in [(0.99e-6, Symplectic), (1.01e-6, Undecided)] {
        let mut light = of_loop(9, LoopKind::Group, vec![step(0.5, 0.0, uncertainty)]);
        light.group = Some(1);
        let mut evidence = evidence.clone();
        evidence.loops.push(light);
        assert_eq!(kind(&evidence), expected, "{uncertainty}");
    }
}

#[test]
fn breaks_about_which_rounding_decides_point_to_a_solver() {
    for (flickering, breaks, expected) in [
        (0, 4, false),
        (1, 4, false),
        (2, 4, true),
        (2, 16, true),
        (2, 17, false),
    ] {
        let mut evidence = of_map(vec![step(0.5, 1e-9, 1e-14)]);
        let step = &mut evidence.loops[0].steps[0];
        step.jump = Some(JUMP);
        step.flickering = flickering;
        step.closing = Some(ClosedBreaks {
            breaks,
            chord: 1e-9,
            closed: defect(0.0, 1e-14),
            bend: 0.0,
            straight: false,
        });
        let advice = judge(&evidence).advice;
        let at_least = |finding: &Finding| {
            matches!(
                finding,
                Finding::Breaks(BreakFinding::Jump { at_least: true, .. })
            )
        };
        let told = judge(&evidence).findings.iter().any(at_least);
        assert_eq!(told, flickering > 0);
        let cause = judge(&evidence).cause;
        let of_solver = cause.is_some_and(|cause| {
            cause.kind == CauseKind::SolverTolerance
                && cause
                    .text
                    .contains(&format!("At {flickering} of {breaks} breaks"))
        });
        let what = format!("{flickering} of {breaks}");
        assert_eq!(of_solver, expected, "{what}");
        assert_eq!(advice.contains(&Advice::SmootherForce), !expected, "{what}");
    }
}

#[test]
fn loops_that_wind_prove_nothing_but_that_a_map_is_not_exact() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    let mut winding = of_loop(2, LoopKind::Winding, vec![step(0.5, 0.1, 1e-15)]);
    winding.winds = true;
    evidence.loops.push(winding);
    let verdict = judge(&evidence);
    assert_eq!(verdict.kind, Symplectic);
    assert!(
        verdict
            .sentences()
            .iter()
            .any(|line| line.contains("no Hamiltonian with this period"))
    );
    evidence.loops.drain(..2);
    assert_eq!(
        decides(&evidence),
        Finding::Changes(ChangeFinding::AllLoopsWind)
    );
}

#[test]
fn orders_are_those_of_whole_slopes_above_one_half() {
    let law = |k: f64| -> Verdict {
        let steps = (1..=8).map(|m| 0.5f64.powi(m));
        judge(&of_map(
            steps.map(|h| step(h, 0.3 * h.powf(k), 1e-15)).collect(),
        ))
    };
    for (slope, order) in [
        (0.4, None),
        (1.0, Some(1.0)),
        (2.1, Some(2.0)),
        (2.5, None),
        (3.0, Some(3.0)),
    ] {
        let verdict = law(slope);
        assert_eq!(verdict.kind, NotSymplectic);
        assert_eq!(verdict.order, order, "h^{slope}");
    }
}

#[test]
fn a_defect_that_is_the_same_at_all_step_sizes_is_named_if_it_has_few_digits() {
    let rows = |sizes: &[f64]| {
        let steps = sizes.iter().map(|&h| step(h, -1.5e-3, 1.4e-4));
        judge(&of_samples(steps.collect()))
    };
    let verdict = rows(&[0.32, 0.16, 0.08]);
    assert_eq!(verdict.kind, NotSymplectic);
    let cause = verdict.cause.as_ref().map(|cause| cause.kind);
    assert_eq!(cause, Some(CauseKind::IndependentOfStepSize));
    // Further step sizes show the same.
    assert!(verdict.advice()[0].starts_with("Compare the states before and after"));
    assert!(
        !verdict
            .advice()
            .concat()
            .contains("to learn the power of h")
    );
    // Over a factor of two, a method looks the same.
    let verdict = rows(&[0.32, 0.16]);
    assert!(verdict.cause.is_none());
    assert!(
        verdict
            .advice()
            .concat()
            .contains("to learn the power of h")
    );
}

#[test]
fn the_jacobian_shows_that_a_defect_does_not_depend_on_the_step_size() {
    let cause = |slope: f64, uncertainty: f64, smaller: f64| {
        let mut evidence = of_map(vec![
            step(1.0, -1e-3, 5e-5),
            step(0.5, -1e-3, 1e-3),
            step(0.25, -1e-3, 1e-3),
        ]);
        let defect = |signed: f64| TangentDefect {
            s: 0.1,
            signed,
            uncertainty,
            dofs: None,
        };
        evidence.jacobian_decay = Some(JacobianDecay {
            step_sizes: [1.0, smaller],
            defects: [defect(0.6), defect(0.6 * smaller.powf(slope))],
        });
        judge(&evidence).cause
    };
    let found = cause(0.0, 1e-9, 0.25).expect("a cause");
    assert_eq!(found.kind, CauseKind::IndependentOfStepSize);
    let words = "The defect of the Jacobian is about the same at all step sizes from 0.25 to 1.";
    assert!(found.text.starts_with(words), "{}", found.text);
    // One that depends on h, is not known well enough, or at step sizes that are too near.
    for (slope, uncertainty, smaller) in [(1.0, 1e-9, 0.25), (0.0, 0.2, 0.25), (0.0, 1e-9, 0.5)] {
        assert_eq!(cause(slope, uncertainty, smaller), None);
    }
}

#[test]
fn errors_at_few_states_are_excluded_from_what_loops_show() {
    let one_in = |evidence: &Evidence| {
        let verdict = judge(evidence);
        verdict.findings.iter().find_map(|finding| match finding {
            Finding::Bounds(BoundFinding::Resolution { one_in, .. }) => Some(*one_in),
            _ => None,
        })
    };
    // Of 128 random states, e⁻⁷ = 1/1100 of all draws miss an error at one in 18.
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15), step(0.25, 0.0, 1e-15)]);
    assert_eq!(kind(&evidence), Symplectic);
    assert_eq!(one_in(&evidence), Some(Some(18)));
    let missed = (1.0f64 - 1.0 / 18.0).powi(128);
    assert!((0.3e-3..1e-3).contains(&missed), "{missed}");
    // A loop that does not bound the defect shows no error.
    let mut loose = of_loop(2, LoopKind::Random, vec![step(0.5, 0.0, 1e-3)]);
    loose.samples = 4096;
    evidence.loops.push(loose);
    assert_eq!(one_in(&evidence), Some(Some(18)));
    let mut unknown = of_map(vec![step(0.5, 0.0, 1e-3)]);
    unknown.loops.truncate(1);
    assert_eq!(one_in(&unknown), Some(None));
}

#[test]
fn a_loop_that_hides_terms_of_lower_order_states_no_order() {
    // The defects of the random loop change their sign, and fall by four at the smallest steps.
    let sizes = [0.4, 0.2, 0.1, 0.05];
    let of_random = |defects: [f64; 4]| {
        let mut evidence = of_map(sizes.map(|h| step(h, -0.3 * h.powi(3), 1e-13)).into());
        let steps = sizes.iter().zip(defects);
        evidence.loops[1].steps = steps.map(|(&h, defect)| step(h, defect, 1e-13)).collect();
        judge(&evidence)
    };
    let verdict = of_random([-4.7e-2, 5.9e-3, 2.3e-3, 5.6e-4]);
    assert_eq!((verdict.kind, verdict.order), (NotSymplectic, None));
    assert!(!verdict.summary().contains("falling as"), "{verdict}");
    assert!(verdict.advice().concat().contains("smaller step sizes"));
    // They fall no slower here.
    let verdict = of_random([-4.7e-2, 5.9e-3, 4.5e-3, 5.6e-4]);
    assert_eq!(verdict.order, Some(3.0));
}

#[test]
fn a_constant_part_is_a_term_of_the_law() {
    let with_noise = |law: fn(f64) -> f64, noise: f64| {
        let sizes = (1..=10).map(|m| 0.5f64.powi(m));
        judge(&of_map(sizes.map(|h| step(h, law(h), noise)).collect()))
    };
    let of = |law| with_noise(law, 1e-15);
    for sign in [1e-6, -1e-6] {
        let verdict = match sign > 0.0 {
            true => of(|h| 0.1 * h.powi(3) + 1e-6),
            false => of(|h| 0.1 * h.powi(3) - 1e-6),
        };
        assert_eq!(verdict.order, Some(3.0), "{verdict}");
        let constant = verdict.fits[0].constant.unwrap();
        assert!((constant / sign - 1.0).abs() < 0.05, "{constant:e}");
        assert!(verdict.summary().contains("constant part"), "{verdict}");
    }
    // Whether it is a constant, or a lower power, one point does not show.
    assert_eq!(with_noise(|h| h.powi(7) + 1e-13, 5e-15).order, None);
    // Nothing else falls but a small part of it.
    let verdict = of(|h| 1e-3 + 1e-4 * h.powi(3));
    assert_eq!(verdict.order, None);
    let kind = verdict.cause.map(|cause| cause.kind);
    assert_eq!(kind, Some(CauseKind::IndependentOfStepSize));
}

#[test]
fn no_order_lies_outside_the_local_slopes() {
    // Two loops by Tao's method: a fit with one degree of freedom left passes for h^0.9 and h^1.8.
    for defects in [
        [1.68e-3, 2.26e-4, 3.05e-5, 4.52e-6, 8.57e-7],
        [2.04e-3, 2.63e-4, 3.20e-5, 3.35e-6, 1.11e-7],
    ] {
        let sizes = [0.4, 0.2, 0.1, 0.05, 0.025].into_iter();
        let steps = sizes.zip(defects).map(|(h, d)| step(h, d, 1e-15));
        let verdict = judge(&of_map(steps.collect()));
        assert_eq!((verdict.kind, verdict.order), (NotSymplectic, None));
        for fit in &verdict.fits {
            assert!((2.4..4.92).contains(&fit.slope), "{fit:?}");
        }
    }
}

#[test]
fn the_jacobian_supports_the_order() {
    let defect = |signed: f64| TangentDefect {
        s: 0.1,
        signed,
        uncertainty: 1e-12,
        dofs: None,
    };
    let of = |slope: f64| {
        let sizes = (1..=8).map(|m| 0.5f64.powi(m));
        let steps = sizes.map(|h| step(h, 0.3 * h.powi(4), 1e-15));
        let mut evidence = of_map(steps.collect());
        evidence.jacobian_decay = Some(JacobianDecay {
            step_sizes: [0.5, 0.125],
            defects: [defect(1e-2), defect(1e-2 * 0.25f64.powf(slope))],
        });
        judge(&evidence)
    };
    // A point may hide the order of the loops, and show the next one.
    for (slope, order) in [(3.4, None), (3.6, Some(4.0)), (5.4, Some(4.0)), (5.6, None)] {
        let verdict = of(slope);
        assert_eq!(verdict.order, order, "{slope}");
        let differ = |finding: &Finding| {
            matches!(
                finding,
                Finding::Changes(ChangeFinding::OrdersDiffer { .. })
            )
        };
        let told = verdict.findings.iter().any(differ);
        assert_eq!(told, order.is_none(), "{slope}");
        assert_eq!(
            verdict.summary().contains("in proportion to"),
            order.is_some(),
            "{verdict}"
        );
    }
    // One that shows nothing, where loops change by much.
    let sizes = (1..=8).map(|m| 0.5f64.powi(m));
    let steps: Vec<StepEvidence> = sizes.map(|h| step(h, 0.3 * h.powi(4), 1e-15)).collect();
    let mut evidence = of_map(steps);
    assert_eq!(judge(&evidence).order, Some(4.0));
    evidence.jacobian = Some(symplectic_jacobian(1e-9));
    assert_eq!(judge(&evidence).order, None);
}

#[test]
fn a_defect_that_is_gone_at_the_next_step_size_is_a_step_that_does_not_converge() {
    let of = |below: f64| {
        let defects = [5.2e-4, below, below, below];
        let sizes = [0.5, 0.25, 0.125, 0.0625].into_iter();
        let steps = sizes.zip(defects).map(|(h, d)| step(h, d, 1e-15));
        judge(&of_map(steps.collect()))
    };
    let verdict = of(1e-16);
    assert_eq!(verdict.kind, NotSymplectic);
    assert_eq!(
        verdict.advice,
        [Advice::LetStepConverge { converges: 0.25 }]
    );
    let text = verdict.sentences().concat();
    assert!(text.contains("fails to converge at h = 0.5"), "{text}");
    // A power of h falls more slowly.
    assert!(!of(1e-7).sentences().concat().contains("converge"));
}

#[test]
fn a_small_break_hides_no_large_change() {
    let broken = |signed: f64, reach: f64| {
        let mut evidence = of_map(vec![step(0.5, signed, 3e-8), step(0.25, 7e-8, 2.7e-6)]);
        let broken = &mut evidence.loops[0].steps[1];
        (broken.jump, broken.reach_of_jumps) = (Some(JUMP), reach);
        evidence
    };
    // A hundred times what the jumps reach, with the uncertainty.
    for (signed, reach, expected) in [
        (5.2e-4, 5e-6, NotSymplectic),
        (5.2e-4, 5.3e-6, BrokenLoops),
        (2.9e-6, 1e-12, BrokenLoops),
        (3.1e-6, 1e-12, NotSymplectic),
        // It is not known how far they reach.
        (5.2e-4, 0.0, BrokenLoops),
    ] {
        let verdict = judge(&broken(signed, reach));
        assert_eq!(verdict.kind, expected, "{signed:e} and {reach:e}");
        assert!(matches!(
            (&verdict.findings[0], expected),
            (
                Finding::Changes(ChangeFinding::Changes { .. }),
                NotSymplectic
            ) | (
                Finding::Breaks(BreakFinding::Discontinuous { .. }),
                BrokenLoops
            )
        ));
        let jumps =
            |finding: &Finding| matches!(finding, Finding::Breaks(BreakFinding::Jump { .. }));
        assert!(verdict.findings.iter().any(jumps));
    }
    // The step that is broken itself, if its closed integral changes by as much.
    let mut evidence = broken(0.0, 1e-6);
    let step = &mut evidence.loops[0].steps[1];
    step.defect = defect(1e-3, 1e-9);
    for (closed, expected) in [(1e-3, NotSymplectic), (1e-6, BrokenLoops)] {
        let step = &mut evidence.loops[0].steps[1];
        step.closing = Some(ClosedBreaks {
            breaks: 1,
            chord: 0.0,
            closed: defect(closed, 1e-9),
            bend: 0.0,
            straight: true,
        });
        assert_eq!(kind(&evidence), expected, "{closed:e}");
    }
}

#[test]
fn radii_that_do_not_fit_the_motion_are_named_first() {
    for (imbalance, told) in [(0.9e3, false), (1.1e3, true)] {
        let balanced = Advice::BalancedRadii { imbalance };
        // A loop that hardly moves, and one that is torn apart.
        let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
        evidence.loops[0].steps[0].motion = Some(motion(0.01));
        for loops in &mut evidence.loops {
            let mut found = motion(0.01);
            found.imbalance = imbalance;
            loops.steps[0].motion = Some(found);
        }
        assert_eq!(judge(&evidence).advice[0] == balanced, told);
        let mut evidence = of_map(vec![step(0.5, 0.0, 1e-3)]);
        let mut found = motion(1.0);
        (found.deformation, found.imbalance) = (1e9, imbalance);
        evidence.loops[0].steps[0].motion = Some(found);
        assert_eq!(judge(&evidence).advice == [balanced], told);
    }
}

#[test]
fn advice_does_not_contradict_itself_for_maps_with_few_digits() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 2e-6)]);
    evidence.survey.single_inside = true;
    let larger = [Advice::MoreDigits, Advice::LargerLoopOrMoreSamples];
    assert_eq!(judge(&evidence).advice, larger);
    evidence.loops[0].steps[0].defect = defect(0.0, 1e-8);
    assert_eq!(judge(&evidence).kind, Symplectic);
    assert_eq!(judge(&evidence).advice, larger);
    evidence.loops[0].steps[0].defect = defect(0.0, 2e-6);
    let deformed = evidence.loops[0].steps[0].motion.as_mut().unwrap();
    deformed.deformation = 101.0;
    let smaller = Advice::SmallerSteps { deformation: 101.0 };
    assert_eq!(judge(&evidence).advice, [smaller, Advice::MoreDigits]);
}

#[test]
fn no_bound_in_the_evidence_exceeds_the_summary() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 2e-6), step(0.25, 0.0, 5e-4)]);
    assert!(matches!(
        decides(&evidence),
        Finding::Bounds(BoundFinding::WeakBound { bound: 5e-4, .. })
    ));
    evidence.loops[0].steps = vec![step(0.5, 0.0, 1e-14)];
    evidence.loops[0].steps[0].motion = Some(motion(0.5));
    let weak = of_loop(2, LoopKind::Random, vec![step(0.5, 0.0, 1e-3)]);
    evidence.loops.push(weak);
    let verdict = judge(&evidence);
    let Finding::Bounds(BoundFinding::Conserved { bound, .. }) = verdict.findings[0] else {
        panic!("{verdict}");
    };
    for finding in &verdict.findings {
        if let Finding::Bounds(BoundFinding::Bound { bound: other, .. }) = finding {
            assert!(other.unwrap() <= bound, "{finding}");
        }
    }
}

#[test]
fn advice_on_the_order_says_what_is_missing() {
    let advice = |steps: Vec<StepEvidence>| judge(&of_map(steps)).advice().join(" ");
    let few = vec![step(0.5, 1e-3, 1e-15), step(0.25, 1e-4, 1e-15)];
    assert!(advice(few).contains("four or more step sizes"));
    let sizes = || (1..=7).map(|m| 0.5f64.powi(m));
    let drowned = sizes()
        .map(|h| step(h, if h == 0.5 { 1e-3 } else { 0.0 }, 1e-5))
        .collect();
    assert!(advice(drowned).contains("larger step sizes"));
    let scattered = sizes().enumerate();
    let scattered = scattered
        .map(|(m, h)| step(h, [1e-3, 5e-6, 2e-3][m % 3], 1e-15))
        .collect();
    let text = advice(scattered);
    assert!(text.contains("do not follow one power"), "{text}");
    let constant = sizes().map(|h| step(h, 1e-3, 1e-15)).collect();
    assert!(advice(constant).contains("a step of a very small size"));
    // Four were given: the budget was spent, or the map failed.
    let three = sizes().zip([1e-3, 5e-6, 2e-3]);
    let mut spent = of_map(three.map(|(h, d)| step(h, d, 1e-15)).collect());
    spent.omissions = vec![self::spent(Check::GivenLoop, 1)];
    spent.evaluations.by_check.insert(Check::GivenLoop, 300);
    // The likeliest causes come first.
    let causes = Advice::LookForCause { order: None };
    assert_eq!(
        judge(&spent).advice,
        [causes, Advice::MoreEvaluations { wanted: 200 }]
    );
    spent.omissions = vec![Omission {
        check: Check::GivenLoop,
        why: OmissionReason::Failed {
            step_size: Some(1.0),
            reason: "the map failed".into(),
        },
    }];
    let advice = judge(&spent).advice().concat();
    assert!(!advice.contains("four or more"), "{advice}");
}

#[test]
fn jumps_of_samples_count_from_the_size_that_single_precision_cannot_explain() {
    let jumping = |largest: f64, confirmed: usize| {
        let mut evidence = of_samples(vec![step(0.5, 0.0, 1e-9)]);
        let step = &mut evidence.loops[0].steps[0];
        step.jumping = Some(JumpingCells {
            cells: 2,
            confirmed,
            largest,
        });
        step.jump = (confirmed > 0).then_some(JUMP);
        evidence
    };
    assert_eq!(kind(&jumping(1.1e-6, 2)), BrokenLoops);
    assert!(matches!(
        decides(&jumping(0.9e-6, 2)),
        Finding::Samples(SampleFinding::SmallJumps { .. })
    ));
    assert!(matches!(
        decides(&jumping(0.0, 0)),
        Finding::Samples(SampleFinding::TooFewForJumps { cells: 2, .. })
    ));
}

#[test]
fn files_that_hold_no_closed_loop_are_told_why() {
    let fine = || of_samples(vec![step(0.5, 0.0, 1e-9)]);
    assert_eq!(kind(&fine()), Symplectic);
    let mut wrapped = fine();
    wrapped.loops[0].wrap_before = Some(Wrap {
        dof: 0,
        period: 2.5,
    });
    assert!(matches!(
        decides(&wrapped),
        Finding::Samples(SampleFinding::Wrapped { step: None, .. })
    ));
    let mut wrapped = fine();
    wrapped.loops[0].steps[0].wrap = Some(Wrap {
        dof: 0,
        period: 2.5,
    });
    assert!(matches!(
        decides(&wrapped),
        Finding::Samples(SampleFinding::Wrapped { step: Some(_), .. })
    ));
    let mut open = fine();
    open.loops[0].broken_before = Some(JUMP);
    assert!(matches!(
        decides(&open),
        Finding::Samples(SampleFinding::NotClosed { .. })
    ));
    for (ratio, shuffled) in [(3.9, false), (4.1, true)] {
        let mut evidence = fine();
        evidence.loops[0].shuffled = Some(ratio);
        let found = matches!(
            decides(&evidence),
            Finding::Samples(SampleFinding::Shuffled { .. })
        );
        assert_eq!(found, shuffled, "{ratio}");
    }
}

#[test]
fn copies_are_told_from_small_steps() {
    let mut evidence = of_samples(vec![step(0.5, 0.0, 1e-15)]);
    evidence.loops[0].steps[0].motion = Some(shear(0.0));
    assert!(judge(&evidence).advice()[0].contains("copies"));
    evidence.loops[0].steps[0].motion = Some(shear(0.1));
    assert!(judge(&evidence).advice()[0].contains("larger step sizes"));
}

#[test]
fn what_many_steps_do_follows_from_four_numbers() {
    let growth = |asked: usize, steps: usize, early: f64, late: f64, least: f64| {
        let mut evidence = of_map(vec![step(0.5, 1e-3, 1e-15)]);
        let json = serde_json::json!({
            "step_size": 0.5, "asked": asked, "steps": steps, "samples": 64,
            "largest": early.max(late), "early": early, "late": late, "least": least,
        });
        let found: LongTime = serde_json::from_value(json).unwrap();
        evidence.long_time = Some(found);
        let verdict = judge(&evidence);
        let finding = (verdict.findings.iter()).find_map(|finding| match finding {
            Finding::Run(RunFinding::ManySteps { growth, .. }) => {
                Some((*growth, finding.to_string()))
            }
            _ => None,
        });
        finding.unwrap()
    };
    assert_eq!(growth(100, 15, 1e-3, 4e-3, 0.0).0, Growth::Undecided);
    assert_eq!(growth(100, 100, 1e-12, 9e-12, 0.0).0, Growth::None);
    assert_eq!(growth(100, 100, 1e-3, 2.6e-3, 1e-3).0, Growth::Grows);
    assert_eq!(growth(100, 100, 1e-3, 1.7e-3, 0.8e-3).0, Growth::Bounded);
    assert_eq!(growth(100, 100, 1e-3, 1.7e-3, 0.9e-3).0, Growth::Undecided);
    assert_eq!(growth(100, 100, 1e-3, 1.9e-3, 0.1e-3).0, Growth::Undecided);
    let (_, text) = growth(1000, 22, 1e-3, 4e-3, 0.0);
    assert!(text.contains("After step 22 of 1000"), "{text}");
    let (_, text) = growth(1000, 0, 0.0, 0.0, 0.0);
    assert!(text.contains("after the first step, 64 samples"), "{text}");
}

#[test]
fn a_weak_bound_needs_larger_steps_than_a_sharp_one() {
    // Runge and Kutta's method of order 4 would show a defect of θ⁶/72: ten times the bound is asked for.
    for (phase_advance, bound, told) in [
        (0.051, 1e-7, Some("near 2:")),
        (0.2, 9.9e-7, Some("near 0.7:")),
        (0.2, 8.8e-7, None),
    ] {
        let mut evidence = of_samples(vec![step(0.5, 0.0, bound)]);
        evidence.loops[0].steps[0].motion = Some(motion(phase_advance));
        let verdict = judge(&evidence);
        match told {
            Some(told) => assert!(
                verdict.advice()[0].contains(told),
                "{}",
                verdict.advice()[0]
            ),
            None => assert_eq!(verdict.kind, Symplectic),
        }
    }
}

#[test]
fn every_group_has_to_be_moved() {
    let group = |dofs: &[usize]| DofGroup {
        dofs: dofs.to_vec(),
        action: 1.0,
    };
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-14)]);
    evidence.groups = vec![group(&[0]), group(&[1]), group(&[2])];
    for (index, phase_advance) in [(1, 0.01), (2, 0.5)] {
        let mut found = of_loop(8 + index, LoopKind::Group, vec![step(0.5, 0.0, 1e-14)]);
        found.group = Some(index);
        found.steps[0].motion = Some(motion(phase_advance));
        evidence.loops.push(found);
    }
    let because = Finding::Map(MapFinding::LittleMotion {
        motion: motion(0.01),
        group: Some(1),
    });
    assert_eq!(decides(&evidence), because);
    evidence.loops[2].steps[0].motion = Some(motion(0.5));
    assert_eq!(kind(&evidence), Symplectic);
}

#[test]
fn without_random_loops_the_jacobian_has_to_bound_as_much_as_the_loop() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-9)]);
    evidence.loops.truncate(1);
    evidence.omissions = vec![spent(Check::RandomLoops, 3)];
    assert_eq!(
        decides(&evidence),
        Finding::Bounds(BoundFinding::NoRandomLoop)
    );
    for (bound, expected) in [(0.9e-9, Symplectic), (1.1e-9, Undecided)] {
        evidence.jacobian = Some(symplectic_jacobian(bound));
        assert_eq!(kind(&evidence), expected, "{bound}");
    }
}

#[test]
fn advice_on_a_weak_bound_follows_what_makes_it() {
    let advice = |deformation: f64, roundoff: f64, rounded: bool| {
        let mut evidence = of_map(vec![step(0.5, 0.0, 1e-3)]);
        let step = &mut evidence.loops[0].steps[0];
        step.motion.as_mut().unwrap().deformation = deformation;
        step.defect.roundoff = roundoff;
        evidence.survey.single_inside = rounded;
        judge(&evidence).advice[0].clone()
    };
    let smaller = Advice::SmallerLoop { deformation: 101.0 };
    assert_eq!(advice(101.0, 0.0, false), smaller);
    assert_eq!(advice(99.0, 0.0, false), Advice::MoreSamplesOrSmallerLoop);
    // Rounding makes more than half of the uncertainty, or less.
    assert_eq!(advice(1.0, 1.1e-3, true), Advice::MoreDigits);
    assert_eq!(advice(1.0, 1.1e-3, false), Advice::LargerLoop);
    assert_eq!(advice(1.0, 0.9e-3, false), Advice::MoreSamplesOrSmallerLoop);
}

#[test]
fn a_tiny_loop_far_from_the_origin_gets_larger() {
    let step = PerSample::new(1, |h, q, p| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    });
    let with_radius = |radius: f64| {
        let circle = Circle::new(vec![1.0], vec![0.5], radius).unwrap();
        Diagnostic::halving(-1, -3).run(&step, &circle).unwrap()
    };
    let verdict = with_radius(1e-12).verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided);
    assert_eq!(verdict.advice[..], [Advice::LargerLoop]);
    // The advice helps.
    assert_eq!(with_radius(1e-6).verdict.kind, VerdictKind::Symplectic);
}

#[test]
fn the_jacobian_refutes_loops_that_are_conserved() {
    let mut jacobian = symplectic_jacobian(1e-9);
    for worst in [&mut jacobian.worst, &mut jacobian.points[0].worst] {
        worst.as_mut().unwrap().signed = 1e-3;
    }
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    assert_eq!(kind(&evidence), Symplectic);
    evidence.jacobian = Some(jacobian);
    assert_eq!(
        decides(&evidence),
        Finding::Run(RunFinding::JacobianRefutes)
    );
    assert_eq!(judge(&evidence).advice, [Advice::OtherLoops]);
    assert_eq!(kind(&evidence), Undecided);
    // A spent budget comes first, and a tolerance if the defect is as small as one.
    evidence.omissions = vec![spent(Check::RandomLoops, 3)];
    evidence.evaluations.wanted = 640;
    let more = Advice::MoreEvaluations { wanted: 640 };
    assert_eq!(judge(&evidence).advice, [more, Advice::OtherLoops]);
    evidence.omissions.clear();
    let jacobian = evidence.jacobian.as_mut().unwrap();
    for worst in [&mut jacobian.worst, &mut jacobian.points[0].worst] {
        worst.as_mut().unwrap().signed = 1e-7;
    }
    let by_tolerance = [Advice::TightenSolver, Advice::OtherLoops];
    assert_eq!(judge(&evidence).advice, by_tolerance);
}

#[test]
fn steps_are_named_by_what_is_known_of_them() {
    let name = |sizes: &[Option<f64>]| {
        let mut steps: Vec<StepEvidence> = (sizes.iter()).map(|_| step(0.5, 0.0, 1e-15)).collect();
        for (step, size) in steps.iter_mut().zip(sizes) {
            step.step_size = *size;
        }
        let last = steps.last_mut().unwrap();
        last.defect = defect(1e-3, 1e-15);
        match decides(&of_samples(steps)) {
            Finding::Changes(ChangeFinding::Changes { step, .. }) => step,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(name(&[Some(0.5), Some(0.25)]), Step::Size(0.25));
    assert_eq!(name(&[None]), Step::Only);
    assert_eq!(name(&[None, None, None]), Step::Number(3));
}

#[test]
fn evaluations_are_told_where_a_map_was_called() {
    let told = |evidence: &Evidence| {
        let findings = judge(evidence).findings;
        let mut of_calls = findings.iter().filter_map(|finding| match finding {
            Finding::Run(RunFinding::Evaluations { made, budget }) => Some((*made, *budget)),
            _ => None,
        });
        of_calls.next()
    };
    for (made, of_a_map) in [(0, None), (640, Some((640, 1000)))] {
        for (origin, expected) in [
            (of_map as fn(Vec<StepEvidence>) -> Evidence, of_a_map),
            (of_samples, None),
        ] {
            let mut evidence = origin(vec![step(0.5, 0.0, 1e-15)]);
            evidence.evaluations.made = made;
            evidence.evaluations.budget = 1000;
            assert_eq!(told(&evidence), expected);
        }
    }
}

#[test]
fn motion_on_a_loop_that_winds_is_no_evidence_of_a_symplectic_map() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    evidence.loops[0].steps[0].motion = Some(motion(0.01));
    let mut winding = of_loop(2, LoopKind::Winding, vec![step(0.5, 0.0, 1e-15)]);
    winding.winds = true;
    winding.steps[0].motion = Some(motion(0.5));
    evidence.loops.push(winding);
    assert_eq!(kind(&evidence), Undecided);
}

#[test]
fn what_the_budget_left_out_is_said_with_what_it_would_take() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-3)]);
    evidence.omissions.push(Omission {
        check: Check::GivenLoop,
        why: OmissionReason::Unresolved,
    });
    evidence.evaluations.wanted = 640;
    let verdict = judge(&evidence);
    assert_eq!(verdict.kind, Undecided);
    assert!(verdict.advice()[0].contains("about 640 evaluations"));
}

#[test]
fn evidence_survives_json_to_the_last_bit() {
    let mut evidence = of_map(vec![
        step(1.0 / 3.0, 0.1 + 0.2, 1e-15),
        step(0.25, 1e-300, 5e-324),
    ]);
    evidence.loops[0].steps[0].jump = Some(JUMP);
    let text = serde_json::to_string(&evidence).unwrap();
    let read: Evidence = serde_json::from_str(&text).unwrap();
    assert_eq!(read, evidence);
    assert_eq!(judge(&read), judge(&evidence));
}

#[test]
fn a_kick_is_judged_by_its_bound_however_little_it_deforms() {
    for deformation in [1e-14, 1e-3] {
        let mut kick = shear(deformation);
        kick.moves = true;
        for (origin, expected) in [
            (of_map as fn(Vec<StepEvidence>) -> Evidence, Symplectic),
            // Loops of another code may be of any step.
            (of_samples, Undecided),
        ] {
            let mut evidence = origin(vec![step(0.5, 0.0, 1e-15)]);
            evidence.loops[0].steps[0].motion = Some(kick);
            assert_eq!(kind(&evidence), expected, "{deformation}");
        }
    }
}

/// A map without a step size, which moves its loops by this phase advance.
fn without_step_size(phase_advance: f64, signed: f64) -> Evidence {
    let mut evidence = of_map(vec![step(0.5, signed, 1e-15)]);
    for found in &mut evidence.loops {
        found.steps[0].step_size = None;
        found.steps[0].motion = Some(motion(phase_advance));
    }
    evidence.radii = Some([0.25, 0.5]);
    evidence
}

#[test]
fn a_map_without_a_step_size_is_judged_itself() {
    let mut evidence = without_step_size(1e-5, 0.0);
    let verdict = judge(&evidence);
    assert_eq!(verdict.kind, Symplectic);
    let summary = "No change above 1.0e-15: on your loop, and on a random one, with radii up to 0.25 in q \
                   and 0.50 in p.";
    assert_eq!(verdict.summary(), summary);
    // A larger loop that is conserved counts, and one that is not leaves it open.
    let mut reach = Reach::default();
    reach.factor = 16.0;
    reach.step = step(0.5, 0.0, 1e-15);
    reach.step.step_size = None;
    evidence.reach = Some(reach);
    assert!(
        judge(&evidence)
            .summary()
            .contains("radii up to 4.00 in q and 8.00 in p")
    );
    reach.step.defect.signed = 1e-3;
    evidence.reach = Some(reach);
    let verdict = judge(&evidence);
    assert_eq!(verdict.kind, Undecided);
    assert_eq!(verdict.advice, [Advice::LargerRadii { factor: 16.0 }]);
    // It has no order.
    let verdict = judge(&without_step_size(1e-5, 1e-3));
    assert_eq!((verdict.kind, verdict.order), (NotSymplectic, None));
    let text = verdict.summary() + &verdict.sentences().concat() + &verdict.advice().concat();
    assert!(text.contains("in one application"), "{text}");
    assert!(!text.contains("step") && !text.contains("h ="), "{text}");
}

#[test]
fn a_larger_step_decides_where_the_others_move_too_little() {
    for (signed, bound, advance, expected) in [
        // A defect is not one of the step sizes that were given.
        (1e-3, 1e-15, 0.7, Undecided),
        (0.0, 1e-15, 0.7, Symplectic),
        // Of a method that is not symplectic, a larger step than this would show a defect.
        (0.0, 1.1e-12, 0.03, Undecided),
        (0.0, 0.9e-12, 0.03, Symplectic),
        // The map does not depend on h.
        (0.0, 1.1e-12, 0.015, Symplectic),
    ] {
        let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
        evidence.loops[0].steps[0].motion = Some(motion(0.01));
        assert_eq!(kind(&evidence), Undecided, "no larger step was tried");
        let mut reach = Reach::default();
        reach.factor = 64.0;
        reach.step = step(32.0, signed, bound);
        reach.step.motion = Some(motion(advance));
        evidence.reach = Some(reach);
        let verdict = judge(&evidence);
        assert_eq!(verdict.kind, expected, "{signed} {advance}");
        if signed > 0.0 {
            let factor = Some(64.0);
            let step_size = Some(0.5);
            assert_eq!(verdict.advice, [Advice::LargerSteps { factor, step_size }]);
        }
    }
}

#[test]
fn a_loop_that_winds_proves_nothing_by_a_break() {
    let mut evidence = of_map(vec![step(0.5, 0.0, 1e-15)]);
    let mut winding = of_loop(8, LoopKind::Winding, vec![step(0.5, 1e-3, 1e-15)]);
    winding.winds = true;
    winding.wound = vec![0];
    winding.steps[0].jump = Some(JUMP);
    evidence.loops.push(winding);
    let verdict = judge(&evidence);
    assert_eq!(verdict.kind, Symplectic);
    let named = |finding: &Finding| {
        matches!(
            finding,
            Finding::Breaks(BreakFinding::Jump { loop_index: 8, .. })
        )
    };
    assert!(verdict.findings.iter().any(named), "{verdict}");
    let exact = |finding: &Finding| {
        matches!(
            finding,
            Finding::Changes(ChangeFinding::NotExact { .. })
                | Finding::Changes(ChangeFinding::Exact { .. })
        )
    };
    assert!(!verdict.findings.iter().any(exact), "{verdict}");
    // Nor do such loops alone.
    evidence.loops.drain(..2);
    assert_eq!(
        decides(&evidence),
        Finding::Changes(ChangeFinding::AllLoopsWind)
    );
}
