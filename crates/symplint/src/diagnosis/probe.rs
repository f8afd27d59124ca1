//! One loop with a rule and a number of samples, ready to be advanced by any step size.

use super::departures::Departures;
use crate::breaks::{Break, find_break_with};
use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, StepFailure, TimeAdvance};
use crate::rules::Defect;
use crate::rules::Streaming;
use crate::rules::{LoopIntegral, Rule};
use crate::rules::{Piecewise, PiecewiseIntegral};
use crate::signal::Extent;
use crate::state::Block;
use crate::state::Coordinates;
use crate::state::Ensemble;
use crate::verdict::Closing;

/// What is under test: a map and a loop to send through it.
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub phase_loop: &'a dyn Loop,
    pub coordinates: &'a Coordinates,
}

/// A subject with its initial loop integral.
pub(super) struct Probe<'a> {
    /// 0 is the given loop, the others are random.
    pub index: usize,
    pub subject: Subject<'a>,
    pub method: Method,
    pub initial: LoopIntegral,
    /// What is known of a step already, with its size.
    known: Option<(f64, Measured)>,
}

/// How a loop is integrated.
#[derive(Clone, Copy, Debug)]
pub(super) enum Method {
    /// From so many equispaced samples.
    Samples(Rule, usize),
    /// From as many states as it takes, beside so many equispaced samples.
    Piecewise(Piecewise, usize),
    /// From so many equispaced samples, of which a few are in memory at any time.
    Streaming(Streaming, usize),
}

/// What one step did to the loop.
#[derive(Clone)]
pub(super) struct Measured {
    pub integral: LoopIntegral,
    pub defect: Defect,
    /// All that the rule finds, or the one that samples led to.
    pub breaks: Vec<Break>,
    /// What closing all breaks gives, where all are known.
    pub closing: Option<Closing>,
    /// States that make up the integral.
    pub samples: usize,
    /// States that the map advanced, those for finding breaks between samples aside.
    pub evaluations: usize,
    /// Sobolev exponent of the advanced loop, where samples tell.
    pub regularity: Option<f64>,
    /// Grid cells, or half periods, from one sample to the next at most.
    pub cells_apart: f64,
}

impl<'a> Probe<'a> {
    pub fn new(index: usize, subject: Subject<'a>, method: Method) -> Result<Self, Error> {
        let initial = match method {
            Method::Samples(rule, samples) => {
                let before = Ensemble::sample(subject.phase_loop, samples)?;
                return Probe::of_samples(index, subject, rule, &before);
            }
            Method::Piecewise(rule, samples) => {
                let before = Ensemble::sample(subject.phase_loop, samples)?;
                return Probe::of_pieces(index, subject, rule, &before);
            }
            Method::Streaming(rule, samples) => {
                rule.initial(subject.phase_loop, subject.coordinates, samples)?
            }
        };
        Ok(Probe {
            index,
            subject,
            method,
            initial,
            known: None,
        })
    }

    /// The probe whose samples before the step are these.
    pub fn of_samples(
        index: usize,
        subject: Subject<'a>,
        rule: Rule,
        before: &Ensemble,
    ) -> Result<Self, Error> {
        Ok(Probe {
            index,
            subject,
            method: Method::Samples(rule, before.samples()),
            initial: LoopIntegral::in_coordinates(before, &rule, subject.coordinates)?,
            known: None,
        })
    }

    /// The probe by the piecewise rule that sees these samples before the step besides.
    pub fn of_pieces(
        index: usize,
        subject: Subject<'a>,
        rule: Piecewise,
        before: &Ensemble,
    ) -> Result<Self, Error> {
        let rest = Identity(subject.coordinates);
        let unmoved = EvaluationCount::unlimited();
        let rest = Evaluator::new(&rest, &unmoved)?;
        let pieces = rule.integrate_beside(&rest, subject.phase_loop, 1.0, Some(before))?;
        let initial = pieces.continuous;
        Ok(Probe {
            index,
            subject,
            method: Method::Piecewise(rule, before.samples()),
            initial,
            known: None,
        })
    }

