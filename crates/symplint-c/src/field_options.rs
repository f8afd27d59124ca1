//! The options of a test of a force or a vector field, which may grow like the options of a check.

use symplint::Coordinates;
use symplint::field::{FieldRadius, FieldTest};

use crate::pointers::{optional_values, overlay, write_prefix};
use crate::status::{Failure, SymplintStatus, guarded};

/// Options of `symplint_check_force` and `symplint_check_field`. Fill it by `symplint_field_options_init`, then change its fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SymplintFieldOptions {
    /// Size of this struct in bytes.
    pub size: usize,
    /// Size of the loops in every coordinate. 0, the default, is the distance on which the force is nearly linear, and at most a tenth
    /// of the size of the centre.
    pub radius: f64,
    /// Size in each position, or NULL: `radius`. A position of size 0 is fixed. For a field, give both arrays or neither.
    pub radius_q: *const f64,
    /// Size in each momentum of a field, or NULL: `radius`. Not used for a force.
    pub radius_p: *const f64,
    /// Period of each position, 0 for none; or NULL. The test then also goes around up to eight of them.
    pub period: *const f64,
    /// Weight of each momentum of a field, canonical momentum = weight * p; or NULL. Not used for a force.
    pub weight: *const f64,
    /// Number of random loops. 4 by default.
    pub loops: usize,
    /// Largest number of states at which the force is evaluated, at least 100. 20000 by default.
    pub budget: usize,
    /// Seed of the random loops and directions. 1 by default.
    pub seed: u64,
    /// Threads for the work of this library, at most one for each processor, 0 for all. 1 by default.
    pub threads: usize,
}

/// Bytes of the struct of version 0.1.0, the first. Later fields come after that.
const FIRST_SIZE: usize = std::mem::offset_of!(SymplintFieldOptions, threads) + size_of::<usize>();

impl Default for SymplintFieldOptions {
    fn default() -> Self {
        let null = std::ptr::null();
        let test = FieldTest::default();
        SymplintFieldOptions {
            size: size_of::<Self>(),
            radius: 0.0,
            radius_q: null,
            radius_p: null,
            period: null,
            weight: null,
            loops: test.loops,
            budget: test.budget,
            seed: test.seed,
            threads: 1,
        }
    }
}

/// Fills options with their defaults. `size` is sizeof(SymplintFieldOptions).
///
/// # Safety
/// `options` has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_options_init(
    options: *mut SymplintFieldOptions,
    size: usize,
) -> SymplintStatus {
    guarded(|| {
        check_size(size)?;
        let defaults = SymplintFieldOptions {
            size,
            ..SymplintFieldOptions::default()
        };
        // SAFETY: what the caller of this function promises.
        unsafe { write_prefix("options", options, size, &defaults) }
    })
}

/// Refuses sizes that no version of the struct has.
fn check_size(size: usize) -> Result<(), Failure> {
    let most = size_of::<SymplintFieldOptions>();
    match (FIRST_SIZE..=most).contains(&size) {
        true => Ok(()),
        false => Err(Failure::bad_argument(format!(
            "the options of a field have {size} bytes, and this library, {}, knows {FIRST_SIZE} to {most}; fill them by \
             symplint_field_options_init with the header of this version",
            env!("CARGO_PKG_VERSION")
        ))),
    }
}

/// The options with the arrays that they point to.
pub struct FieldSettings {
    pub q0: Vec<f64>,
    /// Of a field.
    pub p0: Option<Vec<f64>>,
    pub test: FieldTest,
    pub coordinates: Coordinates,
    pub threads: usize,
}

impl FieldSettings {
    /// Reads options, or takes the defaults if the pointer is null. A field has a `p0`.
    ///
    /// # Safety
    /// Arrays that are not null have as many values as the header says.
    pub unsafe fn read(
        dof: usize,
        q0: *const f64,
        p0: Option<*const f64>,
        options: *const SymplintFieldOptions,
    ) -> Result<Self, Failure> {
        if dof == 0 {
            return Err(Failure::bad_argument(
                "dof is 0; give one degree of freedom or more",
            ));
        }
        let mut read = SymplintFieldOptions::default();
        if !options.is_null() {
            let mut size = 0_usize;
            // SAFETY: the struct begins with its size, and has that number of bytes; integers, numbers and pointers may have any.
            unsafe {
                overlay("options", options.cast(), size_of::<usize>(), &mut size)?;
                check_size(size)?;
                overlay("options", options, size, &mut read)?;
            }
        }
        let is_field = p0.is_some();
        // SAFETY: the caller promises `dof` values, or null.
        let (q0, p0, radii, period, weight) = unsafe {
            let given = |what, pointer| {
                optional_values(what, pointer, dof)?.ok_or_else(|| Failure::null(what))
            };
            (
                given("q0", q0)?,
                p0.map(|p0| given("p0", p0)).transpose()?,
                [
                    optional_values("radius_q", read.radius_q, dof)?,
                    optional_values("radius_p", read.radius_p, dof)?.filter(|_| is_field),
                ],
                optional_values("period", read.period, dof)?,
                optional_values("weight", read.weight, dof)?.filter(|_| is_field),
            )
        };
        let mut coordinates = Coordinates::plain(dof);
        if let Some(period) = period {
            coordinates = coordinates.with_periods(period)?;
        }
        if let Some(weight) = weight {
            coordinates = coordinates.with_weights(weight)?;
        }
        let [of_q, of_p] = radii;
        let radius = match (of_q, of_p, read.radius == 0.0) {
            (None, None, true) => FieldRadius::Auto,
            (None, None, false) => FieldRadius::Same(read.radius),
            (of_q, of_p, is_zero) => {
                if is_field && is_zero && (of_q.is_none() || of_p.is_none()) {
                    return Err(Failure::bad_argument(
                        "one of radius_q and radius_p is given and radius is 0; give both, or a radius",
                    ));
                }
                let or_same = |of: Option<Vec<f64>>| of.unwrap_or_else(|| vec![read.radius; dof]);
                let mut radius = or_same(of_q);
                if is_field {
                    radius.extend(or_same(of_p));
                }
                FieldRadius::Each(radius)
            }
        };
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(FieldSettings {
            q0,
            p0,
            test: FieldTest {
                radius,
                loops: read.loops,
                budget: read.budget,
                seed: read.seed,
            },
            coordinates,
            threads: read.threads.min(processors),
        })
    }
}
