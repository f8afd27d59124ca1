//! Every integrator by name.

use super::implicit::StageSolver;
use super::splitting::Variant;
use super::{aliases, splitting_methods, tableaus};
use crate::error::ModelError;
use crate::model::Model;

pub use super::maker::{Maker, MapResult};

/// What there is to know of an integrator before it is built.
#[derive(Clone, Copy, Debug)]
pub struct IntegratorInfo {
    /// The name by which it is built.
    pub name: &'static str,
    /// Its variants, the default first; empty if there is but one form.
    pub variants: &'static [&'static str],
    /// Order of accuracy for smooth Hamiltonians, of all variants; 0 where a step of size h does
    /// not take the time h.
    pub order: u32,
    /// Whether its step is symplectic for the Hamiltonians it is for, with a continuous force and
    /// stages, if there are any to solve, solved exactly.
    pub symplectic: bool,
    /// Its description in one line.
    pub summary: &'static str,
    /// Its source.
    pub reference: &'static str,
    /// One maker, or one for each variant.
    pub makers: &'static [Maker],
}

impl IntegratorInfo {
    /// Whether it can advance such a system.
    pub fn is_for(&self, model: &Model) -> bool {
        self.makers[0]
            .make(model.clone(), StageSolver::default())
            .is_some()
    }

    /// Whether its steps have stages to be solved, by a [`StageSolver`].
    pub fn is_implicit(&self) -> bool {
        self.makers[0].is_implicit()
    }
}

const FIRST: &[&str] = &["position-first", "momentum-first"];

/// A splitting method in the variants of [`FIRST`].
macro_rules! both_variants {
    ($method:path) => {
        &[
            Maker::Splitting($method, Variant::PositionFirst),
            Maker::Splitting($method, Variant::MomentumFirst),
        ]
    };
}

