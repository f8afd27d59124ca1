//! Random maps that are symplectic in other variables, and maps that preserve no constant form: is the form named that each preserves?
//!
//! 320 members, 20 of each kind. docs/truth.md has the table.

use std::collections::BTreeMap;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use symplint::evidence::Check;
use symplint::verdict::CauseKind;
use symplint::{Circle, Coordinates, Diagnosis, Diagnostic, PerSample, VerdictKind};

use crate::book;

const MEMBERS: u64 = 20;

/// The fault of the variables of a map, or of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Masses,
    LightMasses,
    Units,
    Many,
    Signs,
    Permuted,
    Linear,
    Field,
    VaryingField,
    ScaledPair,
    Single,
    Uncoupled,
    Friction,
    UniformFriction,
    Curl,
    RungeKutta,
}

const KINDS: [Kind; 16] = [
    Kind::Masses,
    Kind::LightMasses,
    Kind::Units,
    Kind::Many,
    Kind::Signs,
    Kind::Permuted,
    Kind::Linear,
    Kind::Field,
    Kind::VaryingField,
    Kind::ScaledPair,
    Kind::Single,
    Kind::Uncoupled,
    Kind::Friction,
    Kind::UniformFriction,
    Kind::Curl,
    Kind::RungeKutta,
];

impl Kind {
    /// As docs/truth.md names it.
    fn text(self) -> &'static str {
        match self {
            Kind::Masses => "velocities, masses over 4 decades, d = 2 to 6",
            Kind::LightMasses => "the same over 8 decades",
            Kind::Units => "units of q and p over 6 decades each, d = 2 to 12",
            Kind::Many => "masses over 2 decades and signs, d = 13 to 50",
            Kind::Signs => "signs of some positions",
            Kind::Permuted => "permuted momenta, some with masses",
            Kind::Linear => "a linear change of q",
            Kind::Field => "velocities in a uniform field",
            Kind::VaryingField => "velocities in a field B(q) of degree 1 or 2, d = 2 and 3",
            Kind::ScaledPair => "one momentum in another unit",
            Kind::Single => "masses, signs, permutations or uniform fields in single precision",
            Kind::Uncoupled => "pendula that are not coupled, permuted, with masses",
            Kind::Friction => "friction on one momentum",
            Kind::UniformFriction => "uniform friction (named as such)",
            Kind::Curl => "a force with a curl",
            Kind::RungeKutta => "Runge–Kutta methods of order 2 and 4",
        }
    }
}

struct Random(ChaCha8Rng);

impl Random {
    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }
    fn below(&mut self, count: usize) -> usize {
        self.between(0.0, count as f64) as usize
    }
    /// Three digits, over these decades.
    fn three_digits(&mut self, from: f64, to: f64) -> f64 {
        let value = 10f64.powf(self.between(from, to));
        format!("{value:.2e}").parse().unwrap()
    }
    fn sign(&mut self) -> f64 {
        if self.below(2) == 0 { 1.0 } else { -1.0 }
    }
    /// No element stays in its place in a cycle.
    fn cycle(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for k in (1..count).rev() {
            order.swap(k, self.below(k));
        }
        order
    }
}

/// A step in canonical coordinates, seen through other variables, and the form that it preserves in those.
struct Member {
    dof: usize,
    /// Bodies with pair forces and a force on each, by springs that are not linear.
    stiffness: Vec<f64>,
    coupling: f64,
    masses: Vec<f64>,
    /// x = Σ change_ij q_j.
    change: Vec<Vec<f64>>,
    /// The canonical momentum i is scale_i × p[order_i].
    order: Vec<usize>,
    scale: Vec<f64>,
    field: f64,
    boris: bool,
    /// Terms x q^m q_a/(1 + m_a) of component b of the vector potential: a and b, m, x.
    potential: Vec<Term>,
    is_coupled: bool,
    damping: Vec<f64>,
    curl: f64,
    /// 0 for leapfrog.
    runge_kutta: usize,
    single: bool,
}

/// The coordinates a and b, and powers of q.
type Powers = ([usize; 2], [u8; 3]);

/// The same with a factor.
type Term = (Powers, f64);

impl Member {
    /// Adds a multiple of the vector potential to momenta.
    fn add_potential(&self, q: &[f64], p: &mut [f64], factor: f64) {
        for (([a, b], powers), value) in &self.potential {
            let of_q = powers.iter().enumerate().filter(|(_, power)| **power > 0);
            let monomial: f64 = of_q.map(|(i, power)| q[i].powi((*power).into())).product();
            p[*b] += factor * value * q[*a] * monomial / f64::from(1 + powers[*a]);
        }
    }

