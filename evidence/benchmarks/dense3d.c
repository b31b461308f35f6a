/* The contact scheme in three directions as one would write it down: dense matrices of the reduced
 * model, one speed at a time. Reads a binary problem, marches it, prints seconds and a checksum.
 *
 *   u_{n+1} = A1 u_n + A2 u_{n-1} (no contact), penetrations, friction along the slip of the step
 *   before, contact forces by an active set that starts from the last one, correction.
 *
 * The first coordinates are the normal, tangential and axial displacements of the contact points.
 * Built by the benchmark with gcc -O3 -march=native -ffast-math.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MOST 64 /* points that are near the casing at a time */

static double *read_doubles(FILE *file, size_t n)
{
    double *values = malloc(n * sizeof *values);
    if (!values || fread(values, sizeof *values, n, file) != n) exit(1);
    return values;
}

/* Forces of the points that touch: a x = b by elimination, in place. */
static void solve(long n, double a[MOST][MOST], double *b)
{
    for (long p = 0; p < n; p++)
        for (long r = p + 1; r < n; r++) {
            const double factor = a[r][p] / a[p][p];
            for (long j = p + 1; j < n; j++) a[r][j] -= factor * a[p][j];
            b[r] -= factor * b[p];
        }
    for (long p = n - 1; p >= 0; p--) {
        for (long j = p + 1; j < n; j++) b[p] -= a[p][j] * b[j];
        b[p] /= a[p][p];
    }
}

int main(int argc, char **argv)
{
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
    long head[4]; /* dof, contact points, table rows, steps */
    double scalar[3]; /* step, growth time, friction */
    if (!file || fread(head, sizeof *head, 4, file) != 4) return 1;
    if (fread(scalar, sizeof *scalar, 3, file) != 3) return 1;
    const long n = head[0], c = head[1], rows = head[2], steps = head[3];
    double *A1 = read_doubles(file, n * n), *A2 = read_doubles(file, n * n);
    double *push = read_doubles(file, 3 * c * n); /* motion per unit force, a row per force */
    double *clearance = read_doubles(file, c), *way = read_doubles(file, c);
    double *bump = read_doubles(file, rows * c);
    double *u = calloc(n, sizeof *u), *before = calloc(n, sizeof *u), *next = calloc(n, sizeof *u);
    double *depth = calloc(c, sizeof *u);
    char *touching = calloc(c, 1);
    static double W[MOST][MOST], a[MOST][MOST];
    double along[MOST], across[MOST], force[MOST], b[MOST];
    long near[MOST], chosen[MOST];
    long failed = 0;
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
        double deepest = 0;
        for (long i = 0; i < c; i++) {
            depth[i] = next[i] + s * bump[(step % rows) * c + i] - clearance[i];
            deepest = fmax(deepest, depth[i]);
        }
        if (deepest > 0) {
            long m = 0;
            for (long i = 0; i < c && m < MOST; i++)
                if (depth[i] > -4 * deepest) near[m++] = i;
            for (long p = 0; p < m; p++) {
                const long i = near[p];
                const double x = way[i] + u[c + i] - before[c + i];
                const double y = u[2 * c + i] - before[2 * c + i];
                along[p] = scalar[2] * x / hypot(x, y);
                across[p] = scalar[2] * y / hypot(x, y);
                const double *N = push + i * n, *T = N + c * n, *A = T + c * n;
                for (long q = 0; q < m; q++)
                    W[q][p] = -N[near[q]] - along[p] * T[near[q]] - across[p] * A[near[q]];
            }
            int wrong = 1;
            for (int trial = 0; wrong && trial < 100; trial++) {
                long k = 0;
                for (long p = 0; p < m; p++)
                    if (touching[near[p]]) chosen[k++] = p;
                for (long p = 0; p < k; p++) {
                    b[p] = depth[near[chosen[p]]];
                    for (long q = 0; q < k; q++) a[p][q] = W[chosen[p]][chosen[q]];
                }
                solve(k, a, b);
                memset(force, 0, sizeof force);
                for (long p = 0; p < k; p++) force[chosen[p]] = b[p];
                wrong = 0;
                for (long p = m - 1; p >= 0 && !(wrong && trial > 12); p--) {
                    double left = depth[near[p]];
                    for (long q = 0; q < k; q++) left -= W[p][chosen[q]] * b[q];
                    if (touching[near[p]] ? force[p] < 0 : left > 1e-12 * deepest) {
                        touching[near[p]] ^= 1;
                        wrong = 1;
                    }
                }
            }
            failed += wrong;
            for (long p = 0; p < m; p++)
                if (force[p] > 0) {
                    const double *N = push + near[p] * n, *T = N + c * n, *A = T + c * n;
                    const double x = force[p] * along[p], y = force[p] * across[p];
                    for (long i = 0; i < n; i++) next[i] += force[p] * N[i] + x * T[i] + y * A[i];
                }
        }
        double *old = before;
        before = u, u = next, next = old;
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t1);
    double largest = 0;
    for (long i = c; i < 2 * c; i++) largest = fmax(largest, fabs(u[i]));
    printf("%.9g %.9g %ld\n", t1.tv_sec - t0.tv_sec + 1e-9 * (t1.tv_nsec - t0.tv_nsec), largest, failed);
    return 0;
}
