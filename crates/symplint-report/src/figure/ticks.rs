//! The ticks of an axis and their labels.
//!
//! Candidates are tried from fine to coarse; the first whose labels keep their distance wins.

use super::Scale;
use super::number::{decade, power, tick_label};
use super::scale::Span;
use super::style::STYLE;

/// A labelled tick at a mapped value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub label: String,
}

/// The ticks of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Ticks {
    pub major: Vec<Tick>,
    /// Mapped values of the unlabelled ticks.
    pub minor: Vec<f64>,
}

/// The room along an axis.
pub(super) struct Room<F> {
    /// Length of the axis on the page.
    pub length: f64,
    /// Room that a label takes along the axis, distance to the next one included.
    pub extent: F,
}

/// The ticks of an axis over `span`.
pub(super) fn choose<F: Fn(&str) -> f64>(scale: Scale, span: Span, room: &Room<F>) -> Ticks {
    let ticks = match scale {
        Scale::Linear => even(scale, span, room),
        Scale::Log10 => powers(10, &[], span, room)
            .or_else(|| one_two_five(span, room))
            .unwrap_or_else(|| even(scale, span, room)),
        Scale::Log2 => {
            powers(2, &[1, 2, 4, 5, 8], span, room).unwrap_or_else(|| even(scale, span, room))
        }
    };
    without_crowded_minors(ticks, span, room.length)
}

/// Ticks at whole powers of `base`, every 1, 2, 3, … powers, or `strides` first if given;
/// `None` if the span has fewer than two.
fn powers<F: Fn(&str) -> f64>(
    base: u32,
    strides: &[i32],
    span: Span,
    room: &Room<F>,
) -> Option<Ticks> {
    let first = (span.low - 1e-9).ceil() as i32;
    let last = (span.high + 1e-9).floor() as i32;
    if last - first < 1 {
        return None;
    }
    let later = strides.last().map_or(1, |stride| stride + 2);
    let (stride, major) = strides
        .iter()
        .copied()
        .chain(later..=(last - first).max(later))
        .map(|stride| (stride, powers_every(base, stride, first, last)))
        .find(|(_, major)| fits(major, span, room))?;
    let minor = if stride > 1 {
        (first..=last)
            .filter(|k| k % stride != 0)
            .map(f64::from)
            .collect()
    } else if base == 10 {
        multiples_between_decades(span)
    } else {
        Vec::new()
    };
    Some(Ticks { major, minor })
}

fn powers_every(base: u32, stride: i32, first: i32, last: i32) -> Vec<Tick> {
    (first..=last)
        .filter(|k| k % stride == 0)
        .map(|k| Tick {
            at: f64::from(k),
            label: power(base, k),
        })
        .collect()
}

/// Ticks at 1, 2 and 5 times powers of ten; `None` if the span has fewer than three, which
/// would leave the reader without a sense of the scale, or if they do not fit.
fn one_two_five<F: Fn(&str) -> f64>(span: Span, room: &Room<F>) -> Option<Ticks> {
    let decades = (span.low.floor() as i32)..=(span.high.ceil() as i32);
    let major: Vec<Tick> = decades
        .flat_map(|decade| [1.0_f64, 2.0, 5.0].map(|digit| (digit, decade)))
        .map(|(digit, decade)| {
            let unit = 10.0_f64.powi(decade);
            Tick {
                at: f64::from(decade) + digit.log10(),
                label: tick_label(digit * unit, unit, Scale::Log10.unmap(span.high)),
            }
        })
        .filter(|tick| inside(tick.at, span))
        .collect();
    (major.len() > 2 && fits(&major, span, room)).then(|| Ticks {
        major,
        minor: multiples_between_decades(span),
    })
}

