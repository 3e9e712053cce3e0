/* Amplitudes on one tone by the exponential Runge-Kutta method of fourth order of Cox and Matthews,
 * J. Comput. Phys. 176 (2002), with steps by an error estimate. */
#include <math.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "base/exact_sum.h"
#include "slow/tone/tone_flow.h"

#define STAGES 4
#define WEIGHTS 7 /* per mode: see coefficients() */
/* Periods of a step. More than four would pass over beats between the modes without seeing them. */
#define LONGEST 4.0
#define SHORTEST 1e-3
#define MAX_SIZE 16384 /* modes, contacts, nodes: counts of doubles fit in 32 bits */

typedef struct {
    sm_tone_flow flow;
    double *a, *next;     /* (2, M) */
    double *load[STAGES]; /* (2, M) at the stages; the first is at a */
    double *end;          /* (2, M) load at the next amplitudes */
    double *weight;       /* (WEIGHTS, 2, M) */
} march;

static void place(march *m, const sm_tone *tone, sm_block *block) {
    const size_t size = 2 * (size_t)tone->modes;
    sm_tone_flow_place(&m->flow, tone, block);
    m->a = sm_take(block, size);
    m->next = sm_take(block, size);
    for (int stage = 0; stage < STAGES; stage++) m->load[stage] = sm_take(block, size);
    m->end = sm_take(block, size);
    m->weight = sm_take(block, WEIGHTS * size);
}

/* phi_k(z) = sum_j z^j / (j + k)!, phi[0] = exp(z). Real parts of z are not positive. */
static void phi_functions(sm_complex z, sm_complex phi[4]) {
    phi[0] = sm_cscale(sm_unit(z.im), exp(z.re));
    if (sm_cabs2(z) > 1.0) {
        double factor = 1.0; /* phi_k(0) = 1 / k! */
        for (int k = 1; k < 4; k++) {
            phi[k] = sm_cdiv(sm_csub(phi[k - 1], sm_cx(factor, 0.0)), z);
            factor /= k;
        }
        return;
    }
    /* By its series where differences would lose digits: 18 terms to 1e-17. */
    sm_complex sum = sm_cx(0.0, 0.0);
    for (int j = 18; j > 0; j--)
        sum = sm_cadd(sm_cx(1.0, 0.0), sm_cscale(sm_cmul(z, sum), 1.0 / (j + 3.0)));
    phi[3] = sm_cscale(sum, 1.0 / 6.0);
    phi[2] = sm_cadd(sm_cmul(z, phi[3]), sm_cx(0.5, 0.0));
    phi[1] = sm_cadd(sm_cmul(z, phi[2]), sm_cx(1.0, 0.0));
}

/* phi_k(2 z) from phi_k(z) */
static void double_argument(const sm_complex phi[4], sm_complex to[4]) {
    const sm_complex one = sm_cx(1.0, 0.0);
    to[0] = sm_cmul(phi[0], phi[0]);
    to[1] = sm_cscale(sm_cmul(phi[1], sm_cadd(phi[0], one)), 0.5);
    to[2] = sm_cscale(sm_cadd(sm_cmul(phi[1], phi[1]), sm_cscale(phi[2], 2.0)), 0.25);
    to[3] = sm_cadd(sm_cmul(phi[2], sm_cadd(phi[1], one)), sm_cscale(phi[3], 2.0));
    to[3] = sm_cscale(to[3], 0.125);
}

/* Weights of a step h at a mean frequency: exp(z / 2), exp(z), and h times phi_1(z / 2) / 2,
 * phi_1(z / 2), and of the first, the middle and the last stage. */
static void coefficients(march *m, double h, double frequency) {
    const sm_tone *tone = m->flow.tone;
    const int M = tone->modes;
    for (int k = 0; k < M; k++) {
        const sm_complex z = sm_cx(h * tone->pole[k], h * (tone->pole[M + k] - frequency));
        sm_complex half[4], phi[4];
        phi_functions(sm_cscale(z, 0.5), half);
        double_argument(half, phi);
        const sm_complex w[WEIGHTS] = {
            half[0],
            phi[0],
            sm_cscale(half[1], 0.5 * h),
            sm_cscale(sm_cmul(half[1], sm_csub(half[0], sm_cx(1.0, 0.0))), 0.5 * h),
            sm_cscale(sm_cadd(sm_csub(phi[1], sm_cscale(phi[2], 3.0)), sm_cscale(phi[3], 4.0)), h),
            sm_cscale(sm_csub(phi[2], sm_cscale(phi[3], 2.0)), 2.0 * h),
            sm_cscale(sm_csub(sm_cscale(phi[3], 4.0), phi[2]), h),
        };
        for (int i = 0; i < WEIGHTS; i++) {
            m->weight[2 * i * M + k] = w[i].re;
            m->weight[(2 * i + 1) * M + k] = w[i].im;
        }
    }
}

