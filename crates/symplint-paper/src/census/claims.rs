//! The results of the census, as claims that numbers decide.

use symplint::VerdictKind;

use super::ITEM;
use super::scheme_result::SchemeResult;
use super::schemes::{
    AVERAGED, BORIS_YEE, CRANK_NICOLSON, DIRECT, ECSIM, GEMPIC, LEWIS, LOOSE, NODAL, STAGGERED,
    SUB_STEPPED, TEXTBOOK, YEE_SPLITTING,
};
use crate::claim::{Claim, Judgement, Origin};

/// Largest relative change of a conserved quantity that is rounding error.
const MAX_ROUNDING_ERROR: f64 = 1e-12;

/// Largest distance of a slope from the order of a defect: the steps are not small.
const MAX_SLOPE_ERROR: f64 = 0.4;

/// Least degree of splines whose fields have the second derivatives that an order needs.
const MIN_SMOOTH_DEGREE: usize = 4;

/// All claims of the census.
pub fn claims(rows: &[SchemeResult]) -> Vec<Claim> {
    let census = Census(rows);
    let groups = [
        electrostatic,
        geometric,
        boris,
        energy_conserving,
        charge_conserving,
    ];
    let decided = is_decided(rows);
    (groups.iter().flat_map(|claims| claims(&census)))
        .chain([headline(&census)])
        .map(|claim| claim.resolved_if(decided))
        .collect()
}

/// Of the textbook scheme and of Lewis' scheme.
fn electrostatic(census: &Census) -> Vec<Claim> {
    vec![
        claim(
            "the textbook momentum-conserving scheme is not symplectic, whatever the shape: its force is no gradient. \
             The defect of a step is of order h",
            census.verdicts(TEXTBOOK),
            census.all(TEXTBOOK, |row| match row.record.degree {
                0 => row.kind == VerdictKind::BrokenLoops && !closed(row),
                _ => row.is_of_order(1.0),
            }),
        ),
        claim(
            "it conserves the momentum, and the variational schemes do not",
            format!(
                "to {:.0e}; Lewis {:.0e}",
                census.worst(TEXTBOOK, |row| row.record.momentum_change),
                census.worst(LEWIS, |row| row.record.momentum_change)
            ),
            census.all(TEXTBOOK, |row| {
                row.record.momentum_change < MAX_ROUNDING_ERROR
            }) && census.all(LEWIS, |row| row.record.momentum_change > 1e-3),
        ),
        claim(
            "Lewis' scheme breaks loops with linear charges, whose force is that of the nearest grid point, and is \
             symplectic with quadratic and cubic ones",
            census.verdicts(LEWIS),
            census.all(LEWIS, |row| match row.record.degree {
                1 => row.kind == VerdictKind::BrokenLoops && closed(row),
                _ => row.kind == VerdictKind::Symplectic,
            }),
        ),
    ]
}

/// Of geometric splittings.
fn geometric(census: &Census) -> Vec<Claim> {
    vec![
        claim(
            "the geometric splitting, of finite elements and on the grid of Yee, breaks loops at p = 1 and is symplectic \
             above",
            format!(
                "{}; Yee: {}",
                census.verdicts(GEMPIC),
                census.verdicts(YEE_SPLITTING)
            ),
            [GEMPIC, YEE_SPLITTING].into_iter().all(|family| {
                census.all(family, |row| match row.record.degree {
                    1 => row.kind == VerdictKind::BrokenLoops,
                    _ => row.kind == VerdictKind::Symplectic,
                })
            }),
        ),
        claim(
            "what changes the closed integral of a geometric splitting is no defect: where its loops break, q and p jump \
             together",
            format!(
                "{}; Yee: {}",
                census.closed(GEMPIC),
                census.closed(YEE_SPLITTING)
            ),
            [GEMPIC, YEE_SPLITTING]
                .into_iter()
                .all(|family| census.all(family, |row| row.record.closed_conserved != Some(false))),
        ),
    ]
}

