//! What findings and advice say, variant by variant.

use serde_json::json;
use symplint::breaks::Break;
use symplint::evidence::{
    Check, Contraction, LongTime, Motion, Omission, OmissionReason, OutputFormat, OutputPrecision,
    Rank, Scatter, ScatterKind, Sector, SubstepDefect,
};
use symplint::verdict::{
    Advice, BoundFinding, BreakFinding, Change, ChangeFinding, DomainFinding, Finding, Growth,
    LocalisationFinding, MapFinding, RunFinding, SampleFinding, Step, StepRange,
};

use crate::recorded::record::check;

fn jump([jump_q, jump_p]: [f64; 2], substep: Option<usize>) -> Break {
    Break {
        s: 0.2503,
        uncertainty: 1e-15,
        dof: 3,
        jump_q,
        jump_p,
        substep,
    }
}

fn change(signed: f64, uncertainty: Option<f64>) -> Change {
    Change {
        signed,
        uncertainty,
    }
}

fn motion(deformation: f64, phase_advance: f64, shear: bool) -> Motion {
    let mut motion = Motion::default();
    motion.deformation = deformation;
    motion.phase_advance = phase_advance;
    motion.shear = shear;
    motion
}

fn many_steps(steps: usize, asked: usize) -> LongTime {
    serde_json::from_value(json!({
        "step_size": 0.5, "asked": asked, "steps": steps, "samples": 128,
        "largest": 3e-3, "early": 1.2e-3, "late": 2.4e-3, "least": 5e-5,
        "exponent": 1.03, "change": -2.4e-3, "predicted": [-2.5e-3, 2e-4],
    }))
    .unwrap()
}

fn substep(substep: usize, change: f64, uncertainty: Option<f64>, breaks: usize) -> SubstepDefect {
    SubstepDefect {
        substep,
        name: format!("kick of {} h", substep + 1),
        change,
        uncertainty,
        breaks,
        new_breaks: breaks,
    }
}

fn sectors(changes: &[f64], uncertainty: Option<f64>) -> Vec<Sector> {
    let count = changes.len() as f64;
    let each = changes.iter().enumerate();
    each.map(|(k, &change)| Sector {
        from: k as f64 / count,
        to: (k + 1) as f64 / count,
        change,
        uncertainty,
    })
    .collect()
}

fn write(text: &mut String, findings: impl IntoIterator<Item = Finding>) {
    findings
        .into_iter()
        .for_each(|finding| *text += &format!("{finding}\n"));
}

