/* Time integration of the amplitudes on the tones, a' = (s - i Omega) a + load (docs/theory.md,
 * "Several modes on one tone"), by the exponential Runge-Kutta method of fourth order of Cox and
 * Matthews, J. Comput. Phys. 176 (2002), with step size control. tone_entries.c calls it. */
#include <math.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "base/exact_sum.h"
#include "slow/tone/tone_flow.h"

/* Longest and shortest step [periods]. Longer steps than four periods would not resolve beats
 * between the modes. */
#define LONGEST 4.0
#define SHORTEST 1e-3

#define ORDER 4.0      /* of the error estimate */
#define MAX_FACTOR 2.0 /* of successive steps */

/* Terms of the series of phi_3 for |z| <= 1: the first neglected one is 3! / 22! < 1e-20. */
#define SERIES_TERMS 18

/* Computes phi_k(z) = sum_j z^j / (j + k)!, k < 4, for Re z <= 0; phi[0] = exp(z). */
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
    /* the series, where differences would lose digits */
    sm_complex sum = sm_cx(0.0, 0.0);
    for (int j = SERIES_TERMS; j > 0; j--)
        sum = sm_cadd(sm_cx(1.0, 0.0), sm_cscale(sm_cmul(z, sum), 1.0 / (j + 3.0)));
    phi[3] = sm_cscale(sum, 1.0 / 6.0);
    phi[2] = sm_cadd(sm_cmul(z, phi[3]), sm_cx(0.5, 0.0));
    phi[1] = sm_cadd(sm_cmul(z, phi[2]), sm_cx(1.0, 0.0));
}

/* Computes phi_k(2 z) from phi_k(z). */
static void double_argument(const sm_complex phi[4], sm_complex to[4]) {
    const sm_complex one = sm_cx(1.0, 0.0);
    to[0] = sm_cmul(phi[0], phi[0]);
    to[1] = sm_cscale(sm_cmul(phi[1], sm_cadd(phi[0], one)), 0.5);
    to[2] = sm_cscale(sm_cadd(sm_cmul(phi[1], phi[1]), sm_cscale(phi[2], 2.0)), 0.25);
    to[3] = sm_cadd(sm_cmul(phi[2], sm_cadd(phi[1], one)), sm_cscale(phi[3], 2.0));
    to[3] = sm_cscale(to[3], 0.125);
}

/* Weights of a step, in the order of `set_weights`. */
enum { HALF, WHOLE, TO_HALF, LAST_PART, FIRST, MIDDLE, LAST };

/* Computes the weights of a step h, with z = h (s - i Omega) at the frequencies `middle` seconds after
 * the inputs' start, for each mode: exp(z / 2) and exp(z) of the amplitude; h phi_1(z / 2) / 2 of the
 * load over half a step, and times exp(z / 2) - 1; then of the loads at the start, in the middle
 * (twice) and at the end. */
static void set_weights(sm_tone_flow *f, double h, double middle) {
    const sm_inputs *in = &f->now->inputs;
    double *weight = f->weight;
    for (int t = 0; t < f->tone.tones; t++) {
        const sm_tone_modes *modes = &f->tone.carrier[t].slow;
        const double frequency = in->frequency[t] + middle * in->frequency_rate[t];
        const int M = modes->count;
        for (int k = 0; k < M; k++) {
            const sm_complex z = sm_cx(h * modes->pole[k], h * (modes->pole[M + k] - frequency));
            sm_complex half[4], phi[4];
            phi_functions(sm_cscale(z, 0.5), half);
            double_argument(half, phi);
            const sm_complex third = sm_csub(phi[1], sm_cscale(phi[2], 3.0));
            const sm_complex w[SM_TONE_WEIGHTS] = {
                half[0],
                phi[0],
                sm_cscale(half[1], 0.5 * h),
                sm_cscale(sm_cmul(half[1], sm_csub(half[0], sm_cx(1.0, 0.0))), 0.5 * h),
                sm_cscale(sm_cadd(third, sm_cscale(phi[3], 4.0)), h),
                sm_cscale(sm_csub(phi[2], sm_cscale(phi[3], 2.0)), 2.0 * h),
                sm_cscale(sm_csub(sm_cscale(phi[3], 4.0), phi[2]), h),
            };
            for (size_t i = 0; i < SM_TONE_WEIGHTS; i++) {
                weight[i * f->amplitudes + (size_t)k] = w[i].re;
                weight[i * f->amplitudes + (size_t)(M + k)] = w[i].im;
            }
        }
        weight += 2 * M;
    }
}

/* Computes the product of a weight and x for each mode; adds it to `to` if `add`. */
static void apply_weight(const sm_tone_flow *f, int weight, const double *x, int add, double *to) {
    const double *re = f->weight + (size_t)weight * f->amplitudes;
    for (int t = 0; t < f->tone.tones; t++) {
        const int M = f->tone.carrier[t].slow.count;
        const double *im = re + M;
        for (int k = 0; k < M; k++) {
            const double a = re[k] * x[k] - im[k] * x[M + k], b = re[k] * x[M + k] + im[k] * x[k];
            to[k] = add ? to[k] + a : a;
            to[M + k] = add ? to[M + k] + b : b;
        }
        re += 2 * M;
        x += 2 * M;
        to += 2 * M;
    }
}

