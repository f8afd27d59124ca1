/* symplint: is a time-advance map symplectic?
 *
 * Written by cbindgen from the crate symplint-c; do not edit. */

#ifndef SYMPLINT_H
#define SYMPLINT_H

#include <stddef.h>
#include <stdint.h>

/**
 * The result of a function.
 */
typedef enum {
  /**
   * No error.
   */
  SYMPLINT_STATUS_OK = 0,
  /**
   * A pointer that must not be null is null.
   */
  SYMPLINT_STATUS_NULL_POINTER = 1,
  /**
   * An argument or an option is not valid.
   */
  SYMPLINT_STATUS_BAD_ARGUMENT = 2,
  /**
   * The step failed, or returned states that are not finite, at all step sizes; or a force or a field did.
   */
  SYMPLINT_STATUS_STEP_FAILED = 3,
  /**
   * The diagnosis is not possible: results depend on earlier calls, the loop has no area, and so on.
   */
  SYMPLINT_STATUS_FAILED = 4,
  /**
   * An error of this library. Please report it.
   */
  SYMPLINT_STATUS_INTERNAL = 5,
} SymplintStatus;

/**
 * The kinds of verdicts on forces and vector fields.
 */
typedef enum {
  /**
   * The report is missing.
   */
  SYMPLINT_FIELD_VERDICT_NONE = -1,
  /**
   * The force is a gradient, or the field Hamiltonian, down to the stated number of digits.
   */
  SYMPLINT_FIELD_VERDICT_HOLDS = 0,
  /**
   * The force is not a gradient, or the field not Hamiltonian.
   */
  SYMPLINT_FIELD_VERDICT_FAILS = 1,
  /**
   * There is not enough evidence.
   */
  SYMPLINT_FIELD_VERDICT_UNDECIDED = 3,
} SymplintFieldVerdict;

/**
 * The kinds of verdicts.
 */
typedef enum {
  /**
   * The report is missing.
   */
  SYMPLINT_VERDICT_NONE = -1,
  /**
   * No defect was found, down to the stated number of digits.
   */
  SYMPLINT_VERDICT_SYMPLECTIC = 0,
  /**
   * The loop integral changes significantly.
   */
  SYMPLINT_VERDICT_NOT_SYMPLECTIC = 1,
  /**
   * The map is discontinuous: it breaks loops.
   */
  SYMPLINT_VERDICT_BROKEN_LOOPS = 2,
  /**
   * There is not enough evidence.
   */
  SYMPLINT_VERDICT_UNDECIDED = 3,
} SymplintVerdict;

/**
 * The result of a test of a force or a vector field. `symplint_check_force` and `symplint_check_field` make it, and
 * `symplint_field_report_free` frees it.
 */
typedef struct SymplintFieldReport SymplintFieldReport;

/**
 * The report of a diagnosis. `symplint_check` makes it, and `symplint_report_free` frees it.
 */
typedef struct SymplintReport SymplintReport;

/**
 * Advances `samples` states by one step of size `h`, in place, and returns 0. Any other number means that the step failed. The report
 * names this number.
 *
 * q[i * samples + k] is the position i of the sample k, and p[i * samples + k] its momentum: one row for each of the `dof` degrees of freedom. In
 * Fortran they are q(samples, dof). The result for a sample must depend on h and this sample only. `samples`
 * may be any number from 1. The function is called on the thread that called `symplint_check`, one call at a time; it
 * must return (no longjmp, no C++ exception).
 */
typedef int (*SymplintStep)(void *user, double h, size_t dof, size_t samples, double *q, double *p);

/**
 * Advances `samples` states by substep number `substep`, from 0, of a step of size `h`, in place. The step is all substeps in their
 * order. The rest is as for `SymplintStep`.
 */
typedef int (*SymplintSubstep)(void *user,
                               size_t substep,
                               double h,
                               size_t dof,
                               size_t samples,
                               double *q,
                               double *p);

/**
 * Reverses `samples` states in time, in place, and returns 0. Any other number ends the check with an error that names it. The function
 * must be its own inverse. The rest is as for `SymplintStep`.
 */
