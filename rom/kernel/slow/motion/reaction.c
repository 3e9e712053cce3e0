#include "slow/motion/reaction.h"

static sm_phasors take_phasors(size_t row, sm_block *block) {
    sm_phasors phasors;
    phasors.re = sm_take(block, row);
    phasors.im = sm_take(block, row);
    return phasors;
}

void sm_reaction_place(sm_reaction *reaction, int contacts, int orders, sm_block *block) {
    const size_t row = sm_reaction_row(orders);
    reaction->orders = orders;
    reaction->row = row;
    reaction->now = take_phasors(row, block);
    reaction->by = take_phasors(row, block);
    reaction->turn = sm_take(block, row);
    reaction->start = sm_take(block, 2 * (size_t)contacts * row);
    reaction->slope = sm_take(block, 2 * (size_t)contacts * row);
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

void sm_reaction_set(const sm_reaction *reaction, sm_phasors *phasors, const int32_t *orders,
                     const sm_complex carrier[SM_MODES]) {
    sm_harmonic_phasors(reaction->orders, orders, carrier, phasors->re, phasors->im);
}

void sm_reaction_turn(const sm_reaction *reaction, const int32_t *orders,
                      const double turn[SM_MODES]) {
    for (int q = 0; q < reaction->orders; q++)
        reaction->turn[q] = orders[2 * q] * turn[0] + orders[2 * q + 1] * turn[1];
}
