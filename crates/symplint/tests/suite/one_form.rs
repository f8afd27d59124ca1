//! Maps in non-canonical coordinates, against the same maps in canonical ones.

use symplint::map::{NonCanonical, OneForm};
use symplint::verdict::{Advice, Agreement, DomainFinding, Finding, RunFinding};
use symplint::{
    Block, Circle, Diagnosis, Diagnostic, Loop, PerSample, Rule, TimeAdvance, VerdictKind,
};

/// ω = dx∧dy/(xy): with u = ln x and v = −ln y, ϑ = v du.
struct Populations;

impl OneForm for Populations {
    fn dimension(&self) -> usize {
        2
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            let (x, y) = (block.q.row(0)[k], block.q.row(1)[k]);
            block.p.row_mut(0)[k] = -y.ln() / x;
            block.p.row_mut(1)[k] = 0.0;
        }
    }
}

/// A circle in x and y, in canonical coordinates.
struct Logarithms<L>(L);

impl<L: Loop> Loop for Logarithms<L> {
    fn dof(&self) -> usize {
        1
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        self.0.sample(s, block);
        to_logarithms(block);
    }
}

fn to_logarithms(block: &mut Block<'_>) {
    block.q.row_mut(0).iter_mut().for_each(|x| *x = x.ln());
    block.p.row_mut(0).iter_mut().for_each(|y| *y = -y.ln());
}

type Step = fn(f64, &mut [f64], &mut [f64]);

/// A step of x and y as one of u and v.
fn canonical(step: Step) -> impl TimeAdvance {
    PerSample::new(1, move |h, u, v| {
        let (mut x, mut y) = (vec![u[0].exp()], vec![(-v[0]).exp()]);
        step(h, &mut x, &mut y);
        (u[0], v[0]) = (x[0].ln(), -y[0].ln());
    })
}

fn circle() -> Circle {
    Circle::new(vec![1.0], vec![1.5], 0.4).unwrap()
}

/// Both diagnoses: in x and y, and in u and v.
fn both(step: Step, diagnostic: &Diagnostic) -> [Diagnosis; 2] {
    let map = NonCanonical::new(PerSample::new(1, step), Populations).unwrap();
    let of_form = diagnostic.run(&map, &map.loop_of(circle())).unwrap();
    let of_logarithms = diagnostic.run(&canonical(step), &Logarithms(circle()));
    [of_form, of_logarithms.unwrap()]
}

/// The flows of x' = x (1 − y) and y' = y (x − 1), one after the other.
fn splitting(h: f64, x: &mut [f64], y: &mut [f64]) {
    x[0] *= (h * (1.0 - y[0])).exp();
    y[0] *= (h * (x[0] - 1.0)).exp();
}

fn field([x, y]: [f64; 2]) -> [f64; 2] {
    [x * (1.0 - y), y * (x - 1.0)]
}

/// The explicit midpoint rule.
fn midpoint(h: f64, x: &mut [f64], y: &mut [f64]) {
    let [dx, dy] = field([x[0], y[0]]);
    let [dx, dy] = field([x[0] + 0.5 * h * dx, y[0] + 0.5 * h * dy]);
    x[0] += h * dx;
    y[0] += h * dy;
}

#[test]
fn verdicts_and_integrals_are_those_of_canonical_coordinates() {
    for rule in [
        Rule::Auto,
        Rule::Pseudospectral,
        Rule::Piecewise(Default::default()),
        Rule::Streaming(Default::default()),
    ] {
        let diagnostic = Diagnostic {
            rule,
            ..Diagnostic::halving(-1, -5)
        };
        for (step, kind) in [
            (splitting as Step, VerdictKind::Symplectic),
            (midpoint, VerdictKind::NotSymplectic),
        ] {
            let [of_form, of_logarithms] = both(step, &diagnostic);
            assert_eq!(of_form.verdict.kind, kind, "{}", of_form.verdict);
            assert_eq!(of_logarithms.verdict.kind, kind);
            assert_eq!(of_form.verdict.order, of_logarithms.verdict.order);
            let steps = |found: &Diagnosis| found.evidence.loops[0].steps.clone();
            for (a, b) in steps(&of_form).iter().zip(steps(&of_logarithms)) {
                let of_errors = a.defect.uncertainty() + b.defect.uncertainty();
                let apart = (a.defect.signed - b.defect.signed).abs();
                assert!(apart <= of_errors, "{rule:?}: {apart:e} {of_errors:e}");
            }
        }
    }
}

