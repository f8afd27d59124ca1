//! Loop integrals, of all degrees of freedom or of some, and their defect.

use std::sync::{Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};
use symplint::state::Rows;
use symplint::{Coordinates, Defect, LoopIntegral, Rule};

use crate::pointers::{Layout, optional_values, value, values, write};
use crate::status::{Failure, SymplintStatus, guarded};

/// ∮ p·dq and its errors, for one degree of freedom, some of them or all.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymplintIntegral {
    /// The integral, in units of momentum × position.
    pub value: f64,
    /// Estimated difference from the integral of the sampled loop; NaN if it is unknown.
    pub quadrature_error: f64,
    /// Rounding error of the value.
    pub roundoff: f64,
    /// Sum of the absolute values of all terms.
    pub scale: f64,
}

/// The relative change of a loop integral over one step. All numbers are relative to the absolute value of the initial one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymplintDefect {
    /// (advanced - initial) / |initial|.
    pub signed_defect: f64,
    /// Sum of the quadrature errors of both integrals; NaN if one is unknown.
    pub quadrature_error: f64,
    /// Round-off of both integrals.
    pub roundoff: f64,
}

impl From<&LoopIntegral> for SymplintIntegral {
    fn from(integral: &LoopIntegral) -> Self {
        SymplintIntegral {
            value: integral.value,
            quadrature_error: integral.quadrature_error.unwrap_or(f64::NAN),
            roundoff: integral.roundoff,
            scale: integral.scale,
        }
    }
}

impl From<&SymplintIntegral> for LoopIntegral {
    fn from(integral: &SymplintIntegral) -> Self {
        LoopIntegral {
            value: integral.value,
            contributions: vec![integral.value],
            quadrature_error: Some(integral.quadrature_error).filter(|error| !error.is_nan()),
            roundoff: integral.roundoff,
            scale: integral.scale,
            omitted: None,
            regularity: None,
        }
    }
}

/// One thread for all integrals: many processes of a code may share a machine, and each of them uses its cores already.
fn single_thread() -> Result<&'static ThreadPool, Failure> {
    // With the process that it belongs to: one that was forked has the pool of its parent without the thread.
    static POOL: Mutex<Option<(u32, &'static ThreadPool)>> = Mutex::new(None);
    let process = std::process::id();
    let lock = || POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let of_process = |(owner, pool)| (owner == process).then_some(pool);
    if let Some(pool) = lock().and_then(of_process) {
        return Ok(pool);
    }
    // Not locked meanwhile: another thread may fork.
    let built = ThreadPoolBuilder::new().num_threads(1).build();
    let built = built.map_err(|error| {
        Failure::new(
            SymplintStatus::Failed,
            format!("cannot start a thread: {error}"),
        )
    })?;
    let mut kept = lock();
    if let Some(pool) = kept.and_then(of_process) {
        return Ok(pool);
    }
    // That of a parent is never dropped: it would wait for its thread.
    let pool = Box::leak(Box::new(built));
    *kept = Some((process, pool));
    Ok(pool)
}

/// Degrees of freedom that are copied together: those of a cache line, where states lie one after another.
const ROWS_TOGETHER: usize = 8;

/// The integrals of all degrees of freedom, one by one.
///
/// # Safety
/// That of `symplint_loop_integral`.
unsafe fn of_each(
    layout: &Layout,
    q: *const f64,
    p: *const f64,
    period: *const f64,
    weight: *const f64,
) -> Result<Vec<LoopIntegral>, Failure> {
    layout.check()?;
    // SAFETY: the caller promises one value for each degree of freedom, or null.
    let (period, weight) = unsafe {
        (
            optional_values("period", period, layout.dof)?,
            optional_values("weight", weight, layout.dof)?,
        )
    };
    let pool = single_thread()?;
    let mut parts = Vec::with_capacity(layout.dof);
    let mut integrate = |q: Rows<'_>, p: Rows<'_>, first: usize| {
        for row in 0..q.count() {
            let i = first + row;
            let of_row = |mut error: symplint::Error| {
                use symplint::Error::{BadCoordinate, NotFinite, Overflow};
                // The row is a separate ensemble, which has no other degree of freedom.
                if let NotFinite { dof, .. } | BadCoordinate { dof, .. } | Overflow { dof, .. } =
                    &mut error
                {
                    *dof = i;
                }
                Failure::from(error)
            };
            let mut coordinates = Coordinates::plain(1);
            if let Some(period) = &period {
                coordinates = coordinates.with_periods(vec![period[i]]).map_err(of_row)?;
            }
            if let Some(weight) = &weight {
                coordinates = coordinates.with_weights(vec![weight[i]]).map_err(of_row)?;
            }
            let [q, p] = [q, p].map(|rows| Rows::new(rows.row(row), 1, rows.len(), rows.len()));
            let integral = || LoopIntegral::of_rows(q, p, &Rule::Auto, &coordinates);
            parts.push(pool.install(integral).map_err(of_row)?);
        }
        Ok::<(), Failure>(())
    };
    for first in (0..layout.dof).step_by(ROWS_TOGETHER) {
        let dofs = first..layout.dof.min(first + ROWS_TOGETHER);
        // SAFETY: the caller promises the values.
        let in_place = unsafe {
            let q = layout.in_place("q", q, dofs.clone())?;
            q.zip(layout.in_place("p", p, dofs.clone())?)
        };
        match in_place {
            Some((q, p)) => integrate(q, p, first)?,
            None => {
                // SAFETY: as above.
                let states = unsafe { layout.copy(q, p, dofs) }?;
                integrate(states.q(), states.p(), first)?;
            }
        }
    }
    Ok(parts)
}