/* to = (add ? to : 0) + weight * x, mode by mode. */
static void weigh(const march *m, int weight, const double *x, int add, double *to) {
    const int M = m->flow.tone->modes;
    const double *re = m->weight + 2 * weight * M, *im = re + M;
    for (int k = 0; k < M; k++) {
        const double a = re[k] * x[k] - im[k] * x[M + k], b = re[k] * x[M + k] + im[k] * x[k];
        to[k] = add ? to[k] + a : a;
        to[M + k] = add ? to[M + k] + b : b;
    }
}

enum { HALF, WHOLE, TO_HALF, LAST_PART, FIRST, MIDDLE, LAST };

/* `next` and the load there, from a and its load; `from` and `to` are parts of the march. */
static sm_status step(march *m, double from, double to) {
    const int size = 2 * m->flow.tone->modes;
    const double middle = 0.5 * (from + to);
    double *stage = m->next; /* not needed before the last sum */
    sm_status status = SM_OK;
    weigh(m, HALF, m->a, 0, stage);
    weigh(m, TO_HALF, m->load[0], 1, stage);
    if ((status = sm_tone_flow_load(&m->flow, middle, stage, m->load[1])) != SM_OK) return status;
    weigh(m, HALF, m->a, 0, m->end);
    weigh(m, TO_HALF, m->load[1], 1, m->end);
    if ((status = sm_tone_flow_load(&m->flow, middle, m->end, m->load[2])) != SM_OK) return status;
    /* the second half step, from the first half step, with the load 2 n_3 - n_1 */
    weigh(m, WHOLE, m->a, 0, stage);
    weigh(m, LAST_PART, m->load[0], 1, stage);
    for (int i = 0; i < size; i++) m->end[i] = 2.0 * m->load[2][i];
    weigh(m, TO_HALF, m->end, 1, stage);
    if ((status = sm_tone_flow_load(&m->flow, to, stage, m->load[3])) != SM_OK) return status;
    weigh(m, WHOLE, m->a, 0, m->next);
    weigh(m, FIRST, m->load[0], 1, m->next);
    weigh(m, MIDDLE, m->load[1], 1, m->next);
    weigh(m, MIDDLE, m->load[2], 1, m->next);
    weigh(m, LAST, m->load[3], 1, m->next);
    return sm_tone_flow_load(&m->flow, to, m->next, m->end);
}

/* Estimated error relative to the amplitudes: with the load at the end instead of that of the last
 * stage, the method is another one of third order or more. */
static double error_of(march *m) {
    const int size = 2 * m->flow.tone->modes;
    double *difference = m->load[3];
    for (int i = 0; i < size; i++) difference[i] -= m->end[i];
    double *error = m->load[2];
    weigh(m, LAST, difference, 0, error);
    double sum = 0.0, before = 0.0, after = 0.0;
    for (int i = 0; i < size; i++) {
        sum += error[i] * error[i];
        before += m->a[i] * m->a[i];
        after += m->next[i] * m->next[i];
    }
    return sum > 0.0 ? sqrt(sum / fmax(before, after)) : sum;
}

static sm_status check_numbers(const sm_tone *tone, const sm_tone_inputs *inputs) {
    const double positive[] = {tone->onset, tone->spacing, tone->tolerance, inputs->frequency[0],
                               inputs->frequency[1]};
    sm_status status = sm_check_not_negative(inputs->duration);
    for (size_t i = 0; i < sizeof positive / sizeof *positive && status == SM_OK; i++)
        status = sm_check_positive(positive[i]);
    if (status == SM_OK) status = sm_check_not_negative(tone->contraction);
    if (status != SM_OK) return status;
    return isfinite(tone->first) && sm_all_finite(inputs->force, 2) ? SM_OK : SM_NOT_FINITE;
}