#[test]
fn the_jacobian_conserves_the_form_of_the_coordinates() {
    let diagnostic = Diagnostic::halving(-1, -5);
    for (step, agreement) in [
        (splitting as Step, Agreement::Symplectic),
        (midpoint, Agreement::NotSymplectic),
    ] {
        let [of_form, _] = both(step, &diagnostic);
        let jacobian = of_form.evidence.jacobian.as_ref().unwrap();
        assert!(jacobian.projected && jacobian.full);
        let agrees = |finding: &Finding| matches!(finding, Finding::Run(RunFinding::Jacobian { finding }) if finding.agreement == agreement);
        assert!(
            of_form.verdict.findings.iter().any(agrees),
            "{}",
            of_form.verdict
        );
    }
}

/// ϑ = v (1 + x²) dx, canonical in u = x + x³/3 and v.
struct Bent;

impl OneForm for Bent {
    fn dimension(&self) -> usize {
        2
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            let (x, v) = (block.q.row(0)[k], block.q.row(1)[k]);
            block.p.row_mut(0)[k] = v * (1.0 + x * x);
            block.p.row_mut(1)[k] = 0.0;
        }
    }
}

/// u moves by a function of v that jumps where v passes 0.2: at a break v is constant, and only ∫ ϑ along it is that of u and v.
fn breaking(h: f64, x: &mut [f64], v: &mut [f64]) {
    let u = x[0] + x[0].powi(3) / 3.0 + h * if v[0] > 0.2 { 0.8 } else { -0.5 };
    for _ in 0..20 {
        x[0] -= (x[0] + x[0].powi(3) / 3.0 - u) / (1.0 + x[0] * x[0]);
    }
}

#[test]
fn breaks_are_closed_by_the_integral_of_the_form() {
    let map = NonCanonical::new(PerSample::new(1, breaking), Bent).unwrap();
    let circle = Circle::new(vec![0.3], vec![0.1], 0.5).unwrap();
    let found = (Diagnostic::halving(0, -3).run(&map, &map.loop_of(circle))).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::BrokenLoops);
    for step in &found.evidence.loops[0].steps {
        let closing = step.closing.unwrap();
        assert_eq!(closing.breaks, 2);
        assert!(closing.closed.magnitude() < 1e-12, "{closing:?}");
    }
}

/// A spin: ϑ = m_z dφ, in three coordinates, on the sphere of size 1 or off it.
struct Spin {
    keeps: bool,
}

impl OneForm for Spin {
    fn dimension(&self) -> usize {
        3
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            let [x, y, z] = [0, 1, 2].map(|i| block.q.row(i)[k]);
            let squared = x * x + y * y;
            let theta = [-z * y / squared, z * x / squared, 0.0];
            (0..3).for_each(|i| block.p.row_mut(i)[k] = theta[i]);
        }
    }

    fn project(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            let squared: f64 = (0..3).map(|i| block.q.row(i)[k].powi(2)).sum();
            let factor = if self.keeps { squared.sqrt() } else { 1.0 };
            (0..3).for_each(|i| block.q.row_mut(i)[k] /= factor);
        }
    }
}

/// Turns about the x-axis, by an angle that depends on x, and in the same way about the z-axis.
fn turns(h: f64, m: &mut [f64], _: &mut [f64]) {
    for (axis, rate) in [(0, 1.0), (2, 0.4)] {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let (sin, cos) = (rate * h * m[axis]).sin_cos();
        (m[j], m[k]) = (cos * m[j] - sin * m[k], sin * m[j] + cos * m[k]);
    }
}

/// The same, and towards the z-axis on the sphere of the state.
fn damped_turns(h: f64, m: &mut [f64], p: &mut [f64]) {
    let size = |m: &[f64]| m.iter().map(|x| x * x).sum::<f64>().sqrt();
    turns(h, m, p);
    let before = size(m);
    m[2] += 0.1 * h;
    let factor = before / size(m);
    m.iter_mut().for_each(|x| *x *= factor);
}

