/* A pendulum, by the Verlet method and by the explicit Euler method: which one is symplectic?
 *
 *   make -C crates/symplint-c install PREFIX=$HOME/.local
 *   export PKG_CONFIG_PATH=$HOME/.local/lib/pkgconfig LD_LIBRARY_PATH=$HOME/.local/lib
 *   gcc examples/c/pendulum.c $(pkg-config --cflags --libs symplint) -lm -o pendulum && ./pendulum */

#include <math.h>
#include <stdio.h>
#include <symplint.h>

/* All samples, one step. There is one degree of freedom, so q and p are one row each. */
static int verlet(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    (void)user;
    for (size_t k = 0; k < dof * samples; k++) {
        p[k] -= 0.5 * h * sin(q[k]);
        q[k] += h * p[k];
        p[k] -= 0.5 * h * sin(q[k]);
    }
    return 0;
}

static int euler(void *user, double h, size_t dof, size_t samples, double *q, double *p) {
    (void)user;
    for (size_t k = 0; k < dof * samples; k++) {
        double force = -sin(q[k]);
        q[k] += h * p[k];
        p[k] += h * force;
    }
    return 0;
}

static int check(const char *name, SymplintStep step) {
    const double q0[1] = {1.0}, p0[1] = {0.5};
    SymplintReport *report = NULL;
    if (symplint_check(step, NULL, 1, q0, p0, NULL, &report) != SYMPLINT_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", name, symplint_last_error());
        return SYMPLINT_VERDICT_NONE;
    }
    int verdict = symplint_report_verdict(report);
    printf("%s: %s\n", name, symplint_report_summary(report));
    symplint_report_free(report);
    return verdict;
}

int main(void) {
    int of_verlet = check("Verlet", verlet), of_euler = check("Euler", euler);
    return of_verlet == SYMPLINT_VERDICT_SYMPLECTIC && of_euler == SYMPLINT_VERDICT_NOT_SYMPLECTIC ? 0 : 1;
}
