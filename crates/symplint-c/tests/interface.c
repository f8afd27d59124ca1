/* The C interface with good and with bad arguments: every error is a status with a text, and none ends the program. */

/* fork, alarm */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <symplint.h>
#include <sys/wait.h>
#include <unistd.h>

static int failures = 0;

#define CHECK(condition)                                                                \
    do {                                                                                \
        if (!(condition)) {                                                             \
            failures++;                                                                 \
            printf("line %d: %s; \"%s\"\n", __LINE__, #condition, symplint_last_error()); \
        }                                                                               \
    } while (0)

/* Whether the last error has these words. */
static int says(const char *words) { return strstr(symplint_last_error(), words) != NULL; }

enum { NONE, RETURNS_AT_ONE, RETURNS, NOT_A_NUMBER, MEMORY };

struct user {
    int fault;
    size_t dof, calls, states;
};

/* Symplectic Euler for pendula that are coupled to the first one. */
static int step(void *pointer, double h, size_t dof, size_t samples, double *q, double *p) {
    struct user *user = pointer;
    user->calls++;
    user->states += samples;
    if (dof != user->dof) return 99;
    for (size_t i = 0; i < dof; i++)
        for (size_t k = 0; k < samples; k++)
            p[i * samples + k] -= h * (sin(q[i * samples + k]) + 0.1 * (i + 1) * sin(q[k]) * (i == 0));
    for (size_t k = 0; k < dof * samples; k++) q[k] += h * p[k];
    switch (user->fault) {
    case RETURNS_AT_ONE: return h == 0.125 ? 17 : 0;
    case RETURNS: return 17;
    case NOT_A_NUMBER: p[dof * samples - 1] = NAN; return 0;
    case MEMORY: q[0] += 1e-3 * (double)user->calls; return 0;
    default: return 0;
    }
}

/* A kick that takes position i of sample k from q[k * dof + i]. */
static int transposed(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    (void)user;
    for (size_t k = 0; k < samples; k++)
        for (size_t i = 0; i < dof; i++) p[k * dof + i] -= h * sin(q[k * dof + i] - q[k * dof]);
    return 0;
}

/* The standard map on the torus. */
static int standard_map(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    const double turn = 6.283185307179586;
    (void)user;
    if (h != floor(h)) return 1;
    for (size_t k = 0; k < dof * samples; k++) {
        p[k] += 0.9 * h * sin(q[k]);
        q[k] += h * p[k];
        p[k] -= turn * floor(p[k] / turn);
        q[k] -= turn * floor(q[k] / turn);
    }
    return 0;
}

/* A momentum that is wrapped: its period has to be stated. */
static void torus(void) {
    const double q0[1] = {3.0}, p0[1] = {6.0}, turn[1] = {6.283185307179586}, sizes[2] = {2, 1}, bad[1] = {-1};
    SymplintReport *report = NULL;
    SymplintOptions options;
    symplint_options_init(&options, sizeof options);
    CHECK(options.momentum_period == NULL);
    options.step_sizes = sizes;
    options.step_count = 2;
    options.radius = 0.5;
    options.period = turn;
    options.momentum_period = turn;
    CHECK(symplint_check(standard_map, NULL, 1, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_report_verdict(report) == SYMPLINT_VERDICT_SYMPLECTIC);
    symplint_report_free(report);
    options.momentum_period = NULL;
    CHECK(symplint_check(standard_map, NULL, 1, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_report_verdict(report) != SYMPLINT_VERDICT_SYMPLECTIC);
    symplint_report_free(report);
    options.momentum_period = bad;
    CHECK(symplint_check(standard_map, NULL, 1, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("period") && report == NULL);
}

/* The fringe field of a magnet: h is no time. */
static int edge(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    double *calls = user;
    *calls += 1;
    for (size_t k = 0; k < samples * dof; k++) {
        if (h != 1.0) return 1;
        p[k] /= 1 + 0.3 * q[k] * q[k];
        q[k] += 0.1 * q[k] * q[k] * q[k];
    }
    return 0;
}

static void no_step_size(void) {
    const double q0[1] = {2e-3}, p0[1] = {1e-3};
    double calls[2] = {0, 0};
    SymplintReport *report = NULL;
    SymplintOptions options;
    symplint_options_init(&options, sizeof options);
    CHECK(options.no_step_size == 0 && options.repeat == 1);
    options.no_step_size = 1;
    options.radius = 8e-3;
    for (size_t k = 0; k < 2; k++) {
        CHECK(symplint_check(edge, &calls[k], 1, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
        CHECK(symplint_report_verdict(report) == SYMPLINT_VERDICT_SYMPLECTIC);
        CHECK(strstr(symplint_report_json(report), "\"step_size\": null") != NULL);
        symplint_report_free(report);
        options.repeat = 3;
    }
    CHECK(calls[1] > calls[0]);
    options.repeat = 0;
    CHECK(symplint_check(edge, calls, 1, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("repeat") && report == NULL);
}

/* The same forward and backward in time, and by a step of -h. */
static int leapfrog(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    (void)user;
    for (size_t k = 0; k < samples * dof; k++) {
        q[k] += 0.5 * h * p[k];
        p[k] -= h * sin(q[k]);
        q[k] += 0.5 * h * p[k];
    }
    return 0;
}

/* A leapfrog whose momenta stand still at 1: no signs reverse it, but p -> 2 - p does. */
static int shifted(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    for (size_t k = 0; k < samples * dof; k++) p[k] -= 1;
    int status = leapfrog(user, h, dof, samples, q, p);
    for (size_t k = 0; k < samples * dof; k++) p[k] += 1;
    return status;
}

/* p -> *user - p, which is its own inverse; 0 for a function that is not, below 0 for a failure. */
static int reflect(void *user, size_t dof, size_t samples, double *q, double *p) {
    const double sum = *(double *)user;
    (void)q;
    for (size_t k = 0; k < samples * dof; k++) p[k] = sum > 0 ? sum - p[k] : -2 * p[k];
    return sum < 0 ? 5 : 0;
}

static void reversal_function(void) {
    const double q0[2] = {0.3, -0.2}, p0[2] = {1.5, 1.1}, signs[4] = {1, 1, -1, -1};
    double sum = 2;
    SymplintReport *report = NULL;
    SymplintOptions options;
    symplint_options_init(&options, sizeof options);
    CHECK(options.reversal_function == NULL);
    CHECK(symplint_check(shifted, &sum, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"not time-reversible (step, p → −p, step") != NULL);
    symplint_report_free(report);
    options.reversal_function = reflect;
    CHECK(symplint_check(shifted, &sum, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"time-reversible (step, the given reversal, step") != NULL);
    symplint_report_free(report);
    sum = 3;
    CHECK(symplint_check(shifted, &sum, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"not time-reversible (step, the given reversal, step") != NULL);
    symplint_report_free(report);
    sum = 0;
    CHECK(symplint_check(shifted, &sum, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("its own inverse") && report == NULL);
    sum = -1;
    CHECK(symplint_check(shifted, &sum, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_STEP_FAILED);
    CHECK(says("the reversal returned 5") && report == NULL);
    options.reversal = signs;
    CHECK(symplint_check(shifted, &sum, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("both reversal and reversal_function") && report == NULL);
}

static void properties(void) {
    const double q0[2] = {0.3, -0.2}, p0[2] = {0.5, 0.1};
    const double kept[4] = {1, 1, 1, 1}, flipped[4] = {-1, 1, 1, -1}, bad[4] = {1, 1, 2, -1};
    SymplintReport *report = NULL;
    SymplintOptions options;
    symplint_options_init(&options, sizeof options);
    CHECK(options.properties == 1 && options.symmetric == 0 && options.reversal == NULL);
    options.symmetric = 1;
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"symmetric") != NULL);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"time-reversible") != NULL);
    symplint_report_free(report);
    options.symmetric = 0;
    options.reversal = kept;
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"not time-reversible") != NULL);
    symplint_report_free(report);
    /* The first pair mirrored as a whole, time reversed in both: sin is odd. */
    options.reversal = flipped;
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"text\": \"time-reversible") != NULL);
    symplint_report_free(report);
    options.reversal = bad;
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("sign") && report == NULL);
    options.reversal = NULL;
    options.properties = 0;
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "reversible") == NULL);
    symplint_report_free(report);
    /* A key of configurations without a field here. */
    options.settings = "{\"sample_sweep\": {\"from\": 16, \"to\": 32, \"step_size\": 0.5}, \"loops\": 2}";
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "\"sweep\": \"samples\"") != NULL);
    symplint_report_free(report);
    options.settings = "{\"closure\": \"chord\"}";
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("closure is \"chord\"; give") && report == NULL);
    options.settings = "loops = 2";
    CHECK(symplint_check(leapfrog, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("not a JSON object") && report == NULL);
}

