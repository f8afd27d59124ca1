//! Loop integrals ∮ p·dq by one of the rules.
//!
//! A rule is a folder, a variant of [`Rule`], and a line in `Rule::integrator`.

mod advanced;
mod banded;
mod defect;
mod finite_difference;
mod merge;
mod piecewise;
mod pseudospectral;
mod sampled;
mod stencil;
mod streaming;

pub(crate) use advanced::{BreakClosure, LoopAfterStep, LoopIntegrator, Samples, Subject};
pub use defect::{Defect, logarithmic_defect};
pub use finite_difference::{Cutoff, Cutoffs, OmittedCell};
pub(crate) use piecewise::Identity;
pub use piecewise::{Closure, Piecewise, PiecewiseIntegral};
pub(crate) use pseudospectral::roughness;
use sampled::SampledRule;
pub(crate) use sampled::cells_apart;
pub use streaming::{Streaming, StreamingIntegral};

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::signal::CompensatedSum;
use crate::state::{Coordinates, Ensemble, Rows, first_not_finite, in_parallel};

/// How ∮ p·dq is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Rule {
    /// Chosen from the advanced loop of the largest step size: pseudospectral if it is smooth
    /// enough to reach round-off that way; piecewise if it is broken, or has kinks; streaming if
    /// ensembles would take more than 512 MiB. Of samples alone, pseudospectral; rows of 512 samples or more, an even number, that are
    /// smooth to rounding have their pseudospectral integral by central differences of order 10 or 20, which takes a third of the time.
    #[default]
    Auto,
    /// Differentiates q by Fourier transform: Barham & Burby, section 2.3, appendix A.
    ///
    /// Converges as fast as the loop is smooth. On a loop with jumps it does not converge to
    /// the absolutely continuous integral.
    Pseudospectral,
    /// Sums p_k (q_{k+1} − q_k) over the cells that the cut-offs retain: section 2.3,
    /// appendix B. First order in the number of samples.
    FiniteDifference(Cutoffs),
    /// Adaptive, for maps that can be evaluated anywhere on the loop: finds and closes every break.
    Piecewise(Piecewise),
    /// From samples that are made, advanced and used in their order: a few dozen states in memory.
    Streaming(Streaming),
}

/// The name of a rule in configurations and reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum RuleKind {
    /// Not chosen yet.
    #[default]
    Auto,
    /// [`Rule::Pseudospectral`].
    Pseudospectral,
    /// [`Rule::FiniteDifference`].
    FiniteDifference,
    /// [`Rule::Piecewise`].
    Piecewise,
    /// [`Rule::Streaming`].
    Streaming,
    /// Trapezoids between the jumps of a loop that is known by its samples only.
    JumpDetecting,
}

impl RuleKind {
    /// Those that a diagnosis can be given, the default first.
    pub const CHOICES: [RuleKind; 5] = [
        RuleKind::Auto,
        RuleKind::Pseudospectral,
        RuleKind::FiniteDifference,
        RuleKind::Piecewise,
        RuleKind::Streaming,
    ];

    /// As configurations and reports write it.
    pub fn name(self) -> &'static str {
        match self {
            RuleKind::Auto => "auto",
            RuleKind::Pseudospectral => "pseudospectral",
            RuleKind::FiniteDifference => "finite-difference",
            RuleKind::Piecewise => "piecewise",
            RuleKind::Streaming => "streaming",
            RuleKind::JumpDetecting => "jump-detecting",
        }
    }

    /// A description in a sentence or two.
    pub fn summary(self) -> &'static str {
        match self {
            RuleKind::Auto => {
                "The default: pseudospectral; piecewise if the advanced loop is broken or has kinks; streaming if an ensemble does not fit \
                 into memory. For files whose loops jump: finite-difference, without the jumps."
            }
            RuleKind::Pseudospectral => {
                "Differentiates q by Fourier transform (paper, section 2.3 and appendix A). Exact to rounding error on smooth loops. \
                 On loops with kinks, the error falls with a power of the number of samples."
            }
            RuleKind::FiniteDifference => {
                "Sums p·Δq over the cells of the loop, without the cells whose slope exceeds a cut-off (paper, appendix B). Gives a few \
                 digits on broken loops."
            }
            RuleKind::Piecewise => {
                "Locates and closes each break, and interpolates between the breaks (Chebyshev). For broken loops and loops with kinks, \
                 nearly to rounding error."
            }
            RuleKind::Streaming => {
                "Makes, advances and drops one sample after another, and takes differences of order 20 along the loop. For ensembles \
                 that do not fit into memory: it keeps a few dozen states."
            }
            RuleKind::JumpDetecting => {
                "Trapezoids between the jumps of a loop that is known by its samples only."
            }
        }
    }
}