/// The loop integral ∮ p·dq of samples, by the pseudospectral rule, or by central differences that have its value to rounding.
///
/// q and p have the coordinate i of the sample k at [i * dof_stride + k * sample_stride]. Rows, one for each degree of
/// freedom, have dof_stride = samples (or more) and sample_stride = 1; columns, one state after another, have dof_stride = 1
/// and sample_stride = dof. In Fortran q(samples, dof) are rows. The sample k is the state at s = k/samples of the loop.
///
/// `period` is NULL or has the period of each position, 0 if it is not periodic. `weight` is NULL or has the weight of each momentum:
/// the canonical momentum is weight * p.
///
/// # Safety
/// Arrays that are not null have as many values as this says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_loop_integral(
    dof: usize,
    samples: usize,
    q: *const f64,
    p: *const f64,
    dof_stride: usize,
    sample_stride: usize,
    period: *const f64,
    weight: *const f64,
    integral: *mut SymplintIntegral,
) -> SymplintStatus {
    guarded(|| {
        let layout = Layout {
            dof,
            samples,
            dof_stride,
            sample_stride,
        };
        // SAFETY: what the caller of this function promises.
        let parts = unsafe { of_each(&layout, q, p, period, weight) }?;
        let merged = LoopIntegral::merged(&parts)?;
        // SAFETY: as above.
        unsafe { write("integral", integral, &[SymplintIntegral::from(&merged)]) }
    })
}

/// Computes a separate integral for each degree of freedom. `parts` has room for `dof` of them.
///
/// If the state of a code is distributed over processes, each process calls this function for its degrees of freedom. Pass all parts,
/// in the order of the degrees of freedom, to `symplint_merge_integrals`. The result equals the result of `symplint_loop_integral`
/// to the last bit, on any number of processes.
///
/// # Safety
/// As for `symplint_loop_integral`; `parts` has room for `dof` values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_partial_integrals(
    dof: usize,
    samples: usize,
    q: *const f64,
    p: *const f64,
    dof_stride: usize,
    sample_stride: usize,
    period: *const f64,
    weight: *const f64,
    parts: *mut SymplintIntegral,
) -> SymplintStatus {
    guarded(|| {
        let layout = Layout {
            dof,
            samples,
            dof_stride,
            sample_stride,
        };
        // SAFETY: what the caller of this function promises.
        let found = unsafe { of_each(&layout, q, p, period, weight) }?;
        let found: Vec<SymplintIntegral> = found.iter().map(SymplintIntegral::from).collect();
        // SAFETY: as above.
        unsafe { write("parts", parts, &found) }
    })
}

/// The loop integral from the parts of all degrees of freedom, in their order: `count` of them.
///
/// # Safety
/// `parts` has `count` values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_merge_integrals(
    count: usize,
    parts: *const SymplintIntegral,
    integral: *mut SymplintIntegral,
) -> SymplintStatus {
    guarded(|| {
        // SAFETY: what the caller of this function promises.
        let parts = unsafe { values("parts", parts, count) }?;
        let parts: Vec<LoopIntegral> = parts.iter().map(LoopIntegral::from).collect();
        let merged = LoopIntegral::merged(&parts)?;
        // SAFETY: as above.
        unsafe { write("integral", integral, &[SymplintIntegral::from(&merged)]) }
    })
}

/// The relative change of a loop integral over a step.
///
/// A change below quadrature_error + roundoff is not distinguishable from zero. A change above ten times this sum is significant.
///
/// # Safety
/// Pointers that are not null point to valid values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_defect(
    initial: *const SymplintIntegral,
    advanced: *const SymplintIntegral,
    defect: *mut SymplintDefect,
) -> SymplintStatus {
    guarded(|| {
        // SAFETY: what the caller of this function promises.
        let (initial, advanced) =
            unsafe { (value("initial", initial)?, value("advanced", advanced)?) };
        for (what, integral) in [("initial", initial), ("advanced", advanced)] {
            if !(integral.value.is_finite() && integral.roundoff.is_finite()) {
                let text = format!("{what} is not finite: its value is {}", integral.value);
                return Err(Failure::bad_argument(text));
            }
        }
        let found = Defect::between(&initial.into(), &advanced.into())?;
        let found = SymplintDefect {
            signed_defect: found.signed,
            quadrature_error: found.quadrature_error.unwrap_or(f64::NAN),
            roundoff: found.roundoff,
        };
        // SAFETY: as above.
        unsafe { write("defect", defect, &[found]) }
    })
}