struct parts {
    double friction;
    size_t fails, calls;
};

/* Drift, kick, drift, and a damping of the momenta. */
static int part(void *pointer, size_t substep, double h, size_t dof, size_t samples, double *q, double *p) {
    struct parts *user = pointer;
    user->calls++;
    if (substep == user->fails) return 17;
    for (size_t k = 0; k < samples * dof; k++) switch (substep) {
        case 0:
        case 2: q[k] += 0.5 * h * p[k]; break;
        case 1: p[k] -= h * sin(q[k]); break;
        default: p[k] *= 1 - h * user->friction;
        }
    return 0;
}

static void substeps(void) {
    const double q0[2] = {0.3, -0.2}, p0[2] = {0.5, 0.1};
    const char *const names[4] = {"drift", "kick", NULL, "damping"};
    struct parts user = {0, 9, 0};
    SymplintReport *report = NULL;
    SymplintOptions options;
    symplint_options_init(&options, sizeof options);
    options.substep = part;
    options.substep_count = 4;
    options.substep_names = names;
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_report_verdict(report) == SYMPLINT_VERDICT_SYMPLECTIC && user.calls % 4 == 0);
    symplint_report_free(report);
    user.friction = 0.1;
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_report_verdict(report) == SYMPLINT_VERDICT_NOT_SYMPLECTIC);
    CHECK(strstr(symplint_report_json(report), "substep 4 (damping)") != NULL);
    symplint_report_free(report);
    /* Without the last one, and without names. */
    options.substep_count = 3;
    options.substep_names = NULL;
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_report_verdict(report) == SYMPLINT_VERDICT_SYMPLECTIC);
    symplint_report_free(report);
    user.fails = 2;
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_STEP_FAILED);
    CHECK(says("substep 3 (part 3) returned 17") && report == NULL);
    CHECK(symplint_check(leapfrog, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("step is NULL") && report == NULL);
    options.substep_count = 0;
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("substep_count"));
    options.substep_count = (size_t)-1;
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("from 1 to 1000000"));
}

