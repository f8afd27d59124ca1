//! The truth table: maps, systems and loops whose right answer is known from theory, with the reason
//! why, and what the diagnosis says of them.
//!
//! No verdict may be wrong. A case may be undecided only if the table states this and the reason, and few may.
//! `cargo test --release -p symplint-truth truth_table:: -- --nocapture` prints the table.

mod case;
mod given;
mod implicit;
mod linear;
mod loops;
mod mistakes;
mod plasma;
mod several;
mod smooth;
mod splines;
mod wedge;

use case::{Case, check};

/// A part of the table.
type Theme = (&'static str, fn() -> Vec<Case>);

const THEMES: &[Theme] = &[
    ("smooth", smooth::cases),
    ("smooth arrays", smooth::arrays),
    ("linear", linear::cases),
    ("several", several::cases),
    ("implicit", implicit::cases),
    ("loops", loops::cases),
    ("wedge", wedge::cases),
    ("rounded wedge", wedge::rounded),
    ("splines", splines::cases),
    ("plasma", plasma::lines),
    ("plasma of more particles", plasma::more_particles),
    ("plasma in a plane", plasma::planes),
    ("given maps", given::cases),
    ("mistakes", mistakes::cases),
];

macro_rules! one_test_a_theme {
    ($($test:ident: $theme:literal,)*) => {
        $(
            #[test]
            fn $test() {
                let (name, cases) = (THEMES.iter()).find(|(name, _)| *name == $theme).unwrap();
                check(name, &cases());
            }
        )*

        #[test]
        fn every_theme_has_its_test() {
            let tested = [$($theme),*];
            assert!(THEMES.iter().map(|(name, _)| *name).eq(tested));
        }
    };
}

one_test_a_theme! {
    smooth_systems: "smooth",
    smooth_arrays: "smooth arrays",
    linear_systems: "linear",
    several_degrees_of_freedom: "several",
    stages_solved_or_not: "implicit",
    loops_of_all_kinds: "loops",
    the_wedge: "wedge",
    the_rounded_wedge: "rounded wedge",
    interpolated_potentials: "splines",
    particles_on_a_line: "plasma",
    more_particles_on_a_line: "plasma of more particles",
    particles_in_a_plane: "plasma in a plane",
    maps_that_are_given: "given maps",
    mistakes_and_composed_maps: "mistakes",
}

#[test]
fn the_table_is_long_and_little_of_it_undecided() {
    let cases: Vec<Case> = THEMES.iter().flat_map(|(_, cases)| cases()).collect();
    let undecided = cases.iter().filter(|case| case.undecided.is_some()).count();
    println!("{} cases, {undecided} of them undecided", cases.len());
    assert!(cases.len() >= 120, "{} cases", cases.len());
    assert!(20 * undecided <= cases.len(), "{undecided} are undecided");
}