fn multiples_between_decades(span: Span) -> Vec<f64> {
    ((span.low.floor() as i32)..=(span.high.floor() as i32))
        .flat_map(|decade| (2..10).map(move |digit| f64::from(decade) + f64::from(digit).log10()))
        .filter(|at| inside(*at, span))
        .collect()
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten, in values rather than mapped values.
fn even<F: Fn(&str) -> f64>(scale: Scale, span: Span, room: &Room<F>) -> Ticks {
    let (low, high) = (scale.unmap(span.low), scale.unmap(span.high));
    let start = decade((high - low) / 20.0);
    for exponent in start..=start + 3 {
        for (digit, parts) in [(1.0, 5), (2.0, 4), (5.0, 5)] {
            let step = digit * 10.0_f64.powi(exponent);
            if !(step.is_normal() && (high - low) / step < 50.0) {
                continue;
            }
            let major = multiples(scale, low, high, step);
            if major.len() < STYLE.max_tick_labels && fits(&major, span, room) {
                let part = step / f64::from(parts);
                let minor = multiples(scale, low, high, part);
                return Ticks {
                    major,
                    minor: minor.into_iter().map(|tick| tick.at).collect(),
                };
            }
        }
    }
    Ticks::default()
}

fn multiples(scale: Scale, low: f64, high: f64, step: f64) -> Vec<Tick> {
    let first = (low / step - 1e-9).ceil();
    let count = ((high / step + 1e-9).floor() - first).max(-1.0) as usize;
    (0..=count)
        .filter_map(|k| {
            let value = (first + k as f64) * step;
            Some(Tick {
                at: scale.map(value)?,
                label: tick_label(value, step, low.abs().max(high.abs())),
            })
        })
        .filter(|tick| tick.at >= scale.map(low).unwrap_or(f64::MIN) - 1e-9 * step)
        .collect()
}

fn inside(at: f64, span: Span) -> bool {
    at >= span.low - 1e-9 && at <= span.high + 1e-9
}

/// Whether the labels are few and apart.
fn fits<F: Fn(&str) -> f64>(ticks: &[Tick], span: Span, room: &Room<F>) -> bool {
    let per_unit = room.length / span.length();
    !ticks.is_empty()
        && ticks.len() <= STYLE.max_tick_labels
        && ticks.windows(2).all(|pair| {
            let distance = (pair[1].at - pair[0].at) * per_unit;
            let needed = 0.5 * ((room.extent)(&pair[0].label) + (room.extent)(&pair[1].label));
            distance >= needed
        })
}

/// Leaves out minor ticks at major ones, and all of them where two would nearly touch.
fn without_crowded_minors(mut ticks: Ticks, span: Span, length: f64) -> Ticks {
    let per_unit = length / span.length();
    let near = |a: f64, b: f64, room: f64| (a - b).abs() * per_unit < room;
    ticks
        .minor
        .retain(|at| ticks.major.iter().all(|tick| !near(*at, tick.at, 0.5)));
    if ticks
        .minor
        .windows(2)
        .any(|p| near(p[0], p[1], STYLE.min_tick_distance))
    {
        ticks.minor.clear();
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(length: f64) -> Room<impl Fn(&str) -> f64> {
        Room {
            length,
            extent: |label: &str| 10.0 * label.chars().count() as f64 + 10.0,
        }
    }

    fn labels(scale: Scale, low: f64, high: f64, length: f64) -> Vec<String> {
        choose(scale, Span { low, high }, &room(length))
            .major
            .into_iter()
            .map(|tick| tick.label)
            .collect()
    }

    #[test]
    fn decades_are_thinned_to_what_fits() {
        assert_eq!(
            labels(Scale::Log10, -3.0, 0.0, 500.0),
            ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]
        );
        assert_eq!(
            labels(Scale::Log10, -16.0, 0.0, 500.0),
            [
                "10⁻¹⁶",
                "10⁻¹⁴",
                "10⁻¹²",
                "10⁻¹⁰",
                "10⁻⁸",
                "10⁻⁶",
                "10⁻⁴",
                "10⁻²",
                "10⁰"
            ]
        );
        assert_eq!(
            labels(Scale::Log10, -16.0, 0.0, 300.0),
            ["10⁻¹⁶", "10⁻¹²", "10⁻⁸", "10⁻⁴", "10⁰"]
        );
    }

    #[test]
    fn step_sizes_are_powers_of_two() {
        let found = labels(Scale::Log2, -10.3, -0.7, 600.0);
        assert_eq!(found.first().map(String::as_str), Some("2⁻¹⁰"));
        assert_eq!(found.last().map(String::as_str), Some("2⁻¹"));
        assert_eq!(found.len(), 10);
    }

    #[test]
    fn short_log_axes_still_have_labels() {
        assert_eq!(
            labels(Scale::Log10, -2.1, -1.2, 500.0),
            ["0.01", "0.02", "0.05"]
        );
        assert!(labels(Scale::Log10, -2.10, -2.05, 500.0).len() > 1);
        assert!(labels(Scale::Log2, 0.1, 0.9, 500.0).len() > 1);
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        assert_eq!(
            labels(Scale::Linear, -0.02, 1.02, 400.0),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"].map(|s| s.replace("0.0", "0"))
        );
        assert_eq!(labels(Scale::Linear, -3.3, 3.3, 400.0).len(), 7);
        assert_eq!(labels(Scale::Linear, 0.0, 1000.0, 400.0).len(), 6);
    }

    #[test]
    fn labels_never_overlap_and_always_exist() {
        for scale in [Scale::Linear, Scale::Log10, Scale::Log2] {
            for (low, high) in [
                (-17.0, 0.0),
                (-300.0, 300.0),
                (0.0, 1e-3),
                (1.0, 1.0 + 1e-9),
                (-0.4, 0.3),
                (-5.2, 2.8),
            ] {
                for length in [120.0, 400.0, 1000.0] {
                    let span = Span { low, high };
                    let room = room(length);
                    let ticks = choose(scale, span, &room);
                    assert!(ticks.major.len() <= STYLE.max_tick_labels);
                    assert!(!ticks.major.is_empty(), "{scale:?} {low} {high} {length}");
                    assert!(fits(&ticks.major, span, &room), "{scale:?} {low} {high}");
                    assert!(ticks.major.iter().all(|tick| inside(tick.at, span)));
                }
            }
        }
    }
}
