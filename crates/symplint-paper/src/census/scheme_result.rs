//! The results for one scheme.

use serde::Serialize;
use symplint::evidence::Localisation;
use symplint::{Diagnosis, Diagnostic, VerdictKind};

use super::conservation::follow;
use super::schemes::Scheme;
use super::small_loops::{STEP_SIZES, SmallLoops};
use crate::error::PaperError;
use crate::settings::Settings;

/// The verdict on one scheme and what it conserves.
pub struct SchemeResult {
    /// The scheme.
    pub family: &'static str,
    /// Defects against step sizes.
    pub small_loops: SmallLoops,
    /// The verdict.
    pub kind: VerdictKind,
    /// The line of the table.
    pub record: TableRow,
}

/// A row of the table and of the data.
#[derive(Serialize)]
pub struct TableRow {
    /// Its name.
    pub scheme: &'static str,
    /// Degree of the shape of the charge.
    pub degree: usize,
    /// The verdict in a few words.
    pub verdict: String,
    /// k of defect ~ h^k, if the verdict has one.
    pub order: Option<f64>,
    /// The same of small loops together, at the two smallest step sizes, if no loop breaks.
    pub slope: Option<f64>,
    /// Digits to which loop integrals are conserved.
    pub digits: Option<f64>,
    /// Breaks of the loop at the largest step.
    pub breaks: usize,
    /// Cell boundaries that particles pass round the loop, before the step.
    pub crossings: usize,
    /// Whether integrals are conserved once breaks are closed.
    pub closed_conserved: Option<bool>,
    /// Relative change of a loop integral, breaks left open; the largest of all loops.
    pub defect: f64,
    /// The step size that it belongs to: that of the run, or the nearest that the budget allowed.
    pub defect_step_size: f64,
    /// The largest relative change of the energy over the run.
    pub energy_error: f64,
    /// That in its second half, over that in its first.
    pub energy_growth: f64,
    /// The largest residual of Gauss' law over the run, if it is not solved for in each step.
    pub gauss_residual: Option<f64>,
    /// The largest change of the momentum along x over the run.
    pub momentum_change: f64,
    /// The substeps that change a loop integral or break a loop.
    pub substeps: String,
    /// Evaluations of the map for the verdict.
    pub evaluations: usize,
}

impl SchemeResult {
    /// Judges a scheme and watches a run.
    pub fn of(scheme: &Scheme, settings: &Settings) -> Result<Self, PaperError> {
        let (h, time) = (settings.number("step_size"), settings.number("time"));
        // The step size of the run is one of those judged.
        let mut step_sizes = STEP_SIZES.to_vec();
        if !step_sizes.contains(&h) {
            step_sizes.push(h);
        }
        let diagnostic = Diagnostic {
            step_sizes,
            loops: 3,
            budget: Some(settings.count("budget") / scheme.cost),
            ..Diagnostic::default()
        };
        let diagnosis = diagnostic.run(&*scheme.map, &scheme.phase_loop)?;
        let (q, p) = &scheme.centre;
        let changes = follow(&scheme.plasma, &*scheme.map, (q, p), (h, time))?;
        let given: Vec<_> = (diagnosis.points().into_iter())
            .filter(|point| point.loop_index == 0)
            .collect();
        let largest = given
            .iter()
            .max_by(|a, b| a.step_size.total_cmp(&b.step_size));
        let verdict = &diagnosis.verdict;
        let small_loops = SmallLoops::of(scheme)?;
        let (defect_step_size, defect) = defect_near(&diagnosis, h);
        let record = TableRow {
            scheme: scheme.family,
            degree: scheme.degree,
            verdict: verdict.headline(),
            order: verdict.order,
            slope: (verdict.kind == VerdictKind::NotSymplectic).then(|| small_loops.slope()),
            digits: verdict.digits,
            breaks: largest.and_then(|point| point.jumps).unwrap_or(0),
            crossings: scheme.crossings,
            closed_conserved: verdict.conserved_once_closed,
            defect,
            defect_step_size,
            energy_error: changes.energy[0].max(changes.energy[1]),
            energy_growth: changes.energy[1] / changes.energy[0],
            gauss_residual: changes.gauss,
            momentum_change: changes.momentum,
            substeps: (diagnosis.evidence.localisation.as_ref())
                .map_or_else(String::new, faulty_substeps),
            evaluations: diagnosis.evidence.evaluations.made,
        };
        Ok(SchemeResult {
            family: scheme.family,
            small_loops,
            kind: verdict.kind,
            record,
        })
    }
}

/// The measured step size nearest to `h`, and the largest relative change of a loop integral there.
fn defect_near(diagnosis: &Diagnosis, h: f64) -> (f64, f64) {
    let points = diagnosis.points();
    let distance = |h_of_point: f64| (h_of_point / h).ln().abs();
    let sizes = points.iter().map(|point| point.step_size);
    let nearest = sizes
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
        .unwrap_or(h);
    let defects = points
        .iter()
        .filter(|point| point.step_size == nearest)
        .map(|point| point.defect);
    (nearest, defects.fold(f64::NAN, f64::max))
}

/// The names of the substeps that change the integral by more than the uncertainty, or have their own breaks.
fn faulty_substeps(localisation: &Localisation) -> String {
    let mut names: Vec<&str> = Vec::new();
    for substep in &localisation.substeps {
        let changes = (substep.uncertainty).is_some_and(|bound| substep.change.abs() > bound);
        // H_p1 for 0.5 h and H_p1 for h are one.
        let end = [" of ", " for "]
            .iter()
            .find_map(|word| substep.name.find(word));
        let name = &substep.name[..end.unwrap_or(substep.name.len())];
        if (changes || substep.new_breaks > 0) && !names.contains(&name) {
            names.push(name);
        }
    }
    names.join(", ")
}
