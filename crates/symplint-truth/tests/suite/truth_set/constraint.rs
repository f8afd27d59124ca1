//! Maps on a constraint manifold, with loops on it.

use std::sync::Arc;

use symplint::{Loop, PerSample, TimeAdvance};

use crate::truth_set::control;
use crate::truth_set::links::{Links, OnLinks};
use crate::truth_set::member::{Expected, Member, SYMPLECTIC, Step, Truth, halvings, map_of};
use crate::truth_set::random::Random;

pub const COUNT: usize = 240;

/// The map of a step with a projection onto the manifold.
fn on_manifold(links: &Links, step: Step) -> Arc<dyn TimeAdvance> {
    let advance = move |h: f64, q: &mut [f64], p: &mut [f64]| step(h, q, p);
    let onto = links.clone();
    let map = PerSample::new(links.dof(), advance);
    Arc::new(map.with_projection(move |q, p| onto.project(q, p)))
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(4, index);
    let links = Links::random(random);
    let on = OnLinks::random(random, &links);
    let h = random.between(0.3, 0.8) / links.omega();
    let (name, step, truth) = match index % 4 {
        0 | 1 => {
            let mut truth = Truth::of(SYMPLECTIC);
            truth.change = Some(Arc::new(|_| 0.0));
            ("RATTLE".into(), links.rattle(), truth)
        }
        _ => {
            let classical = random.chance(0.5);
            let step = links.projected(classical);
            let shared: Arc<dyn Loop> = Arc::new(on.clone());
            let defect = control::change(&step, &shared, h).abs();
            let method = if classical { "RK4" } else { "Heun" };
            let truth = Truth::of(Expected::SmallDefect(defect));
            (
                format!("{method} and projection, defect {defect:.0e}"),
                step,
                truth,
            )
        }
    };
    let mut diagnostic = halvings(h, 8);
    let mut alone = "";
    if index % 2 == 1 {
        alone = ", this loop alone";
        diagnostic.loops = 1;
        diagnostic.jacobian = false;
    }
    let projected = on_manifold(&links, step.clone());
    // Every second map says nothing of its manifold.
    let (map, projection) = match index % 8 < 4 {
        true => (map_of(links.dof(), step), ""),
        false => (projected.clone(), ", with a projection"),
    };
    let label = format!("{}, {name}{alone}{projection}", links.name());
    Member::new(label, map, on, diagnostic, truth).on_manifold(projected)
}
