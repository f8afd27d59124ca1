//! Degrees of freedom of very different action: Jupiter and light bodies round a fixed Sun.

use symplint::verdict::{BoundFinding, Finding};
use symplint::{Circle, Diagnosis, Diagnostic, PerSample, VerdictKind};

/// Astronomical units, days, and masses of Jupiter: GM of the Sun and of Jupiter.
const GM_SUN: f64 = 2.959_122e-4;
const GM_JUPITER: f64 = 2.825_346e-7;

/// A tenth of Jupiter's period, and halvings.
const STEPS: [f64; 4] = [433.0, 216.5, 108.25, 54.125];

struct Bodies {
    masses: Vec<f64>,
}

impl Bodies {
    /// Jupiter and `count` bodies of this mass.
    fn new(count: usize, mass: f64) -> Self {
        let mut masses = vec![1.0];
        masses.resize(1 + count, mass);
        Bodies { masses }
    }

    /// On circles, at different distances from the Sun.
    fn centre(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut p) = (Vec::new(), Vec::new());
        for (k, mass) in self.masses.iter().enumerate() {
            let (distance, angle) = (5.2 + 1.3 * k as f64, 2.4 * k as f64);
            let speed = (GM_SUN / distance).sqrt();
            q.extend([distance * angle.cos(), distance * angle.sin()]);
            p.extend([-mass * speed * angle.sin(), mass * speed * angle.cos()]);
        }
        (q, p)
    }

    /// A tenth of an AU, and a twentieth of the momenta.
    fn circle(&self) -> Circle {
        let (q0, p0) = self.centre();
        let radii_p = self
            .masses
            .iter()
            .flat_map(|mass| [mass * 4e-4; 2])
            .collect();
        let radii_q = vec![0.1; q0.len()];
        Circle::with_radii(q0, p0, radii_q, radii_p)
            .unwrap()
            .with_phases(symplint::Phases::Random { seed: 3 })
    }

    /// The Sun pulls all of them; Jupiter and each of the others pull each other.
    fn kick(&self, tau: f64, q: &[f64], p: &mut [f64]) {
        let cubed = |x: f64, y: f64| x.hypot(y).powi(3);
        for (k, mass) in self.masses.iter().enumerate() {
            let (x, y) = (q[2 * k], q[2 * k + 1]);
            let pull = GM_SUN * mass / cubed(x, y);
            p[2 * k] -= tau * pull * x;
            p[2 * k + 1] -= tau * pull * y;
            if k > 0 {
                let (x, y) = (x - q[0], y - q[1]);
                let pull = GM_JUPITER * mass / cubed(x, y);
                for (i, x) in [x, y].into_iter().enumerate() {
                    p[2 * k + i] -= tau * pull * x;
                    p[i] += tau * pull * x;
                }
            }
        }
    }

    /// Leapfrog; the momenta of the light bodies are multiplied by `damping` after it.
    fn diagnose(self, damping: f64, budget: Option<usize>) -> Diagnosis {
        let circle = self.circle();
        let map = PerSample::new(circle_dof(&self), move |h, q, p| {
            self.kick(0.5 * h, q, p);
            for (k, mass) in self.masses.iter().enumerate() {
                (2 * k..2 * k + 2).for_each(|i| q[i] += h * p[i] / mass);
            }
            self.kick(0.5 * h, q, p);
            p[2..].iter_mut().for_each(|p| *p *= damping);
        });
        let diagnostic = Diagnostic {
            step_sizes: STEPS.to_vec(),
            budget,
            ..Diagnostic::default()
        };
        diagnostic.run(&map, &circle).unwrap()
    }
}

fn circle_dof(bodies: &Bodies) -> usize {
    2 * bodies.masses.len()
}

/// Bounds of loops and of the Jacobian, group by group.
fn bounds(diagnosis: &Diagnosis) -> Vec<(usize, Option<f64>, Option<f64>)> {
    let of_group = |finding: &Finding| match finding {
        Finding::Bounds(BoundFinding::Group {
            dofs,
            by_loops,
            by_jacobian,
            ..
        }) => Some((dofs.len(), *by_loops, *by_jacobian)),
        _ => None,
    };
    diagnosis
        .verdict
        .findings
        .iter()
        .filter_map(of_group)
        .collect()
}

#[test]
fn light_bodies_have_loops_and_tangent_vectors_of_their_own() {
    for (count, mass) in [(9, 1e-15), (2, 1e-15), (9, 1e-9), (2, 1e-4)] {
        let damped = Bodies::new(count, mass).diagnose(0.95, None);
        let verdict = &damped.verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::NotSymplectic,
            "{mass}: {verdict}"
        );
        let worst = damped.evidence.jacobian.as_ref().unwrap().worst.unwrap();
        assert!((worst.signed + 0.05).abs() < 1e-3, "{verdict}");
        let (i, j) = worst.dofs.unwrap();
        assert!(i >= 2 && j >= 2, "{verdict}");

        let leapfrog = Bodies::new(count, mass).diagnose(1.0, None);
        let verdict = &leapfrog.verdict;
        assert_eq!(verdict.kind, VerdictKind::Symplectic, "{mass}: {verdict}");
        assert!(verdict.digits.unwrap() > 11.0, "{verdict}");
        let [
            (2, Some(heavy), Some(_)),
            (light, Some(bound), Some(by_jacobian)),
        ] = bounds(&leapfrog)[..]
        else {
            panic!("{verdict}");
        };
        assert_eq!(light, 2 * count);
        assert!(
            heavy < 1e-12 && bound < 1e-11 && by_jacobian < 1e-6,
            "{verdict}"
        );
    }
}

/// Several groups, and none.
#[test]
fn groups_follow_the_actions() {
    let mut bodies = Bodies::new(3, 1.0);
    bodies.masses = vec![1.0, 1e-5, 1e-10, 0.3];
    let diagnosis = bodies.diagnose(1.0, None);
    assert_eq!(
        diagnosis.verdict.kind,
        VerdictKind::Symplectic,
        "{}",
        diagnosis.verdict
    );
    let dofs: Vec<&[usize]> = diagnosis
        .evidence
        .groups
        .iter()
        .map(|g| &g.dofs[..])
        .collect();
    assert_eq!(dofs, [&[0, 1, 6, 7][..], &[2, 3], &[4, 5]]);
    assert_eq!(bounds(&diagnosis).len(), 3);

    let alike = Bodies::new(3, 0.3).diagnose(1.0, None);
    assert!(alike.evidence.groups.is_empty() && bounds(&alike).is_empty());
}

/// With few evaluations the damping is found, or the verdict is undecided and reports how many more would be enough.
#[test]
fn in_a_tight_budget_no_group_is_forgotten() {
    for budget in [300, 1_000, 3_000, 10_000] {
        let damped = Bodies::new(9, 1e-15).diagnose(0.95, Some(budget));
        let verdict = &damped.verdict;
        assert_ne!(verdict.kind, VerdictKind::Symplectic, "{budget}: {verdict}");
        let leapfrog = Bodies::new(9, 1e-15).diagnose(1.0, Some(budget));
        let verdict = &leapfrog.verdict;
        assert_ne!(
            verdict.kind,
            VerdictKind::NotSymplectic,
            "{budget}: {verdict}"
        );
    }
}