/// Of Boris–Yee codes.
fn boris(census: &Census) -> Vec<Claim> {
    vec![claim(
        "Boris–Yee codes are not symplectic: for smooth fields of order h^3 with Galerkin weighting, h^2 where velocities are staggered, h \
             where fields are gathered at nodes",
        [BORIS_YEE, DIRECT, STAGGERED, NODAL]
            .map(|family| format!("{family}: {}", census.verdicts(family)))
            .join("; "),
        [
            (BORIS_YEE, 3.0),
            (DIRECT, 3.0),
            (STAGGERED, 2.0),
            (NODAL, 1.0),
        ]
        .into_iter()
        .all(|(family, order)| census.all(family, |row| row.is_of_order_if_smooth(order))),
    )]
}

/// Of schemes that conserve the energy exactly.
fn energy_conserving(census: &Census) -> Vec<Claim> {
    vec![
        claim(
            "schemes that are made to conserve the energy exactly do so to round-off and are not symplectic, for smooth fields of \
             order h^3; ECSIM of order h^2 in a magnetic field",
            [CRANK_NICOLSON, SUB_STEPPED, AVERAGED, ECSIM]
                .map(|family| {
                    let energy = census.worst(family, |row| row.record.energy_error);
                    format!("{family}: energy {energy:.0e}, {}", census.verdicts(family))
                })
                .join("; "),
            [
                (CRANK_NICOLSON, 3.0),
                (SUB_STEPPED, 3.0),
                (AVERAGED, 3.0),
                (ECSIM, 2.0),
            ]
            .into_iter()
            .all(|(family, order)| {
                census.all(family, |row| {
                    row.record.energy_error < MAX_ROUNDING_ERROR && row.is_of_order_if_smooth(order)
                })
            }),
        ),
        claim(
            "a solver tolerance of 1e-6 breaks loops, and the energy is conserved no better than that allows",
            format!(
                "{}; at least {} breaks; energy {:.0e}",
                census.verdicts(LOOSE),
                (census.of(LOOSE).map(|row| row.record.breaks).min()).unwrap_or(0),
                census.worst(LOOSE, |row| row.record.energy_error)
            ),
            // The change of the smooth part is larger, and so the verdict.
            census.all(LOOSE, |row| {
                row.record.breaks > 0 && row.record.energy_error > 1e-9
            }),
        ),
    ]
}

/// Of Gauss' law.
fn charge_conserving(census: &Census) -> Vec<Claim> {
    vec![claim(
        "Gauss' law is conserved by the splittings, by charge-conserving currents and by orbit means, and by no other of these schemes",
        format!(
            "to {:.0e}; others {:.0e} and more",
            CONSERVING
                .iter()
                .map(|family| census.worst(family, gauss))
                .fold(0.0, f64::max),
            OTHERS
                .iter()
                .flat_map(|family| census.of(family))
                .map(gauss)
                .fold(f64::INFINITY, f64::min)
        ),
        CONSERVING
            .iter()
            .all(|family| census.all(family, |row| gauss(row) < MAX_ROUNDING_ERROR))
            && OTHERS
                .iter()
                .all(|family| census.all(family, |row| gauss(row) > 1e-6)),
    )]
}

const CONSERVING: [&str; 6] = [GEMPIC, YEE_SPLITTING, BORIS_YEE, STAGGERED, NODAL, AVERAGED];
const OTHERS: [&str; 4] = [DIRECT, CRANK_NICOLSON, SUB_STEPPED, ECSIM];

fn gauss(row: &SchemeResult) -> f64 {
    row.record.gauss_residual.unwrap_or(f64::NAN)
}

