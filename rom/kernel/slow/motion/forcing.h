/* What acts on the contacts along a segment: cubics between instants that are one step apart.
 *
 * There it is exact, and so is its rate of change. In between lie the stages of the steps, of
 * several lengths: the error of a cubic is (nu h)^4 / 384 for a harmonic nu, 2e-6 for a carrier at 40
 * steps a period. The carriers, and the harmonics of the modes' response, have a factor from one instant
 * to the next. In a sweep the factors would move, so there they are computed anew.
 */
#ifndef SLIPMODE_FORCING_H
#define SLIPMODE_FORCING_H

#include "base/exact_sum.h"
#include "slow/motion/reaction.h"

typedef struct {
    const sm_contact *contact;
    const sm_segment *segment;
    sm_reaction *reaction; /* NULL: none */
    double amplitude[SM_MODES][2][4]; /* cubics in the fraction of the segment */
    int swept, since;      /* instants since the carriers were exact */
    double h;
    sm_complex carrier[SM_MODES], by[SM_MODES]; /* at the last instant; to the next */
    double *value, *rate;  /* (N_c) at the last instant; rate times h */
    double *cubic;         /* (N_c, 4) in the fraction of the step that ends there */
    struct {               /* what those factors, and the harmonics', were found for */
        double h, frequency[SM_MODES];
        const sm_reaction *reaction;
    } found;
} sm_forcing;

SM_INLINE void sm_forcing_place(sm_forcing *f, int contacts, sm_block *block) {
    const size_t n = (size_t)contacts;
    f->found.h = 0.0;
    f->value = sm_take(block, n);
    f->rate = sm_take(block, n);
    f->cubic = sm_take(block, 4 * n);
}

/* Whether the factors for steps of h are there already; they will be. */
SM_INLINE int factors_found(sm_forcing *f) {
    int same = f->found.h == f->h && f->found.reaction == f->reaction;
    for (int j = 0; j < f->contact->modes; j++) {
        same = same && f->found.frequency[j] == f->segment->frequency[j];
        f->found.frequency[j] = f->segment->frequency[j];
    }
    f->found.h = f->h;
    f->found.reaction = f->reaction;
    return same;
}

SM_INLINE void find_factors(sm_forcing *f) {
    for (int j = 0; j < SM_MODES; j++)
        f->by[j] = j < f->contact->modes ? sm_unit(f->segment->frequency[j] * f->h)
                                         : sm_cx(1.0, 0.0);
    sm_reaction *reaction = f->reaction;
    if (reaction)
        sm_reaction_set(reaction, &reaction->by, f->contact->response->orders, f->by);
}

/* The carriers and harmonics, exactly. */
SM_INLINE void sm_forcing_set(sm_forcing *f, double elapsed) {
    f->since = 0;
    sm_segment_carriers(f->segment, f->contact->modes, elapsed, f->carrier);
    if (f->reaction)
        sm_reaction_set(f->reaction, &f->reaction->now, f->contact->response->orders, f->carrier);
}

/* c(r) and, in place of the rest, dc/dr. */
SM_INLINE void sm_cubic(const double c[4], double r, double *value, double *slope) {
    *value = c[0] + r * (c[1] + r * (c[2] + r * c[3]));
    *slope = c[1] + r * (2.0 * c[2] + r * 3.0 * c[3]);
}

/* The forcing (N_c) there, -2 Re sum_j L_j a_j exp(i theta_j) and the reaction, and its rate if
 * that is wanted. `n` is N_c; it and `rates` may be literals. */
