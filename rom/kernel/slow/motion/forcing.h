/* What acts on the contacts along a segment, at the stages of steps of several lengths.
 *
 * The carriers, and the harmonics of the modes' response, are known at the start of a step, and
 * have a factor from there to each of its stages. In a sweep the factors would move, so there
 * they are computed anew.
 */
#ifndef SLIPMODE_FORCING_H
#define SLIPMODE_FORCING_H

#include "contact/sdirk2.h"
#include "slow/motion/reaction.h"

#define SM_EXACT_STEPS 64 /* after which rounding is done away with */

typedef struct {
    const sm_contact *contact;
    const sm_segment *segment;
    sm_reaction *reaction; /* NULL: none */
    double amplitude[SM_MODES][2][4]; /* cubics in the fraction of the segment */
    int swept, since;      /* steps since the carriers were exact */
    sm_complex carrier[SM_MODES]; /* at the start of the next step */
    sm_complex by[SM_LEVELS][SM_STAGES][SM_MODES];
    struct {               /* what those factors, and the harmonics', were found for */
        double least, frequency[SM_MODES];
        int finest;
        const sm_reaction *reaction;
    } found;
} sm_forcing;

SM_INLINE sm_complex sm_unit(double angle) { return sm_cx(cos(angle), sin(angle)); }

/* Exact at `elapsed` seconds into the segment. */
SM_INLINE void sm_forcing_set(sm_forcing *f, double elapsed) {
    f->since = 0;
    sm_segment_carriers(f->segment, f->contact->modes, elapsed, f->carrier);
    if (f->reaction && !f->swept)
        sm_reaction_set(f->reaction, &f->reaction->now, f->contact->response->orders, f->carrier);
}

SM_INLINE void find_factors(sm_forcing *f, int level, int stage, double seconds) {
    sm_complex *by = f->by[level][stage];
    for (int j = 0; j < SM_MODES; j++)
        by[j] = j < f->contact->modes ? sm_unit(f->segment->frequency[j] * seconds)
                                      : sm_cx(1.0, 0.0);
    sm_reaction *reaction = f->reaction;
    if (reaction)
        sm_reaction_set(reaction, &reaction->by[level][stage], f->contact->response->orders, by);
}

/* Those of the steps twice as long as the next. */
SM_INLINE void square_factors(sm_forcing *f, int level, int stage) {
    const sm_complex *half = f->by[level + 1][stage];
    for (int j = 0; j < SM_MODES; j++) f->by[level][stage][j] = sm_cmul(half[j], half[j]);
    sm_reaction *reaction = f->reaction;
    if (!reaction) return;
    const sm_phasors *root = &reaction->by[level + 1][stage];
    sm_phasors_multiply(reaction->row, root, root, &reaction->by[level][stage]);
}

/* Whether the factors for steps of `least` and more are there already; they will be. */
SM_INLINE int factors_found(sm_forcing *f, double least, int finest) {
    int same = f->found.least == least && f->found.finest == finest
               && f->found.reaction == f->reaction;
    for (int j = 0; j < f->contact->modes; j++) {
        same = same && f->found.frequency[j] == f->segment->frequency[j];
        f->found.frequency[j] = f->segment->frequency[j];
    }
    f->found.least = least;
    f->found.finest = finest;
    f->found.reaction = f->reaction;
    return same;
}

/* Along a segment, from `elapsed` on. */
SM_INLINE void forcing_from(sm_forcing *f, const sm_contact *contact, const sm_segment *segment,
                            sm_reaction *reaction, double elapsed) {
    f->contact = contact;
    f->segment = segment;
    f->reaction = reaction;
    f->swept = segment->frequency_rate[0] != 0.0 || segment->frequency_rate[1] != 0.0;
    for (int j = 0; j < contact->modes; j++) sm_segment_cubics(segment, j, f->amplitude[j]);
    if (reaction) sm_reaction_start(reaction, contact->contacts, segment);
    sm_forcing_set(f, elapsed);
}