static sm_status check(const sm_tone *tone, const sm_tone_inputs *inputs, const double *amplitude,
                       const double *deficit, const double *step_size) {
    if (!tone || !inputs || !amplitude || !deficit || !step_size) return SM_BAD_ARGUMENT;
    if (tone->modes < 1 || tone->modes > MAX_SIZE || tone->contacts < 1
        || tone->contacts > MAX_SIZE || tone->nodes < 2 || tone->nodes > MAX_SIZE
        || tone->kinds < 1 || tone->contacts % tone->kinds != 0)
        return SM_BAD_ARGUMENT;
    const size_t M = 2 * (size_t)tone->modes, n = (size_t)tone->contacts;
    const struct {
        const double *values;
        size_t count;
    } arrays[] = {{tone->pole, M},
                  {tone->excitation, M},
                  {tone->motion, M * n},
                  {tone->projection, M * n},
                  {tone->others, 2 * n * (n + 1)},
                  {tone->secant, 4 * (size_t)tone->nodes * (size_t)tone->kinds},
                  {amplitude, M},
                  {deficit, 2 * n}};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        if (!arrays[i].values) return SM_BAD_ARGUMENT;
        if (!sm_all_finite(arrays[i].values, arrays[i].count)) return SM_NOT_FINITE;
    }
    const sm_status status = check_numbers(tone, inputs);
    return status == SM_OK ? sm_check_not_negative(*step_size) : status;
}

static sm_status run(march *m, double *suggested) {
    const sm_tone *tone = m->flow.tone;
    const sm_tone_inputs *in = m->flow.inputs;
    const size_t bytes = 2 * (size_t)tone->modes * sizeof(double);
    const double swept = in->frequency[1] - in->frequency[0];
    const double period = SM_TWO_PI / fmax(in->frequency[0], in->frequency[1]);
    /* A sweep turns the phase by |Omega'| h^2 / 8 against a constant frequency. */
    const double slow = sqrt(8.0 * tone->tolerance * in->duration / fabs(swept));
    const double longest = fmin(LONGEST * period, slow);
    double h = *suggested > 0.0 ? fmin(*suggested, longest) : fmin(period, longest);
    sm_status status = sm_tone_flow_load(&m->flow, 0.0, m->a, m->load[0]);
    double time = 0.0;
    while (status == SM_OK && time < in->duration) {
        const double left = in->duration - time;
        /* Two steps rather than one and a rest. */
        const double taken = h >= left ? left : fmin(h, 0.5 * left);
        const double from = time / in->duration;
        const double to = taken == left ? 1.0 : (time + taken) / in->duration;
        coefficients(m, taken, in->frequency[0] + 0.5 * (from + to) * swept);
        if ((status = step(m, from, to)) != SM_OK) return status;
        const double error = error_of(m) / tone->tolerance;
        if (isnan(error)) return SM_NOT_FINITE;
        const double grow = error > 0.0 ? fmin(fmax(0.9 * pow(error, -0.25), 0.2), 2.0) : 2.0;
        if (error > 1.0) {
            h = grow * taken;
            if (h < SHORTEST * period) return SM_STEP_TOO_SMALL;
            continue;
        }
        time = taken == left ? in->duration : time + taken;
        if (grow < 1.0 || taken == h) h = fmin(grow * taken, longest);
        memcpy(m->a, m->next, bytes);
        memcpy(m->load[0], m->end, bytes);
    }
    *suggested = h;
    return status;
}

sm_status sm_tone_march(const sm_tone *tone, const sm_tone_inputs *inputs, double *amplitude,
                        double *deficit, double *step_size) {
    sm_status status = check(tone, inputs, amplitude, deficit, step_size);
    if (status != SM_OK) return status;
    march m = {.flow = {.tone = tone, .inputs = inputs}};
    sm_block block = {NULL, 0};
    const size_t a_size = 2 * (size_t)tone->modes, y_size = 2 * (size_t)tone->contacts;
    double suggested = *step_size;
    place(&m, tone, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    place(&m, tone, &block);
    memcpy(m.a, amplitude, a_size * sizeof(double));
    memcpy(m.flow.deficit, deficit, y_size * sizeof(double));
    status = run(&m, &suggested);
    if (status == SM_OK
        && !(sm_all_finite(m.a, a_size) && sm_all_finite(m.flow.deficit, y_size)))
        status = SM_NOT_FINITE;
    if (status == SM_OK) {
        memcpy(amplitude, m.a, a_size * sizeof(double));
        memcpy(deficit, m.flow.deficit, y_size * sizeof(double));
        *step_size = suggested;
    }
    free(block.memory);
    return status;
}