    fn force(&self, q: &[f64], i: usize) -> f64 {
        let d = self.dof;
        let mut force = -self.stiffness[i] * self.masses[i] * q[i].sin();
        if self.is_coupled && d > 1 {
            // All pairs of few bodies, or neighbours in a ring.
            let others = match d {
                ..8 => (0..d).collect(),
                _ => vec![(i + 1) % d, (i + d - 1) % d],
            };
            for j in others {
                let masses = self.masses[i] * self.masses[j];
                force -= self.coupling * masses * (q[i] - q[j]).sin();
            }
        }
        if d > 1 {
            match i {
                0 => force -= self.curl * q[1],
                1 => force += self.curl * q[0],
                _ => {}
            }
        }
        force
    }

    fn field_of(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
        let velocity = (0..self.dof).map(|i| p[i] / self.masses[i]);
        let force = (0..self.dof).map(|i| self.force(q, i));
        velocity.chain(force).collect()
    }

    /// A step of canonical coordinates; in a field, of positions and velocities.
    fn step(&self, h: f64, q: &mut [f64], p: &mut [f64]) {
        let d = self.dof;
        if self.runge_kutta > 0 {
            let z: Vec<f64> = q.iter().chain(p.iter()).copied().collect();
            let at = |k: &[f64], part: f64| -> Vec<f64> {
                let moved = z.iter().zip(k).map(|(z, k)| z + part * h * k);
                let moved: Vec<f64> = moved.collect();
                self.field_of(&moved[..d], &moved[d..])
            };
            let k1 = at(&vec![0.0; 2 * d], 0.0);
            let k2 = at(&k1, 0.5);
            let change: Vec<f64> = match self.runge_kutta {
                2 => k2,
                _ => {
                    let k3 = at(&k2, 0.5);
                    let k4 = at(&k3, 1.0);
                    let sum = |c: usize| (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]) / 6.0;
                    (0..2 * d).map(sum).collect()
                }
            };
            for i in 0..d {
                q[i] += h * change[i];
                p[i] += h * change[d + i];
            }
            return;
        }
        let half = |q: &mut [f64], p: &[f64]| {
            (0..d).for_each(|i| q[i] += 0.5 * h * p[i] / self.masses[i]);
        };
        let kick = |q: &[f64], p: &mut [f64], part: f64| {
            let forces: Vec<f64> = (0..d).map(|i| self.force(q, i)).collect();
            (0..d).for_each(|i| p[i] += part * h * forces[i]);
        };
        if self.field != 0.0 && !self.boris {
            // Shears: x0 with p1, then x1 with p0, in a field along the third axis.
            q[0] += h * p[0];
            p[1] -= self.field * h * p[0];
            q[1] += h * p[1];
            p[0] += self.field * h * p[1];
            (2..d).for_each(|i| q[i] += h * p[i]);
            kick(q, p, 1.0);
            return;
        }
        half(q, p);
        kick(q, p, 0.5);
        if self.field != 0.0 {
            let t = 0.5 * h * self.field;
            let s = 2.0 * t / (1.0 + t * t);
            let prime = [p[0] + t * p[1], p[1] - t * p[0]];
            (p[0], p[1]) = (p[0] + s * prime[1], p[1] - s * prime[0]);
        }
        kick(q, p, 0.5);
        half(q, p);
        (0..d).for_each(|i| p[i] *= 1.0 - h * self.damping[i]);
    }

    /// The step in the variables that the diagnosis gets.
    fn advance(&self, h: f64, x: &mut [f64], y: &mut [f64]) {
        let d = self.dof;
        let round = |z: &mut [f64]| {
            if self.single {
                z.iter_mut().for_each(|z| *z = f64::from(*z as f32));
            }
        };
        round(x);
        round(y);
        let mut q: Vec<f64> = (0..d)
            .map(|i| (0..d).map(|j| self.change[i][j] * x[j]).sum())
            .collect();
        let mut p: Vec<f64> = (0..d).map(|i| self.scale[i] * y[self.order[i]]).collect();
        self.add_potential(&q, &mut p, -1.0);
        self.step(h, &mut q, &mut p);
        self.add_potential(&q, &mut p, 1.0);
        let solved = solve(&self.change, &q);
        x.copy_from_slice(&solved);
        (0..d).for_each(|i| y[self.order[i]] = p[i] / self.scale[i]);
        round(x);
        round(y);
    }

    /// Σ dq_i∧dp_i, and the entries of a field, in the variables x, y.
    fn form(&self, h: f64) -> BTreeMap<Powers, f64> {
        let d = self.dof;
        let mut form = BTreeMap::new();
        for i in 0..d {
            for j in 0..d {
                if self.change[i][j] != 0.0 {
                    let value = self.change[i][j] * self.scale[i];
                    form.insert(([j, d + self.order[i]], [0; 3]), value);
                }
            }
        }
        if self.field != 0.0 {
            form.insert(([0, 1], [0; 3]), -self.field);
            if self.boris {
                form.insert(([d, d + 1], [0; 3]), 0.25 * h * h * self.field);
            }
        }
        form.extend(self.potential.iter().copied());
        form
    }
}