/// The integrators of this crate, splitting methods first, mistakes last. HNW is E. Hairer, S. P. Nørsett & G.
/// Wanner, Solving Ordinary Differential Equations I, 2nd edition.
const METHODS: &[IntegratorInfo] = &[
    IntegratorInfo {
        name: "lie-trotter",
        variants: FIRST,
        order: 1,
        symplectic: true,
        summary: "Lie–Trotter splitting (symplectic Euler): one drift, one kick; the momentum-first form is \
                  the staggered leapfrog, with momenta half a step behind positions",
        reference: "Barham & Burby, section 4.2; HLW, section VI.3",
        makers: both_variants!(splitting_methods::lie_trotter),
    },
    IntegratorInfo {
        name: "strang",
        variants: FIRST,
        order: 2,
        symplectic: true,
        summary: "Strang splitting (Störmer–Verlet, leapfrog): half a drift, a kick, half a drift; the \
                  momentum-first form, with half kicks, is velocity Verlet",
        reference: "Barham & Burby, appendix D; HLW, section II.5",
        makers: both_variants!(splitting_methods::strang),
    },
    IntegratorInfo {
        name: "mclachlan4",
        variants: FIRST,
        order: 4,
        symplectic: true,
        summary: "McLachlan's splitting of five stages, with a small error constant",
        reference: "McLachlan 1995; HLW, section V.3.1",
        makers: both_variants!(splitting_methods::mclachlan4),
    },
    IntegratorInfo {
        name: "yoshida4",
        variants: FIRST,
        order: 4,
        symplectic: true,
        summary: "Triple jump: three Strang steps",
        reference: "Yoshida 1990; HLW, section II.4",
        makers: both_variants!(splitting_methods::yoshida4),
    },
    IntegratorInfo {
        name: "yoshida6",
        variants: FIRST,
        order: 6,
        symplectic: true,
        summary: "Yoshida's solution A: seven Strang steps",
        reference: "Yoshida 1990; HLW, section V.3.2",
        makers: both_variants!(splitting_methods::yoshida6),
    },
    IntegratorInfo {
        name: "yoshida8",
        variants: FIRST,
        order: 8,
        symplectic: true,
        summary: "Yoshida's solution D: fifteen Strang steps",
        reference: "Yoshida 1990",
        makers: both_variants!(splitting_methods::yoshida8),
    },
    IntegratorInfo {
        name: "euler",
        variants: &[],
        order: 1,
        symplectic: false,
        summary: "Explicit Euler",
        reference: "HLW, section I.1.2",
        makers: &[Maker::RungeKutta(tableaus::euler)],
    },
    IntegratorInfo {
        name: "rk2",
        variants: &["midpoint", "heun"],
        order: 2,
        symplectic: false,
        summary: "Runge–Kutta of order 2: explicit midpoint rule, or Heun's explicit trapezoidal rule",
        reference: "HLW, section II.1.1",
        makers: &[
            Maker::RungeKutta(tableaus::midpoint),
            Maker::RungeKutta(tableaus::heun),
        ],
    },
    IntegratorInfo {
        name: "rk4",
        variants: &[],
        order: 4,
        symplectic: false,
        summary: "The classical Runge–Kutta method of order 4",
        reference: "HLW, section II.1.1",
        makers: &[Maker::RungeKutta(tableaus::rk4)],
    },
    IntegratorInfo {
        name: "partitioned-rk",
        variants: &["strang-position-first", "strang-momentum-first"],
        order: 2,
        symplectic: true,
        summary: "Strang splitting written as a partitioned Runge–Kutta method",
        reference: "Barham & Burby, appendix D",
        makers: &[
            Maker::Partitioned(tableaus::strang_position_first),
            Maker::Partitioned(tableaus::strang_momentum_first),
        ],
    },
    IntegratorInfo {
        name: "rk45",
        variants: &[],
        order: 5,
        symplectic: false,
        summary: "Dormand–Prince 5(4), the fifth-order weights at a fixed step",
        reference: "Dormand & Prince 1980; HNW, section II.5",
        makers: &[Maker::RungeKutta(tableaus::rk45)],
    },
    IntegratorInfo {
        name: "dop853",
        variants: &[],
        order: 8,
        symplectic: false,
        summary: "DOP853, the eighth-order weights at a fixed step",
        reference: "HNW, section II.5",
        makers: &[Maker::RungeKutta(tableaus::dop853)],
    },
    IntegratorInfo {
        name: "implicit-midpoint",
        variants: &[],
        order: 2,
        symplectic: true,
        summary: "The implicit midpoint rule, Gauss of one stage",
        reference: "HLW, section II.1.3",
        makers: &[Maker::Implicit(tableaus::implicit_midpoint)],
    },
    IntegratorInfo {
        name: "gauss4",
        variants: &[],
        order: 4,
        symplectic: true,
        summary: "Gauss–Legendre of two stages",
        reference: "HLW, section II.1.3",
        makers: &[Maker::Implicit(tableaus::gauss4)],
    },
    IntegratorInfo {
        name: "gauss6",
        variants: &[],
        order: 6,
        symplectic: true,
        summary: "Gauss–Legendre of three stages",
        reference: "HLW, section II.1.3",
        makers: &[Maker::Implicit(tableaus::gauss6)],
    },
    IntegratorInfo {
        name: "trapezoidal",
        variants: &[],
        order: 2,
        symplectic: false,
        summary: "The implicit trapezoidal rule, conjugate to the midpoint rule and not symplectic itself",
        reference: "HLW, section VI.8",
        makers: &[Maker::Implicit(tableaus::trapezoidal)],
    },
    IntegratorInfo {
        name: "averaged-vector-field",
        variants: &[],
        order: 2,
        symplectic: false,
        summary: "A discrete gradient, conserves the energy",
        reference: "Quispel & McLaren 2008",
        makers: &[Maker::Implicit(tableaus::averaged_vector_field)],
    },
    IntegratorInfo {
        name: "discrete-gradient",
        variants: &[],
        order: 2,
        symplectic: false,
        summary: "The midpoint discrete gradient, conserves any energy as far as it is solved",
        reference: "Gonzalez 1996; HLW, section V.5",
        makers: &[Maker::DiscreteGradient],
    },
    IntegratorInfo {
        name: "boris",
        variants: &[],
        order: 2,
        symplectic: false,
        summary: "The Boris method in canonical variables: conserves volumes, for charged-particle only",
        reference: "Boris 1970; Qin et al. 2013",
        makers: &[Maker::Boris],
    },
    IntegratorInfo {
        name: "adaptive-strang",
        variants: FIRST,
        order: 0,
        symplectic: false,
        summary: "Strang splitting with the step h/√(1 + |force|²), which depends on the state",
        reference: "HLW, chapter VIII",
        makers: &[
            Maker::AdaptiveStrang(Variant::PositionFirst),
            Maker::AdaptiveStrang(Variant::MomentumFirst),
        ],
    },
    IntegratorInfo {
        name: "wrong-sign-euler",
        variants: &[],
        order: 1,
        symplectic: false,
        summary: "Symplectic Euler whose drift uses momenta kicked with the wrong sign, a deliberate mistake",
        reference: "none",
        makers: &[Maker::Partitioned(tableaus::wrong_sign_euler)],
    },
];

