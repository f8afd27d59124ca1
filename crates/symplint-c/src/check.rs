//! The diagnosis.

use std::ffi::c_void;

use crate::callback::{Call, SymplintStep, callback_map};
use crate::options::{Settings, SymplintOptions};
use crate::pointers::write;
use crate::report::SymplintReport;
use crate::status::{Failure, SymplintStatus, guarded};

/// Tests whether the map `step` is symplectic.
///
/// q0 and p0 have `dof` values each, and are the centre of the loop. `options` is NULL for the defaults. `step` gets `user` unchanged.
/// On success, `*report` is a report, which the caller frees by `symplint_report_free`. Otherwise it is NULL.
///
/// With `options->substep`, the step is a composition of substeps, and `step` is NULL. The report then names the substeps that are not
/// symplectic or break a loop.
///
/// If the step fails at a step size, the report names this step size, and the diagnosis continues with the others. If it fails at all
/// step sizes, or at the largest and the smallest one, the status is SYMPLINT_STATUS_STEP_FAILED.
///
/// # Safety
/// `step` does what its type says, arrays that are not null have as many values as this says, and texts end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_check(
    step: SymplintStep,
    user: *mut c_void,
    dof: usize,
    q0: *const f64,
    p0: *const f64,
    options: *const SymplintOptions,
    report: *mut *mut SymplintReport,
) -> SymplintStatus {
    guarded(|| {
        // SAFETY: what the caller of this function promises.
        unsafe { write("report", report, &[std::ptr::null_mut()]) }?;
        // SAFETY: as above.
        let settings = unsafe { Settings::read(dof, q0, p0, options) }?;
        if step.is_some() && settings.substep.is_some() {
            return Err(Failure::bad_argument(
                "both a step and a substep are given; with options.substep, step is NULL",
            ));
        }
        if step.is_none() && settings.substep.is_none() {
            return Err(Failure::null("step"));
        }
        let (diagnostic, circle) = (settings.diagnostic()?, settings.circle()?);
        let (map, steps) = callback_map(settings.coordinates()?, settings.substeps.clone());
        let map = map.with_reversal(settings.reversal_function.is_some());
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(settings.threads)
            .build()
            .map_err(|error| {
                Failure::new(
                    SymplintStatus::Failed,
                    format!("cannot start threads: {error}"),
                )
            })?;
        let run = symplint_report::provenance::Run::start(env!("CARGO_PKG_VERSION"), None);
        let diagnosis = std::thread::scope(|scope| {
            let measuring = scope.spawn(|| {
                // Dropped at the end, whatever happens: no more steps are taken then.
                let map = map;
                pool.install(|| diagnostic.run(&map, &circle))
            });
            let served = steps.serve(|call, dof, samples, q, p| {
                let (q, p) = (q.as_mut_ptr(), p.as_mut_ptr());
                let reversal = settings.reversal_function;
                // SAFETY: both have dof × samples values, no other code uses them meanwhile, and the caller promises the rest.
                unsafe {
                    match (call, step, settings.substep, reversal) {
                        (Call::Substep(_, h), Some(step), ..) => step(user, h, dof, samples, q, p),
                        (Call::Substep(k, h), None, Some(substep), _) => {
                            substep(user, k, h, dof, samples, q, p)
                        }
                        (Call::Reversal, .., Some(reversal)) => reversal(user, dof, samples, q, p),
                        _ => unreachable!("the function is given"),
                    }
                }
            });
            let found = (measuring.join()).map_err(|panic| Failure::of_panic(&*panic))?;
            served.map(|()| found)
        })??;
        let provenance = run.provenance(pool.current_num_threads());
        let made = SymplintReport::new(&settings, &diagnosis, provenance);
        // SAFETY: as above.
        unsafe { write("report", report, &[Box::into_raw(Box::new(made))]) }
    })
}
