//! Whether a map whose loop integrals change preserves another closed two-form: the form of the right variables.

mod fit;
mod limits;
mod matrix;
mod null_space;
mod on_loops;
mod refine;
mod rounded;

use fit::{Entry, FormFit, Term};
use limits::{
    DOFS_OF_FIELD, EXTRA_VECTORS, MAX_DOF_OF_ALL_FORMS, MAX_DOF_OF_WEIGHTS, MAX_EVALUATIONS,
    MAX_SAMPLES, SEED_OF_REFINING, STATES,
};
use on_loops::AdvancedLoop;

use super::random_loops::loop_of_kind;
use super::{GivenLoop, Runner};
use crate::error::Error;
use crate::evidence::{
    Check, FormEntry, FormOnLoop, LoopEvidence, LoopKind, OmissionReason, PreservedForm,
    uncertain_part,
};
use crate::jacobian::{JacobianEvidence, JacobianTest, TangentImages};
use crate::loops::FEW_SAMPLES;
use crate::rules::Subject;
use crate::signal::{NEGLIGIBLE, parameters};

impl Runner<'_> {
    /// If the integral of a loop without breaks changes, searches for a form that the Jacobians preserve, and compares the integrals of
    /// that form before and after a step.
    pub(super) fn look_for_form(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let images = std::mem::take(&mut self.images);
        let survey = &self.evidence.survey;
        let is_smooth = !self.evidence.loops.iter().any(LoopEvidence::is_broken);
        let is_defined = survey.singular.is_none()
            && survey.degenerate_form.is_none()
            && subject.evaluator.constraint().is_none()
            && !survey.scatter.is_some_and(|scatter| scatter.is_random());
        let of_jacobian = self.evidence.jacobian.as_ref();
        let is_wanted = self.diagnostic.jacobian && self.diagnostic.properties;
        if !(is_wanted && is_smooth && is_defined)
            || given.probe.is_beyond_memory()
            || subject.dof() > MAX_DOF_OF_WEIGHTS
            || self.changed_loop().is_none()
            || of_jacobian.is_some_and(|of| !JacobianEvidence::shows_defect(of))
        {
            return Ok(());
        }
        let (dof, h) = (subject.dof(), self.largest);
        let all_constant = dof <= MAX_DOF_OF_ALL_FORMS;
        let Some(images) = self.columns(subject, given, images)? else {
            self.omit(Check::PreservedForm, OmissionReason::BUDGET);
            return Ok(());
        };
        let mut found = PreservedForm {
            step_size: subject.evaluator.stated(h),
            dof,
            all_constant,
            with_fields: false,
            is_linear: fit::are_equal(&images),
            digits_of_matrix: None,
            states: images.len(),
            exists: None,
            change: None,
            entries: Vec::new(),
            groups: 0,
            loops: Vec::new(),
        };
        if let ([first, ..], true) = (&images[..], found.is_linear && all_constant) {
            let size = given.size.radius.concat();
            found.digits_of_matrix = matrix::digits(first, &size, subject.coordinates());
        }
        // The last state confirms what the others show.
        let [of_fit @ .., _] = &images[..] else {
            return Ok(());
        };
        let mut fit = fit::preserved(of_fit, dof, all_constant);
        let has_period = (0..dof).any(|i| subject.coordinates().period(i) != 0.0);
        if let FormFit::None { .. } | FormFit::Degenerate = fit
            && DOFS_OF_FIELD.contains(&dof)
            && !has_period
        {
            match fit::with_field(of_fit, dof) {
                // The constant form that comes nearest stays the answer.
                FormFit::None { .. } => found.with_fields = true,
                FormFit::Open | FormFit::Degenerate => {}
                preserved @ FormFit::Preserved(_) => (fit, found.with_fields) = (preserved, true),
            }
        }
        match fit {
            FormFit::Open => {}
            FormFit::Degenerate => found.exists = Some(false),
            FormFit::None { change } => {
                (found.exists, found.change) = (Some(false), Some(change));
            }
            FormFit::Preserved(entries) => {
                if let Some(entries) = self.form(subject, given, &images, &entries)? {
                    found.loops = self.on_loops(subject, given, &entries)?;
                    found.exists = Some(true);
                    found.groups = entries.iter().map(|of| of.group + 1).max().unwrap_or(0);
                    found.entries = entries;
                }
            }
        }
        self.evidence.preserved_form = Some(found);
        Ok(())
    }

    /// A form that fits the Jacobians, in the coordinates of the map with as many digits as it is known to. `None` if the Jacobian at
    /// another state does not confirm it.
    fn form(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        images: &[TangentImages],
        of_fit: &[Entry],
    ) -> Result<Option<Vec<FormEntry>>, Error> {
        let (dof, size) = (subject.dof(), given.size.radius.concat());
        let holds = |entries: &[FormEntry]| {
            let mut errors = entries.iter().map(FormEntry::relative_error);
            errors.all(|error| error <= NEGLIGIBLE)
                && fit::holds(images, dof, &rounded::in_units(entries, &size))
        };
        let exact = rounded::in_coordinates(of_fit, &size);
        let chosen = rounded::rounded(&exact, dof, None);
        let entries = match uncertain_part(&chosen) > f64::EPSILON {
            true => self.refined(subject, given, &exact)?.unwrap_or(chosen),
            false => chosen,
        };
        Ok(holds(&entries).then_some(entries))
    }

    /// The images of tangent vectors at several states: those that the Jacobian has, and as many further ones as are needed. `None` if the
    /// budget does not allow them.
    fn columns(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        mut images: Vec<TangentImages>,
    ) -> Result<Option<Vec<TangentImages>>, Error> {
        let dof = subject.dof();
        let (states, random) = match dof <= MAX_DOF_OF_ALL_FORMS {
            true => (STATES, None),
            false => {
                images.clear();
                let vectors = (2.0 * dof as f64).sqrt().ceil() as usize + EXTRA_VECTORS;
                (STATES - 1, Some(vectors))
            }
        };
        let missing = states.saturating_sub(images.len());
        if missing > 0 {
            let test = JacobianTest {
                points: missing,
                full_up_to: if random.is_none() { dof } else { 0 },
                directions: random.unwrap_or(2 * dof),
                ..JacobianTest::default()
            };
            let cost = test.evaluations(dof, false);
            let left = self.count.left().min(MAX_EVALUATIONS);
            if cost + FEW_SAMPLES > left {
                return Ok(None);
            }
            let spare = left - cost - FEW_SAMPLES;
            let with = (subject.phase_loop, &given.size);
            // Not those of the Jacobian.
            let first = JacobianTest::default().points;
            let s = parameters(first + missing).split_off(first);
            let more = test.images(
                subject.evaluator,
                with,
                self.largest,
                s,
                random,
                spare.min(cost / 2),
            )?;
            images.extend(more);
        }
        Ok(Some(images))
    }

    /// The entries with as many digits as further random loops give them; `None` if the budget does not allow loops.
    fn refined(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        entries: &[FormEntry],
    ) -> Result<Option<Vec<FormEntry>>, Error> {
        let coordinates = subject.coordinates();
        // The weights of that many degrees of freedom need no more.
        let loops = entries.len().min(MAX_DOF_OF_ALL_FORMS);
        // One entry alone has the unit of its group.
        if entries.len() < 2 || (loops + 2) * FEW_SAMPLES > self.count.left() {
            return Ok(None);
        }
        let mut changes = Vec::new();
        for k in 0..loops {
            let seed = SEED_OF_REFINING.wrapping_add(self.diagnostic.seed + k as u64);
            let random = loop_of_kind(LoopKind::Extended, None, &given.size, coordinates, seed)?;
            let advanced = AdvancedLoop::new(subject.on(random.as_ref()), self.largest)?;
            changes.extend(advanced.change(entries, coordinates));
        }
        let resolutions = changes.iter().map(|of| of.uncertainty / of.scale);
        let resolution = resolutions.reduce(f64::min);
        let refined = refine::refined(entries, &changes);
        Ok(refined.map(|refined| rounded::rounded(&refined, subject.dof(), resolution)))
    }

    /// The changes of integrals of the form round the given loop and a random one.
    fn on_loops(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        entries: &[FormEntry],
    ) -> Result<Vec<FormOnLoop>, Error> {
        let counts = |found: &&LoopEvidence| {
            let is_random = matches!(found.kind, LoopKind::Random | LoopKind::Extended);
            found.index == 0 || is_random && !found.winds && !found.steps.is_empty()
        };
        let mut changes = Vec::new();
        for found in self.evidence.loops.iter().filter(counts).take(2) {
            let left = self.count.left().min(MAX_SAMPLES);
            if left < FEW_SAMPLES {
                break;
            }
            let random = (self.diagnostic).random_loop_of(found, &given.size, subject)?;
            let of_loop = subject.on(random.as_ref());
            changes.extend(on_loops::change(
                of_loop,
                found.index,
                self.largest,
                entries,
                left,
            )?);
        }
        Ok(changes)
    }
}
