/* Forces on the contacts along a segment of slow motion, eq. (12):
 *   u(t) = -2 Re sum_j L_j a_j exp(i theta_j) + Re sum_nm G_nm exp(i (n theta_A + m theta_B)),
 * with cubic amplitudes a_j and linear coefficients G_nm of the response of the modes. The time
 * integration of the contacts (contact_march.c) calls it. */
#ifndef SLIPMODE_FORCING_H
#define SLIPMODE_FORCING_H

#include "base/block.h"
#include "base/exact_sum.h"
#include "base/hermite.h"
#include "slow/motion/segment.h"

/* The forces on the contacts during an integration. At instants that are a step h apart, u and its
 * rate are exact. Between them, at the stages of shorter steps, u is a cubic, with the error
 * (nu h)^4 / 384 for a harmonic nu: 2e-6 for a carrier at 40 steps per period. At constant
 * frequencies the phasors are advanced by constant factors. */
typedef struct {
    const sm_contact *contact;
    const sm_segment *segment;
    double h;              /* between two instants [s] */
    int swept;             /* 1: the frequencies change during the segment */
    int since;             /* instants since the phasors were computed from their angles */
    sm_complex carrier[SM_MODES]; /* at the last instant */
    sm_complex factor[SM_MODES];  /* of the carriers from an instant to the next one */
    double *value, *rate;  /* (N_c) forces [N] at the last instant, and their rates times h [N] */
    double *before;        /* (2, N_c) value and rate at the instant before */
    int orders;            /* harmonics of the response on this segment */
    size_t row;            /* length of a row: `orders` of the contact, then 0 up to whole vectors */
    double *re, *im, *factor_re, *factor_im; /* (row) phasors of the harmonics, and their factors */
    double *turn;          /* (row) angles of the factors [rad] */
    double *start, *slope; /* (N_c, 2, row): real, imaginary parts of G, and change per segment */
} sm_forcing;

/* Places the arrays for up to `orders` harmonics of the response. */
static inline void sm_forcing_place(sm_forcing *f, int contacts, int orders, sm_block *block) {
    const size_t n = (size_t)contacts, row = sm_whole((size_t)orders, SM_SHORT_VECTOR);
    f->row = row;
    SM_TAKE_EACH(block, n, &f->value, &f->rate);
    f->before = sm_take(block, 2 * n);
    SM_TAKE_EACH(block, 2 * n * row, &f->start, &f->slope);
    SM_TAKE_EACH(block, row, &f->re, &f->im, &f->factor_re, &f->factor_im, &f->turn);
}

/* Returns the angle by which a carrier turns in a step at its present frequency [rad]. */
SM_INLINE double sm_forcing_angle(const sm_forcing *f, int j, double elapsed) {
    return f->h * (f->segment->frequency[j] + f->segment->frequency_rate[j] * elapsed);
}

/* Computes carriers, phasors and turns at a time of the segment from their angles. */
static inline void sm_forcing_set(sm_forcing *f, double elapsed) {
    f->since = 0;
    sm_segment_carriers(f->segment, f->contact->modes, elapsed, f->carrier);
    if (f->orders == 0) return;
    const int32_t *order = f->contact->response->orders;
    sm_harmonic_phasors(f->orders, order, f->carrier, f->re, f->im);
    for (int q = 0; q < f->orders; q++) {
        f->turn[q] = 0.0;
        for (int j = 0; j < f->contact->modes; j++)
            f->turn[q] += order[2 * q + j] * sm_forcing_angle(f, j, elapsed);
    }
}

/* Starts at a time of a segment, in steps of h. */
static inline void sm_forcing_start(sm_forcing *f, const sm_contact *contact,
                                    const sm_segment *segment, double elapsed, double h) {
    const int responds = contact->response && segment->reaction_start && segment->reaction_end;
    f->contact = contact;
    f->segment = segment;
    f->h = h;
    f->orders = responds ? contact->response->orders_count : 0;
    f->swept = 0;
    for (int j = 0; j < SM_MODES; j++) {
        f->factor[j] = sm_cx(1.0, 0.0);
        if (j >= contact->modes) continue;
        f->swept |= segment->frequency_rate[j] != 0.0;
        f->factor[j] = sm_unit(h * segment->frequency[j]);
    }
    if (f->orders > 0)
        sm_harmonic_phasors(f->orders, contact->response->orders, f->factor, f->factor_re,
                            f->factor_im);
    const size_t columns = 2 * (size_t)contact->contacts;
    for (size_t q = 0; q < (size_t)f->orders; q++)
        for (size_t k = 0; k < columns; k++) {
            const double from = segment->reaction_start[q * columns + k];
            f->start[k * f->row + q] = from;
            f->slope[k * f->row + q] = segment->reaction_end[q * columns + k] - from;
        }
    sm_forcing_set(f, elapsed);
}