#[test]
fn of_findings() {
    let (half, third, only) = (Step::Size(0.5), Step::Number(3), Step::Only);
    let text = &mut String::new();
    write(
        text,
        [
            Finding::Run(RunFinding::NothingMeasured),
            Finding::Bounds(BoundFinding::OneState),
            Finding::Changes(ChangeFinding::AllLoopsWind),
        ],
    );
    write(
        text,
        [
            Finding::Bounds(BoundFinding::RandomLoopsFail),
            Finding::Bounds(BoundFinding::NoRandomLoop),
            Finding::Map(MapFinding::SingleInside),
        ],
    );
    write(
        text,
        [
            Finding::Run(RunFinding::JacobianRefutes),
            Finding::Samples(SampleFinding::SamplesAreNoProof { samples: 77 }),
        ],
    );
    for step in [None, Some(half), Some(third), Some(only)] {
        write(
            text,
            [Finding::Samples(SampleFinding::Wrapped {
                dof: 2,
                period: 6.5,
                step,
            })],
        );
    }
    // Jumps of one coordinate, of the other, and of both, next to a thousandth of each other.
    for jumps in [
        [1.0, 0.9e-3],
        [1.0, 1.1e-3],
        [0.9e-3, -1.0],
        [1.1e-3, -1.0],
        [0.2, 0.0],
    ] {
        write(
            text,
            [Finding::Samples(SampleFinding::NotClosed {
                jump: jump(jumps, None),
            })],
        );
        for conserved in [None, Some(true), Some(false)] {
            let jump = jump(jumps, Some(1));
            write(
                text,
                [Finding::Breaks(BreakFinding::Discontinuous {
                    jump,
                    conserved,
                })],
            );
        }
    }
    for (breaks, at_least, sampled, substep) in [
        (None, false, false, None),
        (Some(1), false, false, Some(0)),
        (Some(7), true, false, Some(6)),
        (Some(7), true, true, None),
    ] {
        let jump = jump([0.1, 0.2], substep);
        for (loop_index, step) in [(0, half), (4, third)] {
            write(
                text,
                [Finding::Breaks(BreakFinding::Jump {
                    loop_index,
                    step,
                    breaks,
                    at_least,
                    jump,
                    sampled,
                })],
            );
        }
    }
    // Step sizes in the ways that people write them.
    for h in [
        0.5,
        1.0,
        -0.25,
        0.3,
        0.1 + 0.2,
        1e-3,
        9e-4,
        999.0,
        1000.0,
        -12345.0,
    ] {
        let step = Step::Size(h);
        write(
            text,
            [Finding::Changes(ChangeFinding::Significant {
                change: change(2e-3, Some(1e-9)),
                loop_index: 1,
                step,
            })],
        );
    }
    for change in [
        change(-2e-3, None),
        change(1e-16, Some(3e-15)),
        change(0.5, Some(0.2)),
    ] {
        write(
            text,
            [
                Finding::Breaks(BreakFinding::ClosedChanges {
                    change,
                    straight: true,
                    bend: None,
                    loop_index: 0,
                    step: half,
                }),
                Finding::Breaks(BreakFinding::ClosedChanges {
                    change,
                    straight: false,
                    bend: None,
                    loop_index: 0,
                    step: half,
                }),
                Finding::Breaks(BreakFinding::ClosedChanges {
                    change,
                    straight: false,
                    bend: Some(0.3),
                    loop_index: 2,
                    step: only,
                }),
                Finding::Changes(ChangeFinding::NotExact {
                    loop_index: 3,
                    wound: vec![0],
                    change,
                    step: half,
                }),
                Finding::Domain(DomainFinding::ContractionUnknown {
                    loop_index: 1,
                    change,
                    step: half,
                    bound: 2e-9,
                }),
                Finding::Domain(DomainFinding::ManifoldUnknown {
                    loop_index: 1,
                    change,
                    step: third,
                }),
                Finding::Samples(SampleFinding::SampledBreaks {
                    step: third,
                    cells: 5,
                    confirmed: 4,
                    open: change,
                    closed: change,
                }),
            ],
        );
        for (points, area) in [(1, 3e-5), (3, 6e-4)] {
            let contraction = Contraction {
                s: [0.25, 0.5],
                r: [0.5, 0.625],
                points,
                area,
            };
            write(
                text,
                [Finding::Domain(DomainFinding::ChangesAtAPoint {
                    loop_index: 0,
                    change,
                    step: half,
                    contraction,
                })],
            );
        }
    }
    for (range, failed, random, given) in [
        (StepRange::Unknown, 0, 0, true),
        (StepRange::One(0.5), 1, 1, true),
        (StepRange::Between(0.125, 0.5), 2, 7, true),
        (StepRange::Between(0.125, 0.5), 0, 7, false),
    ] {
        write(
            text,
            [Finding::Bounds(BoundFinding::Conserved {
                bound: 3.3e-12,
                range,
                failed,
                random,
                given,
                radii: None,
            })],
        );
    }
    for motion in [
        motion(0.0, 0.0, false),
        motion(0.1, 1e-3, true),
        motion(0.1, 1e-3, false),
        motion(2.0, 0.7, false),
    ] {
        for group in [None, Some(1)] {
            write(
                text,
                [Finding::Map(MapFinding::LittleMotion { motion, group })],
            );
        }
        let moves = |has_step_size| {
            Finding::Map(MapFinding::Moves {
                motion,
                has_step_size,
            })
        };
        write(text, [moves(true), moves(false)]);
    }
    for (roundoff, too_few, sure) in [(true, true, Some(1e-9)), (false, false, None)] {
        write(
            text,
            [
                Finding::Bounds(BoundFinding::WeakBound {
                    loop_index: usize::from(too_few),
                    bound: 3e-5,
                    step: half,
                    roundoff,
                }),
                Finding::Samples(SampleFinding::UnknownIntegral {
                    samples: 16,
                    step: third,
                    too_few,
                }),
                Finding::Bounds(BoundFinding::Bound {
                    loop_index: 0,
                    samples: Some(64),
                    bound: sure,
                    measured: 2e-10,
                    uncertainty: sure,
                    step: half,
                }),
                Finding::Bounds(BoundFinding::Bound {
                    loop_index: 2,
                    samples: None,
                    bound: sure,
                    measured: 2e-10,
                    uncertainty: sure,
                    step: half,
                }),
            ],
        );
    }
    write(
        text,
        [
            Finding::Bounds(BoundFinding::MissesGrid {
                loop_index: 0,
                cells_apart: 0.7,
                step: half,
            }),
            Finding::Samples(SampleFinding::SmallJumps {
                size: 3e-7,
                step: half,
            }),
            Finding::Samples(SampleFinding::TooFewForJumps {
                cells: 3,
                step: half,
                samples: 40,
            }),
            Finding::Samples(SampleFinding::Shuffled { ratio: 21.5 }),
            Finding::Changes(ChangeFinding::Unexplained {
                defect: 3e-9,
                uncertainty: 1e-9,
                step: half,
            }),
            Finding::Samples(SampleFinding::JumpingSamples {
                loops: 2,
                of: 3,
                jumps: 9,
                step: third,
                samples: 128,
            }),
            Finding::Domain(DomainFinding::LoopBesideManifold {
                smallest: 1e-17,
                first: 0.2,
                second: 3e-14,
            }),
            Finding::Breaks(BreakFinding::BrokenCount { broken: 2, of: 5 }),
            Finding::Breaks(BreakFinding::ClosedConserved {
                bound: 1e-13,
                straight: false,
                loop_index: 0,
                step: half,
            }),
            Finding::Breaks(BreakFinding::ClosedConserved {
                bound: 1e-13,
                straight: true,
                loop_index: 6,
                step: third,
            }),
            Finding::Bounds(BoundFinding::MovesRest { loop_index: 2 }),
            Finding::Bounds(BoundFinding::LoopFailed {
                loop_index: 2,
                reason: "no root".into(),
            }),
            Finding::Changes(ChangeFinding::Exact {
                loop_index: 3,
                bound: 2e-14,
                wound: vec![0, 1],
            }),
            Finding::Bounds(BoundFinding::Resolution {
                samples: 4096,
                one_in: Some(585),
            }),
            Finding::Map(MapFinding::Scatter(Scatter {
                coordinate: 'p',
                dof: 2,
                size: 3e-9,
                kind: ScatterKind::Noise,
            })),
            Finding::Run(RunFinding::Evaluations {
                made: 12,
                budget: 200,
            }),
        ],
    );
    let rank = Rank { rank: 2, of: 3 };
    for given in [None, Some(1e-14)] {
        write(
            text,
            [Finding::Domain(DomainFinding::DegenerateForm {
                rank,
                given,
            })],
        );
    }
    write(text, [Finding::Domain(DomainFinding::LosesRank { rank })]);
    for (given, beside) in [(None, None), (Some(1e-14), Some((3, 0.2)))] {
        write(
            text,
            [Finding::Domain(DomainFinding::Projects {
                smallest: 3e-17,
                given,
                beside,
            })],
        );
    }
    for (index, dofs, by_loops, by_jacobian) in [
        (0, vec![7], Some(1e-13), None),
        (1, vec![0, 1, 2, 3], None, Some(2e-9)),
        (2, vec![4, 5, 6, 8, 9, 10, 11], Some(3e-12), Some(2e-9)),
    ] {
        write(
            text,
            [Finding::Bounds(BoundFinding::Group {
                index,
                of: 3,
                dofs,
                action: 2e-9,
                loops: 2,
                by_loops,
                by_jacobian,
            })],
        );
    }
    for exponent in [0.3, 0.99, 1.0, 1.9, 2.0, 4.4, 4.6] {
        write(
            text,
            [Finding::Map(MapFinding::Regularity {
                exponent,
                step: half,
            })],
        );
    }
    for format in [
        OutputFormat::Decimal { digits: 3 },
        OutputFormat::Multiples,
        OutputFormat::Single,
        OutputFormat::Binary { digits: 11 },
        OutputFormat::Binary { digits: 8 },
        OutputFormat::Binary { digits: 20 },
    ] {
        write(
            text,
            [Finding::Map(MapFinding::Precision(OutputPrecision {
                coordinate: 'q',
                dof: 1,
                format,
                unit: 1e-3,
            }))],
        );
    }
    for growth in [
        Growth::None,
        Growth::Bounded,
        Growth::Grows,
        Growth::Undecided,
    ] {
        for steps in [99, 100] {
            write(
                text,
                [Finding::Run(RunFinding::ManySteps {
                    steps: many_steps(steps, 100),
                    growth,
                })],
            );
        }
    }
    let (sure, quiet) = (Some(1e-12), substep(0, 1e-14, Some(1e-13), 0));
    for substeps in [
        vec![quiet.clone(), substep(1, 9e-12, sure, 0)],
        vec![quiet.clone(), substep(1, 11e-12, sure, 0)],
        vec![
            quiet.clone(),
            substep(1, 0.0, sure, 2),
            substep(2, -0.5, sure, 1),
        ],
        vec![substep(0, 0.5, sure, 0), substep(1, -0.4, sure, 0)],
        vec![substep(0, 0.5, sure, 0), substep(1, 0.0, None, 0)],
    ] {
        write(
            text,
            [Finding::Localisation(LocalisationFinding::Substeps {
                substeps,
                step: half,
            })],
        );
    }
    for (changes, uncertainty) in [
        (&[1e-3, -4e-3, 1e-3][..], Some(1e-9)),
        (&[2e-3, -2e-3, 2e-3], Some(1e-9)),
        (&[0.0, -4e-3, 0.0], Some(1e-2)),
        (&[0.0, -4e-3, 0.0], None),
    ] {
        write(
            text,
            [Finding::Localisation(LocalisationFinding::Sectors {
                sectors: sectors(changes, uncertainty),
                step: half,
            })],
        );
    }
    check("sentences_of_findings", text);
}