/* In steps of two lengths, and as level 2 of their sum, at the ends of which alone it is wanted. */
SM_INLINE void sm_forcing_start_two(sm_forcing *f, const sm_contact *contact,
                                    const sm_segment *segment, sm_reaction *reaction,
                                    double elapsed, const double length[2]) {
    const int end = SM_STAGES - 1;
    forcing_from(f, contact, segment, reaction, elapsed);
    if (f->swept || factors_found(f, length[0], -1)) return; /* the other is always the same */
    for (int level = 0; level < 2; level++) find_factors(f, level, end, length[level]);
    for (int j = 0; j < SM_MODES; j++)
        f->by[2][end][j] = sm_cmul(f->by[0][end][j], f->by[1][end][j]);
    if (!f->reaction) return;
    sm_phasors_multiply(f->reaction->row, &f->reaction->by[0][end], &f->reaction->by[1][end],
                        &f->reaction->by[2][end]);
}

/* In steps of h / 2^level, level = 0 ... finest. */
SM_INLINE void sm_forcing_start(sm_forcing *f, const sm_contact *contact,
                                const sm_segment *segment, sm_reaction *reaction, double elapsed,
                                double h, int finest) {
    forcing_from(f, contact, segment, reaction, elapsed);
    const double least = ldexp(h, -finest), at[SM_STAGES] = {SM_GAMMA * least, least};
    if (f->swept || factors_found(f, least, finest)) return;
    for (int level = finest; level >= 0; level--)
        for (int stage = 0; stage < SM_STAGES; stage++) {
            if (level == finest)
                find_factors(f, level, stage, at[stage]);
            else
                square_factors(f, level, stage);
        }
}

SM_INLINE double sm_cubic(const double c[4], double r) {
    return c[0] + r * (c[1] + r * (c[2] + r * c[3]));
}

/* The forcing u (N_c) at a stage of a step, `elapsed` seconds into the segment:
 * -2 Re sum_j L_j a_j exp(i theta_j), and the reaction. `n` is N_c, and may be a literal. */
SM_INLINE void sm_forcing_load(const int n, sm_forcing *f, int level, int stage, double elapsed,
                               double *restrict u) {
    const sm_contact *contact = f->contact;
    const double r = elapsed / f->segment->duration;
    sm_complex carrier[SM_MODES];
    if (f->swept)
        sm_segment_carriers(f->segment, contact->modes, elapsed, carrier);
    else
        for (int j = 0; j < SM_MODES; j++)
            carrier[j] = sm_cmul(f->carrier[j], f->by[level][stage][j]);
    for (int i = 0; i < n; i++) u[i] = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        const sm_complex a = sm_cx(sm_cubic(f->amplitude[j][0], r), sm_cubic(f->amplitude[j][1], r));
        const sm_complex q = sm_cmul(a, carrier[j]);
        const double *restrict L = contact->coupling + 2 * (size_t)j * (size_t)n;
        for (int i = 0; i < n; i++) u[i] -= 2.0 * (L[2 * i] * q.re - L[2 * i + 1] * q.im);
    }
    sm_reaction *reaction = f->reaction;
    if (!reaction) return;
    if (f->swept) sm_reaction_set(reaction, &reaction->now, contact->response->orders, carrier);
    sm_reaction_add(n, reaction, f->swept ? &reaction->none : &reaction->by[level][stage], r, u);
}

/* Past a step, which ends at `elapsed`. */
SM_INLINE void sm_forcing_advance(sm_forcing *f, int level, double elapsed) {
    if (f->swept) return;
    if (++f->since == SM_EXACT_STEPS) {
        sm_forcing_set(f, elapsed);
        return;
    }
    for (int j = 0; j < SM_MODES; j++)
        f->carrier[j] = sm_cmul(f->carrier[j], f->by[level][1][j]);
    if (f->reaction)
        sm_phasors_multiply(f->reaction->row, &f->reaction->now, &f->reaction->by[level][1],
                            &f->reaction->now);
}

#endif
