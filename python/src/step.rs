//! Functions of the user as maps, manifolds and loops: what the threads of a diagnosis see of them.

use std::sync::Arc;

use symplint::map::{
    Capabilities, Constraint, Difference, Differences, Parts, Prefetch, Substeps, TangentMap,
};
use symplint::state::Rows;
use symplint::{Block, Coordinates, Ensemble, Loop, StepFailure, TimeAdvance};

use crate::calls::{Call, Caller, call, stopped};

/// Coordinates that are handed to the thread of the user at once, at most: 32 MiB of positions and as many of momenta.
const MAX_VALUES: usize = 1 << 22;

/// A map whose step is a Python function.
pub struct PythonMap<'a> {
    caller: &'a dyn Caller,
    coordinates: Coordinates,
    projection: Option<Projection<'a>>,
    /// The names of the parts of the step; none if it is one whole.
    pub parts: &'a [String],
    /// Whether workers take the steps.
    pub has_workers: bool,
    /// Whether a function gives its derivatives.
    pub has_tangent: bool,
    /// Whether a function gives the energy of states.
    pub has_energy: bool,
    /// Whether a function reverses states in time.
    pub has_reversal: bool,
}

/// The kind of a Python function that puts states on a manifold.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Projects {
    /// The user gave no such function.
    Nothing,
    /// It puts states on a constraint manifold.
    OntoManifold,
    /// It evaluates a one-form, on a leaf or without one.
    OntoForm,
}

/// A manifold on which a Python function puts states.
struct Projection<'a> {
    caller: &'a dyn Caller,
    is_of_one_form: bool,
}

impl<'a> PythonMap<'a> {
    /// The map, of which nothing more is known.
    pub fn new(caller: &'a dyn Caller, coordinates: Coordinates, projects: Projects) -> Self {
        PythonMap {
            caller,
            coordinates,
            projection: (projects != Projects::Nothing).then_some(Projection {
                caller,
                is_of_one_form: projects == Projects::OntoForm,
            }),
            parts: &[],
            has_workers: false,
            has_tangent: false,
            has_energy: false,
            has_reversal: false,
        }
    }
}

impl TimeAdvance for PythonMap<'_> {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        call(self.caller, block, |loan| Call::Step(h, loan)).map(|_| ())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            block_width: (MAX_VALUES / self.dof().max(1)).max(1),
            substeps: (!self.parts.is_empty()).then_some(self),
            tangent: self.has_tangent.then_some(self),
            constraint: self.projection.as_ref().map(|found| found as _),
            energy: self.has_energy.then(|| {
                Box::new(|q: Rows<'_>, p: Rows<'_>, energies: &mut [f64]| {
                    self.energies(q, p, energies);
                }) as _
            }),
            reversal: self.has_reversal.then(|| {
                Box::new(|block: &mut Block<'_>| {
                    // If the call fails, the diagnosis stops.
                    let _ = call(self.caller, block, Call::Reverse);
                }) as _
            }),
            prefetch: self.has_workers.then_some(self),
            difference: self
                .has_workers
                .then(|| Box::new(|| self.difference()) as Differences<'_>),
            is_stopped: Some(Box::new(|| self.caller.is_stopped())),
            ..Capabilities::of_coordinates(self.coordinates.clone())
        }
    }
}

impl Substeps for PythonMap<'_> {
    fn substeps(&self) -> usize {
        self.parts.len()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        call(self.caller, block, |loan| Call::Part(substep, h, loan)).map(|_| ())
    }

    fn substep_name(&self, substep: usize) -> String {
        self.parts[substep].clone()
    }
}

impl PythonMap<'_> {
    /// Writes the energy of each state.
    fn energies(&self, q: Rows<'_>, p: Rows<'_>, energies: &mut [f64]) {
        let mut states = Ensemble::zeros(self.dof(), energies.len());
        let mut block = states.block();
        for i in 0..self.dof() {
            block.q.row_mut(i).copy_from_slice(q.row(i));
            block.p.row_mut(i).copy_from_slice(p.row(i));
        }
        match call(self.caller, &mut block, Call::Energy) {
            Ok(_) => energies.copy_from_slice(block.q.row(0)),
            // The diagnosis stops.
            Err(_) => energies.fill(f64::NAN),
        }
    }
}