typedef int (*SymplintReversal)(void *user, size_t dof, size_t samples, double *q, double *p);

/**
 * Options of `symplint_check`. Fill it by `symplint_options_init`, then change its fields.
 */
typedef struct {
  /**
   * Size of this struct in bytes.
   */
  size_t size;
  /**
   * Step sizes, or NULL: 2^-1, 2^-2, ..., 2^-10, or what `typical_step` finds.
   */
  const double *step_sizes;
  /**
   * Number of step sizes.
   */
  size_t step_count;
  /**
   * A typical step size, or 0. If `step_sizes` is NULL, the step sizes are the largest one that advances the motions on the loop by
   * about a radian, and seven halvings of it.
   */
  double typical_step;
  /**
   * Radius of the loop, a circle in every degree of freedom. 1 by default.
   */
  double radius;
  /**
   * Radius in each position, or NULL: `radius`.
   */
  const double *radius_q;
  /**
   * Radius in each momentum, or NULL: `radius`.
   */
  const double *radius_p;
  /**
   * Period of each position, 0 for none; or NULL.
   */
  const double *period;
  /**
   * Period of each momentum, 0 for none; or NULL. Loops must not wind round such a torus, because ∮ p·dq has no unique value there.
   */
  const double *momentum_period;
  /**
   * Weight of each momentum, canonical momentum = weight * p; or NULL.
   */
  const double *weight;
  /**
   * "auto", "pseudospectral", "finite-difference", "piecewise" or "streaming"; NULL is "auto".
   */
  const char *rule;
  /**
   * Samples of a loop. 0, the default, takes as many as the loop needs.
   */
  size_t samples;
  /**
   * The largest number of evaluations (states advanced by one step), at least 200. 20000 by default.
   */
  size_t budget;
  /**
   * Loops in all; those after the first are random. 8 by default.
   */
  size_t loops;
  /**
   * Number of steps of the largest size, to test whether a defect accumulates. 0 by default.
   */
  size_t steps;
  /**
   * Seed of the random loops. 1 by default.
   */
  uint64_t seed;
  /**
   * Tolerance of the piecewise rule, relative. 1e-12 by default.
   */
  double tolerance;
  /**
   * Threads for the work of this library, at most one for each processor, 0 for all; the step is called on the calling thread alone. 1 by default.
   */
  size_t threads;
  /**
   * Whether the Jacobian of a step is also tested: 1, the default, or 0.
   */
  int32_t jacobian;
  /**
   * Whether a defect is traced to a part of the loop: 1, the default, or 0.
   */
  int32_t localise;
  /**
   * Where each degree of freedom starts on its circle: "staggered" at multiples of the golden ratio, "equal" (the circle of
   * the paper) or "random"; NULL is "staggered".
   */
  const char *phases;
  /**
   * The step is composed with itself this number of times. 1 by default.
   */
  size_t repeat;
  /**
   * Whether the step is a map without a step size, such as a kicker or one turn of a ring: 1, or 0, the default. It is
   * called with h = 1, and `step_sizes` and `typical_step` are not used.
   */
  int32_t no_step_size;
  /**
   * 2 dof signs, 1 or -1, of all positions and then all momenta, that reverse time; or NULL: the signs of all momenta change.
   */
  const double *reversal;
  /**
   * Whether other properties of the map are tested, such as the conservation of volume: 1, the default, or 0. The report has
   * them.
   */
  int32_t properties;
  /**
   * Whether a step of size -h is tested to undo a step of size h: 1, or 0, the default. The step is called with negative h then.
   */
  int32_t symmetric;
  /**
   * Settings that have no field here, as a JSON object with the keys of `diagnostic` in configuration files, such as
   * "{\"cutoff_q\": 10.0, \"closure\": \"chords\"}"; or NULL. They replace the fields for the same settings.
   */
  const char *settings;
  /**
   * A substep of a step that is a composition, such as a kick, a drift or an element of a lattice; or NULL: then
   * `step` is the whole step.
   */
  SymplintSubstep substep;
  /**
   * Number of substeps of one step, if `substep` is not NULL.
   */
  size_t substep_count;
  /**
   * Names of the substeps in their order, for the report; or NULL: "part 1", "part 2", ...
   */
  const char *const *substep_names;
  /**
   * A function of states that reverses time, instead of `reversal`; or NULL.
   */
  SymplintReversal reversal_function;
} SymplintOptions;

