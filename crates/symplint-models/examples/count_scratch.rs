//! scratch
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};
use symplint::*;
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_models::pic::{ParticleWeights, Pic1d, PicConfig};

struct Counted<'a> {
    map: &'a dyn TimeAdvance,
    n: AtomicUsize,
}
impl TimeAdvance for Counted<'_> {
    fn dof(&self) -> usize {
        self.map.dof()
    }
    fn advance(&self, h: f64, b: &mut Block<'_>) -> Result<(), StepFailure> {
        self.n.fetch_add(b.len(), Ordering::Relaxed);
        self.map.advance(h, b)
    }
    fn coordinates(&self) -> Coordinates {
        self.map.coordinates()
    }
}
struct Wedge(Vec<(char, f64)>);
impl TimeAdvance for Wedge {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.substeps()).try_for_each(|k| self.advance_substep(k, h, block))
    }
    fn substeps(&self) -> usize {
        self.0.len()
    }
    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let (flow, fraction) = self.0[k];
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            match flow {
                'T' => *q += fraction * h * *p,
                _ => *p -= fraction * h * if *q < 0.0 { -1.0 } else { 1.0 },
            }
        }
        Ok(())
    }
}
fn show(name: &str, map: &dyn TimeAdvance, on: &dyn Loop, h: f64, exact: f64) {
    let f = Piecewise::default().integrate(map, on, h).unwrap();
    let c = f.closed();
    println!(
        "{name:34} h={h:<5} evals {:6} breaks {:4} pieces {:4} I {:.15e} err {:.1e} closed-exact {:.1e} err {:.1e} ro {:.1e} unres {}",
        f.evaluations,
        f.breaks.len(),
        f.pieces,
        f.continuous.value,
        f.continuous.quadrature_error.unwrap(),
        c.value - exact,
        c.quadrature_error.unwrap(),
        c.roundoff,
        f.unresolved.len()
    );
}
fn main() {
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    for h in [0.5, 0.1, 0.01] {
        show("lie-q", &Wedge(vec![('T', 1.0), ('V', 1.0)]), &unit, h, PI);
        show("lie-p", &Wedge(vec![('V', 1.0), ('T', 1.0)]), &unit, h, PI);
        show(
            "strang-q",
            &Wedge(vec![('T', 0.5), ('V', 1.0), ('T', 0.5)]),
            &unit,
            h,
            PI,
        );
        show(
            "strang-p",
            &Wedge(vec![('V', 0.5), ('T', 1.0), ('V', 0.5)]),
            &unit,
            h,
            PI,
        );
    }
    let whole = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * q[0].signum();
        q[0] += 0.5 * h * p[0];
    });
    show("strang-q whole (bench)", &whole, &unit, 0.1, PI);
    let kink = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * (q[0] - 0.3).abs();
        q[0] += h * p[0];
    });
    show("kink", &kink, &unit, 0.5, PI);
    let pend = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    });
    show("pendulum", &pend, &unit, 0.5, PI);
    let single = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * f64::from((q[0] as f32).sin());
        q[0] += h * p[0];
    });
    show("single", &single, &unit, 0.5, PI);
    for (n, degree, h) in [
        (2, 1, 0.5),
        (2, 1, 0.1),
        (2, 1, 0.01),
        (16, 1, 0.5),
        (16, 1, 0.1),
        (128, 1, 0.1),
        (2, 2, 0.1),
        (2, 3, 0.1),
        (16, 3, 0.1),
    ] {
        for v in [Variant::PositionFirst, Variant::MomentumFirst] {
            let weights = ParticleWeights::Equal {
                particles: n,
                density: 1.0,
            };
            let config = PicConfig {
                weights,
                degree,
                ..PicConfig::default()
            };
            let l = config.length;
            let pic = Pic1d::new(config).unwrap();
            let phi = 0.6180339887498949;
            let x: Vec<f64> = (0..n).map(|a| l * (0.5 + a as f64 * phi).fract()).collect();
            let vv: Vec<f64> = (0..n)
                .map(|a| 3.0 * (-1f64).powi(a as i32) + 0.3 * (1.0 + a as f64).sin())
                .collect();
            let on = Circle::new(x, vv, 1.0).unwrap();
            let method = splitting_methods::strang(v);
            let map = Splitting::new(method, pic);
            let exact = PI * map.coordinates().weight(0) * n as f64;
            show(&format!("pic {n} deg {degree} {v:?}"), &map, &on, h, exact);
        }
    }
    // find_break
    for n in [16, 32, 48, 64, 128, 512, 4096, 65536] {
        for (name, map) in [
            (
                "jump",
                &PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                    p[0] -= h * (q[0] - 0.3).signum();
                    q[0] += h * p[0];
                }) as &dyn TimeAdvance,
            ),
            (
                "small jump",
                &PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                    p[0] += h * (3.0 * q[0] - 1e-6 * (q[0] - 0.3).signum());
                    q[0] += h * p[0];
                }),
            ),
            (
                "kink",
                &PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                    p[0] -= h * (q[0] - 0.3).abs();
                    q[0] += h * p[0];
                }),
            ),
            (
                "steep1e-4",
                &PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                    let x = q[0] - 0.3;
                    p[0] -= h * x / x.hypot(1e-4);
                    q[0] += h * p[0];
                }),
            ),
            (
                "steep1e-8",
                &PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
                    let x = q[0] - 0.3;
                    p[0] -= h * x / x.hypot(1e-8);
                    q[0] += h * p[0];
                }),
            ),
            ("single", &single),
            ("smooth", &pend),
        ] {
            let mut e = Ensemble::sample(&unit, n).unwrap();
            e.advance(map, 0.5).unwrap();
            let c = Counted {
                map,
                n: AtomicUsize::new(0),
            };
            let f = find_break(&c, &unit, 0.5, &e, &Coordinates::plain(1)).unwrap();
            println!(
                "N={n:6} {name:12} evals {:5} {:?}",
                c.n.load(Ordering::Relaxed),
                f.map(|b| (b.s, b.jump_q, b.jump_p))
            );
        }
    }
}