impl PythonMap<'_> {
    /// The largest difference between results of workers.
    fn difference(&self) -> Option<Difference> {
        let (found, mut any) = (Arc::default(), Ensemble::zeros(1, 1));
        let compare = |loan| Call::Compare(Arc::clone(&found), loan);
        call(self.caller, &mut any.block(), compare).ok()?;
        found.get().copied()
    }
}

impl Prefetch for PythonMap<'_> {
    fn begin(&self, h: f64, block: &Block<'_>) {
        let states = block.copy_of(0..block.len());
        self.caller.tell(Call::Begin(h, states));
    }
}

impl TangentMap for PythonMap<'_> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let dof = self.dof();
        let mut both = Ensemble::zeros(2 * dof, states.len());
        let mut block = both.block();
        for (first, from) in [(0, &*states), (dof, &*tangents)] {
            for i in 0..dof {
                block.q.row_mut(first + i).copy_from_slice(from.q.row(i));
                block.p.row_mut(first + i).copy_from_slice(from.p.row(i));
            }
        }
        call(self.caller, &mut block, |loan| Call::Tangents(h, loan))?;
        for (first, mut to) in [(0, states.reborrow()), (dof, tangents.reborrow())] {
            for i in 0..dof {
                to.q.row_mut(i).copy_from_slice(block.q.row(first + i));
                to.p.row_mut(i).copy_from_slice(block.p.row(first + i));
            }
        }
        Ok(())
    }
}

impl Constraint for Projection<'_> {
    fn project(&self, block: &mut Block<'_>) {
        if call(self.caller, block, Call::Project).is_err() {
            invalidate(block);
        }
    }

    fn is_of_one_form(&self) -> bool {
        self.is_of_one_form
    }
}

/// A loop that a Python function samples.
pub struct PythonLoop<'a> {
    caller: &'a dyn Caller,
    dof: usize,
}

impl<'a> PythonLoop<'a> {
    /// The loop in a phase space of `dof` degrees of freedom.
    pub fn new(caller: &'a dyn Caller, dof: usize) -> Self {
        PythonLoop { caller, dof }
    }
}

impl Loop for PythonLoop<'_> {
    fn dof(&self) -> usize {
        self.dof
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let sampled = call(self.caller, block, |loan| Call::Loop(s.to_vec(), loan));
        if sampled.is_err() {
            invalidate(block);
        }
    }
}

/// States that are not valid: the diagnosis refuses them.
fn invalidate(block: &mut Block<'_>) {
    block.q.fill(f64::NAN);
    block.p.fill(f64::NAN);
}

/// A compiled map that fails once the user has stopped the diagnosis.
pub struct Stoppable<'a> {
    map: &'a dyn TimeAdvance,
    caller: &'a dyn Caller,
}

impl<'a> Stoppable<'a> {
    /// `map`, as long as the diagnosis is not stopped.
    pub fn new(map: &'a dyn TimeAdvance, caller: &'a dyn Caller) -> Self {
        Stoppable { map, caller }
    }

    fn check(&self) -> Result<(), StepFailure> {
        match self.caller.is_stopped() {
            true => Err(stopped()),
            false => Ok(()),
        }
    }
}

impl TimeAdvance for Stoppable<'_> {
    fn dof(&self) -> usize {
        self.map.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.check()?;
        self.map.advance(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            is_stopped: Some(Box::new(|| self.caller.is_stopped())),
            ..self.map.capabilities()
        }
    }
}

impl Substeps for Stoppable<'_> {
    fn substeps(&self) -> usize {
        Parts::of(self.map).count()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.check()?;
        Parts::of(self.map).advance(substep, h, block)
    }

    fn substep_name(&self, substep: usize) -> String {
        Parts::of(self.map).name(substep)
    }
}
