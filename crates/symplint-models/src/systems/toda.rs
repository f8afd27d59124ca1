//! The springs of the Toda lattice.

use super::chain::Bond;

/// A spring that pushes exponentially: φ = e^{−r} + r − 1 (M. Toda, J. Phys. Soc. Japan 22 (1967)
/// 431).
///
/// The periodic chain of these has as many integrals as degrees of freedom (H. Flaschka, Phys. Rev.
/// B 9 (1974) 1924; M. Hénon, Phys. Rev. B 9 (1974) 1921).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TodaBond;

impl Bond for TodaBond {
    fn energy(&self, r: f64) -> f64 {
        // e^{−r} − 1 without the loss of digits at small r.
        (-r).exp_m1() + r
    }

    fn tension(&self, r: f64) -> f64 {
        -(-r).exp_m1()
    }

    fn stiffness(&self, r: f64) -> f64 {
        (-r).exp()
    }
}
