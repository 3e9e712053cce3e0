/* Force deficits of the contacts on one or two tones, and the loads on the modes (docs/theory.md,
 * "Several modes on one tone"). The drives c and the deficits y = k c of the contacts depend on each
 * other through all modes; a fixed-point iteration finds them. Fast modes are steady: their
 * response is computed once per band of frequency. Called by tone_march.c and tone_entries.c. */
#include "slow/tone/tone_flow.h"

#include <math.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "base/hermite.h"
#include "base/lanes.h"

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

double sm_tone_band(const sm_tone *tone, int t, double frequency) {
    return round((frequency / tone->carrier[t].reference - 1.0) / BAND);
}

double sm_tone_edge(const sm_tone *tone, int t, double band, int way) {
    return tone->carrier[t].reference * (1.0 + (band + 0.5 * way) * BAND);
}

void sm_tone_enter_band(sm_tone_flow *flow, int t, double band) {
    const sm_tone *tone = &flow->tone;
    const sm_tone_carrier *carrier = &tone->carrier[t];
    const sm_tone_modes *fast = &carrier->fast;
    const size_t n = (size_t)tone->contacts, M = (size_t)fast->count, size = 2 * n * (n + 1);
    const double frequency = carrier->reference * (1.0 + band * BAND);
    double *others = flow->others + (size_t)t * size;
    flow->now->band[t] = band;
    memcpy(others, carrier->flexibility, size * sizeof(double));
    for (size_t j = 0; j <= n; j++) {
        const double *rates = j < n ? fast->projection + 2 * M * j : fast->excitation;
        memcpy(flow->fast, rates, 2 * M * sizeof(double));
        sm_tone_steady(fast, frequency, flow->fast);
        sm_tone_add_product(tone->contacts, fast->count, fast->motion, flow->fast,
                            others + 2 * n * j);
    }
}

/* Computes the weights of value and slope at both ends of the cell of a cubic Hermite polynomial
 * that contains `place`, from 0 to the last node. Returns the first node of the cell. */
SM_INLINE int hermite(double place, double last, double weight[4]) {
    const int node = (int)fmin(place, last - 1.0);
    const sm_hermite_weights value = sm_hermite_at(1.0, place - node).value;
    weight[0] = 1.0 - value.rise;
    weight[1] = value.bend[0];
    weight[2] = value.rise;
    weight[3] = value.bend[1];
    return node;
}

/* Computes the secants k (tones, 2) of a kind of contact at the moduli |c| of its drives. `scale` is
 * the ratio of the friction limits to the limits of the tables. */
SM_INLINE void secants(const int tones, const sm_tone *tone, int kind, double scale,
                       const double modulus[SM_MODES], double k[2 * SM_MODES]) {
    const double whole = tones > 1 ? modulus[0] + modulus[1] : modulus[0];
    const double past = whole / (scale * tone->onset[kind]) - 1.0;
    for (int i = 0; i < 2 * tones; i++) k[i] = 0.0;
    if (!(past > 0.0)) return;
    const double place = (log(past) - tone->first) / tone->spacing;
    if (!(place > 0.0)) return;
    const double last = tone->nodes - 1.0;
    double along[4], across[4] = {1.0};
    const int node = hermite(place < last ? place : last, last, along);
    int share = 0;
    if (tones > 1) {
        const double angle = atan2(sqrt(modulus[1]), sqrt(modulus[0])), end = tone->shares - 1.0;
        share = hermite(fmin(angle / (0.25 * SM_TWO_PI), 1.0) * end, end, across);
    }
    const size_t kinds = (size_t)tone->kinds, shares = (size_t)tone->shares;
    const size_t values = (size_t)(4 * tones * tones); /* of a kind at a node */
    const double *from =
        tone->secant + values * (((size_t)node * shares + (size_t)share) * kinds + (size_t)kind);
    const double *to = from + values * shares * kinds;
    for (int corner = 0; corner < tones; corner++, from += values * kinds, to += values * kinds)
        for (int i = 0; i < 2 * tones; i++)
            for (int order = 0; order < tones; order++) {
                const double *a = from + 2 * (i * tones + order), *b = to + (a - from);
                k[i] += across[2 * corner + order]
                        * (along[0] * a[0] + along[1] * a[1] + along[2] * b[0] + along[3] * b[1]);
            }
}

/* Computes drives and deficits from the last deficits; returns the relative change of the
 * deficits. `tones` is a literal. */