/// Solves a small system by elimination with pivots.
fn solve(matrix: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let d = right.len();
    let (mut a, mut b) = (matrix.to_vec(), right.to_vec());
    for k in 0..d {
        let pivot = (k..d).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()));
        let pivot = pivot.unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..d {
            let factor = a[i][k] / a[k][k];
            let (above, below) = a.split_at_mut(i);
            let rows = below[0].iter_mut().zip(&above[k]);
            rows.for_each(|(x, of_pivot)| *x -= factor * of_pivot);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..d).rev() {
        for j in k + 1..d {
            b[k] -= a[k][j] * b[j];
        }
        b[k] /= a[k][k];
    }
    b
}

fn member(kind: Kind, number: u64) -> (Member, Circle) {
    let random = &mut Random(ChaCha8Rng::seed_from_u64(1000 * number + kind as u64));
    let single_of = [Kind::Masses, Kind::Signs, Kind::Permuted, Kind::Field];
    let single = kind == Kind::Single;
    let kind = match single {
        true => single_of[random.below(4)],
        false => kind,
    };
    let dof = match kind {
        Kind::Many => 13 + random.below(38),
        Kind::Units => 2 + random.below(11),
        Kind::Linear | Kind::Uncoupled => 2 + random.below(3),
        Kind::Field | Kind::VaryingField => 2 + random.below(2),
        Kind::ScaledPair => 3,
        Kind::Friction | Kind::UniformFriction => 1 + random.below(5),
        _ => 2 + random.below(5),
    };
    let identity = |x: &dyn Fn(usize) -> f64| -> Vec<Vec<f64>> {
        (0..dof)
            .map(|i| (0..dof).map(|j| if i == j { x(i) } else { 0.0 }).collect())
            .collect()
    };
    let mut found = Member {
        dof,
        stiffness: (0..dof).map(|_| random.between(0.5, 2.0)).collect(),
        coupling: random.between(0.3, 0.8),
        masses: vec![1.0; dof],
        change: identity(&|_| 1.0),
        order: (0..dof).collect(),
        scale: vec![1.0; dof],
        field: 0.0,
        boris: false,
        potential: Vec::new(),
        is_coupled: kind != Kind::Uncoupled,
        damping: vec![0.0; dof],
        curl: 0.0,
        runge_kutta: 0,
        single,
    };
    // Areas of pairs with opposite signs do not cancel.
    let sizes: Vec<f64> = (0..dof).map(|_| random.between(0.3, 0.6)).collect();
    let mut radii = [sizes.clone(), sizes.clone()];
    let mut masses = |random: &mut Random, decades: f64| {
        found.masses = (0..dof)
            .map(|_| random.three_digits(-decades, 0.0))
            .collect();
        found.masses[random.below(dof)] = 1.0;
        // Forces on light bodies are in proportion to their masses: all move alike.
        found.scale.clone_from(&found.masses);
    };
    match kind {
        // The forces of light bodies on heavy ones are to stand clear of rounding.
        Kind::Masses if single => masses(random, 1.0),
        Kind::Masses => masses(random, 4.0),
        Kind::LightMasses => masses(random, 8.0),
        Kind::Many => masses(random, 2.0),
        Kind::Permuted if !single && random.below(2) == 0 => masses(random, 2.0),
        Kind::Uncoupled => masses(random, 2.0),
        _ => {}
    }
    match kind {
        Kind::Many | Kind::Signs => {
            let mut signs: Vec<f64> = (0..dof).map(|_| random.sign()).collect();
            signs[0] = 1.0;
            signs[1] = -1.0;
            found.change = identity(&|i| signs[i]);
        }
        Kind::Units => {
            let q: Vec<f64> = (0..dof).map(|_| random.three_digits(-3.0, 3.0)).collect();
            found.scale = (0..dof).map(|_| random.three_digits(-3.0, 3.0)).collect();
            found.change = identity(&|i| q[i]);
            radii = [
                q.iter()
                    .zip(&sizes)
                    .map(|(unit, size)| size / unit)
                    .collect(),
                found
                    .scale
                    .iter()
                    .zip(&sizes)
                    .map(|(unit, size)| size / unit)
                    .collect(),
            ];
        }
        Kind::Permuted => found.order = random.cycle(dof),
        Kind::Uncoupled => found.order = random.cycle(dof),
        Kind::Linear => {
            for row in &mut found.change {
                for x in row.iter_mut() {
                    *x += random.sign() * random.three_digits(-1.0, -0.5);
                }
            }
        }
        Kind::Field => {
            found.field = random.sign() * random.three_digits(-1.0, 0.0);
            found.boris = random.below(2) == 0;
        }
        Kind::VaryingField => {
            let degree = 1 + random.below(2) as u8;
            let firsts = (0..dof).flat_map(|a| (a + 1..dof).map(move |b| [a, b]));
            for [a, b] in firsts {
                for last in a..dof {
                    let mut powers = [0; 3];
                    powers[a] += degree - 1;
                    powers[last] += 1;
                    found.potential.push((
                        ([a, b], powers),
                        random.sign() * random.three_digits(-1.0, 0.0),
                    ));
                }
                if random.below(2) == 0 {
                    found.potential.push((
                        ([a, b], [0; 3]),
                        random.sign() * random.three_digits(-1.0, 0.0),
                    ));
                }
            }
        }
        Kind::ScaledPair => found.scale[2] = random.three_digits(-1.0, 0.3),
        Kind::Friction => found.damping[0] = random.three_digits(-3.0, -0.5),
        Kind::UniformFriction => found.damping = vec![random.three_digits(-3.0, -0.5); dof],
        Kind::Curl => found.curl = random.three_digits(-3.0, -0.5),
        Kind::RungeKutta => found.runge_kutta = [2, 4][random.below(2)],
        _ => {}
    }
    let centre = |random: &mut Random, radius: &[f64]| -> Vec<f64> {
        radius
            .iter()
            .map(|r| 2.0 * r * random.between(-1.0, 1.0))
            .collect()
    };
    let (q, p) = (centre(random, &radii[0]), centre(random, &radii[1]));
    let [of_q, of_p] = radii;
    (found, Circle::with_radii(q, p, of_q, of_p).unwrap())
}

