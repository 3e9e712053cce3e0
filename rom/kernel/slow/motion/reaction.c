#include "slow/motion/reaction.h"

void sm_pull_place(sm_pull *pull, int contacts, int orders, double *memory) {
    double **const rows[] = {&pull->re[0], &pull->im[0], &pull->re[1],
                             &pull->im[1], &pull->by_re, &pull->by_im};
    pull->orders = orders;
    pull->row = sm_pull_row(orders);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++, memory += pull->row) *rows[k] = memory;
    pull->start = memory;
    pull->slope = memory + 2 * (size_t)contacts * pull->row;
}

void sm_pull_start(sm_pull *pull, int contacts, const sm_segment *segment) {
    const size_t n = (size_t)contacts, orders = (size_t)pull->orders;
    for (size_t q = 0; q < orders; q++)
        for (size_t k = 0; k < 2 * n; k++) {
            const double start = segment->pull_start[2 * q * n + k];
            pull->start[k * pull->row + q] = start;
            pull->slope[k * pull->row + q] = segment->pull_end[2 * q * n + k] - start;
        }
}

void sm_pull_set(sm_pull *pull, int stage, const int32_t *orders,
                 const sm_complex carrier[SM_MODES]) {
    sm_turns(pull->orders, orders, carrier, pull->re[stage], pull->im[stage]);
}

void sm_pull_set_turn(sm_pull *pull, const int32_t *orders, const sm_complex by[SM_MODES]) {
    sm_turns(pull->orders, orders, by, pull->by_re, pull->by_im);
}