/**
 * Writes the force at `samples` positions to `force`, and returns 0. Any other number means that the force cannot be evaluated. The
 * error names this number.
 *
 * q[i * samples + k] is the position i of the sample k, and so is force: one row for each of the `dof` degrees of freedom. In Fortran
 * they are q(samples, dof). The force on a sample must depend on this sample only. `samples` may be any number from 1. The
 * function is called on the thread that called `symplint_check_force`, one call at a time; it must return (no longjmp, no C++
 * exception).
 */
typedef int (*SymplintForce)(void *user, size_t dof, size_t samples, const double *q, double *force);

/**
 * Options of `symplint_check_force` and `symplint_check_field`. Fill it by `symplint_field_options_init`, then change its fields.
 */
typedef struct {
  /**
   * Size of this struct in bytes.
   */
  size_t size;
  /**
   * Size of the loops in every coordinate. 0, the default, is the distance on which the force is nearly linear, and at most a tenth
   * of the size of the centre.
   */
  double radius;
  /**
   * Size in each position, or NULL: `radius`. A position of size 0 is fixed. For a field, give both arrays or neither.
   */
  const double *radius_q;
  /**
   * Size in each momentum of a field, or NULL: `radius`. Not used for a force.
   */
  const double *radius_p;
  /**
   * Period of each position, 0 for none; or NULL. The test then also goes around up to eight of them.
   */
  const double *period;
  /**
   * Weight of each momentum of a field, canonical momentum = weight * p; or NULL. Not used for a force.
   */
  const double *weight;
  /**
   * Number of random loops. 4 by default.
   */
  size_t loops;
  /**
   * Largest number of states at which the force is evaluated, at least 100. 20000 by default.
   */
  size_t budget;
  /**
   * Seed of the random loops and directions. 1 by default.
   */
  uint64_t seed;
  /**
   * Threads for the work of this library, at most one for each processor, 0 for all. 1 by default.
   */
  size_t threads;
} SymplintFieldOptions;

/**
 * Writes the rates of q and p at `samples` states to `q_rate` and `p_rate`, and returns 0. The arrays and the rules are those of
 * `SymplintForce`.
 */
typedef int (*SymplintField)(void *user,
                             size_t dof,
                             size_t samples,
                             const double *q,
                             const double *p,
                             double *q_rate,
                             double *p_rate);

/**
 * ∮ p·dq and its errors, for one degree of freedom, some of them or all.
 */
typedef struct {
  /**
   * The integral, in units of momentum × position.
   */
  double value;
  /**
   * Estimated difference from the integral of the sampled loop; NaN if it is unknown.
   */
  double quadrature_error;
  /**
   * Rounding error of the value.
   */
  double roundoff;
  /**
   * Sum of the absolute values of all terms.
   */
  double scale;
} SymplintIntegral;

/**
 * The relative change of a loop integral over one step. All numbers are relative to the absolute value of the initial one.
 */
typedef struct {
  /**
   * (advanced - initial) / |initial|.
   */
  double signed_defect;
  /**
   * Sum of the quadrature errors of both integrals; NaN if one is unknown.
   */
  double quadrature_error;
  /**
   * Round-off of both integrals.
   */
  double roundoff;
} SymplintDefect;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Tests whether the map `step` is symplectic.
 *
 * q0 and p0 have `dof` values each, and are the centre of the loop. `options` is NULL for the defaults. `step` gets `user` unchanged.
 * On success, `*report` is a report, which the caller frees by `symplint_report_free`. Otherwise it is NULL.
 *
 * With `options->substep`, the step is a composition of substeps, and `step` is NULL. The report then names the substeps that are not
 * symplectic or break a loop.
 *
 * If the step fails at a step size, the report names this step size, and the diagnosis continues with the others. If it fails at all
 * step sizes, or at the largest and the smallest one, the status is SYMPLINT_STATUS_STEP_FAILED.
 *
 * # Safety
 * `step` does what its type says, arrays that are not null have as many values as this says, and texts end with a zero.
 */