static void checks(void) {
    const double q0[2] = {0.3, -0.2}, p0[2] = {0.5, 0.1}, sizes[2] = {0.5, 0.125}, bad_period[2] = {-1, 0};
    struct user user = {NONE, 2, 0, 0};
    SymplintReport *report = NULL;
    SymplintOptions options;
    CHECK(symplint_options_init(&options, sizeof options) == SYMPLINT_STATUS_OK);
    CHECK(options.size == sizeof options && options.budget == 20000 && options.loops == 8 && options.radius == 1.0);
    options.budget = 1500;
    options.step_sizes = sizes;
    options.step_count = 2;
    CHECK(symplint_check(step, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(*symplint_last_error() == 0);
    CHECK(symplint_report_verdict(report) == SYMPLINT_VERDICT_SYMPLECTIC);
    CHECK(symplint_report_digits(report) > 10 && isnan(symplint_report_order(report)));
    CHECK(user.states > 200 && user.states <= 1500);
    const char *json = symplint_report_json(report);
    char made[64];
    snprintf(made, sizeof made, "\"made\": %zu", user.states);
    CHECK(strstr(json, "\"schema\": \"symplint/report/3\"") && strstr(json, made) && strstr(json, "\"budget\": 1500"));
    CHECK(strstr(symplint_report_summary(report), "symplectic") == symplint_report_summary(report));
    CHECK(strstr(symplint_report_text(report), "2 degrees of freedom") && strstr(symplint_report_text(report), "Relative change"));

    /* Threads of the library change nothing, and there is a check on every thread count. */
    char *first = malloc(strlen(json) + 1);
    strcpy(first, json);
    *strstr(first, "\"provenance\"") = 0;
    symplint_report_free(report);
    options.threads = 2;
    CHECK(symplint_check(step, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strncmp(first, symplint_report_json(report), strlen(first)) == 0);
    free(first);
    symplint_report_free(report);

    /* Faults of the step. */
    user.fault = RETURNS_AT_ONE;
    CHECK(symplint_check(step, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_report_json(report), "The step size h = 0.125 was left out") != NULL);
    CHECK(strstr(symplint_report_json(report), "the step returned 17") != NULL);
    symplint_report_free(report);
    user.fault = RETURNS;
    CHECK(symplint_check(step, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_STEP_FAILED);
    CHECK(says("the step returned 17") && says("h = 0.5") && report == NULL);
    user.fault = NOT_A_NUMBER;
    CHECK(symplint_check(step, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_STEP_FAILED);
    CHECK(says("p[1] is NaN"));
    user.fault = MEMORY;
    CHECK(symplint_check(step, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_FAILED);
    CHECK(says("the result depends on earlier calls"));
    user.fault = NONE;
    CHECK(symplint_check(transposed, NULL, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_FAILED);
    CHECK(says("other rows of the batch") && says("q[i * samples + k]"));

    /* Bad arguments. */
    const double infinite[2] = {INFINITY, 0};
    CHECK(symplint_check(NULL, &user, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_NULL_POINTER && says("step"));
    CHECK(symplint_check(step, &user, 2, NULL, p0, &options, &report) == SYMPLINT_STATUS_NULL_POINTER && says("q0"));
    CHECK(symplint_check(step, &user, 2, q0, NULL, NULL, &report) == SYMPLINT_STATUS_NULL_POINTER && says("p0"));
    CHECK(symplint_check(step, &user, 2, q0, p0, NULL, NULL) == SYMPLINT_STATUS_NULL_POINTER && says("report"));
    CHECK(symplint_check(step, &user, 0, q0, p0, NULL, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("dof"));
    CHECK(symplint_check(step, &user, (size_t)-1, q0, p0, NULL, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(symplint_check(step, &user, 2, infinite, p0, NULL, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("inf"));

    SymplintOptions bad = options;
    bad.rule = "simpson";
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("simpson"));
    bad = options, bad.phases = "golden";
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("golden"));
    bad = options, bad.period = bad_period;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("period"));
    bad = options, bad.budget = 10;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("budget"));
    bad = options, bad.radius = 0;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("radius is 0"));
    bad = options, bad.radius = -1;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("radius"));
    bad = options, bad.loops = 0;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("loops"));
    bad = options, bad.loops = 1000000000000000;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("loops is"));
    bad = options, bad.tolerance = NAN;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("tolerance"));
    bad = options, bad.step_count = 0;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("step_sizes"));
    bad = options, bad.samples = 2;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("samples"));
    bad = options, bad.size = 3;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("3 bytes"));
    bad = options, bad.size = sizeof bad + 8;
    CHECK(symplint_check(step, &user, 2, q0, p0, &bad, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("newer"));
    CHECK(symplint_options_init(NULL, sizeof bad) == SYMPLINT_STATUS_NULL_POINTER);

    CHECK(symplint_report_verdict(NULL) == SYMPLINT_VERDICT_NONE && symplint_report_json(NULL) == NULL);
    CHECK(isnan(symplint_report_digits(NULL)) && symplint_report_summary(NULL) == NULL && symplint_report_text(NULL) == NULL);
    symplint_report_free(NULL);
}

enum { DOF = 3, SAMPLES = 40, PADDED = 48 };

static int same(const SymplintIntegral *a, const SymplintIntegral *b) { return memcmp(a, b, sizeof *a) == 0; }

static void integrals(void) {
    static double rows[2][DOF][SAMPLES], padded[2][DOF][PADDED], columns[2][SAMPLES][DOF];
    const double weight[DOF] = {1, 2, -0.5}, no_weight[DOF] = {1, 0, 1};
    double expected = 0;
    for (int i = 0; i < DOF; i++) {
        /* The area of the ellipse with radii 1 + i and 2, times the weight. */
        expected += weight[i] * 6.283185307179586 * (1 + i);
        for (int k = 0; k < SAMPLES; k++) {
            double angle = 6.283185307179586 * k / SAMPLES;
            double state[2] = {0.2 + (1 + i) * sin(angle), i + 2 * cos(angle)};
            for (int c = 0; c < 2; c++) rows[c][i][k] = padded[c][i][k] = columns[c][k][i] = state[c];
        }
        for (int k = SAMPLES; k < PADDED; k++) padded[0][i][k] = padded[1][i][k] = NAN;
    }
    SymplintIntegral whole, other, parts[DOF];
    const double *q = rows[0][0], *p = rows[1][0];
    CHECK(symplint_loop_integral(DOF, SAMPLES, q, p, SAMPLES, 1, NULL, weight, &whole) == SYMPLINT_STATUS_OK);
    CHECK(fabs(whole.value - expected) < 1e-13 * expected && whole.quadrature_error < 1e-12 && whole.roundoff > 0);
    symplint_loop_integral(DOF, SAMPLES, padded[0][0], padded[1][0], PADDED, 1, NULL, weight, &other);
    CHECK(same(&whole, &other));
    symplint_loop_integral(DOF, SAMPLES, columns[0][0], columns[1][0], 1, DOF, NULL, weight, &other);
    CHECK(same(&whole, &other));

    /* One degree of freedom and two, as two processes have them. */
    symplint_partial_integrals(1, SAMPLES, q, p, SAMPLES, 1, NULL, weight, parts);
    symplint_partial_integrals(2, SAMPLES, rows[0][1], rows[1][1], SAMPLES, 1, NULL, weight + 1, parts + 1);
    CHECK(symplint_merge_integrals(DOF, parts, &other) == SYMPLINT_STATUS_OK && same(&whole, &other));

    SymplintDefect defect;
    other.value *= 1.5;
    CHECK(symplint_defect(&whole, &other, &defect) == SYMPLINT_STATUS_OK && fabs(defect.signed_defect - 0.5) < 1e-14);
    other.value = 0;
    CHECK(symplint_defect(&other, &whole, &defect) == SYMPLINT_STATUS_FAILED && says("no area"));
    other.value = NAN;
    CHECK(symplint_defect(&whole, &other, &defect) == SYMPLINT_STATUS_BAD_ARGUMENT && says("advanced"));
    CHECK(symplint_defect(NULL, &other, &defect) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_merge_integrals(0, parts, &other) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(symplint_merge_integrals(DOF, NULL, &other) == SYMPLINT_STATUS_NULL_POINTER);

    /* A winding position. */
    const double period[1] = {6.283185307179586};
    for (int k = 0; k < SAMPLES; k++) rows[0][0][k] = fmod(1 + period[0] * k / SAMPLES, period[0]), rows[1][0][k] = 3;
    CHECK(symplint_loop_integral(1, SAMPLES, q, p, SAMPLES, 1, period, NULL, &other) == SYMPLINT_STATUS_OK);
    CHECK(fabs(other.value - 3 * period[0]) < 1e-13);

    /* Bad arguments. */
    CHECK(symplint_loop_integral(0, SAMPLES, q, p, SAMPLES, 1, NULL, NULL, &other) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(symplint_loop_integral(1, 2, q, p, SAMPLES, 1, NULL, NULL, &other) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(symplint_loop_integral((size_t)-1 / 4, SAMPLES, q, p, SAMPLES, 1, NULL, NULL, &other) ==
              SYMPLINT_STATUS_BAD_ARGUMENT && says("too large"));
    CHECK(symplint_loop_integral(1, (size_t)1 << 55, q, p, SAMPLES, 1, NULL, NULL, &other) ==
              SYMPLINT_STATUS_BAD_ARGUMENT && says("take fewer samples"));
    CHECK(symplint_loop_integral(1, (size_t)-1 / 2, q, p, SAMPLES, 0, NULL, NULL, &other) ==
              SYMPLINT_STATUS_BAD_ARGUMENT && says("take fewer samples"));
    CHECK(symplint_loop_integral(1, SAMPLES, NULL, p, SAMPLES, 1, NULL, NULL, &other) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_loop_integral(1, SAMPLES, q, NULL, SAMPLES, 1, NULL, NULL, &other) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_loop_integral(1, SAMPLES, q, p, SAMPLES, 1, NULL, NULL, NULL) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_loop_integral(DOF, SAMPLES, q, p, SAMPLES, 1, NULL, no_weight, &other) ==
              SYMPLINT_STATUS_BAD_ARGUMENT && says("weight[1]"));
    const double *misaligned = (const double *)((const char *)q + 1);
    CHECK(symplint_loop_integral(1, SAMPLES - 1, misaligned, p, SAMPLES, 1, NULL, NULL, &other) ==
              SYMPLINT_STATUS_BAD_ARGUMENT && says("aligned"));
    rows[1][2][7] = NAN;
    CHECK(symplint_loop_integral(DOF, SAMPLES, q, p, SAMPLES, 1, NULL, NULL, &other) ==
              SYMPLINT_STATUS_BAD_ARGUMENT && says("p[2] is NaN at sample 7"));
}

/* A process that was forked has the memory of its parent and none of its threads. */
static void forked(void) {
    const double q[4] = {0, 1, 0, -1}, p[4] = {1, 0, -1, 0};
    SymplintIntegral before, after;
    CHECK(symplint_loop_integral(1, 4, q, p, 4, 1, NULL, NULL, &before) == SYMPLINT_STATUS_OK);
    pid_t child = fork();
    if (child == 0) {
        alarm(60);
        SymplintStatus found = symplint_loop_integral(1, 4, q, p, 4, 1, NULL, NULL, &after);
        _exit(found != SYMPLINT_STATUS_OK || !same(&before, &after));
    }
    int ended = -1;
    CHECK(child > 0 && waitpid(child, &ended, 0) == child && ended == 0);
}

/* With an argument, what valgrind must not see: it counts what the threads of a parent have allocated as lost in the child. */
struct force_user {
    double curl;
    int fault;
    size_t states;
};

/* The gradient of -q0² q1²/2, and a rotation. */
static int force(void *pointer, size_t dof, size_t samples, const double *q, double *f) {
    struct force_user *user = pointer;
    const double *x = q, *y = q + samples;
    user->states += samples;
    if (dof != 2) return 99;
    for (size_t k = 0; k < samples; k++) {
        f[k] = -x[k] * y[k] * y[k] - user->curl * y[k];
        f[samples + k] = -x[k] * x[k] * y[k] + user->curl * x[k];
    }
    if (user->fault == NOT_A_NUMBER) f[0] = NAN;
    return user->fault == RETURNS ? 17 : 0;
}

/* Two pendula of different mass in velocities, with friction. */
static int field(void *pointer, size_t dof, size_t samples, const double *q, const double *v, double *q_rate, double *v_rate) {
    const double friction = *(const double *)pointer, mass[2] = {1, 3};
    for (size_t i = 0; i < dof; i++)
        for (size_t k = 0; k < samples; k++) {
            const size_t at = i * samples + k, other = (1 - i) * samples + k;
            q_rate[at] = v[at];
            v_rate[at] = (-sin(q[at]) - 0.3 * sin(q[at] - q[other])) / mass[i] - friction * v[at];
        }
    return 0;
}

/* Forces and vector fields. */
static void fields(void) {
    const double q0[2] = {1, 0.5}, p0[2] = {0.5, -0.2}, weight[2] = {1, 3}, radii[2] = {0.1, 0.1}, bad[2] = {-1, 1};
    struct force_user user = {0, NONE, 0};
    double error = 0, friction = 0;
    SymplintFieldReport *report = NULL, *again = NULL;
    SymplintFieldOptions options;

    CHECK(symplint_check_force(force, &user, 2, q0, NULL, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_field_report_verdict(report) == SYMPLINT_FIELD_VERDICT_HOLDS);
    CHECK(symplint_field_report_digits(report) > 12);
    CHECK(symplint_field_report_curl(report, &error) < error && error < 1e-12);
    CHECK(strstr(symplint_field_report_summary(report), "gradient to ") != NULL);
    CHECK(strstr(symplint_field_report_text(report), "GRADIENT to ") != NULL);
    CHECK(strstr(symplint_field_report_json(report), "\"schema\":\"symplint/field/1\"") != NULL);
    CHECK(user.states > 100 && user.states < 20000);
    CHECK(symplint_check_force(force, &user, 2, q0, NULL, &again) == SYMPLINT_STATUS_OK);
    CHECK(strcmp(symplint_field_report_json(report), symplint_field_report_json(again)) == 0);
    symplint_field_report_free(report);
    symplint_field_report_free(again);

    user.curl = 1e-6;
    CHECK(symplint_check_force(force, &user, 2, q0, NULL, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_field_report_verdict(report) == SYMPLINT_FIELD_VERDICT_FAILS);
    CHECK(isnan(symplint_field_report_digits(report)));
    CHECK(symplint_field_report_curl(report, NULL) > 1e-8);
    CHECK(strstr(symplint_field_report_text(report), "NOT A GRADIENT") != NULL);
    symplint_field_report_free(report);

    /* Velocities are no momenta, but with masses as weights. */
    CHECK(symplint_check_field(field, &friction, 2, q0, p0, NULL, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_field_report_verdict(report) == SYMPLINT_FIELD_VERDICT_FAILS);
    symplint_field_report_free(report);
    CHECK(symplint_field_options_init(&options, sizeof options) == SYMPLINT_STATUS_OK);
    CHECK(options.loops == 4 && options.budget == 20000 && options.radius == 0);
    options.weight = weight;
    options.radius_q = options.radius_p = radii;
    CHECK(symplint_check_field(field, &friction, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(symplint_field_report_verdict(report) == SYMPLINT_FIELD_VERDICT_HOLDS);
    symplint_field_report_free(report);
    friction = 0.1;
    CHECK(symplint_check_field(field, &friction, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_OK);
    CHECK(strstr(symplint_field_report_text(report), "uniform friction") != NULL);
    symplint_field_report_free(report);

    /* Errors. */
    user.fault = RETURNS;
    options.radius_q = options.radius_p = NULL;
    options.radius = 0.1;
    CHECK(symplint_check_force(force, &user, 2, q0, &options, &report) == SYMPLINT_STATUS_STEP_FAILED);
    CHECK(report == NULL && says("returned 17"));
    user.fault = NOT_A_NUMBER;
    CHECK(symplint_check_force(force, &user, 2, q0, &options, &report) == SYMPLINT_STATUS_STEP_FAILED && says("NaN"));
    CHECK(symplint_check_force(NULL, NULL, 2, q0, NULL, &report) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_check_force(force, &user, 2, NULL, NULL, &report) == SYMPLINT_STATUS_NULL_POINTER && says("q0"));
    CHECK(symplint_check_force(force, &user, 2, q0, NULL, NULL) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_check_force(force, &user, 0, q0, NULL, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(symplint_check_field(field, &friction, 2, q0, NULL, NULL, &report) == SYMPLINT_STATUS_NULL_POINTER && says("p0"));
    options.budget = 99;
    CHECK(symplint_check_force(force, &user, 2, q0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("budget"));
    options.budget = 1000;
    options.radius_q = bad;
    CHECK(symplint_check_force(force, &user, 2, q0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("radius"));
    options.radius = 0;
    CHECK(symplint_check_field(field, &friction, 2, q0, p0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(says("radius_p"));
    options.size = 1000;
    CHECK(symplint_check_force(force, &user, 2, q0, &options, &report) == SYMPLINT_STATUS_BAD_ARGUMENT && says("bytes"));
    CHECK(symplint_field_options_init(&options, 8) == SYMPLINT_STATUS_BAD_ARGUMENT);
    CHECK(symplint_field_options_init(NULL, sizeof options) == SYMPLINT_STATUS_NULL_POINTER);
    CHECK(symplint_field_report_verdict(NULL) == SYMPLINT_FIELD_VERDICT_NONE);
    CHECK(isnan(symplint_field_report_digits(NULL)) && isnan(symplint_field_report_curl(NULL, &error)) && isnan(error));
    CHECK(symplint_field_report_summary(NULL) == NULL && symplint_field_report_text(NULL) == NULL);
    CHECK(symplint_field_report_json(NULL) == NULL);
    symplint_field_report_free(NULL);
}

int main(int count, char **arguments) {
    (void)arguments;
    if (count > 1) {
        forked();
        return failures != 0;
    }
    CHECK(strlen(symplint_version()) >= 5);
    checks();
    torus();
    no_step_size();
    properties();
    reversal_function();
    substeps();
    integrals();
    fields();
    printf("%d failures\n", failures);
    return failures != 0;
}
