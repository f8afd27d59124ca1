//! Integrators by name, with the schemes for plasmas.

use std::any::Any;
use std::num::NonZeroUsize;
use std::sync::Arc;

use symplint_models::integrators::StageSolver;
use symplint_models::integrators::catalogue::{Catalogue, IntegratorInfo, Maker, MapResult};
use symplint_models::{Model, ModelError};

use crate::gempic::{Boris1d2v, Gempic, Orbit, PlasmaStep};

/// The integrators of [`symplint_models`], and the schemes for electromagnetic plasmas.
///
/// ```
/// use symplint::map::Parts;
/// use symplint_models::Model;
/// use symplint_models::integrators::StageSolver;
/// use symplint_plasma::CATALOGUE;
/// use symplint_plasma::gempic::{Gempic, GempicConfig};
///
/// let plasma = Model::from(Gempic::new(GempicConfig::default())?);
/// let step = CATALOGUE.build(StageSolver::default(), "boris-pic", Some("staggered"), plasma)?;
/// assert_eq!(Parts::of(&step).name(0), "kick of 0.5 h");
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
pub const CATALOGUE: Catalogue = Catalogue::with(SCHEMES);

impl From<Gempic> for Model {
    fn from(plasma: Gempic) -> Self {
        Model::Split(Arc::new(plasma))
    }
}

const NEEDS: &str = "electromagnetic plasmas";

/// Sub-steps of an orbit in one step.
const SUBSTEPS: NonZeroUsize = NonZeroUsize::new(4).unwrap();

/// The push of Boris in its default form.
const BORIS: Boris1d2v = Boris1d2v {
    is_staggered: false,
    gathers_at_nodes: false,
    deposits_directly: false,
};

const fn explicit(make: fn(&Model, StageSolver) -> Option<MapResult>) -> Maker {
    Maker::For {
        needs: NEEDS,
        is_implicit: false,
        make,
    }
}

const fn implicit(make: fn(&Model, StageSolver) -> Option<MapResult>) -> Maker {
    Maker::For {
        needs: NEEDS,
        is_implicit: true,
        make,
    }
}

const SCHEMES: &[IntegratorInfo] = &[
    IntegratorInfo {
        name: "boris-pic",
        variants: &["synchronised", "staggered", "nodal", "direct"],
        order: 2,
        symplectic: false,
        summary: "The push of Boris with leapfrog fields and charge-conserving currents, for pic-1d2v only: velocities \
                  at whole steps or staggered, fields gathered at nodes, or currents deposited directly",
        reference: "Birdsall & Langdon 1985; Esirkepov 2001",
        makers: &[
            explicit(|model, _| boris(model, BORIS)),
            explicit(|model, _| {
                let is_staggered = true;
                boris(
                    model,
                    Boris1d2v {
                        is_staggered,
                        ..BORIS
                    },
                )
            }),
            explicit(|model, _| {
                let gathers_at_nodes = true;
                boris(
                    model,
                    Boris1d2v {
                        gathers_at_nodes,
                        ..BORIS
                    },
                )
            }),
            explicit(|model, _| {
                let deposits_directly = true;
                boris(
                    model,
                    Boris1d2v {
                        deposits_directly,
                        ..BORIS
                    },
                )
            }),
        ],
    },
    IntegratorInfo {
        name: "crank-nicolson",
        variants: &["midpoint", "sub-stepped", "orbit-averaged"],
        order: 2,
        symplectic: false,
        summary: "Crank–Nicolson for particles and fields, conserves the energy, for pic-1d2v only: fields in the middle \
                  of each orbit, of four sub-steps of it, or averaged along it, which conserves the charge as well",
        reference: "Chen, Chacón & Barnes 2011; Kormann & Sonnendrücker 2021",
        makers: &[
            implicit(|model, solver| crank_nicolson(model, Orbit::Midpoint, solver)),
            implicit(|model, solver| crank_nicolson(model, Orbit::SubStepped(SUBSTEPS), solver)),
            implicit(|model, solver| crank_nicolson(model, Orbit::Averaged, solver)),
        ],
    },
    IntegratorInfo {
        name: "ecsim",
        variants: &[],
        // 2 without a magnetic field.
        order: 1,
        symplectic: false,
        summary: "Drifts, and velocities and fields implicitly in between, conserves the energy, for pic-1d2v only",
        reference: "Lapenta 2017",
        makers: &[implicit(|model, solver| {
            plasma(model, |gempic| PlasmaStep::ecsim(gempic, solver))
        })],
    },
];

fn boris(model: &Model, scheme: Boris1d2v) -> Option<MapResult> {
    plasma(model, |gempic| Ok(PlasmaStep::boris(gempic, scheme)))
}

fn crank_nicolson(model: &Model, orbit: Orbit, solver: StageSolver) -> Option<MapResult> {
    plasma(model, |gempic| {
        PlasmaStep::crank_nicolson(gempic, orbit, solver)
    })
}

/// The step that `make` makes of a plasma, or nothing if the model is another system.
fn plasma(
    model: &Model,
    make: impl FnOnce(Gempic) -> Result<PlasmaStep, ModelError>,
) -> Option<MapResult> {
    let Model::Split(system) = model else {
        return None;
    };
    let system: &dyn Any = &**system;
    let gempic = system.downcast_ref::<Gempic>()?.clone();
    Some(make(gempic).map(|step| Box::new(step) as Box<_>))
}