SymplintStatus symplint_check(SymplintStep step,
                              void *user,
                              size_t dof,
                              const double *q0,
                              const double *p0,
                              const SymplintOptions *options,
                              SymplintReport **report);

/**
 * Tests whether the force F(q) is a gradient: whether ∮F·dq = 0 around random loops. Also measures λ, the antisymmetric part of the
 * Jacobian of F relative to the Jacobian. The number of evaluations does not depend on `dof`, unless a curl is
 * found.
 *
 * q0 has `dof` values, and is the centre of the loops. `options` is NULL for the defaults. `force` gets `user` unchanged. On success,
 * `*report` is a report, which the caller frees by `symplint_field_report_free`. Otherwise it is NULL. If the force fails or is not
 * finite on a loop, the status is SYMPLINT_STATUS_STEP_FAILED.
 *
 * # Safety
 * `force` does what its type says, and arrays that are not null have as many values as this says.
 */
SymplintStatus symplint_check_force(SymplintForce force,
                                    void *user,
                                    size_t dof,
                                    const double *q0,
                                    const SymplintFieldOptions *options,
                                    SymplintFieldReport **report);

/**
 * Tests whether the vector field (q, p)' = f(q, p) is Hamiltonian in these variables: whether ∮(f_q·dp − f_p·dq) = 0 around random
 * loops. q0 and p0 have `dof` values each; the rest is as for `symplint_check_force`.
 *
 * # Safety
 * `field` does what its type says, and arrays that are not null have as many values as this says.
 */
SymplintStatus symplint_check_field(SymplintField field,
                                    void *user,
                                    size_t dof,
                                    const double *q0,
                                    const double *p0,
                                    const SymplintFieldOptions *options,
                                    SymplintFieldReport **report);

/**
 * Fills options with their defaults. `size` is sizeof(SymplintFieldOptions).
 *
 * # Safety
 * `options` has `size` bytes.
 */
SymplintStatus symplint_field_options_init(SymplintFieldOptions *options, size_t size);

/**
 * The verdict; SYMPLINT_FIELD_VERDICT_NONE if `report` is NULL.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
SymplintFieldVerdict symplint_field_report_verdict(const SymplintFieldReport *report);

/**
 * The digits to which a force is a gradient or a field Hamiltonian; NaN for other verdicts, and for a constant force.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
double symplint_field_report_digits(const SymplintFieldReport *report);

/**
 * λ, the antisymmetric part of the Jacobian relative to the Jacobian, and its error in `*error`, unless that is NULL. Both are NaN if
 * λ was not measured.
 *
 * # Safety
 * `report` is NULL or was not freed; `error` is NULL or points to a number.
 */
double symplint_field_report_curl(const SymplintFieldReport *report,
                                  double *error);

/**
 * The verdict and its reason in one line, in UTF-8; NULL if `report` is NULL. Valid until the report is freed.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
const char *symplint_field_report_summary(const SymplintFieldReport *report);

/**
 * The table of all loops and the verdict with its reasons, in UTF-8; NULL if `report` is NULL. Valid until the report is freed.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
const char *symplint_field_report_text(const SymplintFieldReport *report);

/**
 * The whole report as JSON, schema symplint/field/1; NULL if `report` is NULL. Valid until the report is freed.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
const char *symplint_field_report_json(const SymplintFieldReport *report);

/**
 * Frees a report and its texts; NULL is allowed.
 *
 * # Safety
 * `report` is NULL or was not freed before.
 */
void symplint_field_report_free(SymplintFieldReport *report);