/* Makes a step between two times after the inputs' start [s]: computes the amplitudes `next` at
 * its end, the load there in `end`, and the `power` dissipated in its middle. */
static sm_status step(sm_tone_flow *f, double from, double to, double *power) {
    const size_t size = f->amplitudes;
    const double middle = 0.5 * (from + to);
    double *stage = f->next; /* not needed before the last sum */
    apply_weight(f, HALF, f->amplitude, 0, stage);
    apply_weight(f, TO_HALF, f->stage[0], 1, stage);
    SM_TRY(sm_tone_load(f, middle, stage, f->stage[1]));
    apply_weight(f, HALF, f->amplitude, 0, f->end);
    apply_weight(f, TO_HALF, f->stage[1], 1, f->end);
    SM_TRY(sm_tone_load(f, middle, f->end, f->stage[2]));
    *power = f->now->power;
    /* the second half step, from the first half step, with the load 2 n_3 - n_1 */
    apply_weight(f, WHOLE, f->amplitude, 0, stage);
    apply_weight(f, LAST_PART, f->stage[0], 1, stage);
    for (size_t i = 0; i < size; i++) f->end[i] = 2.0 * f->stage[2][i];
    apply_weight(f, TO_HALF, f->end, 1, stage);
    SM_TRY(sm_tone_load(f, to, stage, f->stage[3]));
    apply_weight(f, WHOLE, f->amplitude, 0, f->next);
    apply_weight(f, FIRST, f->stage[0], 1, f->next);
    apply_weight(f, MIDDLE, f->stage[1], 1, f->next);
    apply_weight(f, MIDDLE, f->stage[2], 1, f->next);
    apply_weight(f, LAST, f->stage[3], 1, f->next);
    return sm_tone_load(f, to, f->next, f->end);
}

/* Returns the estimated error relative to the amplitudes: the difference from a method, of third
 * order or higher, with the load at the end in place of the load of the last stage. */
static double error_of(sm_tone_flow *f) {
    const size_t size = f->amplitudes;
    double *difference = f->stage[3];
    for (size_t i = 0; i < size; i++) difference[i] -= f->end[i];
    double *error = f->stage[2];
    apply_weight(f, LAST, difference, 0, error);
    double sum = 0.0, before = 0.0, after = 0.0;
    for (size_t i = 0; i < size; i++) {
        sum += error[i] * error[i];
        before += f->amplitude[i] * f->amplitude[i];
        after += f->next[i] * f->next[i];
    }
    return sum > 0.0 ? sqrt(sum / fmax(before, after)) : sum;
}

sm_status sm_tone_march(sm_tone_flow *f, double from, double to) {
    sm_tone_state *now = f->now;
    const sm_inputs *in = &now->inputs;
    const size_t bytes = f->amplitudes * sizeof(double);
    double highest = 0.0, rate = 0.0; /* of all tones */
    for (int t = 0; t < f->tone.tones; t++) {
        const double start = in->frequency[t] + in->frequency_rate[t] * from;
        highest = fmax(highest, fmax(start, start + in->frequency_rate[t] * (to - from)));
        rate = fmax(rate, fabs(in->frequency_rate[t]));
    }
    const double period = SM_TWO_PI / highest;
    /* The phase of a sweep deviates by |Omega'| h^2 / 8 from the phase at the mean frequency. */
    const double longest = fmin(LONGEST * period, sqrt(8.0 * f->tolerance / rate));
    double h = now->step > 0.0 ? fmin(now->step, longest) : fmin(period, longest);
    double time = from, power[3] = {now->power};
    while (time < to) {
        const double left = to - time;
        /* two equal steps are better than a long and a very short one */
        const double taken = h >= left ? left : fmin(h, 0.5 * left);
        const double end = taken == left ? to : time + taken;
        set_weights(f, taken, 0.5 * (time + end));
        SM_TRY(step(f, time, end, power + 1));
        const double error = error_of(f) / f->tolerance;
        if (isnan(error)) return SM_NOT_FINITE;
        const double factor = sm_step_factor(error, ORDER, MAX_FACTOR);
        if (error > 1.0) {
            f->rejected++;
            h = factor * taken;
            if (h < SHORTEST * period) return SM_STEP_TOO_SMALL;
            continue;
        }
        f->accepted++;
        time = end;
        power[2] = now->power;
        sm_add(&now->energy, taken / 6.0 * (power[0] + 4.0 * power[1] + power[2])); /* Simpson */
        power[0] = power[2];
        if (factor < 1.0 || taken == h) h = fmin(factor * taken, longest);
        memcpy(f->amplitude, f->next, bytes);
        memcpy(f->stage[0], f->end, bytes);
    }
    now->step = h;
    return SM_OK;
}
