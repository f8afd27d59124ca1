//! The integral from its parts.

use super::PiecewiseIntegral;
use super::closure::ClosingChords;
use super::limits::{ERROR_OVER_ESTIMATE, MAX_DISTANCE_OF_NEIGHBOURS, SAMPLES_PER_ESTIMATE};
use super::piece::SmoothPiece;
use super::refinement::Refinement;
use super::under_resolved::{beside_samples, under_resolved};
use crate::breaks::Break;
use crate::error::Error;
use crate::rules::LoopIntegral;
use crate::signal::{CompensatedSum, UNIT_ROUNDOFF, nearest};

/// Adds up pieces and chords, in the order of the loop.
pub(super) fn sum(
    refinement: &Refinement<'_>,
    closed: &ClosingChords,
    break_uncertainty: f64,
) -> Result<PiecewiseIntegral, Error> {
    let mut smooth: Vec<&SmoothPiece> = refinement.smooth.iter().collect();
    smooth.sort_by(|x, y| (x.curve.cmp(&y.curve)).then(x.a.total_cmp(&y.a)));
    let pieces = smooth.partition_point(|piece| piece.curve == 0);
    let errors = Errors::of(refinement, &smooth);
    let integrals = Integrals::of(refinement, closed, smooth.split_at(pieces));
    let value = integrals.value;
    let known = value + errors.quadrature + break_uncertainty + errors.scale;
    if !known.is_finite() {
        let dof = integrals.contributions.iter().position(|c| !c.is_finite());
        return Err(Error::Overflow {
            dof: dof.unwrap_or(0),
            value: known,
        });
    }
    let mut unresolved: Vec<(f64, f64)> = (smooth.iter())
        .take(pieces)
        .filter(|piece| !piece.resolved)
        .map(|piece| (piece.a, piece.b))
        .collect();
    unresolved.dedup();
    let found = BreaksOfLoop::of(refinement);
    // Rounding decides next to the breaks of a solver: their positions are known to a factor of two of the width of that zone,
    // and pairs of them in narrow stretches are missed. There may be as many of them as were found.
    let break_uncertainty = match found.flickering {
        0 => break_uncertainty,
        _ => 2.0 * break_uncertainty + found.across,
    };
    let (error, regularity) =
        beside_samples(refinement, value, errors.quadrature, found.is_broken)?;
    let exposure = errors.exposure + integrals.exposure;
    Ok(PiecewiseIntegral {
        continuous: LoopIntegral {
            value,
            contributions: integrals.contributions,
            quadrature_error: error.map(|error| error + break_uncertainty),
            roundoff: 4.0 * UNIT_ROUNDOFF * (exposure + errors.scale),
            scale: errors.scale,
            omitted: None,
            regularity,
        },
        break_uncertainty,
        insubstantial: found.insubstantial,
        closing: integrals.closing,
        bend: closed.bend,
        breaks: found.breaks,
        flickering: found.flickering,
        pieces,
        unresolved,
        evaluations: refinement.budget.made,
    })
}

/// Error estimates and sizes of all pieces together.
struct Errors {
    quadrature: f64,
    /// How much the integral changes if the states do, relative to their rounding.
    exposure: f64,
    /// The sum of absolute contributions.
    scale: f64,
}

impl Errors {
    fn of(refinement: &Refinement<'_>, smooth: &[&SmoothPiece]) -> Self {
        let (mut error, mut exposure, mut scale) = (under_resolved(refinement), 0.0, 0.0);
        let mut missed = [0.0; SAMPLES_PER_ESTIMATE];
        for piece in smooth {
            match piece.missed.as_ref().filter(|_| piece.resolved) {
                Some(of_piece) => {
                    error += of_piece.jump;
                    let sums = missed.iter_mut().zip(of_piece.estimates);
                    sums.for_each(|(sum, estimate)| *sum += estimate);
                }
                None => error += piece.error,
            }
            exposure += piece.exposure;
            scale += piece.areas.iter().map(|area| area.abs()).sum::<f64>();
        }
        error += ERROR_OVER_ESTIMATE * missed.into_iter().map(f64::abs).fold(0.0, f64::max);
        // Neighbours share the state between them: noise takes from one what it adds to the other.
        let is_noisy = |piece: &SmoothPiece| piece.error_of_noise > 0.0;
        for run in smooth.chunk_by(|x, y| is_noisy(x) && is_noisy(y) && x.b == y.a) {
            error += run
                .iter()
                .map(|piece| piece.error_of_noise)
                .fold(0.0, f64::max);
        }
        Errors {
            quadrature: error,
            exposure,
            scale,
        }
    }
}

/// Integrals of the loop and of the segments and chords that close it.
struct Integrals {
    value: f64,
    contributions: Vec<f64>,
    closing: Vec<f64>,
    /// How much the reference momenta add to [`Errors::exposure`].
    exposure: f64,
}

