//! A system and its integrators from the library, diagnosed one after the other: the Hénon–Heiles
//! system, from the catalogue of integrators.
//!
//! Run it with: cargo run --release --example henon_heiles

use std::error::Error;
use std::sync::Arc;

use symplint::{Circle, Diagnostic};
use symplint_models::Model;
use symplint_models::integrators::catalogue::{CATALOGUE, build};
use symplint_models::systems::HenonHeiles;

fn main() -> Result<(), Box<dyn Error>> {
    // Small circles in both planes of phase space.
    let circles = Circle::new(vec![0.0, 0.1], vec![0.3, 0.0], 0.2)?;
    let diagnostic = Diagnostic::halving(0, -6);
    let model = Model::Separable(Arc::new(HenonHeiles));
    for info in CATALOGUE.iter().filter(|info| info.is_for(&model)) {
        let step = build(info.name, None, Arc::new(HenonHeiles))?;
        let verdict = diagnostic.run(&*step, &circles)?.verdict;
        let detail = match (verdict.digits, verdict.order) {
            (Some(digits), _) => format!("to {digits} digits"),
            (_, Some(order)) => format!("defect of order h^{order}"),
            _ => String::new(),
        };
        println!("{:21} {:15} {detail}", info.name, verdict.kind.to_string());
    }
    Ok(())
}
