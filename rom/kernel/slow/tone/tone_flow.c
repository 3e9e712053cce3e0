/* Force deficits of the contacts on one tone, and the loads on its modes (docs/theory.md, "Several
 * modes on one tone"). The drives c and the deficits y = k(|c|) c of the contacts depend on each
 * other through all modes; a fixed-point iteration finds them. Fast modes are steady: their
 * response is computed once per band of frequency. Called by tone_march.c and tone_entries.c. */
#include "slow/tone/tone_flow.h"

#include <math.h>

#include "base/cnumber.h"
#include "base/lanes.h"

#define MAX_ITERATIONS 60 /* of the deficits; weakly coupled contacts need one or two */
#define BLOCK SM_VECTOR   /* rows that are computed together */
/* Width of the bands of frequency, relative to the reference frequency [-]: within a band the
 * response of the fast modes changes by less than 1e-3. */
#define BAND 2e-3

/* Adds `count` (a literal) successive rows of the product of sm_tone_add_product; the sums stay in
 * registers. */
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

/* Adds the product of sm_tone_add_product, compiled for the vectors of the calling function. */
SM_INLINE void add_product(int rows, int columns, const double *matrix, const double *x,
                           double *to) {
    int i = 0;
    for (; i + BLOCK <= rows; i += BLOCK)
        add_rows(BLOCK, rows, columns, matrix + i, x, to + i);
    for (; i < rows; i++) add_rows(1, rows, columns, matrix + i, x, to + i);
}

SM_HOT void sm_tone_add_product(int rows, int columns, const double *matrix, const double *x,
                                double *to) {
    add_product(rows, columns, matrix, x, to);
}

void sm_tone_steady(const sm_tone_modes *modes, double frequency, double *rates) {
    const int M = modes->count;
    for (int m = 0; m < M; m++) {
        const sm_complex pole = sm_cx(-modes->pole[m], frequency - modes->pole[M + m]);
        const sm_complex steady = sm_cdiv(sm_cx(rates[m], rates[M + m]), pole);
        rates[m] = steady.re;
        rates[M + m] = steady.im;
    }
}

double sm_tone_band(const sm_tone *tone, double frequency) {
    return round((frequency / tone->reference - 1.0) / BAND);
}

double sm_tone_edge(const sm_tone *tone, double band, int way) {
    return tone->reference * (1.0 + (band + 0.5 * way) * BAND);
}

void sm_tone_enter_band(sm_tone_flow *flow, double band) {
    const sm_tone *tone = &flow->tone;
    const sm_tone_modes *fast = &tone->fast;
    const size_t n = (size_t)tone->contacts, M = (size_t)fast->count;
    const double frequency = tone->reference * (1.0 + band * BAND);
    flow->now->band = band;
    memcpy(flow->others, tone->flexibility, 2 * n * (n + 1) * sizeof(double));
    for (size_t j = 0; j <= n; j++) {
        const double *rates = j < n ? fast->projection + 2 * M * j : fast->excitation;
        memcpy(flow->fast, rates, 2 * M * sizeof(double));
        sm_tone_steady(fast, frequency, flow->fast);
        sm_tone_add_product(tone->contacts, fast->count, fast->motion, flow->fast,
                            flow->others + 2 * n * j);
    }
}

/* Computes y = k(|c|) c of one contact. `scale` is the ratio of the friction limits to the limits
 * of the tables; k is interpolated by cubic Hermite polynomials in log(|c| / onset - 1). */
SM_INLINE void contact_deficit(const sm_tone *tone, int kind, double scale, const double c[2],
                               double y[2]) {
    const double past = sqrt(c[0] * c[0] + c[1] * c[1]) / (scale * tone->onset) - 1.0;
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

/* Computes drives and deficits from the last deficits; returns the relative change of the
 * deficits. */
SM_INLINE double iterate(sm_tone_flow *flow, double scale) {
    const sm_tone *tone = &flow->tone;
    const int n = tone->contacts;
    memcpy(flow->drive, flow->given, 2 * (size_t)n * sizeof(double));
    add_product(n, n, flow->others, flow->deficit, flow->drive);
    double change = 0.0, all = 0.0;
    for (int j = 0; j < n; j++) {
        const double c[2] = {flow->drive[j], flow->drive[n + j]};
        double y[2];
        contact_deficit(tone, j % tone->kinds, scale, c, y);
        for (int i = 0; i < 2; i++) {
            const double difference = y[i] - flow->deficit[i * n + j];
            change += difference * difference;
            all += y[i] * y[i];
            flow->deficit[i * n + j] = y[i];
        }
    }
    return change > 0.0 ? sqrt(change / all) : 0.0;
}

/* Returns the mean over a period of the power that the contacts dissipate [W]. */
static double dissipated(const sm_tone_flow *flow, double frequency) {
    const int n = flow->tone.contacts;
    const double *c = flow->drive, *y = flow->deficit, *own = flow->tone.own + n;
    double sum = 0.0;
    for (int j = 0; j < n; j++)
        sum += y[j] * c[n + j] - y[n + j] * c[j] + own[j] * (y[j] * y[j] + y[n + j] * y[n + j]);
    return 2.0 * frequency * sum;
}

SM_HOT sm_status sm_tone_load(sm_tone_flow *flow, double elapsed, const double *amplitude,
                              double *load) {
    const sm_tone *tone = &flow->tone;
    const sm_inputs *in = &flow->now->inputs;
    const double phase = in->phase[0] + elapsed * in->phase_rate[0];
    const sm_complex force =
        sm_cscale(sm_unit(phase), in->force[0] + elapsed * in->force_rate[0]);
    const double scale = in->limit_scale + elapsed * in->limit_scale_rate;
    const int n = tone->contacts, M = tone->slow.count;
    const double magnitude[2] = {force.re, force.im};
    memset(flow->given, 0, 2 * (size_t)n * sizeof(double));
    add_product(n, 1, flow->others + 2 * (size_t)n * (size_t)n, magnitude, flow->given);
    add_product(n, M, tone->slow.motion, amplitude, flow->given);
    int iterations = 0;
    /* the error of the deficits is the contraction times their last change */
    while (!(tone->contraction * iterate(flow, scale) <= flow->tolerance))
        if (++iterations >= MAX_ITERATIONS) return SM_NOT_CONVERGED;
    memset(load, 0, 2 * (size_t)M * sizeof(double));
    add_product(M, 1, tone->slow.excitation, magnitude, load);
    add_product(M, n, tone->slow.projection, flow->deficit, load);
    flow->now->power = dissipated(flow, in->frequency[0] + elapsed * in->frequency_rate[0]);
    return SM_OK;
}