impl Integrals {
    /// Momenta are counted from a reference, p = p_ref + …: the contribution of p_ref is known exactly, as
    /// the positions return but for the breaks and whole periods.
    fn of(
        refinement: &Refinement<'_>,
        closed: &ClosingChords,
        (pieces, segments): (&[&SmoothPiece], &[&SmoothPiece]),
    ) -> Self {
        let (coordinates, scales) = (refinement.coordinates, &refinement.scales);
        let dof = coordinates.dof();
        // ∫ (p − p_ref) dq and ∫ dq of the loop, and of what closes it.
        let sums = |parts: &mut dyn Iterator<Item = (&[f64], &[f64])>| {
            let mut sums = vec![[CompensatedSum::default(); 2]; dof];
            for (areas, gains) in parts {
                for (sums, (area, gain)) in sums.iter_mut().zip(areas.iter().zip(gains)) {
                    sums[0].add(*area);
                    sums[1].add(*gain);
                }
            }
            sums
        };
        fn part(piece: &SmoothPiece) -> (&[f64], &[f64]) {
            (&piece.areas, &piece.gains)
        }
        let pieces = sums(&mut pieces.iter().map(|piece| part(piece)));
        let of_chords = (closed.chords)
            .iter()
            .map(|chord| (&chord.areas[..], &chord.gains[..]));
        let of_segments = segments.iter().map(|piece| part(piece));
        let segments = sums(&mut of_segments.chain(of_chords));
        let mut integrals = Integrals {
            value: 0.0,
            contributions: Vec::with_capacity(dof),
            closing: Vec::with_capacity(dof),
            exposure: 0.0,
        };
        let mut total = CompensatedSum::default();
        for i in 0..dof {
            let [[area, gain], [closing, closing_gain]] =
                [&pieces[i], &segments[i]].map(|sums| sums.each_ref().map(CompensatedSum::total));
            let of_loop = refinement.breaks.iter().filter(|found| found.curve == 0);
            let jumps: f64 = of_loop.map(|found| found.jump(i, coordinates)).sum();
            let around = gain + jumps;
            let winding = around - nearest(around, coordinates.period(i));
            let reference = coordinates.weight(i) * scales.p_reference[i];
            let contribution = area + reference * (winding - jumps);
            // Each jump is a difference of two rounded positions.
            let rounded = refinement.breaks.len() as f64 * scales.magnitude[i];
            integrals.exposure += (reference * rounded).abs();
            integrals.contributions.push(contribution);
            // The closed curve may wind otherwise: a segment opens by whole periods where a jump, of which only
            // the ends are known, seems to be less.
            let closed = gain + closing_gain;
            let closed_winding = closed - nearest(closed, coordinates.period(i));
            let of_closing = closing + reference * (closed_winding - winding + jumps);
            integrals.closing.push(of_closing);
            total.add(contribution);
        }
        integrals.value = total.total();
        integrals
    }
}

/// The breaks of the loop itself, without those of the segments that close it.
struct BreaksOfLoop {
    breaks: Vec<Break>,
    /// Whether one of them is larger than rounding and noise.
    is_broken: bool,
    /// How many lie in zones in which states flicker.
    flickering: usize,
    /// The sum of absolute integrals across all of them.
    across: f64,
    /// The same for those that are not larger than rounding and noise.
    insubstantial: f64,
}

impl BreaksOfLoop {
    fn of(refinement: &Refinement<'_>) -> Self {
        let (coordinates, scales) = (refinement.coordinates, &refinement.scales);
        let dof = coordinates.dof();
        let is_substantial = |found: &Break| {
            let range = |c: usize| 2.0 * scales.size[c];
            found.is_substantial([range(found.dof), range(dof + found.dof)])
        };
        let of_loop = || refinement.breaks.iter().filter(|found| found.curve == 0);
        let of_solver = of_loop().any(|found| found.flickers);
        let (mut breaks, mut flickering) = (Vec::new(), 0);
        let (mut across, mut insubstantial) = (0.0, 0.0);
        for found in of_loop() {
            let summary = found.summary(scales, coordinates, of_solver);
            let chord = found.chord(scales, coordinates);
            let reference = |i: usize| coordinates.weight(i) * scales.p_reference[i];
            let parts = chord.areas.iter().zip(&chord.gains).enumerate();
            let of_break = parts
                .map(|(i, (area, gain))| (area + reference(i) * gain).abs())
                .sum::<f64>();
            if !is_substantial(&summary) {
                insubstantial += of_break;
            }
            across += of_break;
            flickering += usize::from(found.flickers);
            breaks.push(summary);
        }
        breaks.sort_by(|a: &Break, b| a.s.total_cmp(&b.s));
        // A force that has a separate value where it jumps breaks the loop twice round one double.
        breaks.dedup_by(|next, found| {
            let one = next.dof == found.dof && next.s - found.s < MAX_DISTANCE_OF_NEIGHBOURS;
            if one {
                found.jump_q += next.jump_q;
                found.jump_p += next.jump_p;
            }
            one
        });
        BreaksOfLoop {
            is_broken: breaks.iter().any(is_substantial),
            breaks,
            flickering,
            across,
            insubstantial,
        }
    }
}