    /// Keeps what a step of size `h` was found to do, so that nobody measures it again.
    pub fn knowing(mut self, h: f64, measured: Measured) -> Self {
        self.known = Some((h, measured));
        self
    }

    /// Name of the rule.
    pub fn rule_name(&self) -> &'static str {
        match self.method {
            Method::Samples(rule, _) => rule.name(),
            Method::Piecewise(..) => Piecewise::NAME,
            Method::Streaming(..) => Streaming::NAME,
        }
    }

    /// Equispaced samples of the loop that are looked at.
    pub fn samples(&self) -> usize {
        match self.method {
            Method::Samples(_, samples)
            | Method::Piecewise(_, samples)
            | Method::Streaming(_, samples) => samples,
        }
    }

    /// The rule for any number of equispaced samples that are kept.
    pub fn sampling_rule(&self) -> Rule {
        match self.method {
            Method::Samples(rule, _) => rule,
            Method::Piecewise(..) | Method::Streaming(..) => Rule::Pseudospectral,
        }
    }

    /// The same with another number of samples, by the streaming rule; `None` where samples are kept.
    pub fn streaming(&self, samples: usize) -> Option<Result<Self, Error>> {
        match self.method {
            Method::Streaming(rule, _) => {
                let method = Method::Streaming(rule, samples);
                Some(Probe::new(self.index, self.subject, method))
            }
            _ => None,
        }
    }

    /// The quadrature error of a finite-difference integral of a loop without breaks, not less than its
    /// distance from the pseudospectral one: cut-offs can leave out steep but smooth cells.
    fn cross_checked(
        &self,
        ensemble: &Ensemble,
        integral: &LoopIntegral,
    ) -> Result<Option<f64>, Error> {
        let rule = Rule::Pseudospectral;
        let other = LoopIntegral::in_coordinates(ensemble, &rule, self.subject.coordinates)?;
        let distance = (other.value - integral.value).abs();
        let errors = integral.quadrature_error.zip(other.quadrature_error);
        Ok(errors.map(|(own, of_other)| own.max(distance + of_other)))
    }

    /// Advances the loop by one step and compares the loop integrals.
    pub fn measure(&self, h: f64) -> Result<Measured, Error> {
        self.measure_from(&mut Departures::new(self.subject), h)
    }

    /// The same, for one step size after the other from the same departures.
    pub fn measure_from(&self, departures: &mut Departures<'_>, h: f64) -> Result<Measured, Error> {
        match &self.known {
            Some((of, measured)) if *of == h => return Ok(measured.clone()),
            _ => {}
        }
        match self.method {
            Method::Samples(_, samples) => {
                self.measure_samples(departures.advanced(samples, h)?, h)
            }
            Method::Piecewise(rule, samples) => {
                self.measure_pieces(&rule, departures.advanced(samples, h)?, h)
            }
            Method::Streaming(rule, samples) => self.measure_streaming(&rule, samples, h),
        }
    }

    /// A break, if advanced samples lead to one.
    fn find_break(&self, after: &Ensemble, h: f64) -> Result<Option<Break>, Error> {
        let Subject {
            evaluator,
            phase_loop,
            ..
        } = self.subject;
        let found = find_break_with(evaluator, phase_loop, h, after)?;
        Ok(found.filter(|found| is_substantial(found, after)))
    }

    /// What a step of size `h` did to the samples, which are as many as those before it.
    pub fn measure_samples(&self, after: &Ensemble, h: f64) -> Result<Measured, Error> {
        let coordinates = self.subject.coordinates;
        let (rule, samples) = (self.sampling_rule(), after.samples());
        let found = self.find_break(after, h)?;
        let mut integral = LoopIntegral::in_coordinates(after, &rule, coordinates)?;
        if let Rule::FiniteDifference(_) = rule {
            integral.quadrature_error = match found {
                // The rule took a jump for a part of the loop: nobody knows how far off that is.
                Some(found) if retains(&integral, &found, samples) => None,
                Some(_) => integral.quadrature_error,
                None => self.cross_checked(after, &integral)?,
            };
        }
        Ok(Measured {
            defect: Defect::between(&self.initial, &integral)?,
            regularity: integral.regularity,
            integral,
            breaks: found.into_iter().collect(),
            closing: None,
            samples,
            evaluations: samples,
            cells_apart: cells_apart(after, coordinates),
        })
    }

    /// What a step of size `h` did to the loop, by pieces.
    ///
    /// A few pieces can miss what is narrow. The equispaced samples that are `seen` besides, many more of
    /// them in small systems, show it.
    pub fn measure_pieces(
        &self,
        rule: &Piecewise,
        seen: &Ensemble,
        h: f64,
    ) -> Result<Measured, Error> {
        let Subject {
            evaluator,
            phase_loop,
            coordinates,
        } = self.subject;
        let pieces = rule.integrate_beside(evaluator, phase_loop, h, Some(seen))?;
        let mut closed = pieces.closed();
        let (samples, evaluations) = (pieces.nodes(), pieces.evaluations + seen.samples());
        let PiecewiseIntegral {
            continuous: mut integral,
            mut breaks,
            ..
        } = pieces;
        breaks.retain(|found| is_substantial(found, seen));
        if breaks.is_empty()
            && let Some(found) = self.find_break(seen, h)?
        {
            (integral.quadrature_error, closed.quadrature_error) = (None, None);
            breaks.push(found);
        }
        Ok(Measured {
            defect: Defect::between(&self.initial, &integral)?,
            regularity: integral.regularity,
            closing: Some(Closing {
                breaks: breaks.len(),
                chord: pieces.closing.iter().sum(),
                closed: Defect::between(&self.initial, &closed)?,
            }),
            integral,
            breaks,
            samples,
            evaluations,
            cells_apart: cells_apart(seen, coordinates),
        })
    }
}

