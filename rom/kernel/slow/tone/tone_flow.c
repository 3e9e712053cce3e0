/* Force deficits of the contacts at one tone, and the loads on its modes. */
#include "slow/tone/tone_flow.h"

#include <math.h>

#include "base/lanes.h"

#define MOST_ITERATIONS 60 /* where contacts hardly act on each other, one or two */
#define BLOCK 8            /* rows side by side, of the widest vectors */

void sm_tone_flow_place(sm_tone_flow *flow, const sm_tone *tone, sm_block *block) {
    double **vectors[] = {&flow->given, &flow->drive, &flow->deficit};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++)
        *vectors[i] = sm_take(block, 2 * (size_t)tone->contacts);
}

/* As add_product, for `count` (a literal) neighbouring rows: sums stay in registers. */
SM_INLINE void add_rows(const int count, int rows, int columns, const double *restrict matrix,
                        const double *restrict x, double *restrict to) {
    double re_re[BLOCK] = {0.0}, re_im[BLOCK] = {0.0}, im_re[BLOCK] = {0.0}, im_im[BLOCK] = {0.0};
    for (int j = 0; j < columns; j++, matrix += 2 * rows) {
        SM_SIMD
        for (int i = 0; i < count; i++) {
            re_re[i] += matrix[i] * x[j];
            im_im[i] += matrix[rows + i] * x[columns + j];
            re_im[i] += matrix[i] * x[columns + j];
            im_re[i] += matrix[rows + i] * x[j];
        }
    }
    for (int i = 0; i < count; i++) {
        to[i] += re_re[i] - im_im[i];
        to[rows + i] += re_im[i] + im_re[i];
    }
}

/* to += matrix x, with `columns` columns of `rows` complex numbers. */
SM_INLINE void add_product(int rows, int columns, const double *matrix, const double *x,
                           double *to) {
    int i = 0;
    for (; i + BLOCK <= rows; i += BLOCK)
        add_rows(BLOCK, rows, columns, matrix + i, x, to + i);
    for (; i < rows; i++) add_rows(1, rows, columns, matrix + i, x, to + i);
}

/* y = k(|c|) c of one contact. */
SM_INLINE void contact_deficit(const sm_tone *tone, int kind, const double c[2], double y[2]) {
    const double past = sqrt(c[0] * c[0] + c[1] * c[1]) / tone->onset - 1.0;
    y[0] = y[1] = 0.0;
    if (!(past > 0.0)) return;
    const double place = (log(past) - tone->first) / tone->spacing;
    if (!(place > 0.0)) return;
    const double end = tone->nodes - 1.0, inside = place < end ? place : end;
    const int node = (int)fmin(inside, end - 1.0);
    const double t = inside - node, u = 1.0 - t;
    const double weight[4] = {u * u * (1.0 + 2.0 * t), u * u * t, t * t * (1.0 + 2.0 * u),
                              -t * t * u};
    const double *from = tone->secant + 4 * ((size_t)node * (size_t)tone->kinds + (size_t)kind);
    const double *to = from + 4 * tone->kinds;
    double k[2];
    for (int part = 0; part < 2; part++)
        k[part] = weight[0] * from[part] + weight[1] * from[2 + part] + weight[2] * to[part]
                  + weight[3] * to[2 + part];
    y[0] = k[0] * c[0] - k[1] * c[1];
    y[1] = k[0] * c[1] + k[1] * c[0];
}

/* One iteration: new deficits from the last ones. Returns their change, relative to them. */
SM_INLINE double iterate(sm_tone_flow *flow) {
    const sm_tone *tone = flow->tone;
    const int n = tone->contacts;
    memcpy(flow->drive, flow->given, 2 * (size_t)n * sizeof(double));
    add_product(n, n, tone->others, flow->deficit, flow->drive);
    double change = 0.0, all = 0.0;
    for (int j = 0; j < n; j++) {
        const double c[2] = {flow->drive[j], flow->drive[n + j]};
        double y[2];
        contact_deficit(tone, j % tone->kinds, c, y);
        for (int i = 0; i < 2; i++) {
            const double moved = y[i] - flow->deficit[i * n + j];
            change += moved * moved;
            all += y[i] * y[i];
            flow->deficit[i * n + j] = y[i];
        }
    }
    return change > 0.0 ? sqrt(change / all) : 0.0;
}

SM_HOT sm_status sm_tone_flow_load(sm_tone_flow *flow, double part, const double *amplitude,
                                   double *load) {
    const sm_tone *tone = flow->tone;
    const double *force_at = flow->inputs->force;
    const double force = force_at[0] + part * (force_at[1] - force_at[0]);
    const int n = tone->contacts, M = tone->modes;
    const double *by_force = tone->others + 2 * (size_t)n * (size_t)n;
    for (int i = 0; i < 2 * n; i++) flow->given[i] = force * by_force[i];
    add_product(n, M, tone->motion, amplitude, flow->given);
    int iterations = 0;
    /* The error is the change times the contraction. */
    while (!(tone->contraction * iterate(flow) <= tone->tolerance))
        if (++iterations >= MOST_ITERATIONS) return SM_NOT_CONVERGED;
    for (int i = 0; i < 2 * M; i++) load[i] = force * tone->excitation[i];
    add_product(M, n, tone->projection, flow->deficit, load);
    return SM_OK;
}