/// An answer on a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Answer {
    /// The form that it preserves, by the name of the mistake.
    Named,
    /// No form, and it has none; or uniform friction, and it has that.
    NoForm,
    /// Nothing.
    Unknown,
    Wrong,
}

const STEP: f64 = 0.25;

fn diagnose(member: &Member, circle: &Circle, weights: Option<Vec<f64>>) -> Diagnosis {
    let mut map = PerSample::new(member.dof, |h, x, y| member.advance(h, x, y));
    if let Some(weights) = weights {
        let coordinates = Coordinates::plain(member.dof)
            .with_weights(weights)
            .unwrap();
        map = map.with_coordinates(coordinates).unwrap();
    }
    let diagnostic = Diagnostic {
        step_sizes: [1.0, 0.5, 0.25, 0.125].map(|part| part * STEP).to_vec(),
        budget: Some(20_000),
        properties: true,
        ..Diagnostic::default()
    };
    diagnostic.run(&map, circle).unwrap()
}

fn answer(kind: Kind, number: u64) -> (Answer, String, usize) {
    let (member, circle) = member(kind, number);
    let found = diagnose(&member, &circle, None);
    let made = found.evidence.evaluations.of(Check::PreservedForm);
    let verdict = &found.verdict;
    let told = format!(
        "{kind:?} {number}, d = {}: {verdict}\n  {:?}\n  {:?}",
        member.dof,
        verdict.cause.as_ref().map(|cause| &cause.text),
        found.evidence.preserved_form.as_ref().map(|of| (
            of.exists,
            of.change,
            of.states,
            &of.loops,
            &of.entries
        )),
    );
    let has_form = !matches!(
        kind,
        Kind::Friction | Kind::UniformFriction | Kind::Curl | Kind::RungeKutta
    );
    if verdict.kind == VerdictKind::Symplectic {
        return (Answer::Wrong, told, made);
    }
    let Some(cause) = &verdict.cause else {
        return (Answer::Unknown, told, made);
    };
    let answer = match cause.kind {
        CauseKind::NoForm
        | CauseKind::ForceWithCurl
        | CauseKind::VelocityWithCurl
        | CauseKind::PartialFriction
        | CauseKind::FewIterations => match found.evidence.preserved_form.as_ref() {
            _ if has_form => Answer::Wrong,
            Some(form) if form.exists == Some(false) => Answer::NoForm,
            _ => Answer::Unknown,
        },
        CauseKind::Friction
            if kind == Kind::UniformFriction || kind == Kind::Friction && member.dof == 1 =>
        {
            Answer::NoForm
        }
        _ if cause.digits.is_none() || !has_form => Answer::Wrong,
        of_form => {
            let names: &[CauseKind] = match kind {
                Kind::Masses | Kind::LightMasses | Kind::Units | Kind::ScaledPair | Kind::Many => {
                    &[CauseKind::VelocitiesForMomenta]
                }
                Kind::Signs => &[CauseKind::SignOfAPair],
                Kind::Permuted | Kind::Uncoupled => &[CauseKind::PairsPermuted],
                Kind::Linear => &[CauseKind::OtherForm],
                Kind::Field | Kind::VaryingField => &[CauseKind::KineticMomenta],
                _ => &[
                    CauseKind::VelocitiesForMomenta,
                    CauseKind::SignOfAPair,
                    CauseKind::PairsPermuted,
                    CauseKind::KineticMomenta,
                ],
            };
            match names.contains(&of_form) && is_preserved(&member, &circle, &found) {
                true => Answer::Named,
                false => Answer::Wrong,
            }
        }
    };
    (answer, told, made)
}

