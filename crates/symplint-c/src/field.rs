//! Tests of a force or a vector field that the caller's function evaluates.

use std::ffi::{c_int, c_void};

use symplint::field::FieldReport;

use crate::callback::callback_map;
use crate::field_options::{FieldSettings, SymplintFieldOptions};
use crate::field_report::SymplintFieldReport;
use crate::pointers::write;
use crate::status::{Failure, SymplintStatus, guarded};

/// Writes the force at `samples` positions to `force`, and returns 0. Any other number means that the force cannot be evaluated. The
/// error names this number.
///
/// q[i * samples + k] is the position i of the sample k, and so is force: one row for each of the `dof` degrees of freedom. In Fortran
/// they are q(samples, dof). The force on a sample must depend on this sample only. `samples` may be any number from 1. The
/// function is called on the thread that called `symplint_check_force`, one call at a time; it must return (no longjmp, no C++
/// exception).
pub type SymplintForce = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        dof: usize,
        samples: usize,
        q: *const f64,
        force: *mut f64,
    ) -> c_int,
>;

/// Writes the rates of q and p at `samples` states to `q_rate` and `p_rate`, and returns 0. The arrays and the rules are those of
/// `SymplintForce`.
pub type SymplintField = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        dof: usize,
        samples: usize,
        q: *const f64,
        p: *const f64,
        q_rate: *mut f64,
        p_rate: *mut f64,
    ) -> c_int,
>;

/// Tests whether the force F(q) is a gradient: whether ∮F·dq = 0 around random loops. Also measures λ, the antisymmetric part of the
/// Jacobian of F relative to the Jacobian. The number of evaluations does not depend on `dof`, unless a curl is
/// found.
///
/// q0 has `dof` values, and is the centre of the loops. `options` is NULL for the defaults. `force` gets `user` unchanged. On success,
/// `*report` is a report, which the caller frees by `symplint_field_report_free`. Otherwise it is NULL. If the force fails or is not
/// finite on a loop, the status is SYMPLINT_STATUS_STEP_FAILED.
///
/// # Safety
/// `force` does what its type says, and arrays that are not null have as many values as this says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_check_force(
    force: SymplintForce,
    user: *mut c_void,
    dof: usize,
    q0: *const f64,
    options: *const SymplintFieldOptions,
    report: *mut *mut SymplintFieldReport,
) -> SymplintStatus {
    guarded(|| {
        // SAFETY: what the caller of this function promises.
        unsafe { write("report", report, &[std::ptr::null_mut()]) }?;
        let force = force.ok_or_else(|| Failure::null("force"))?;
        // SAFETY: as above.
        let settings = unsafe { FieldSettings::read(dof, q0, None, options) }?;
        let found = run(&settings, |dof, samples, q, p| {
            // SAFETY: both have dof × samples values, and the caller promises the rest.
            unsafe { force(user, dof, samples, q.as_ptr(), p.as_mut_ptr()) }
        })?;
        // SAFETY: as above.
        unsafe { write("report", report, &[found.into_pointer()]) }
    })
}

/// Tests whether the vector field (q, p)' = f(q, p) is Hamiltonian in these variables: whether ∮(f_q·dp − f_p·dq) = 0 around random
/// loops. q0 and p0 have `dof` values each; the rest is as for `symplint_check_force`.
///
/// # Safety
/// `field` does what its type says, and arrays that are not null have as many values as this says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_check_field(
    field: SymplintField,
    user: *mut c_void,
    dof: usize,
    q0: *const f64,
    p0: *const f64,
    options: *const SymplintFieldOptions,
    report: *mut *mut SymplintFieldReport,
) -> SymplintStatus {
    guarded(|| {
        // SAFETY: what the caller of this function promises.
        unsafe { write("report", report, &[std::ptr::null_mut()]) }?;
        let field = field.ok_or_else(|| Failure::null("field"))?;
        // SAFETY: as above.
        let settings = unsafe { FieldSettings::read(dof, q0, Some(p0), options) }?;
        let found = run(&settings, |dof, samples, q, p| {
            let states = [q.to_vec(), p.to_vec()];
            let [of_q, of_p] = states.each_ref().map(|rows| rows.as_ptr());
            // SAFETY: all have dof × samples values, and the caller promises the rest.
            unsafe {
                field(
                    user,
                    dof,
                    samples,
                    of_q,
                    of_p,
                    q.as_mut_ptr(),
                    p.as_mut_ptr(),
                )
            }
        })?;
        // SAFETY: as above.
        unsafe { write("report", report, &[found.into_pointer()]) }
    })
}

/// Runs a test on other threads, and evaluates rates on this one: they replace positions and momenta.
fn run(
    settings: &FieldSettings,
    mut rates: impl FnMut(usize, usize, &mut [f64], &mut [f64]) -> c_int,
) -> Result<SymplintFieldReport, Failure> {
    let (map, steps) = callback_map(settings.coordinates.clone(), Vec::new());
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|error| {
            let text = format!("cannot start threads: {error}");
            Failure::new(SymplintStatus::Failed, text)
        })?;
    let found: FieldReport = std::thread::scope(|scope| {
        let measuring = scope.spawn(|| {
            // Dropped at the end, whatever happens: no more rates are evaluated then.
            let map = map;
            pool.install(|| match &settings.p0 {
                None => settings.test.run_force(&map, &settings.q0),
                Some(p0) => settings.test.run_field(&map, &settings.q0, p0),
            })
        });
        steps.serve(|_, dof, samples, q, p| rates(dof, samples, q, p))?;
        (measuring.join()).map_err(|panic| Failure::of_panic(&*panic))
    })??;
    SymplintFieldReport::new(&found)
}