#[test]
fn of_advice() {
    let mut text = String::new();
    let (few, many) = (3e-9, 4e7);
    for advice in [
        Advice::MeasureLoop,
        Advice::StatePeriod,
        Advice::PeriodIfPeriodic,
        Advice::OrderOfSamples,
        Advice::MoreSamplesOfFile,
        Advice::SmootherForce,
        Advice::TightenSolver,
        Advice::MoreStepSizes { given: 1 },
        Advice::MoreStepSizes { given: 3 },
        Advice::NoOrder {
            given: 5,
            drowned: true,
        },
        Advice::NoOrder {
            given: 5,
            drowned: false,
        },
        Advice::StateStepSizes,
        Advice::LargerSteps {
            factor: None,
            step_size: None,
        },
        Advice::LargerSteps {
            factor: None,
            step_size: Some(0.25),
        },
        Advice::LargerSteps {
            factor: Some(3.2),
            step_size: None,
        },
        Advice::LargerSteps {
            factor: Some(3.2),
            step_size: Some(0.25),
        },
        Advice::LargerSteps {
            factor: Some(many),
            step_size: Some(few),
        },
        Advice::LoopWithForces,
        Advice::CheckCopies,
        Advice::ReturnStates,
        Advice::SamplesInCells,
        Advice::MoreSamplesAndLargerSteps,
        Advice::ContractibleLoops,
        Advice::LoopBesidePoint,
        Advice::LargerRadiiOfGroup,
        Advice::LoopOnManifold,
        Advice::Project,
        Advice::SmallerLoopInDomain,
        Advice::SmallerLoop { deformation: 250.0 },
        Advice::MoreSamplesOrSmallerLoop,
        Advice::RuleAuto,
        Advice::LargerLoop,
        Advice::MoreDigits,
        Advice::OtherLoops,
        Advice::MoreLoops,
        Advice::MoreLoopsOfFile,
        Advice::MoreEvaluations { wanted: 1234 },
        Advice::KeepToManifold,
        Advice::MovesNothing,
        Advice::CorrectPeriod,
        Advice::LookBeyondFriction,
        Advice::StepsAtOnce {
            repeat: 22,
            budget: None,
        },
        Advice::StepsAtOnce {
            repeat: 220,
            budget: Some(220_000),
        },
        Advice::UseStepSize,
    ] {
        text += &format!("{advice}\n");
    }
    check("sentences_of_advice", &text);
}