/// Integrators by name: those of this crate, and those that another one has for its own systems.
///
/// ```
/// use symplint_models::integrators::catalogue::CATALOGUE;
///
/// let (info, variant) = CATALOGUE.resolve("leapfrog", None)?;
/// assert_eq!((info.name, variant), ("strang", Some("momentum-first")));
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Catalogue {
    others: &'static [IntegratorInfo],
}

/// The integrators of this crate.
pub const CATALOGUE: Catalogue = Catalogue::with(&[]);

impl Catalogue {
    /// The integrators of this crate and `others`.
    pub const fn with(others: &'static [IntegratorInfo]) -> Self {
        Catalogue { others }
    }

    /// All entries.
    pub fn iter(self) -> impl Iterator<Item = &'static IntegratorInfo> + Clone {
        METHODS.iter().chain(self.others)
    }

    /// The entry of an integrator, by its name or by one of the [`aliases`].
    ///
    /// # Errors
    /// If the catalogue does not have this name; the error lists its names.
    pub fn find(self, name: &str) -> Result<&'static IntegratorInfo, ModelError> {
        let name = aliases::find(name).map_or(name, |alias| alias.integrator);
        let entry = self.iter().find(|info| info.name == name);
        entry.ok_or_else(|| ModelError::UnknownIntegrator {
            name: name.to_owned(),
            known: self.iter().map(|info| info.name).collect(),
        })
    }

    /// The entry of the integrator `name`, and the variant if one is given or implied by an alias.
    ///
    /// # Errors
    /// If no integrator has this name, it has no such variant, or the alias stands for another one.
    pub fn resolve(
        self,
        name: &str,
        variant: Option<&str>,
    ) -> Result<(&'static IntegratorInfo, Option<&'static str>), ModelError> {
        let info = self.find(name)?;
        let (name, known) = match aliases::find(name) {
            Some(alias) if !alias.variants.is_empty() => (alias.name, alias.variants),
            _ => (info.name, info.variants),
        };
        match variant {
            None if known.len() == 1 => Ok((info, Some(known[0]))),
            None => Ok((info, None)),
            Some(variant) => match known.iter().find(|one| **one == variant) {
                Some(&found) => Ok((info, Some(found))),
                None => Err(ModelError::UnknownVariant {
                    integrator: name,
                    variant: variant.to_owned(),
                    known,
                }),
            },
        }
    }

    /// The map of the integrator `name`, in its default form unless a `variant` is given, for `system`. The name may
    /// be one of the [`aliases`]. Stages of implicit methods are solved by `solver`.
    ///
    /// # Errors
    /// If no integrator has this name, it has no such variant, or it cannot advance such a system (the error
    /// lists those that can); or as [`ImplicitRungeKutta::new`](super::ImplicitRungeKutta::new).
    pub fn build(
        self,
        solver: StageSolver,
        name: &str,
        variant: Option<&str>,
        system: impl Into<Model>,
    ) -> MapResult {
        let ((info, variant), model) = (self.resolve(name, variant)?, system.into());
        let index = info
            .variants
            .iter()
            .position(|known| Some(*known) == variant);
        // Without a variant the first, or only, form.
        let maker = info.makers[index.unwrap_or(0)];
        let made = maker.make(model.clone(), solver);
        made.unwrap_or_else(|| {
            let known = self.iter().filter(|info| info.is_for(&model));
            Err(ModelError::NotForThis {
                integrator: info.name,
                needs: maker.needs(),
                kind: model.kind(),
                known: known.map(|info| info.name).collect(),
            })
        })
    }
}

