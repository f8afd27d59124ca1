//! Random maps whose properties are known by construction: symplectic, volume preserving, conformally symplectic, time-reversible.
//!
//! In two and three degrees of freedom, 200 members of each kind and of each pair of kinds. docs/truth.md has the table.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use symplint::verdict::PropertyName;
use symplint::{Circle, Diagnostic, PerSample, Verdict};

use crate::book;

const MEMBERS: u64 = 200;

/// The members of which each kind has a test at every build.
const SAMPLE: u64 = 15;

/// How a step is composed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Leapfrog in a potential: symplectic and reversible.
    Leapfrog,
    /// Symplectic Euler steps: a drift follows a kick.
    Euler,
    /// Leapfrog with a force that has a curl: it preserves volume and is reversible.
    CurlLeapfrog,
    /// The same as Euler steps: volume alone.
    CurlEuler,
    /// Leapfrog between two factors that multiply all momenta: conformal.
    Damped,
    /// One momentum alone is damped.
    OneDamped,
    /// A ∘ ρ A⁻¹ ρ with a stretch of q that depends on p: reversible, and volume changes.
    Stretched,
    /// The leapfrog with a curl, damped: nothing is left.
    CurlDamped,
    /// The leapfrog with a curl, stretched: reversible.
    CurlStretched,
    /// Damped and stretched: nothing is left.
    StretchedDamped,
    /// Euler steps, and all momenta change their sign, in two degrees of freedom: areas change their sign, and volumes do not.
    Anti,
    /// ρ A σ A⁻¹ with Euler steps A, and σ that changes the signs of q0 and p0: the same, and reversible.
    AntiReversible,
}

const KINDS: [Kind; 12] = [
    Kind::Leapfrog,
    Kind::Euler,
    Kind::CurlLeapfrog,
    Kind::CurlEuler,
    Kind::Damped,
    Kind::OneDamped,
    Kind::Stretched,
    Kind::CurlDamped,
    Kind::CurlStretched,
    Kind::StretchedDamped,
    Kind::Anti,
    Kind::AntiReversible,
];

impl Kind {
    /// As docs/truth.md names it.
    fn text(self) -> &'static str {
        match self {
            Kind::Leapfrog => "leapfrog in a potential",
            Kind::Euler => "symplectic Euler steps",
            Kind::CurlLeapfrog => "leapfrog, force with a curl",
            Kind::CurlEuler => "Euler steps, force with a curl",
            Kind::Damped => "leapfrog, all momenta damped",
            Kind::OneDamped => "leapfrog, one momentum damped",
            Kind::Stretched => "stretch, leapfrog, and the reversed stretch",
            Kind::CurlDamped => "leapfrog, force with a curl, all momenta damped",
            Kind::CurlStretched => "stretch, leapfrog, force with a curl, and the reversed stretch",
            Kind::StretchedDamped => {
                "stretch, leapfrog, and the reversed stretch, all momenta damped"
            }
            Kind::Anti => "Euler steps, then all momenta change their sign",
            Kind::AntiReversible => {
                "the same, reversible: ρ A σ A⁻¹ with Euler steps A and σ = −1 on one pair"
            }
        }
    }

    /// Symplectic, conformal, volume preserving, reversible.
    fn truth(self) -> [(PropertyName, bool); 4] {
        let [symplectic, conformal, volume, reversible] = match self {
            Kind::Leapfrog => [true, true, true, true],
            Kind::Euler => [true, true, true, false],
            Kind::CurlLeapfrog => [false, false, true, true],
            Kind::CurlEuler => [false, false, true, false],
            Kind::Damped => [false, true, false, false],
            Kind::OneDamped => [false, false, false, false],
            Kind::Stretched | Kind::CurlStretched => [false, false, false, true],
            Kind::CurlDamped | Kind::StretchedDamped => [false, false, false, false],
            Kind::Anti => [false, true, true, false],
            Kind::AntiReversible => [false, true, true, true],
        };
        [
            (PropertyName::Symplectic, symplectic),
            (PropertyName::Conformal, conformal),
            (PropertyName::Volume, volume),
            (PropertyName::Reversible, reversible),
        ]
    }
}

