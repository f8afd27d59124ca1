//! Loop integrals of any samples, in any coordinates, by all rules of samples.

use arbitrary::{Result, Unstructured};
use symplint::breaks::find_break;
use symplint::map::balanced_radii;
use symplint::rules::{Cutoff, Cutoffs, logarithmic_defect};
use symplint::{
    Circle, Coordinates, Defect, Ensemble, Loop, LoopIntegral, PerSample, Rule, SampledLoop,
    Snapshot, measure,
};

use crate::numbers;
use crate::verdicts::judge_and_write;

/// Integrates, merges and compares loops that the bytes describe.
pub fn integrals(data: &[u8]) {
    let _ = integrate(&mut Unstructured::new(data));
}

fn integrate(u: &mut Unstructured<'_>) -> Result<()> {
    let dof = u.int_in_range(0..=4)?;
    let samples = match u.arbitrary()? {
        true => u.int_in_range(0..=12)?,
        false => *u.choose(&[16, 31, 32, 64, 100, 128, 257])?,
    };
    let Some(coordinates) = coordinates(u, dof)? else {
        return Ok(());
    };
    let before = states(u, dof, samples)?;
    let after = states(u, dof, samples)?;
    let rules = [
        Rule::Auto,
        Rule::Pseudospectral,
        Rule::FiniteDifference(Cutoffs::relative(numbers::any(u)?)),
        Rule::FiniteDifference(Cutoffs {
            q: Cutoff::Absolute(numbers::any(u)?),
            p: Cutoff::Relative(numbers::any(u)?),
        }),
    ];
    for rule in rules {
        let of = |states| LoopIntegral::in_coordinates(states, &rule, &coordinates);
        if let (Ok(a), Ok(b)) = (of(&before), of(&after)) {
            let _ = Defect::between(&a, &b);
            let _ = logarithmic_defect(a.value, b.value);
            let _ = LoopIntegral::merged(&[a, b]);
        }
    }
    let snapshots = [
        Snapshot::new(after.clone()).after_step(numbers::rarely_any(u)?),
        Snapshot::new(after.clone()).with_unit_roundoff(numbers::any(u)?),
    ];
    let before = Snapshot::new(before);
    for count in 0..=2 {
        if let Ok(diagnosis) = measure(&before, &snapshots[..count], &coordinates) {
            judge_and_write(diagnosis.evidence);
        }
    }
    between_samples(u, &before.states, &after, &coordinates)
}

/// What evaluates loops between their samples: interpolants, and the search for a break.
fn between_samples(
    u: &mut Unstructured<'_>,
    before: &Ensemble,
    after: &Ensemble,
    coordinates: &Coordinates,
) -> Result<()> {
    let step = numbers::rarely_any(u)?;
    let map = PerSample::new(before.dof(), |h, q: &mut [f64], p: &mut [f64]| {
        for (q, p) in q.iter_mut().zip(p) {
            *p -= h * q.signum();
            *q += h * *p;
        }
    });
    let (Ok(phase_loop), Ok(map)) = (
        SampledLoop::new(before.clone(), coordinates),
        map.with_coordinates(coordinates.clone()),
    ) else {
        return Ok(());
    };
    let s = [numbers::any(u)?, 0.5, 0.123];
    let mut there = Ensemble::zeros(before.dof(), s.len());
    phase_loop.sample(&s, &mut there.block());
    let _ = find_break(&map, &phase_loop, step, after);
    let centre = numbers::several(u, 2 * before.dof())?;
    let (q, p) = centre.split_at(before.dof());
    let _ = balanced_radii(&map, q, p, step);
    let radius = numbers::any(u)?;
    if let Ok(circle) = Circle::new(q.to_vec(), p.to_vec(), radius)
        && let Ok(samples) = Ensemble::sample(&circle, before.samples())
    {
        let _ = LoopIntegral::in_coordinates(&samples, &Rule::Pseudospectral, coordinates);
    }
    Ok(())
}

fn coordinates(u: &mut Unstructured<'_>, dof: usize) -> Result<Option<Coordinates>> {
    let mut coordinates = Ok(Coordinates::plain(dof));
    if u.arbitrary()? {
        let periods = numbers::several(u, dof)?;
        coordinates = coordinates.and_then(|known| known.with_periods(periods));
    }
    if u.arbitrary()? {
        let periods = numbers::several(u, dof)?;
        coordinates = coordinates.and_then(|known| known.with_momentum_periods(periods));
    }
    if u.arbitrary()? {
        let weights = numbers::several(u, dof)?;
        coordinates = coordinates.and_then(|known| known.with_weights(weights));
    }
    if u.arbitrary()? {
        let spacing = numbers::any(u)?;
        coordinates = coordinates.and_then(|known| known.with_grid_spacing(spacing));
    }
    Ok(coordinates.ok())
}

/// An ellipse, or a line or any numbers in its place, with other numbers at some samples.
fn states(u: &mut Unstructured<'_>, dof: usize, samples: usize) -> Result<Ensemble> {
    let mut states = Ensemble::zeros(dof, samples);
    let mut block = states.block();
    for i in 0..dof {
        for (rows, phase) in [(&mut block.q, 0.0), (&mut block.p, 0.25)] {
            let (size, centre) = (numbers::rarely_any(u)?, numbers::rarely_any(u)?);
            let kind = u.int_in_range(0..=5)?;
            for (k, x) in rows.row_mut(i).iter_mut().enumerate() {
                let s = k as f64 / samples as f64 + phase;
                *x = match kind {
                    0 => numbers::any(u)?,
                    1 => centre + size * s,
                    2 => centre + size * s.fract(),
                    _ => centre + size * (std::f64::consts::TAU * s).sin(),
                };
            }
            for _ in 0..u.int_in_range(0..=2)? {
                if let Some(x) = rows.row_mut(i).get_mut(u.choose_index(samples.max(1))?) {
                    *x = numbers::any(u)?;
                }
            }
        }
    }
    Ok(states)
}
