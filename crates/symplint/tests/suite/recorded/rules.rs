//! Integrals by each rule.

use std::fmt::Write;

use symplint::breaks::{Break, find_break};
use symplint::rules::{Closure, Cutoffs, Piecewise, Streaming};
use symplint::{Ensemble, LoopIntegral, Rule};

use crate::recorded::maps::cases;
use crate::recorded::record::check;

fn write_integral(text: &mut String, what: &str, integral: &LoopIntegral) {
    let estimate = |x: Option<f64>| x.map_or("unknown".into(), |x| format!("{x:.6e}"));
    writeln!(
        text,
        "  {what}: {:.12e} error {} roundoff {:.6e} scale {:.6e} regularity {}",
        integral.value,
        estimate(integral.quadrature_error),
        integral.roundoff,
        integral.scale,
        estimate(integral.regularity),
    )
    .unwrap();
    if integral.contributions.len() > 1 {
        let parts = integral.contributions.iter();
        let parts: Vec<_> = parts.map(|x| format!("{x:.9e}")).collect();
        writeln!(text, "    of {}", parts.join(" ")).unwrap();
    }
    if let Some(omitted) = integral.omitted.as_ref().filter(|cells| !cells.is_empty()) {
        let cells: Vec<_> = omitted.iter().map(|cell| (cell.dof, cell.cell)).collect();
        writeln!(text, "    without {cells:?}").unwrap();
    }
}

fn write_break(text: &mut String, found: &Break) {
    writeln!(
        text,
        "    break at {:.9e} ± {:.3e} of {} by {:.6e} {:.6e} in {:?}",
        found.s, found.uncertainty, found.dof, found.jump_q, found.jump_p, found.substep
    )
    .unwrap();
}

fn record(text: &mut String, rule: &Piecewise, what: &str, case: &crate::recorded::maps::Case) {
    let found = match rule.integrate(&*case.map, &*case.phase_loop, case.h) {
        Ok(found) => found,
        Err(error) => return writeln!(text, "{}, {what}: {error}", case.name).unwrap(),
    };
    writeln!(
        text,
        "{}, {what}: {} pieces, {} evaluations, {} flickering, {:.3e} of breaks, {:.3e} insubstantial, bend {:.6e}",
        case.name,
        found.pieces,
        found.evaluations,
        found.flickering,
        found.break_uncertainty,
        found.insubstantial,
        found.bend,
    )
    .unwrap();
    write_integral(text, "continuous", &found.continuous);
    if !found.breaks.is_empty() {
        write_integral(text, "closed", &found.closed());
    }
    found
        .breaks
        .iter()
        .for_each(|found| write_break(text, found));
    if let Some((from, _)) = found.unresolved.first() {
        let count = found.unresolved.len();
        writeln!(text, "    {count} stretches unresolved from {from:.6e}").unwrap();
    }
}

#[test]
fn piecewise() {
    let (mut text, plain) = (String::new(), Piecewise::default());
    let chords = Piecewise {
        closure: Closure::Chords,
        ..plain
    };
    for case in cases() {
        // Noise is of the last bits, and their number depends on the processor.
        record(
            &mut text,
            &Piecewise {
                most_evaluations: 40_000,
                ..plain
            },
            "in full",
            &case,
        );
        record(
            &mut text,
            &Piecewise {
                most_evaluations: 120,
                ..plain
            },
            "on 120",
            &case,
        );
        record(
            &mut text,
            &Piecewise {
                tolerance: 1e-7,
                pieces: 7,
                most_evaluations: 20_000,
                ..chords
            },
            "to 1e-7 by chords",
            &case,
        );
    }
    check("piecewise", &text);
}

#[test]
fn of_samples() {
    let mut text = String::new();
    for case in cases() {
        for samples in [33, 1000] {
            let mut ensemble = Ensemble::sample(&*case.phase_loop, samples).unwrap();
            ensemble.advance(&*case.map, case.h).unwrap();
            writeln!(text, "{}, {samples} samples", case.name).unwrap();
            for (what, rule) in [
                ("pseudospectral", Rule::Pseudospectral),
                (
                    "cells below 10",
                    Rule::FiniteDifference(Cutoffs::relative(10.0)),
                ),
            ] {
                let coordinates = case.map.capabilities().coordinates;
                match LoopIntegral::in_coordinates(&ensemble, &rule, &coordinates) {
                    Ok(integral) => write_integral(&mut text, what, &integral),
                    Err(error) => writeln!(text, "  {what}: {error}").unwrap(),
                }
            }
            let found = find_break(&*case.map, &*case.phase_loop, case.h, &ensemble).unwrap();
            found.iter().for_each(|found| write_break(&mut text, found));
        }
    }
    check("of_samples", &text);
}

#[test]
fn streaming() {
    let mut text = String::new();
    for case in cases() {
        for (half_width, samples) in [(8, 40), (16, 3000)] {
            let rule = Streaming { half_width };
            writeln!(text, "{}, {samples} samples", case.name).unwrap();
            match rule.integrate(&*case.map, &*case.phase_loop, case.h, samples) {
                Ok(found) => {
                    write_integral(&mut text, "streaming", &found.integral);
                    found
                        .found
                        .iter()
                        .for_each(|found| write_break(&mut text, found));
                    writeln!(
                        text,
                        "    {:.6e} cells, {} evaluations",
                        found.cells_apart, found.evaluations
                    )
                    .unwrap();
                }
                Err(error) => writeln!(text, "  {error}").unwrap(),
            }
        }
    }
    check("streaming", &text);
}