/// Exact energy with a defect, compared with exact loops with an energy error that does not grow.
fn headline(census: &Census<'_>) -> Claim {
    const SMOOTH_DEGREE: usize = 4;
    let smooth = |family| {
        census
            .of(family)
            .find(|row| row.record.degree == SMOOTH_DEGREE)
    };
    let (Some(energy), Some(loops)) = (smooth(CRANK_NICOLSON), smooth(GEMPIC)) else {
        unreachable!("both are in the census");
    };
    claim(
        "one conserves the energy and has a defect of order h^3; the other conserves loop integrals and has an energy error \
         that stays bounded",
        format!(
            "at p = 4: Crank–Nicolson energy {:.0e}, defect {:.0e}; GEMPIC defect {:.0e}, energy {:.0e}, in the second half \
             of the run {:.1} times that of the first",
            energy.record.energy_error,
            energy.record.defect,
            loops.record.defect,
            loops.record.energy_error,
            loops.record.energy_growth
        ),
        energy.record.energy_error < MAX_ROUNDING_ERROR
            && energy.record.defect > 1e-5
            && loops.record.defect < MAX_ROUNDING_ERROR
            && loops.record.digits.is_some_and(|digits| digits > 11.0)
            && (1e-5..1.0).contains(&loops.record.energy_error)
            && loops.record.energy_growth < 2.0,
    )
}

/// The rows, by family.
struct Census<'a>(&'a [SchemeResult]);

impl<'a> Census<'a> {
    fn of(&self, family: &'static str) -> impl Iterator<Item = &'a SchemeResult> {
        self.0.iter().filter(move |row| row.family == family)
    }

    fn all(&self, family: &'static str, holds: impl Fn(&SchemeResult) -> bool) -> bool {
        // Nothing holds of no schemes.
        self.of(family).next().is_some() && self.of(family).all(holds)
    }

    fn worst(&self, family: &'static str, of: impl Fn(&SchemeResult) -> f64) -> f64 {
        self.of(family).map(of).fold(0.0, f64::max)
    }

    /// What closed integrals do where loops break.
    fn closed(&self, family: &'static str) -> String {
        let broken = (self.of(family)).filter(|row| row.kind == VerdictKind::BrokenLoops);
        let of_degrees = broken.map(|row| {
            let closed = match row.record.closed_conserved {
                Some(true) => "conserved",
                Some(false) => "change",
                None => "open",
            };
            format!("{} {closed}", row.record.degree)
        });
        of_degrees.collect::<Vec<_>>().join(", ")
    }

    /// Degree by degree.
    fn verdicts(&self, family: &'static str) -> String {
        let of_degrees = self.of(family).map(|row| {
            let slope =
                (row.record.slope).map_or(String::new(), |slope| format!(" (h^{slope:.1})"));
            format!("{} {}{slope}", row.record.degree, row.kind)
        });
        of_degrees.collect::<Vec<_>>().join(", ")
    }
}

impl SchemeResult {
    /// Whether loops break at degree 1, and it is not symplectic above, with a defect of this order for smooth fields.
    fn is_of_order_if_smooth(&self, order: f64) -> bool {
        match self.record.degree {
            1 => self.kind == VerdictKind::BrokenLoops,
            degree if degree < MIN_SMOOTH_DEGREE => self.kind == VerdictKind::NotSymplectic,
            _ => self.is_of_order(order),
        }
    }

    /// Whether it is not symplectic, with a defect of this order.
    fn is_of_order(&self, order: f64) -> bool {
        let near = |slope: f64| (slope - order).abs() < MAX_SLOPE_ERROR;
        self.kind == VerdictKind::NotSymplectic && self.record.slope.is_some_and(near)
    }
}

/// Whether integrals are conserved once breaks are closed.
fn closed(row: &SchemeResult) -> bool {
    row.record.closed_conserved == Some(true)
}

fn claim(says: &str, measured: String, holds: bool) -> Claim {
    Claim {
        item: ITEM.id,
        origin: Origin::Beyond,
        place: "census",
        says: says.into(),
        measured,
        judgement: Judgement::of(holds),
    }
}

/// Whether every scheme has a verdict.
fn is_decided(rows: &[SchemeResult]) -> bool {
    (rows.iter()).all(|row| row.kind != VerdictKind::Undecided)
}
