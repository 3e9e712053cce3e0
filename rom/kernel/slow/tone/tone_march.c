/* Amplitudes on one tone by the exponential Runge-Kutta method of fourth order of Cox and Matthews,
 * J. Comput. Phys. 176 (2002), with steps by an error estimate. */
#include <math.h>

#include "base/cnumber.h"
#include "base/exact_sum.h"
#include "slow/tone/tone_flow.h"

/* Periods of a step. More than four would pass over beats between the modes without seeing them. */
#define LONGEST 4.0
#define SHORTEST 1e-3

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
static void coefficients(sm_tone_flow *f, double h, double frequency) {
    const sm_tone_modes *modes = &f->tone.slow;
    const int M = modes->count;
    for (int k = 0; k < M; k++) {
        const sm_complex z = sm_cx(h * modes->pole[k], h * (modes->pole[M + k] - frequency));
        sm_complex half[4], phi[4];
        phi_functions(sm_cscale(z, 0.5), half);
        double_argument(half, phi);
        const sm_complex w[SM_TONE_WEIGHTS] = {
            half[0],
            phi[0],
            sm_cscale(half[1], 0.5 * h),
            sm_cscale(sm_cmul(half[1], sm_csub(half[0], sm_cx(1.0, 0.0))), 0.5 * h),
            sm_cscale(sm_cadd(sm_csub(phi[1], sm_cscale(phi[2], 3.0)), sm_cscale(phi[3], 4.0)), h),
            sm_cscale(sm_csub(phi[2], sm_cscale(phi[3], 2.0)), 2.0 * h),
            sm_cscale(sm_csub(sm_cscale(phi[3], 4.0), phi[2]), h),
        };
        for (int i = 0; i < SM_TONE_WEIGHTS; i++) {
            f->weight[2 * i * M + k] = w[i].re;
            f->weight[(2 * i + 1) * M + k] = w[i].im;
        }
    }
}

/* to = (add ? to : 0) + weight * x, mode by mode. */
static void weigh(const sm_tone_flow *f, int weight, const double *x, int add, double *to) {
    const int M = f->tone.slow.count;
    const double *re = f->weight + 2 * weight * M, *im = re + M;
    for (int k = 0; k < M; k++) {
        const double a = re[k] * x[k] - im[k] * x[M + k], b = re[k] * x[M + k] + im[k] * x[k];
        to[k] = add ? to[k] + a : a;
        to[M + k] = add ? to[M + k] + b : b;
    }
}

enum { HALF, WHOLE, TO_HALF, LAST_PART, FIRST, MIDDLE, LAST };

/* `next` and the load there, from a and its load, between times after the inputs' start [s].
 * `power` is that dissipated in the middle. */
static sm_status step(sm_tone_flow *f, double from, double to, double *power) {
    const int size = 2 * f->tone.slow.count;
    const double middle = 0.5 * (from + to);
    double *stage = f->next; /* not needed before the last sum */
    sm_status status = SM_OK;
    weigh(f, HALF, f->amplitude, 0, stage);
    weigh(f, TO_HALF, f->stage[0], 1, stage);
    if ((status = sm_tone_load(f, middle, stage, f->stage[1])) != SM_OK) return status;
    weigh(f, HALF, f->amplitude, 0, f->end);
    weigh(f, TO_HALF, f->stage[1], 1, f->end);
    if ((status = sm_tone_load(f, middle, f->end, f->stage[2])) != SM_OK) return status;
    *power = f->now->power;
    /* the second half step, from the first half step, with the load 2 n_3 - n_1 */
    weigh(f, WHOLE, f->amplitude, 0, stage);
    weigh(f, LAST_PART, f->stage[0], 1, stage);
    for (int i = 0; i < size; i++) f->end[i] = 2.0 * f->stage[2][i];
    weigh(f, TO_HALF, f->end, 1, stage);
    if ((status = sm_tone_load(f, to, stage, f->stage[3])) != SM_OK) return status;
    weigh(f, WHOLE, f->amplitude, 0, f->next);
    weigh(f, FIRST, f->stage[0], 1, f->next);
    weigh(f, MIDDLE, f->stage[1], 1, f->next);
    weigh(f, MIDDLE, f->stage[2], 1, f->next);
    weigh(f, LAST, f->stage[3], 1, f->next);
    return sm_tone_load(f, to, f->next, f->end);
}

/* Estimated error relative to the amplitudes: with the load at the end instead of that of the last
 * stage, the method is another one of third order or more. */
static double error_of(sm_tone_flow *f) {
    const int size = 2 * f->tone.slow.count;
    double *difference = f->stage[3];
    for (int i = 0; i < size; i++) difference[i] -= f->end[i];
    double *error = f->stage[2];
    weigh(f, LAST, difference, 0, error);
    double sum = 0.0, before = 0.0, after = 0.0;
    for (int i = 0; i < size; i++) {
        sum += error[i] * error[i];
        before += f->amplitude[i] * f->amplitude[i];
        after += f->next[i] * f->next[i];
    }
    return sum > 0.0 ? sqrt(sum / fmax(before, after)) : sum;
}

sm_status sm_tone_march(sm_tone_flow *f, double from, double to) {
    sm_tone_state *now = f->now;
    const double rate = now->inputs.frequency_rate[0], duration = to - from;
    const double start = now->inputs.frequency[0] + rate * from;
    const size_t bytes = 2 * (size_t)f->tone.slow.count * sizeof(double);
    const double period = SM_TWO_PI / fmax(start, start + rate * duration);
    /* A sweep turns the phase by |Omega'| h^2 / 8 against a constant frequency. */
    const double slow = sqrt(8.0 * f->tolerance / fabs(rate));
    const double longest = fmin(LONGEST * period, slow);
    double h = now->step > 0.0 ? fmin(now->step, longest) : fmin(period, longest);
    double time = from, power[3] = {now->power};
    while (time < to) {
        const double left = to - time;
        /* Two steps rather than one and a rest. */
        const double taken = h >= left ? left : fmin(h, 0.5 * left);
        const double end = taken == left ? to : time + taken;
        coefficients(f, taken, now->inputs.frequency[0] + 0.5 * (time + end) * rate);
        const sm_status status = step(f, time, end, power + 1);
        if (status != SM_OK) return status;
        const double error = error_of(f) / f->tolerance;
        if (isnan(error)) return SM_NOT_FINITE;
        const double grow = error > 0.0 ? fmin(fmax(0.9 * pow(error, -0.25), 0.2), 2.0) : 2.0;
        if (error > 1.0) {
            f->rejected++;
            h = grow * taken;
            if (h < SHORTEST * period) return SM_STEP_TOO_SMALL;
            continue;
        }
        f->accepted++;
        time = end;
        power[2] = now->power;
        sm_add(&now->energy, taken / 6.0 * (power[0] + 4.0 * power[1] + power[2]));
        power[0] = power[2];
        if (grow < 1.0 || taken == h) h = fmin(grow * taken, longest);
        memcpy(f->amplitude, f->next, bytes);
        memcpy(f->stage[0], f->end, bytes);
    }
    now->step = h;
    return SM_OK;
}
