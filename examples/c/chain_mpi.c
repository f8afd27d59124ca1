/* A chain of coupled pendula whose degrees of freedom are spread over MPI ranks, one step of the Verlet method.
 *
 * Every rank has its pendula for all samples of a loop. It integrates p dq over them before and after the step, and the
 * parts of all ranks, in the order of the pendula, make the loop integrals: with the same bits on any number of ranks.
 *
 *   mpicc examples/c/chain_mpi.c $(pkg-config --cflags --libs symplint) -lm -o chain_mpi && mpirun -n 3 ./chain_mpi
 *
 * With the argument "euler" the step is one of the explicit Euler method. */

#include <math.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <symplint.h>

enum { PENDULA = 20, SAMPLES = 128, DOUBLES = sizeof(SymplintIntegral) / sizeof(double) };

static int rank, ranks, first, count;

/* The pendula of a rank: `count` rows, and room for the neighbours' rows before and after them. */
static double q[PENDULA + 2][SAMPLES], p[PENDULA][SAMPLES];

static int first_of(int r) { return PENDULA * r / ranks; }

/* Fetches the rows of the neighbours. Both ends of the chain are fixed at 0. */
static void exchange(void) {
    int before = rank > 0 ? rank - 1 : MPI_PROC_NULL, after = rank < ranks - 1 ? rank + 1 : MPI_PROC_NULL;
    memset(q[0], 0, sizeof q[0]);
    memset(q[count + 1], 0, sizeof q[0]);
    MPI_Sendrecv(q[count], SAMPLES, MPI_DOUBLE, after, 0, q[0], SAMPLES, MPI_DOUBLE, before, 0, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE);
    MPI_Sendrecv(q[1], SAMPLES, MPI_DOUBLE, before, 1, q[count + 1], SAMPLES, MPI_DOUBLE, after, 1, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE);
}

static double force(int i, int k) { return -sin(q[i][k]) + q[i - 1][k] - 2 * q[i][k] + q[i + 1][k]; }

static void kick(double h) {
    exchange();
    for (int i = 1; i <= count; i++)
        for (int k = 0; k < SAMPLES; k++) p[i - 1][k] += h * force(i, k);
}

static void drift(double h, double (*momenta)[SAMPLES]) {
    for (int i = 1; i <= count; i++)
        for (int k = 0; k < SAMPLES; k++) q[i][k] += h * momenta[i - 1][k];
}

static void check(SymplintStatus status) {
    if (status == SYMPLINT_STATUS_OK) return;
    fprintf(stderr, "rank %d: %s\n", rank, symplint_last_error());
    MPI_Abort(MPI_COMM_WORLD, 1);
}

/* The loop integral of the whole chain, on every rank. */
static SymplintIntegral integral(void) {
    SymplintIntegral parts[PENDULA], all[PENDULA], whole;
    int counts[ranks], starts[ranks];
    for (int r = 0; r < ranks; r++) {
        starts[r] = DOUBLES * first_of(r);
        counts[r] = DOUBLES * first_of(r + 1) - starts[r];
    }
    check(symplint_partial_integrals(count, SAMPLES, q[1], p[0], SAMPLES, 1, NULL, NULL, parts));
    MPI_Allgatherv(parts, DOUBLES * count, MPI_DOUBLE, all, counts, starts, MPI_DOUBLE, MPI_COMM_WORLD);
    check(symplint_merge_integrals(PENDULA, all, &whole));
    return whole;
}

int main(int argc, char **argv) {
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    if (ranks > PENDULA) MPI_Abort(MPI_COMM_WORLD, 1);
    first = first_of(rank);
    count = first_of(rank + 1) - first;
    const double tau = 6.283185307179586, h = 0.25;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < SAMPLES; k++) {
            /* A circle in every degree of freedom, each with a phase of its own. */
            double angle = tau * k / SAMPLES + 0.3 * (first + i);
            q[i + 1][k] = 0.4 + 0.5 * sin(angle);
            p[i][k] = 0.1 + 0.5 * cos(angle);
        }

    SymplintIntegral before = integral();
    if (argc > 1 && strcmp(argv[1], "euler") == 0) {
        static double momenta[PENDULA][SAMPLES];
        memcpy(momenta, p, sizeof p);
        kick(h);
        drift(h, momenta);
    } else {
        kick(0.5 * h);
        drift(h, p);
        kick(0.5 * h);
    }
    SymplintIntegral after = integral();
    SymplintDefect defect;
    check(symplint_defect(&before, &after, &defect));

    double uncertainty = defect.quadrature_error + defect.roundoff;
    int significant = !(fabs(defect.signed_defect) <= 10 * uncertainty);
    if (rank == 0) {
        /* In hexadecimal, every bit shows. */
        printf("before %a, after %a\n", before.value, after.value);
        printf("relative change %.1e, uncertain by %.1e: %s\n", defect.signed_defect, uncertainty,
               significant ? "not symplectic" : "no defect on this loop");
    }
    MPI_Finalize();
    return significant;
}