/**
 * The loop integral ∮ p·dq of samples, by the pseudospectral rule, or by central differences that have its value to rounding.
 *
 * q and p have the coordinate i of the sample k at [i * dof_stride + k * sample_stride]. Rows, one for each degree of
 * freedom, have dof_stride = samples (or more) and sample_stride = 1; columns, one state after another, have dof_stride = 1
 * and sample_stride = dof. In Fortran q(samples, dof) are rows. The sample k is the state at s = k/samples of the loop.
 *
 * `period` is NULL or has the period of each position, 0 if it is not periodic. `weight` is NULL or has the weight of each momentum:
 * the canonical momentum is weight * p.
 *
 * # Safety
 * Arrays that are not null have as many values as this says.
 */
SymplintStatus symplint_loop_integral(size_t dof,
                                      size_t samples,
                                      const double *q,
                                      const double *p,
                                      size_t dof_stride,
                                      size_t sample_stride,
                                      const double *period,
                                      const double *weight,
                                      SymplintIntegral *integral);

/**
 * Computes a separate integral for each degree of freedom. `parts` has room for `dof` of them.
 *
 * If the state of a code is distributed over processes, each process calls this function for its degrees of freedom. Pass all parts,
 * in the order of the degrees of freedom, to `symplint_merge_integrals`. The result equals the result of `symplint_loop_integral`
 * to the last bit, on any number of processes.
 *
 * # Safety
 * As for `symplint_loop_integral`; `parts` has room for `dof` values.
 */
SymplintStatus symplint_partial_integrals(size_t dof,
                                          size_t samples,
                                          const double *q,
                                          const double *p,
                                          size_t dof_stride,
                                          size_t sample_stride,
                                          const double *period,
                                          const double *weight,
                                          SymplintIntegral *parts);

/**
 * The loop integral from the parts of all degrees of freedom, in their order: `count` of them.
 *
 * # Safety
 * `parts` has `count` values.
 */
SymplintStatus symplint_merge_integrals(size_t count,
                                        const SymplintIntegral *parts,
                                        SymplintIntegral *integral);

/**
 * The relative change of a loop integral over a step.
 *
 * A change below quadrature_error + roundoff is not distinguishable from zero. A change above ten times this sum is significant.
 *
 * # Safety
 * Pointers that are not null point to valid values.
 */
SymplintStatus symplint_defect(const SymplintIntegral *initial,
                               const SymplintIntegral *advanced,
                               SymplintDefect *defect);

/**
 * Fills options with their defaults. `size` is sizeof(SymplintOptions).
 *
 * # Safety
 * `options` has `size` bytes.
 */
SymplintStatus symplint_options_init(SymplintOptions *options, size_t size);

/**
 * The verdict; SYMPLINT_VERDICT_NONE if `report` is NULL.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
SymplintVerdict symplint_report_verdict(const SymplintReport *report);

/**
 * The digits to which a symplectic map conserves loop integrals; NaN for other verdicts.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
double symplint_report_digits(const SymplintReport *report);

/**
 * The order k of defect ~ h^k; NaN if no order is stated.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
double symplint_report_order(const SymplintReport *report);

/**
 * The verdict and its reason in one line, in UTF-8; NULL if `report` is NULL. Valid until the report is freed.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
const char *symplint_report_summary(const SymplintReport *report);

/**
 * The verdict with its table, its findings and what to do next, as the program prints them, in UTF-8; NULL if `report` is NULL. Valid until
 * the report is freed.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
const char *symplint_report_text(const SymplintReport *report);

/**
 * The whole report as JSON, schema symplint/report/3; NULL if `report` is NULL. Valid until the report is freed.
 *
 * # Safety
 * `report` is NULL or was not freed.
 */
const char *symplint_report_json(const SymplintReport *report);

/**
 * Frees a report and its texts; NULL is allowed.
 *
 * # Safety
 * `report` is NULL or was not freed before.
 */
void symplint_report_free(SymplintReport *report);

/**
 * The error message of the last call on this thread that returns a status; empty if there was no error.
 *
 * In UTF-8. It is valid until the next call on this thread.
 */
const char *symplint_last_error(void);

/**
 * The version of the library, such as "0.1.0". The text is always valid.
 */
const char *symplint_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SYMPLINT_H */
