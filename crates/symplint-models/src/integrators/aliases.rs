//! Names in common use for integrators of the catalogue.

const KICK_FIRST: &[&str] = &["momentum-first"];

/// Another name in common use for an integrator, or for one of its variants.
#[derive(Clone, Copy, Debug)]
pub struct Alias {
    /// The other name.
    pub name: &'static str,
    /// The name of the integrator in the [catalogue](super::catalogue).
    pub integrator: &'static str,
    /// The variant that the name stands for, alone in a list; an empty list if it stands for all of them.
    pub variants: &'static [&'static str],
}

/// Every alias. Verlet and leapfrog without an attribute are the kick-drift-kick form, velocity Verlet,
/// which is the one that most codes implement.
pub const ALIASES: &[Alias] = &[
    Alias {
        name: "verlet",
        integrator: "strang",
        variants: KICK_FIRST,
    },
    Alias {
        name: "velocity-verlet",
        integrator: "strang",
        variants: KICK_FIRST,
    },
    Alias {
        name: "leapfrog",
        integrator: "strang",
        variants: KICK_FIRST,
    },
    Alias {
        name: "kick-drift-kick",
        integrator: "strang",
        variants: KICK_FIRST,
    },
    Alias {
        name: "drift-kick-drift",
        integrator: "strang",
        variants: &["position-first"],
    },
    Alias {
        name: "symplectic-euler",
        integrator: "lie-trotter",
        variants: &[],
    },
];

/// The alias of this name, if it is one.
pub fn find(name: &str) -> Option<&'static Alias> {
    ALIASES.iter().find(|alias| alias.name == name)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use symplint::Block;
    use symplint::state::RowsMut;

    use super::*;
    use crate::integrators::catalogue::{self, CATALOGUE, build};
    use crate::systems::HarmonicOscillator;

    /// One step of h = ½ from (1, 0) on H = p²/2 + q²/2, computed by hand.
    #[test]
    fn aliases_are_the_methods_that_textbooks_call_so() {
        let step = |name: &str, variant: Option<&str>| {
            let oscillator = HarmonicOscillator::new(vec![1.0]).unwrap();
            let map = build(name, variant, Arc::new(oscillator)).unwrap();
            let (mut q, mut p) = ([1.0], [0.0]);
            let rows = |values| RowsMut::new(values, 1, 1, 1);
            let mut state = Block::new(rows(&mut q), rows(&mut p));
            map.advance(0.5, &mut state).unwrap();
            (q[0], p[0])
        };
        // p ← p − h/2 q, q ← q + h p, p ← p − h/2 q.
        for name in ["verlet", "leapfrog", "velocity-verlet", "kick-drift-kick"] {
            assert_eq!(step(name, None), (0.875, -0.46875), "{name}");
            assert_eq!(step(name, Some("momentum-first")), (0.875, -0.46875));
        }
        // q ← q + h/2 p, p ← p − h q, q ← q + h/2 p.
        assert_eq!(step("drift-kick-drift", None), (0.875, -0.5));
        // q ← q + h p, p ← p − h q, and the other way round.
        let of_first_order = |variant| step("symplectic-euler", Some(variant));
        assert_eq!(of_first_order("position-first"), (1.0, -0.5));
        assert_eq!(of_first_order("momentum-first"), (0.75, -0.5));
    }

    #[test]
    fn aliases_stand_for_what_is_in_the_catalogue() {
        for alias in ALIASES {
            let known = catalogue::CATALOGUE.find(alias.integrator).unwrap();
            assert_eq!(known.name, alias.integrator, "an alias of an alias");
            assert!(CATALOGUE.iter().all(|info| info.name != alias.name));
            assert!(alias.variants.len() <= 1);
            assert!(
                alias
                    .variants
                    .iter()
                    .all(|one| known.variants.contains(one))
            );
        }
    }
}