#[test]
fn of_omissions() {
    let failed = |step_size| OmissionReason::Failed {
        step_size,
        reason: "the map failed".into(),
    };
    let (one, three) = (
        OmissionReason::Budget { missing: 1 },
        OmissionReason::Budget { missing: 3 },
    );
    let memory = OmissionReason::Memory { samples: 64 };
    let of_checks = [
        (
            Check::GivenLoop,
            vec![
                one.clone(),
                three.clone(),
                OmissionReason::Unresolved,
                failed(Some(0.5)),
            ],
        ),
        (
            Check::SampleSweep,
            vec![one.clone(), three.clone(), failed(None)],
        ),
        (Check::RandomLoops, vec![one.clone(), three]),
        (
            Check::Jacobian,
            vec![one.clone(), memory.clone(), failed(None)],
        ),
        (Check::Constraint, vec![one.clone()]),
        (Check::Contraction, vec![one.clone(), failed(None)]),
        (Check::Localisation, vec![one.clone(), failed(None)]),
        (Check::ManySteps, vec![one, memory, failed(None)]),
    ];
    let mut text = String::new();
    for (check, whys) in of_checks {
        for why in whys {
            text += &format!("{}\n", Omission { check, why });
        }
    }
    check("sentences_of_omissions", &text);
}