SM_INLINE void sm_forcing_find(const int n, const int rates, sm_forcing *f, double elapsed) {
    const sm_contact *contact = f->contact;
    const sm_segment *g = f->segment;
    const double r = elapsed / g->duration, h_r = f->h / g->duration;
    double turn[SM_MODES] = {0.0}; /* of the carriers in a step */
    double *restrict value = f->value, *restrict rate = f->rate;
    for (int i = 0; i < n; i++) value[i] = rate[i] = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        sm_complex a, slope;
        sm_cubic(f->amplitude[j][0], r, &a.re, &slope.re);
        sm_cubic(f->amplitude[j][1], r, &a.im, &slope.im);
        turn[j] = f->h * (g->frequency[j] + g->frequency_rate[j] * elapsed);
        const sm_complex moving =
            sm_cx(h_r * slope.re - turn[j] * a.im, h_r * slope.im + turn[j] * a.re);
        const sm_complex q = sm_cmul(a, f->carrier[j]), dq = sm_cmul(moving, f->carrier[j]);
        const double *restrict L = contact->coupling + 2 * (size_t)j * (size_t)n;
        for (int i = 0; i < n; i++) {
            value[i] -= 2.0 * (L[2 * i] * q.re - L[2 * i + 1] * q.im);
            if (rates) rate[i] -= 2.0 * (L[2 * i] * dq.re - L[2 * i + 1] * dq.im);
        }
    }
    sm_reaction *reaction = f->reaction;
    if (!reaction) return;
    if (rates && f->swept) sm_reaction_turn(reaction, contact->response->orders, turn);
    sm_reaction_add(n, rates, reaction, r, h_r, value, rate);
}

/* Along a segment, in steps of h, from `elapsed` on; the forcing there is still to be found. */
SM_INLINE void sm_forcing_start(sm_forcing *f, const sm_contact *contact,
                                const sm_segment *segment, sm_reaction *reaction, double elapsed,
                                double h) {
    f->contact = contact;
    f->segment = segment;
    f->reaction = reaction;
    f->h = h;
    f->swept = segment->frequency_rate[0] != 0.0 || segment->frequency_rate[1] != 0.0;
    for (int j = 0; j < contact->modes; j++) sm_segment_cubics(segment, j, f->amplitude[j]);
    if (reaction) sm_reaction_start(reaction, contact->contacts, segment);
    if (f->swept) {
        f->found.h = 0.0; /* its turns are not those of a step any more */
    } else if (!factors_found(f)) {
        double turn[SM_MODES];
        find_factors(f);
        for (int j = 0; j < SM_MODES; j++) turn[j] = h * segment->frequency[j];
        if (reaction) sm_reaction_turn(reaction, contact->response->orders, turn);
    }
    sm_forcing_set(f, elapsed);
}

/* The carriers and harmonics a step later, at `elapsed`. */
SM_INLINE void sm_forcing_turn(sm_forcing *f, double elapsed) {
    if (f->swept || ++f->since == SM_EXACT_STEPS) {
        sm_forcing_set(f, elapsed);
    } else {
        for (int j = 0; j < SM_MODES; j++) f->carrier[j] = sm_cmul(f->carrier[j], f->by[j]);
        sm_reaction *reaction = f->reaction;
        if (reaction)
            sm_phasors_multiply(reaction->row, &reaction->now, &reaction->by, &reaction->now);
    }
}

/* On to the step that ends at `elapsed`, its start being found with its rate. */
SM_INLINE void sm_forcing_advance(const int n, sm_forcing *f, double elapsed) {
    double *restrict cubic = f->cubic;
    for (int i = 0; i < n; i++) {
        cubic[4 * i] = f->value[i];
        cubic[4 * i + 1] = f->rate[i];
    }
    sm_forcing_turn(f, elapsed);
    sm_forcing_find(n, 1, f, elapsed);
    for (int i = 0; i < n; i++) {
        const double change = f->value[i] - cubic[4 * i], leaving = cubic[4 * i + 1];
        cubic[4 * i + 2] = 3.0 * change - 2.0 * leaving - f->rate[i];
        cubic[4 * i + 3] = leaving + f->rate[i] - 2.0 * change;
    }
}

/* u (N_c) at a fraction of that step. */
SM_INLINE void sm_forcing_load(const int n, const sm_forcing *f, double s, double *restrict u) {
    for (int i = 0; i < n; i++) {
        const double *c = f->cubic + 4 * i;
        u[i] = c[0] + s * (c[1] + s * (c[2] + s * c[3]));
    }
}

#endif