/// Whether the form that was found is that of the member, up to a factor for each group; and whether weights that were found make the
/// map symplectic.
fn is_preserved(member: &Member, circle: &Circle, found: &Diagnosis) -> bool {
    let form = found.evidence.preserved_form.as_ref().unwrap();
    let truth = member.form(form.step_size.unwrap());
    let mut factors: BTreeMap<usize, f64> = BTreeMap::new();
    let agree = form.entries.iter().all(|entry| {
        let Some(exact) = truth.get(&(entry.coordinates, entry.powers)) else {
            return false;
        };
        let factor = entry.value / exact;
        let known = factors.entry(entry.group).or_insert(factor);
        let error = 3.0
            * form
                .entries
                .iter()
                .map(|of| of.error / of.value.abs())
                .fold(1e-12, f64::max);
        (factor / *known - 1.0).abs() < error
    });
    let weights: Option<Vec<f64>> = (0..member.dof)
        .map(|i| {
            let mut entries = form.entries.iter();
            let of = entries.find(|of| of.coordinates == [i, i + member.dof])?;
            Some(of.value)
        })
        .collect();
    let is_of_weights = form.entries.len() == member.dof && !member.single;
    let becomes_symplectic = match weights.filter(|_| is_of_weights) {
        Some(weights) => {
            let verdict = diagnose(member, circle, Some(weights)).verdict;
            verdict.kind == VerdictKind::Symplectic
        }
        None => true,
    };
    agree && form.entries.len() == truth.len() && becomes_symplectic
}

#[test]
fn forms_are_named_that_maps_preserve() {
    let all: Vec<(Kind, u64)> = (KINDS.iter())
        .flat_map(|&kind| (0..MEMBERS).map(move |number| (kind, number)))
        .collect();
    let answers: Vec<(Answer, String, usize)> = (all.par_iter())
        .map(|&(kind, number)| answer(kind, number))
        .collect();
    let mut table: BTreeMap<(Kind, Answer), usize> = BTreeMap::new();
    for ((kind, _), (answer, told, _)) in all.iter().zip(&answers) {
        *table.entry((*kind, *answer)).or_default() += 1;
        if matches!(answer, Answer::Wrong | Answer::Unknown) {
            println!("{answer:?}: {told}");
        }
    }
    let mut text =
        "| variables, or map | named | no form | unknown | wrong |\n|---|---|---|---|---|\n"
            .to_owned();
    for kind in KINDS {
        let count = |answer| table.get(&(kind, answer)).copied().unwrap_or(0);
        let answers = [
            Answer::Named,
            Answer::NoForm,
            Answer::Unknown,
            Answer::Wrong,
        ];
        let [named, none, unknown, wrong] = answers.map(count);
        text += &format!(
            "| {} | {named} | {none} | {unknown} | {wrong} |\n",
            kind.text()
        );
    }
    let most = answers.iter().map(|of| of.2).max().unwrap();
    text += &format!(
        "\nThe search made at most {} evaluations.\n",
        book::grouped(most)
    );
    book::publish("preserved_forms", &text);
    let of = |wanted: Answer| answers.iter().filter(|of| of.0 == wanted).count();
    assert_eq!(of(Answer::Wrong), 0);
    assert!(of(Answer::Unknown) <= 15, "{}", of(Answer::Unknown));
    assert!(answers.iter().all(|of| of.2 <= 2000));
}