impl Measured {
    /// The largest break, by the size of its jump.
    pub fn largest_break(&self) -> Option<Break> {
        let size = |found: &Break| found.jump_q.hypot(found.jump_p);
        let breaks = self.breaks.iter().copied();
        breaks.reduce(|a, b| if size(&b) > size(&a) { b } else { a })
    }
}

fn is_substantial(found: &Break, ensemble: &Ensemble) -> bool {
    let ranges = [ensemble.q(), ensemble.p()].map(|x| Extent::of(x.row(found.dof)).length());
    found.is_substantial(ranges)
}

/// Whether the cell of a break is among those that make up the integral.
fn retains(integral: &LoopIntegral, found: &Break, samples: usize) -> bool {
    let position = found.s * samples as f64;
    integral.omitted.as_ref().is_none_or(|omitted| {
        // A break at a sample may be in the cell on either side.
        !omitted.iter().any(|cell| {
            let from = cell.cell as f64;
            cell.dof == found.dof && (from - 1e-6..=from + 1.0 + 1e-6).contains(&position)
        })
    })
}

/// The map that leaves every state where it is.
pub(super) struct Identity<'a>(pub &'a Coordinates);

impl TimeAdvance for Identity<'_> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn advance(&self, _h: f64, _block: &mut Block<'_>) -> Result<(), StepFailure> {
        Ok(())
    }
    fn coordinates(&self) -> Coordinates {
        self.0.clone()
    }
}

/// Grid cells between neighbouring samples at most, or half periods, if they are more; 0 where there is
/// neither. Positions that are half a period apart could be unwrapped either way.
fn cells_apart(ensemble: &Ensemble, coordinates: &Coordinates) -> f64 {
    let furthest = |dof: usize| {
        let (row, period) = (ensemble.q().row(dof), coordinates.period(dof));
        let spacing = match (coordinates.grid_spacing(), 0.5 * period) {
            (0.0, 0.0) => return 0.0,
            (0.0, other) | (other, 0.0) => other,
            (grid, half) => grid.min(half),
        };
        let distance = |a: f64, b: f64| {
            let direct = (b - a).abs();
            if period > 0.0 {
                direct.min((direct - period).abs())
            } else {
                direct
            }
        };
        let closing = distance(row[row.len() - 1], row[0]);
        let steps = row.windows(2).map(|pair| distance(pair[0], pair[1]));
        steps.fold(closing, f64::max) / spacing
    };
    (0..ensemble.dof()).map(furthest).fold(0.0, f64::max)
}