#[test]
fn a_degenerate_form_decides_on_its_leaf_only() {
    for (step, kind) in [
        (turns as Step, VerdictKind::Symplectic),
        (damped_turns, VerdictKind::NotSymplectic),
    ] {
        for keeps in [true, false] {
            let map = NonCanonical::of_positions(PerSample::new(3, step), Spin { keeps }).unwrap();
            let circle = Circle::new(vec![0.6, 0.5, 0.4], vec![0.0; 3], 0.2).unwrap();
            let found = Diagnostic::halving(-1, -5).run(&map, &map.loop_of(circle));
            let verdict = found.unwrap().verdict;
            if keeps {
                assert_eq!(verdict.kind, kind, "{verdict}");
                continue;
            }
            assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict}");
            let Finding::Domain(DomainFinding::DegenerateForm { rank, .. }) = verdict.findings[0]
            else {
                panic!("{verdict}");
            };
            assert_eq!((rank.rank, rank.of), (2, 3));
            assert_eq!(verdict.advice, [Advice::KeepToLeaf]);
        }
    }
}

/// ϑ = p0 dq0, of a map of two pairs.
struct OnePair;

impl OneForm for OnePair {
    fn dimension(&self) -> usize {
        4
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            let momentum = block.q.row(2)[k];
            (0..4).for_each(|i| block.p.row_mut(i)[k] = 0.0);
            block.p.row_mut(0)[k] = momentum;
        }
    }
}

#[test]
fn a_form_that_lacks_a_pair_does_not_decide_about_it() {
    let step = |h: f64, z: &mut [f64], _: &mut [f64]| {
        for i in 0..2 {
            z[2 + i] -= h * z[i].sin();
            z[i] += h * z[2 + i];
        }
        z[3] *= (-h).exp();
    };
    let map = NonCanonical::of_positions(PerSample::new(4, step), OnePair).unwrap();
    let circle = Circle::new(vec![1.0, 0.2, 0.5, 0.1], vec![0.0; 4], 0.5).unwrap();
    let found = Diagnostic::halving(-1, -5).run(&map, &map.loop_of(circle));
    let verdict = found.unwrap().verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict}");
    assert!(
        verdict.summary().contains("dϑ has rank 2 of 4"),
        "{verdict}"
    );
}

#[test]
fn a_step_that_changes_a_casimir_function_is_not_called_symplectic() {
    // ϑ does not depend on the size of the spin, which the step halves.
    let step = |h: f64, m: &mut [f64], p: &mut [f64]| {
        turns(h, m, p);
        m.iter_mut().for_each(|x| *x *= 0.5);
    };
    let map = NonCanonical::of_positions(PerSample::new(3, step), Projected).unwrap();
    let circle = Circle::new(vec![0.6, 0.5, 0.4], vec![0.0; 3], 0.2).unwrap();
    let found = Diagnostic::halving(-1, -5).run(&map, &map.loop_of(circle));
    let verdict = found.unwrap().verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict}");
    assert_eq!(verdict.advice, [Advice::KeepToManifold]);
}

/// The area of directions: ϑ = cos θ dφ, on the unit sphere.
struct Projected;

impl OneForm for Projected {
    fn dimension(&self) -> usize {
        3
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        Spin { keeps: true }.evaluate(block);
        for k in 0..block.len() {
            let squared: f64 = (0..3).map(|i| block.q.row(i)[k].powi(2)).sum();
            (0..3).for_each(|i| block.p.row_mut(i)[k] /= squared.sqrt());
        }
    }

    fn project(&self, block: &mut Block<'_>) {
        Spin { keeps: true }.project(block);
    }
}

#[test]
fn a_form_of_another_dimension_is_an_error() {
    let map = PerSample::new(2, |_, _: &mut [f64], _: &mut [f64]| {});
    let error = NonCanonical::new(map, Bent).err().unwrap();
    assert!(
        error
            .to_string()
            .contains("2 coordinates and the map 2 degrees"),
        "{error}"
    );
}