/// The map of an integrator of this crate, as [`Catalogue::build`] makes it, with stages solved as
/// [`StageSolver::default`] says.
///
/// ```
/// use std::sync::Arc;
/// use symplint_models::integrators::catalogue;
/// use symplint_models::systems::HenonHeiles;
///
/// let step = catalogue::build("strang", Some("momentum-first"), Arc::new(HenonHeiles))?;
/// assert_eq!(step.dof(), 2);
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
///
/// # Errors
/// As [`Catalogue::build`].
pub fn build(name: &str, variant: Option<&str>, system: impl Into<Model>) -> MapResult {
    CATALOGUE.build(StageSolver::default(), name, variant, system)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::discrete::StandardMap;
    use crate::systems::{ChargedParticle, DoublePendulum, HenonHeiles, RotationalForce};

    #[test]
    fn every_variant_has_its_maker() {
        for info in METHODS {
            assert_eq!(
                info.makers.len(),
                info.variants.len().max(1),
                "{}",
                info.name
            );
        }
    }

    #[test]
    fn the_catalogue_repeats_what_the_methods_say() {
        for info in METHODS {
            for maker in info.makers {
                let (order, symplectic) = match maker {
                    Maker::Splitting(method, variant) => (method(*variant).order(), true),
                    Maker::RungeKutta(tableau) | Maker::Implicit(tableau) => {
                        (tableau().order(), tableau().is_symplectic())
                    }
                    // These are no tables.
                    Maker::AdaptiveStrang(_)
                    | Maker::DiscreteGradient
                    | Maker::Boris
                    | Maker::For { .. } => continue,
                    Maker::Partitioned(pair) => (
                        pair().position().order(),
                        pair().is_symplectic_if_separable(),
                    ),
                };
                assert_eq!(
                    (info.order, info.symplectic),
                    (order, symplectic),
                    "{}",
                    info.name
                );
            }
        }
    }

    #[test]
    fn wrong_names_are_answered_by_the_right_ones() {
        let message = |name, variant| match build(name, variant, Arc::new(HenonHeiles)) {
            Ok(_) => panic!("{name} was built"),
            Err(error) => error.to_string(),
        };
        assert!(message("leap-frog", None).contains("strang, mclachlan4"));
        assert_eq!(
            message("rk2", Some("ralston")),
            "integrator \"rk2\" has no variant \"ralston\"; there are midpoint, heun (the first \
             is the default)"
        );
        assert!(message("rk4", Some("midpoint")).ends_with("leave the variant out"));
        let said = message("verlet", Some("position-first"));
        assert!(
            said.contains("\"verlet\" has no variant \"position-first\""),
            "{said}"
        );
        assert!(said.contains("momentum-first"), "{said}");
    }

    #[test]
    fn each_kind_of_system_has_its_integrators() {
        let names = |model: Model| -> Vec<&str> {
            let known = CATALOGUE.iter().filter(|info| info.is_for(&model));
            known.map(|info| info.name).collect()
        };
        let separable = names(Model::Separable(Arc::new(HenonHeiles)));
        // All but the one for charges.
        assert_eq!(separable.len(), METHODS.len() - 1);
        let general = names(Model::General(Arc::new(DoublePendulum::default())));
        assert!(general.contains(&"rk4") && general.contains(&"gauss6"));
        assert!(!general.contains(&"strang") && !general.contains(&"partitioned-rk"));
        let particle = ChargedParticle::new(1.0, 0.0, 0.0).unwrap();
        let charged = names(Model::Charged(particle));
        assert_eq!(charged.len(), general.len() + 1);
        assert!(charged.contains(&"boris"));
        let force = RotationalForce::new(0.1).unwrap();
        let forced = names(Model::Forced(Arc::new(force)));
        assert!(forced.contains(&"strang") && !forced.contains(&"rk4"));
        let map = StandardMap::new(1.0).unwrap();
        assert!(names(Model::Map(Arc::new(map))).is_empty());
    }

    #[test]
    fn what_cannot_be_advanced_is_told_what_can() {
        let pendulum = Model::General(Arc::new(DoublePendulum::default()));
        let error = build("strang", None, pendulum).map(|_| ()).unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("not separable; there are euler, rk2"),
            "{message}"
        );
    }
}
