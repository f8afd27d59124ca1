//! Vector instructions named one by one, where LLVM does not find them reliably by itself.

use pulp::{Arch, Scalar512b, Simd, WithSimd};

/// Runs a computation with the widest vector registers of the processor.
#[inline(always)]
pub(super) fn vectorised<Op: WithSimd>(work: Op) -> Op::Output {
    on(Arch::new(), work)
}

/// Runs a computation with these registers; without any that are known here, on eight numbers at a time.
#[inline(always)]
pub(super) fn on<Op: WithSimd>(registers: Arch, work: Op) -> Op::Output {
    match registers {
        Arch::Scalar => Scalar512b.vectorize(work),
        registers => registers.dispatch(work),
    }
}

/// Kinds of registers that the processor has.
#[cfg(test)]
pub(super) fn widths() -> Vec<Arch> {
    let mut widths = vec![Arch::Scalar, Arch::new()];
    #[cfg(target_arch = "x86_64")]
    widths.extend(pulp::x86::V3::try_new().map(Arch::V3));
    widths
}
