//! Every integrator by name.

use std::sync::Arc;

use symplint::TimeAdvance;

use super::splitting::{Splitting, SplittingMethod, Variant};
use super::tableau::{Tableau, TableauPair};
use super::{RungeKutta, splitting_methods, tableaus};
use crate::error::ModelError;
use crate::hamiltonian::Separable;

/// What there is to know of an integrator before it is built.
#[derive(Clone, Copy, Debug)]
pub struct IntegratorInfo {
    /// The name by which it is built.
    pub name: &'static str,
    /// Its variants, the default first; empty if there is but one form.
    pub variants: &'static [&'static str],
    /// Order of accuracy for smooth Hamiltonians, of all variants.
    pub order: u32,
    /// Whether its step is symplectic for separable Hamiltonians with a continuous force.
    pub symplectic: bool,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Where it is from.
    pub reference: &'static str,
    /// One maker, or one for each variant.
    makers: &'static [Maker],
}

/// How an integrator is made.
#[derive(Clone, Copy, Debug)]
enum Maker {
    Splitting(fn(Variant) -> SplittingMethod, Variant),
    RungeKutta(fn() -> Tableau),
    Partitioned(fn() -> TableauPair),
}

impl Maker {
    fn make(self, system: Arc<dyn Separable>) -> Result<Box<dyn TimeAdvance>, ModelError> {
        Ok(match self {
            Maker::Splitting(method, variant) => Box::new(Splitting::new(method(variant), system)),
            Maker::RungeKutta(tableau) => Box::new(RungeKutta::separable(tableau(), system)?),
            Maker::Partitioned(pair) => Box::new(RungeKutta::separable(pair(), system)?),
        })
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

/// Every integrator, splitting methods first.
pub const CATALOGUE: &[IntegratorInfo] = &[
    IntegratorInfo {
        name: "lie-trotter",
        variants: FIRST,
        order: 1,
        symplectic: true,
        summary: "Lie–Trotter splitting (symplectic Euler): one drift, one kick",
        reference: "Barham & Burby, section 4.2; HLW, section VI.3",
        makers: both_variants!(splitting_methods::lie_trotter),
    },
    IntegratorInfo {
        name: "strang",
        variants: FIRST,
        order: 2,
        symplectic: true,
        summary: "Strang splitting (Störmer–Verlet, leapfrog)",
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
];

/// The entry of an integrator.
///
/// # Errors
/// If there is none of this name; the error lists those there are.
pub fn find(name: &str) -> Result<&'static IntegratorInfo, ModelError> {
    let entry = CATALOGUE.iter().find(|info| info.name == name);
    entry.ok_or_else(|| ModelError::UnknownIntegrator {
        name: name.to_owned(),
        known: CATALOGUE.iter().map(|info| info.name).collect(),
    })
}

/// The map of the integrator `name`, in its default form unless a `variant` is given, for
/// `system`.
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
/// If there is no integrator of this name or it has no such variant; the error lists those
/// there are.
pub fn build(
    name: &str,
    variant: Option<&str>,
    system: Arc<dyn Separable>,
) -> Result<Box<dyn TimeAdvance>, ModelError> {
    let info = find(name)?;
    let place = match variant {
        None => 0,
        Some(variant) => {
            let place = info.variants.iter().position(|known| *known == variant);
            place.ok_or_else(|| ModelError::UnknownVariant {
                integrator: info.name,
                variant: variant.to_owned(),
                known: info.variants,
            })?
        }
    };
    info.makers[place].make(system)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::systems::HenonHeiles;

    #[test]
    fn every_variant_has_its_maker() {
        for info in CATALOGUE {
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
        for info in CATALOGUE {
            for maker in info.makers {
                let (order, symplectic) = match maker {
                    Maker::Splitting(method, variant) => (method(*variant).order(), true),
                    Maker::RungeKutta(tableau) => (tableau().order(), tableau().is_symplectic()),
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
        assert!(message("leapfrog", None).contains("strang, mclachlan4"));
        assert_eq!(
            message("rk2", Some("ralston")),
            "integrator \"rk2\" has no variant \"ralston\"; there are midpoint, heun (the first \
             is the default)"
        );
        assert!(message("rk4", Some("midpoint")).ends_with("leave the variant out"));
    }
}