impl std::fmt::Display for RuleKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Rule {
    /// The rule of this name with its default settings. Cut-offs are those of the paper for particle-in-cell codes.
    pub fn named(name: &str) -> Option<Self> {
        let rules = [
            Rule::Auto,
            Rule::Pseudospectral,
            Rule::FiniteDifference(Cutoffs::relative(1000.0)),
            Rule::Piecewise(Piecewise::default()),
            Rule::Streaming(Streaming::default()),
        ];
        rules.into_iter().find(|rule| rule.kind().name() == name)
    }

    /// Its kind, which has its name.
    pub fn kind(&self) -> RuleKind {
        match self {
            Rule::Auto => RuleKind::Auto,
            Rule::Pseudospectral => RuleKind::Pseudospectral,
            Rule::FiniteDifference(_) => RuleKind::FiniteDifference,
            Rule::Piecewise(_) => RuleKind::Piecewise,
            Rule::Streaming(_) => RuleKind::Streaming,
        }
    }

    /// What integrates loops by this rule; [`Rule::Auto`] stands for the pseudospectral rule.
    pub(crate) fn integrator(&self) -> Box<dyn LoopIntegrator> {
        match *self {
            // By the transform alone: it states smaller errors than the band, and how regular a loop is.
            Rule::Auto => Box::new(SampledRule(Rule::Pseudospectral)),
            Rule::Pseudospectral | Rule::FiniteDifference(_) => Box::new(SampledRule(*self)),
            Rule::Piecewise(piecewise) => Box::new(piecewise),
            Rule::Streaming(streaming) => Box::new(streaming),
        }
    }
}

/// ∮ p·dq of one ensemble, with its error.
#[derive(Clone, Debug)]
pub struct LoopIntegral {
    /// ∮ p·dq, in units of momentum × position.
    pub value: f64,
    /// The part of each degree of freedom; `value` is their sum.
    pub contributions: Vec<f64>,
    /// Estimate of the distance from the integral of the loop that the samples belong to, absolute.
    ///
    /// From the same integral with every second sample and from what the samples show of the
    /// loop's roughness; it tends to overestimate. `None` where the samples are too
    /// few to tell.
    pub quadrature_error: Option<f64>,
    /// What double precision alone leaves uncertain, absolute.
    pub roundoff: f64,
    /// Sum of the absolute values of all terms, at most 18 per cent too large: `value` is accurate relative
    /// to this.
    pub scale: f64,
    /// The cells that the finite-difference rule left out; `None` for rules that leave out none.
    pub omitted: Option<Vec<OmittedCell>>,
    /// The largest s for which all coordinates are in the Sobolev space H^s, as the decay of their Fourier
    /// coefficients has it: ½ for a jump, 3/2 for a kink. Of a loop whose coefficients fall to round-off it is
    /// a lower bound. `None` where the rule has no coefficients, or too few, and of rows that [`Rule::Auto`] integrates without them.
    pub regularity: Option<f64>,
}

impl LoopIntegral {
    /// Integrates in plain coordinates: nothing periodic, every momentum canonical.
    ///
    /// # Errors
    /// See [`LoopIntegral::in_coordinates`].
    pub fn of(ensemble: &Ensemble, rule: &Rule) -> Result<Self, Error> {
        Self::in_coordinates(ensemble, rule, &Coordinates::plain(ensemble.dof()))
    }

    /// Integrates with the periods and weights of `coordinates`.
    ///
    /// Coordinates with a period are unwrapped, and positions may wind; where momenta are periodic and either winds, the
    /// quadrature error is not known. States must be finite: an
    /// [`Ensemble`] from a loop or a map was checked when it was made. Rows are spread over the threads
    /// of the current Rayon pool; the result does not depend on their number. The last bits of the
    /// pseudospectral rule depend on the processor: transforms and sums use the instructions that it has.
    ///
    /// # Errors
    /// If the rule needs the map and not only samples, there are fewer than 3 samples, `coordinates` has other degrees of freedom than
    /// the ensemble, a cut-off is not positive, or the integral overflows.
    pub fn in_coordinates(
        ensemble: &Ensemble,
        rule: &Rule,
        coordinates: &Coordinates,
    ) -> Result<Self, Error> {
        let integrated = Self::in_coordinates_with(ensemble, rule, coordinates, |_| ());
        integrated.map(|(integral, _)| integral)
    }

    /// Integrates as [`in_coordinates`](Self::in_coordinates). Also returns the result of `look` for each degree of freedom, which
    /// reads its rows just before they are integrated.
    pub(crate) fn in_coordinates_with<T: Send>(
        ensemble: &Ensemble,
        rule: &Rule,
        coordinates: &Coordinates,
        look: impl Fn(usize) -> T + Sync,
    ) -> Result<(Self, Vec<T>), Error> {
        Error::check_length("coordinates", ensemble.dof(), coordinates.dof())?;
        let (unwrapped, winding) = ensemble.unwrap_momenta(coordinates);
        let (q, p) = (unwrapped.q(), unwrapped.p());
        Self::of_unwrapped(q, p, rule, coordinates, &winding, look)
    }