SM_INLINE double iterate(const int tones, sm_tone_flow *flow, double scale) {
    const sm_tone *tone = &flow->tone;
    const int n = tone->contacts;
    const size_t size = 2 * (size_t)n; /* of the contacts on one tone */
    memcpy(flow->drive, flow->given, (size_t)tones * size * sizeof(double));
    for (int t = 0; t < tones; t++)
        add_product(n, n, flow->others + (size_t)t * size * (size_t)(n + 1),
                    flow->deficit + (size_t)t * size, flow->drive + (size_t)t * size);
    double change = 0.0, all = 0.0;
    for (int j = 0; j < n; j++) {
        double modulus[SM_MODES], k[2 * SM_MODES];
        for (int t = 0; t < tones; t++) {
            const double *c = flow->drive + (size_t)t * size + j;
            modulus[t] = sqrt(c[0] * c[0] + c[n] * c[n]);
        }
        secants(tones, tone, j % tone->kinds, scale, modulus, k);
        for (int t = 0; t < tones; t++) {
            const double *c = flow->drive + (size_t)t * size + j;
            const double y[2] = {k[2 * t] * c[0] - k[2 * t + 1] * c[n],
                                 k[2 * t] * c[n] + k[2 * t + 1] * c[0]};
            for (int i = 0; i < 2; i++) {
                double *last = flow->deficit + (size_t)t * size + i * n + j;
                const double difference = y[i] - *last;
                change += difference * difference;
                all += y[i] * y[i];
                *last = y[i];
            }
        }
    }
    return change > 0.0 ? sqrt(change / all) : 0.0;
}

/* Returns the mean over the periods of the power that the contacts dissipate [W]. */
SM_INLINE double dissipated(const sm_tone_flow *flow, double elapsed) {
    const sm_inputs *in = &flow->now->inputs;
    const int n = flow->tone.contacts;
    const double *c = flow->drive, *y = flow->deficit;
    double power = 0.0;
    for (int t = 0; t < flow->tone.tones; t++, c += 2 * n, y += 2 * n) {
        const double *own = flow->tone.carrier[t].own + n;
        double sum = 0.0;
        for (int j = 0; j < n; j++)
            sum += y[j] * c[n + j] - y[n + j] * c[j]
                   + own[j] * (y[j] * y[j] + y[n + j] * y[n + j]);
        power += 2.0 * (in->frequency[t] + elapsed * in->frequency_rate[t]) * sum;
    }
    return power;
}

/* Finds the deficits `elapsed` seconds after the inputs' start. `tones` is a literal. */
SM_INLINE sm_status find_deficits(const int tones, sm_tone_flow *flow, double elapsed) {
    const sm_inputs *in = &flow->now->inputs;
    const double scale = in->limit_scale + elapsed * in->limit_scale_rate;
    int iterations = 0;
    /* the error of the deficits is the contraction times their last change */
    while (!(flow->tone.contraction * iterate(tones, flow, scale) <= flow->tolerance))
        if (++iterations >= SM_MAX_ITERATIONS) return SM_NOT_CONVERGED;
    return SM_OK;
}

SM_HOT sm_status sm_tone_load(sm_tone_flow *flow, double elapsed, const double *amplitude,
                              double *load) {
    const sm_tone *tone = &flow->tone;
    const sm_inputs *in = &flow->now->inputs;
    const int n = tone->contacts;
    const size_t size = 2 * (size_t)n, others = size * (size_t)(n + 1);
    double magnitude[SM_MODES][2];
    memset(flow->given, 0, (size_t)tone->tones * size * sizeof(double));
    for (int t = 0; t < tone->tones; t++) {
        const sm_tone_modes *slow = &tone->carrier[t].slow;
        const sm_complex force =
            sm_cscale(sm_unit(in->phase[t] + elapsed * in->phase_rate[t]),
                      in->force[t] + elapsed * in->force_rate[t]);
        double *given = flow->given + (size_t)t * size;
        magnitude[t][0] = force.re;
        magnitude[t][1] = force.im;
        add_product(n, 1, flow->others + (size_t)t * others + size * (size_t)n, magnitude[t],
                    given);
        add_product(n, slow->count, slow->motion, amplitude, given);
        amplitude += 2 * slow->count;
    }
    SM_TRY(tone->tones > 1 ? find_deficits(2, flow, elapsed) : find_deficits(1, flow, elapsed));
    memset(load, 0, flow->amplitudes * sizeof(double));
    for (int t = 0; t < tone->tones; t++) {
        const sm_tone_modes *slow = &tone->carrier[t].slow;
        add_product(slow->count, 1, slow->excitation, magnitude[t], load);
        add_product(slow->count, n, slow->projection, flow->deficit + (size_t)t * size, load);
        load += 2 * slow->count;
    }
    flow->now->power = dissipated(flow, elapsed);
    return SM_OK;
}
