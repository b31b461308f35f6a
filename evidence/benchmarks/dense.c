/* The contact scheme of the paper as one would write it down: dense matrices of the reduced model,
 * one speed at a time. Reads a binary problem, marches it, prints seconds and a checksum.
 *
 *   u_{n+1} = A1 u_n + A2 u_{n-1} (no contact), penetrations, Gauss-Seidel multipliers, correction.
 *
 * Built by the benchmark with gcc -O3 -march=native -ffast-math.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double *read_doubles(FILE *file, size_t n)
{
    double *values = malloc(n * sizeof *values);
    if (!values || fread(values, sizeof *values, n, file) != n) exit(1);
    return values;
}

int main(int argc, char **argv)
{
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
    long head[4]; /* dof, contact points, table rows, steps */
    double scalar[3]; /* step, growth time, clearance */
    if (!file || fread(head, sizeof *head, 4, file) != 4) return 1;
    if (fread(scalar, sizeof *scalar, 3, file) != 3) return 1;
    const long n = head[0], c = head[1], rows = head[2], steps = head[3];
    double *A1 = read_doubles(file, n * n), *A2 = read_doubles(file, n * n);
    double *push = read_doubles(file, n * c); /* motion per unit multiplier, column per point */
    double *W = read_doubles(file, c * c), *bump = read_doubles(file, rows * c);
    double *u = calloc(n, sizeof *u), *before = calloc(n, sizeof *u), *next = calloc(n, sizeof *u);
    double depth[256], lambda[256];
    struct timespec t0, t1;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t0);
    for (long step = 0; step < steps; step++) {
        const double t = (step + 1) * scalar[0];
        const double s = t < scalar[1] ? (1 - exp(-5 * t / scalar[1])) / (1 - exp(-5.0)) : 1.0;
        for (long i = 0; i < n; i++) {
            double sum = 0;
            for (long j = 0; j < n; j++) sum += A1[i * n + j] * u[j] + A2[i * n + j] * before[j];
            next[i] = sum;
        }
        int touching = 0;
        for (long i = 0; i < c; i++) {
            depth[i] = next[i] + s * bump[(step % rows) * c + i] - scalar[2];
            lambda[i] = 0;
            touching |= depth[i] > 0;
        }
        for (int sweep = 0; touching && sweep < 500; sweep++) {
            double change = 0, largest = 0;
            for (long i = 0; i < c; i++) {
                double d = depth[i];
                for (long j = 0; j < c; j++)
                    if (j != i) d -= W[i * c + j] * lambda[j];
                const double new = d > 0 ? d / W[i * c + i] : 0;
                change = fmax(change, fabs(new - lambda[i]));
                largest = fmax(largest, new);
                lambda[i] = new;
            }
            if (change <= 1e-12 * largest) break;
        }
        if (touching)
            for (long i = 0; i < n; i++)
                for (long j = 0; j < c; j++) next[i] += push[i * c + j] * lambda[j];
        double *old = before;
        before = u, u = next, next = old;
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t1);
    double largest = 0;
    for (long i = c; i < 2 * c; i++) largest = fmax(largest, fabs(u[i]));
    printf("%.9g %.9g\n", t1.tv_sec - t0.tv_sec + 1e-9 * (t1.tv_nsec - t0.tv_nsec), largest);
    return 0;
}