/* Computes carriers and phasors at the next instant, `elapsed`. */
SM_INLINE void sm_forcing_turn(sm_forcing *f, double elapsed) {
    if (f->swept || ++f->since == SM_EXACT_STEPS) {
        sm_forcing_set(f, elapsed);
        return;
    }
    for (int j = 0; j < SM_MODES; j++) f->carrier[j] = sm_cmul(f->carrier[j], f->factor[j]);
    sm_turn(f->row, f->re, f->im, f->factor_re, f->factor_im);
}

/* Adds the response of the modes at the fraction r of the segment, and its rate if `rates`. */
SM_INLINE void sm_forcing_add_response(const int n, const int rates, sm_forcing *f, double r) {
    const size_t row = f->row;
    const double h_r = f->h / f->segment->duration;
    for (size_t i = 0; i < (size_t)n; i++) {
        const double *start_re = f->start + 2 * i * row, *start_im = start_re + row;
        const double *slope_re = f->slope + 2 * i * row, *slope_im = slope_re + row;
        double sum = 0.0, change = 0.0;
        SM_SIMD_SUM(sum, change)
        for (size_t q = 0; q < row; q++) {
            const double re = start_re[q] + r * slope_re[q], im = start_im[q] + r * slope_im[q];
            sum += re * f->re[q] - im * f->im[q];
            if (rates)
                change += (h_r * slope_re[q] - f->turn[q] * im) * f->re[q]
                          - (h_r * slope_im[q] + f->turn[q] * re) * f->im[q];
        }
        f->value[i] += sum;
        if (rates) f->rate[i] += change;
    }
}

/* Computes the forces (n) at the last instant, `elapsed`, and their rates if `rates`. */
SM_INLINE void sm_forcing_find(const int n, const int rates, sm_forcing *f, double elapsed) {
    const sm_contact *contact = f->contact;
    const sm_segment *g = f->segment;
    const double r = elapsed / g->duration;
    double *restrict value = f->value, *restrict rate = f->rate;
    for (int i = 0; i < n; i++) value[i] = rate[i] = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        sm_complex slope;
        const sm_complex a = sm_segment_amplitude(g, j, r, &slope);
        const double turn = sm_forcing_angle(f, j, elapsed);
        const sm_complex moving =
            sm_cx(f->h * slope.re - turn * a.im, f->h * slope.im + turn * a.re);
        const sm_complex q = sm_cmul(a, f->carrier[j]), dq = sm_cmul(moving, f->carrier[j]);
        const double *restrict L = contact->coupling + 2 * (size_t)j * (size_t)n;
        for (int i = 0; i < n; i++) {
            value[i] -= 2.0 * (L[2 * i] * q.re - L[2 * i + 1] * q.im);
            if (rates) rate[i] -= 2.0 * (L[2 * i] * dq.re - L[2 * i + 1] * dq.im);
        }
    }
    if (f->orders > 0) sm_forcing_add_response(n, rates, f, r);
}

/* Advances to the end of a step, at `elapsed`: computes the forces and rates there, and keeps the
 * ones at its start, which are known. */
SM_INLINE void sm_forcing_advance(const int n, sm_forcing *f, double elapsed) {
    memcpy(f->before, f->value, (size_t)n * sizeof(double));
    memcpy(f->before + n, f->rate, (size_t)n * sizeof(double));
    sm_forcing_turn(f, elapsed);
    sm_forcing_find(n, 1, f, elapsed);
}

/* Computes the forces u (n) at the fraction s of the step that ends at the last instant. */
SM_INLINE void sm_forcing_load(const int n, const sm_forcing *f, double s, double *restrict u) {
    const sm_hermite at = sm_hermite_at(1.0, s);
    const double *value = f->before, *rate = value + n;
    for (int i = 0; i < n; i++)
        u[i] = sm_hermite_value(&at.value, value[i], rate[i], f->value[i], f->rate[i]);
}

#endif
