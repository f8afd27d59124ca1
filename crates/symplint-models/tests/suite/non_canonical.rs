//! Systems in non-canonical coordinates: their equations against their one-forms, and the verdicts on their steps.

use symplint::map::ProjectedLoop;
use symplint::{Block, Circle, Diagnosis, Diagnostic, Ensemble, Loop, TimeAdvance, VerdictKind};
use symplint_models::integrators::{Boris, tableaus};
use symplint_models::non_canonical::{
    GuidingCenter, LotkaVolterra, MasslessCharge, NonCanonicalSystem, State, Velocities,
    VelocityStep, by_runge_kutta, by_steps, by_symplectic_steps, states_of,
};
use symplint_models::systems::ChargedParticle;

fn massless() -> MasslessCharge {
    MasslessCharge::new(1.0, 0.3, 1.5).unwrap()
}

fn guiding_center() -> GuidingCenter {
    GuidingCenter::new(1.0, 0.3, 0.4, 0.5, 0.2).unwrap()
}

fn particle() -> ChargedParticle {
    ChargedParticle::new(1.0, 0.4, 0.7).unwrap()
}

fn velocities() -> Velocities {
    Velocities(particle())
}

const POPULATIONS: State<1> = [[1.2], [0.8]];
const MASSLESS: State<1> = [[0.3], [0.2]];
const CENTER: State<2> = [[0.7, -0.4], [0.3, 0.5]];
const CHARGE: State<2> = [[0.3, -0.2], [0.4, 0.6]];

/// The derivative of a function of the coordinates by one of them, extrapolated to the fourth order.
fn derivative<const D: usize>(z: State<D>, by: usize, f: impl Fn(State<D>) -> f64) -> f64 {
    let at = |step: f64| {
        let mut z = z;
        z.as_flattened_mut()[by] += step;
        f(z)
    };
    let central = |step: f64| (at(step) - at(-step)) / (2.0 * step);
    (4.0 * central(1e-3) - central(2e-3)) / 3.0
}

/// ω(ż, ·) = −dH, with ω from differences of the one-form and dH from those of the energy.
fn check_equations<const D: usize>(system: &impl NonCanonicalSystem<D>, z: State<D>) {
    let velocity = system.velocity(z);
    for j in 0..2 * D {
        let of_form =
            |i: usize, j: usize| derivative(z, i, |z| system.one_form(z).as_flattened()[j]);
        let contracted: f64 = (velocity.as_flattened().iter().enumerate())
            .map(|(i, velocity)| velocity * (of_form(i, j) - of_form(j, i)))
            .sum();
        let slope = derivative(z, j, |z| system.energy(z));
        assert!(
            (contracted + slope).abs() < 1e-9,
            "{j}: {contracted} {slope}"
        );
    }
}

#[test]
fn equations_of_motion_are_those_of_form_and_energy() {
    check_equations(&LotkaVolterra, POPULATIONS);
    check_equations(&massless(), MASSLESS);
    check_equations(&guiding_center(), CENTER);
    check_equations(&velocities(), CHARGE);
}

/// How far a step of size h is from the exact motion, which is 64 steps of Runge–Kutta 4.
fn error<const D: usize>(
    system: &impl NonCanonicalSystem<D>,
    z: State<D>,
    h: f64,
    step: impl Fn(f64, State<D>) -> State<D>,
) -> f64 {
    let add = |z: State<D>, by: f64, slope: State<D>| -> State<D> {
        [0, 1].map(|half| std::array::from_fn(|i| z[half][i] + by * slope[half][i]))
    };
    let small = h / 64.0;
    let exact = (0..64).fold(z, |z, _| {
        let a = system.velocity(z);
        let b = system.velocity(add(z, 0.5 * small, a));
        let c = system.velocity(add(z, 0.5 * small, b));
        let d = system.velocity(add(z, small, c));
        [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)]
            .into_iter()
            .fold(z, |z, (slope, part)| add(z, part * small / 6.0, slope))
    });
    let found = step(h, z);
    let apart = found.as_flattened().iter().zip(exact.as_flattened());
    apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn check_order<const D: usize>(
    system: &impl NonCanonicalSystem<D>,
    z: State<D>,
    order: i32,
    step: impl Fn(f64, State<D>) -> State<D>,
) {
    let [large, small] = [0.02, 0.01].map(|h| error(system, z, h, &step));
    let found = (large / small).log2();
    assert!((found - f64::from(order + 1)).abs() < 0.1, "{found}");
}