/// The verdict on a member.
fn verdict(kind: Kind, member: u64) -> Verdict {
    let random = &mut ChaCha8Rng::seed_from_u64(1000 * member + kind as u64);
    let mut between =
        |a: f64, b: f64| a + (b - a) * (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let is_anti = matches!(kind, Kind::Anti | Kind::AntiReversible);
    let dof = if between(0.0, 1.0) < 0.5 || is_anti {
        2
    } else {
        3
    };
    let stiffness: Vec<f64> = (0..dof).map(|_| between(0.5, 2.0)).collect();
    let coupling = between(0.2, 0.8);
    // From a part in a million on.
    let strength = 10f64.powf(between(-6.0, -0.5));
    let centre: [Vec<f64>; 2] =
        std::array::from_fn(|_| (0..dof).map(|_| between(-0.5, 0.5)).collect());
    let radius = between(0.3, 1.0);
    let curl = matches!(
        kind,
        Kind::CurlLeapfrog | Kind::CurlEuler | Kind::CurlDamped | Kind::CurlStretched
    );
    let stretched = matches!(
        kind,
        Kind::Stretched | Kind::CurlStretched | Kind::StretchedDamped
    );
    // Springs, and pendula between neighbours in a ring.
    let kick = move |h: f64, q: &[f64], p: &mut [f64]| {
        for i in 0..dof {
            let (next, last) = ((i + 1) % dof, (i + dof - 1) % dof);
            let pairs = (q[i] - q[next]).sin() + (q[i] - q[last]).sin();
            p[i] -= h * (stiffness[i] * q[i] + coupling * pairs);
        }
        if curl {
            p[0] -= h * strength * q[1];
            p[1] += h * strength * q[0];
        }
    };
    let drift = |h: f64, q: &mut [f64], p: &[f64]| (0..dof).for_each(|i| q[i] += h * p[i]);
    let map = PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
        let damped = match kind {
            Kind::Damped | Kind::CurlDamped | Kind::StretchedDamped => dof,
            Kind::OneDamped => 1,
            _ => 0,
        };
        let factor = (-0.5 * h * strength).exp();
        p[..damped].iter_mut().for_each(|p| *p *= factor);
        match kind {
            Kind::Euler | Kind::CurlEuler => {
                kick(h, q, p);
                drift(h, q, p);
            }
            Kind::Anti => {
                kick(h, q, p);
                drift(h, q, p);
                p.iter_mut().for_each(|p| *p = -*p);
            }
            Kind::AntiReversible => {
                drift(-h, q, p);
                kick(-h, q, p);
                (q[0], p[0]) = (-q[0], -p[0]);
                kick(h, q, p);
                drift(h, q, p);
                p.iter_mut().for_each(|p| *p = -*p);
            }
            _ => {
                if stretched {
                    q[0] /= 1.0 - h * strength * p[1];
                }
                drift(0.5 * h, q, p);
                kick(h, q, p);
                drift(0.5 * h, q, p);
                if stretched {
                    q[0] *= 1.0 + h * strength * p[1];
                }
            }
        }
        p[..damped].iter_mut().for_each(|p| *p *= factor);
    });
    let [q, p] = centre;
    let circle = Circle::new(q, p, radius).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(5_000),
        ..Diagnostic::halving(-2, -7)
    };
    diagnostic.run(&map, &circle).unwrap().verdict
}

/// The results for members of each kind, as a table.
///
/// # Panics
///
/// If a property is wrong, or unknown for more than 5% of a kind.
fn compare(of_kind: u64) -> String {
    let members: Vec<(Kind, u64)> = (KINDS.into_iter())
        .flat_map(|kind| (0..of_kind).map(move |member| (kind, member)))
        .collect();
    let verdicts: Vec<(Kind, u64, Verdict)> = (members.into_par_iter())
        .map(|(kind, member)| (kind, member, verdict(kind, member)))
        .collect();
    let mut wrong = Vec::new();
    let mut table =
        "| kind | symplectic | conformally symplectic | volume preserving | time-reversible |\n| --- | --- | --- | --- | --- |\n"
            .to_owned();
    for kind in KINDS {
        table += &format!("| {} |", kind.text());
        for (name, truth) in kind.truth() {
            let mut counts = [0; 3];
            for (_, member, verdict) in verdicts.iter().filter(|(of, ..)| *of == kind) {
                let found = verdict.properties.iter().find(|found| found.name == name);
                let holds = found.and_then(|found| found.holds);
                counts[match holds {
                    Some(true) => 0,
                    Some(false) => 1,
                    None => 2,
                }] += 1;
                if holds.is_some_and(|holds| holds != truth) {
                    let texts: Vec<String> =
                        verdict.properties.iter().map(ToString::to_string).collect();
                    wrong.push(format!(
                        "{kind:?} {member}, {name}: {verdict}\n  {}",
                        texts.join(", ")
                    ));
                }
            }
            let unknown = counts[2];
            assert!(
                20 * unknown <= of_kind as usize,
                "{kind:?}: {unknown} unknown of {name}"
            );
            let cells = ["yes", "no", "unknown"].iter().zip(counts);
            let cells: Vec<String> = cells
                .filter(|(_, count)| *count > 0)
                .map(|(answer, count)| format!("{count} {answer}"))
                .collect();
            table += &format!(" {} |", cells.join(", "));
        }
        table += "\n";
    }
    assert!(
        wrong.is_empty(),
        "{} wrong\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    table
}

#[test]
fn no_property_is_wrong_and_few_are_unknown() {
    compare(SAMPLE);
}

#[test]
#[ignore = "half a minute: writes a table of docs/truth.md"]
fn no_property_of_all_members_is_wrong() {
    book::publish("properties", &compare(MEMBERS));
}
