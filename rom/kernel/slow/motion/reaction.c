#include "slow/motion/reaction.h"

void sm_reaction_place(sm_reaction *reaction, int contacts, int orders, double *memory) {
    double **const rows[] = {&reaction->re[0], &reaction->im[0], &reaction->re[1],
                             &reaction->im[1], &reaction->by_re, &reaction->by_im};
    reaction->orders = orders;
    reaction->row = sm_reaction_row(orders);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++, memory += reaction->row)
        *rows[k] = memory;
    reaction->start = memory;
    reaction->slope = memory + 2 * (size_t)contacts * reaction->row;
}

void sm_reaction_start(sm_reaction *reaction, int contacts, const sm_segment *segment) {
    const size_t n = (size_t)contacts, orders = (size_t)reaction->orders;
    for (size_t q = 0; q < orders; q++)
        for (size_t k = 0; k < 2 * n; k++) {
            const double start = segment->reaction_start[2 * q * n + k];
            reaction->start[k * reaction->row + q] = start;
            reaction->slope[k * reaction->row + q] = segment->reaction_end[2 * q * n + k] - start;
        }
}

void sm_reaction_set(sm_reaction *reaction, int stage, const int32_t *orders,
                 const sm_complex carrier[SM_MODES]) {
    sm_harmonic_phasors(reaction->orders, orders, carrier, reaction->re[stage],
                        reaction->im[stage]);
}

void sm_reaction_set_factors(sm_reaction *reaction, const int32_t *orders,
                             const sm_complex by[SM_MODES]) {
    sm_harmonic_phasors(reaction->orders, orders, by, reaction->by_re, reaction->by_im);
}