#[test]
fn steps_follow_the_equations() {
    let symplectic = |system: &LotkaVolterra, h, z| system.symplectic_step(h, z).unwrap();
    check_order(&LotkaVolterra, POPULATIONS, 1, |h, z| {
        symplectic(&LotkaVolterra, h, z)
    });
    check_order(&massless(), MASSLESS, 1, |h, z| {
        massless().symplectic_step(h, z).unwrap()
    });
    let center = guiding_center();
    check_order(&center, CENTER, 1, |h, z| {
        center.symplectic_step(h, z).unwrap()
    });
    let charge = velocities();
    check_order(&charge, CHARGE, 2, |h, z| {
        charge.symplectic_step(h, z).unwrap()
    });
    for step in [VelocityStep::Boris, VelocityStep::VolumePreserving] {
        check_order(&charge, CHARGE, 2, |h, z| charge.step(step, h, z));
    }
}

/// A circle of radius 0.2 with random phases round a state, on the points (z, ϑ(z)).
fn circle<'a, const D: usize>(
    system: &impl NonCanonicalSystem<D>,
    z: State<D>,
    map: &'a dyn TimeAdvance,
) -> impl Loop + 'a {
    let [q0, p0] = states_of(system, z);
    let circle = Circle::new(q0, p0, 0.2)
        .unwrap()
        .with_phases(symplint::Phases::Random { seed: 7 });
    ProjectedLoop::new(circle, map)
}

fn diagnose<const D: usize>(
    system: &impl NonCanonicalSystem<D>,
    z: State<D>,
    map: &dyn TimeAdvance,
) -> Diagnosis {
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        ..Diagnostic::halving(-2, -6)
    };
    let found = diagnostic.run(map, &circle(system, z, map)).unwrap();
    println!("{}", found.verdict);
    found
}

fn check_verdicts<const D: usize>(system: impl NonCanonicalSystem<D>, z: State<D>) {
    let symplectic = by_symplectic_steps(system.clone()).unwrap();
    let verdict = diagnose(&system, z, &symplectic).verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict}");
    assert!(verdict.digits.unwrap() > 10.0, "{verdict}");
    let midpoint = by_runge_kutta(system.clone(), tableaus::midpoint()).unwrap();
    let verdict = diagnose(&system, z, &midpoint).verdict;
    assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{verdict}");
    assert_eq!(verdict.order, Some(3.0), "{verdict}");
}

#[test]
fn verdicts_are_those_of_theory() {
    check_verdicts(LotkaVolterra, POPULATIONS);
    check_verdicts(massless(), MASSLESS);
    check_verdicts(guiding_center(), CENTER);
    check_verdicts(velocities(), CHARGE);
    for step in [VelocityStep::Boris, VelocityStep::VolumePreserving] {
        let charge = velocities();
        let map = by_steps(charge, move |h, z| Ok(charge.step(step, h, z))).unwrap();
        let verdict = diagnose(&charge, CHARGE, &map).verdict;
        assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{verdict}");
        assert_eq!(verdict.order, Some(3.0), "{verdict}");
    }
}

/// The loop of positions and velocities in canonical momenta.
struct Momenta<L>(L);

impl<L: Loop> Loop for Momenta<L> {
    fn dof(&self) -> usize {
        2
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let mut points = Ensemble::zeros(4, s.len());
        self.0.sample(s, &mut points.block());
        for i in 0..2 {
            block.q.row_mut(i).copy_from_slice(points.q().row(i));
            block.p.row_mut(i).copy_from_slice(points.p().row(i));
        }
    }
}

#[test]
fn boris_has_the_numbers_of_canonical_momenta() {
    let charge = velocities();
    let map = by_steps(charge, move |h, z| {
        Ok(charge.step(VelocityStep::Boris, h, z))
    })
    .unwrap();
    let canonical = Boris::new(particle());
    let diagnostic = Diagnostic::halving(-1, -4);
    let of_form = diagnostic
        .run(&map, &circle(&charge, CHARGE, &map))
        .unwrap();
    let momenta = Momenta(circle(&charge, CHARGE, &map));
    let of_momenta = diagnostic.run(&canonical, &momenta).unwrap();
    let steps = |found: &Diagnosis| found.evidence.loops[0].steps.clone();
    for (a, b) in steps(&of_form).iter().zip(steps(&of_momenta)) {
        let apart = (a.defect.signed - b.defect.signed).abs();
        let errors = a.defect.uncertainty() + b.defect.uncertainty();
        assert!(
            a.defect.magnitude() > 1e-6 && apart <= errors,
            "{apart:e} {errors:e}"
        );
    }
}

#[test]
fn steps_that_cannot_be_taken_say_why() {
    let far = massless().symplectic_step(50.0, MASSLESS).unwrap_err();
    assert!(far.contains("magnetic field vanishes"), "{far}");
    assert!(guiding_center().symplectic_step(f64::NAN, CENTER).is_err());
    assert!(MasslessCharge::new(0.0, 0.0, 1.0).is_err());
    assert!(GuidingCenter::new(1.0, f64::NAN, 0.0, 0.0, 0.0).is_err());
}
