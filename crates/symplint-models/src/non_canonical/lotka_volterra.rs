//! Populations of prey and predators.

use super::{NonCanonicalSystem, State};

/// Lotka–Volterra: ẋ = x (1 − y), ẏ = y (x − 1), with H = x − ln x + y − ln y and ω = dx∧dy/(xy), the derivative of
/// ϑ = −(ln y / x) dx. Canonical in u = ln x and v = −ln y (HLW, section VII.2).
///
/// The symplectic step is the flow of y − ln y and then that of x − ln x: symplectic Euler in u and v.
#[derive(Clone, Copy, Debug, Default)]
pub struct LotkaVolterra;

impl NonCanonicalSystem<1> for LotkaVolterra {
    fn velocity(&self, [[x], [y]]: State<1>) -> State<1> {
        [[x * (1.0 - y)], [y * (x - 1.0)]]
    }

    fn energy(&self, [[x], [y]]: State<1>) -> f64 {
        x - x.ln() + y - y.ln()
    }

    fn one_form(&self, [[x], [y]]: State<1>) -> State<1> {
        [[-y.ln() / x], [0.0]]
    }

    fn symplectic_step(&self, h: f64, [[x], [y]]: State<1>) -> Result<State<1>, &'static str> {
        let x = x * (h * (1.0 - y)).exp();
        Ok([[x], [y * (h * (x - 1.0)).exp()]])
    }
}