    /// The same of rows in the memory of the caller, one for each degree of freedom, which is read and not copied.
    ///
    /// # Errors
    /// If q and p differ in shape, or values are not finite; else as there.
    pub fn of_rows(
        q: Rows<'_>,
        p: Rows<'_>,
        rule: &Rule,
        coordinates: &Coordinates,
    ) -> Result<Self, Error> {
        Error::check_length("rows of p", q.count(), p.count())?;
        Error::check_length("samples of p", q.len(), p.len())?;
        let not_finite = || first_not_finite(q, p).map(|found| found.into_error(0, None));
        if coordinates.has_momentum_periods() {
            let states = Ensemble::of_rows(q, p);
            states.check_finite(None)?;
            return Self::in_coordinates(&states, rule, coordinates);
        }
        Error::check_length("coordinates", q.count(), coordinates.dof())?;
        // Cut-offs leave out what is not a number. In other sums it is found for nothing.
        if let Rule::FiniteDifference(_) = rule
            && let Some(error) = not_finite()
        {
            return Err(error);
        }
        let found = Self::of_unwrapped(q, p, rule, coordinates, &[], |_| ());
        (found.map(|(integral, _)| integral)).map_err(|error| not_finite().unwrap_or(error))
    }

    /// Of rows whose momenta are not periodic or were unwrapped; in some degrees of freedom they or the positions wind.
    fn of_unwrapped<T: Send>(
        q: Rows<'_>,
        p: Rows<'_>,
        rule: &Rule,
        coordinates: &Coordinates,
        winding: &[usize],
        look: impl Fn(usize) -> T + Sync,
    ) -> Result<(Self, Vec<T>), Error> {
        if q.len() < 3 {
            return Err(Error::TooFewSamples { samples: q.len() });
        }
        let integrate: Box<dyn Fn(usize) -> RowIntegral + Sync> = match rule {
            Rule::Auto => Box::new(pseudospectral::of_rows(q, p, coordinates, true)),
            Rule::Pseudospectral => Box::new(pseudospectral::of_rows(q, p, coordinates, false)),
            Rule::FiniteDifference(cutoffs) => {
                cutoffs.check()?;
                Box::new(finite_difference::of_rows(q, p, coordinates, cutoffs))
            }
            Rule::Piecewise(_) | Rule::Streaming(_) => {
                return Err(Error::NeedsMap {
                    rule: rule.kind().name(),
                });
            }
        };
        let rows = in_parallel(0..q.count(), 2 * q.len(), |dof| (look(dof), integrate(dof)));
        let (looks, mut rows): (Vec<T>, Vec<RowIntegral>) = rows.into_iter().unzip();
        for &dof in winding {
            rows[dof].quadrature_error = None;
        }
        for (dof, row) in rows.iter().enumerate() {
            let weight = coordinates.weight(dof).abs();
            let estimate = row.quadrature_error.unwrap_or(0.0);
            let value = weight * (row.value.abs() + row.scale + row.roundoff + estimate);
            if !value.is_finite() {
                return Err(Error::Overflow { dof, value });
            }
        }
        Ok((Self::sum(rows, coordinates, rule), looks))
    }

    /// Adds the degrees of freedom in their order, independently of the thread that computed them.
    fn sum(rows: Vec<RowIntegral>, coordinates: &Coordinates, rule: &Rule) -> Self {
        let mut total = LoopIntegral {
            value: 0.0,
            contributions: Vec::with_capacity(rows.len()),
            quadrature_error: Some(0.0),
            roundoff: 0.0,
            scale: 0.0,
            omitted: matches!(rule, Rule::FiniteDifference(_)).then(Vec::new),
            regularity: None,
        };
        let mut value = CompensatedSum::default();
        for (dof, row) in rows.into_iter().enumerate() {
            let weight = coordinates.weight(dof);
            let contribution = weight * row.value;
            value.add(contribution);
            total.contributions.push(contribution);
            total.quadrature_error = (total.quadrature_error.zip(row.quadrature_error))
                .map(|(sum, error)| sum + weight.abs() * error);
            total.roundoff += weight.abs() * row.roundoff;
            total.scale += weight.abs() * row.scale;
            total.regularity = least(total.regularity, row.regularity);
            if let Some(omitted) = &mut total.omitted {
                omitted.extend(row.omitted.iter().map(|&cell| OmittedCell { dof, cell }));
            }
        }
        total.value = value.total();
        total.roundoff += f64::EPSILON * total.value.abs();
        total
    }
}

/// ∮ p dq of one degree of freedom, without its weight.
#[derive(Debug, Default)]
struct RowIntegral {
    value: f64,
    quadrature_error: Option<f64>,
    roundoff: f64,
    scale: f64,
    omitted: Vec<usize>,
    regularity: Option<f64>,
}

/// The lesser of two where there are two.
fn least(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (one, None) | (None, one) => one,
    }
}
