/* The discretisation of the torus, eq. (13), for rigid contacts: angles t_A and t_B - t_B0 at all
 * stages, phasors of the harmonics of eq. (14), and relaxation factors of the modal response. */
#include "torus/rigid/grid.h"

#include <stdlib.h>

#include "base/cnumber.h"
#include "base/exact_sum.h"
#include "torus/march.h"

/* Size of H / K up to which the response of the modes is iterated without relaxation: the error is
 * then reduced by more than a factor of 3 per period. */
#define UNRELAXED 0.3

/* Computes carriers, weights and phasors at all stages. */
static void fill_angles(sm_torus_grid *grid) {
    const int orders = grid->orders_count;
    for (int k = 0; k < 2 * (grid->steps + SM_TOGETHER); k++) {
        const double t = SM_TWO_PI * sm_stage_place((size_t)k) / grid->steps;
        double *c = grid->carrier + k * 4;
        c[0] = cos(t);
        c[1] = sin(t);
        c[2] = cos(grid->ratio * t);
        c[3] = sin(grid->ratio * t);
        for (int q = 0; q < orders; q++) {
            const int32_t *order = grid->orders + 2 * q;
            const sm_complex z = sm_unit((order[0] + order[1] * grid->ratio) * t);
            if (grid->phasor) {
                grid->phasor[2 * (k * orders + q)] = z.re;
                grid->phasor[2 * (k * orders + q) + 1] = z.im;
            }
            if (k % 2 == 1) {
                grid->weight[(k - 1) * orders + 2 * q] = z.re / grid->steps;
                grid->weight[(k - 1) * orders + 2 * q + 1] = -z.im / grid->steps;
            }
        }
    }
}

/* Returns the relaxation factor of the response to a harmonic. The response to one period acts in
 * the next one: a fixed-point iteration with the complex factor f = H / K, of magnitude `size` and
 * real part `along`. With relaxation w the factor is 1 - w + w f; w = best minimises its magnitude,
 * and w = safe keeps it below 1 for any phase of f. */
static double relaxation_of(const sm_contact *contact, const double *H) {
    const size_t n = (size_t)contact->contacts;
    double size = 0.0, re = 0.0, im = 0.0;
    for (size_t i = 0; i < n; i++) {
        double row = 0.0;
        for (size_t k = 0; k < n; k++)
            row += hypot(H[2 * (i * n + k)], H[2 * (i * n + k) + 1]);
        size = fmax(size, row / contact->stiffness[i * n + i]);
        re += H[2 * (i * n + i)] / contact->stiffness[i * n + i];
        im += H[2 * (i * n + i) + 1] / contact->stiffness[i * n + i];
    }
    if (size <= UNRELAXED) return 1.0;
    const double along = size * re / fmax(hypot(re, im), SM_TINY);
    const double best = (1.0 - along) / (1.0 - 2.0 * along + size * size);
    const double safe = 1.0 / (1.0 + size);
    return best > 0.0 ? fmin(best, safe) : safe;
}

/* Places the arrays. */
static void place(sm_torus_grid *grid, sm_block *block) {
    const size_t rows = (size_t)grid->steps + SM_TOGETHER, orders = (size_t)grid->orders_count;
    sm_stepper_place(&grid->stepper, grid->contact->contacts, block);
    block->taken = sm_whole_lines(block->taken);
    grid->carrier = sm_take(block, rows * 8);
    grid->weight = sm_take(block, rows * orders * 2);
    if (!grid->contact->response) return;
    grid->phasor = sm_take(block, rows * orders * 4);
    grid->relaxation = sm_take(block, orders);
}

sm_status sm_torus_grid_make(sm_torus_grid *grid, const sm_contact *contact,
                             const sm_discretisation *fine, size_t points) {
    const int lines = fine->lines;
    const int lanes = points * (size_t)lines <= SM_FEW_LANES ? SM_FEW_LANES : SM_LANES;
    const size_t n = (size_t)contact->contacts;
    const double *H = contact->response ? contact->response->dynamic_stiffness : NULL;
    *grid = (sm_torus_grid){
        .contact = contact, .steps = fine->steps, .lines = lines, .lanes = lanes,
        .points_per_group = lines > lanes ? 1 : lanes / lines, .orders_count = fine->orders_count,
        .per_point = (size_t)fine->orders_count * n * 2, .orders = fine->orders,
        .ratio = contact->modes == 2 ? fine->rates[1] / fine->rates[0] : 0.0,
        .dynamic_stiffness = H};
    sm_block block = {NULL, 0};
    place(grid, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    grid->memory = block.memory;
    place(grid, &block);
    fill_angles(grid);
    for (int q = 0; q < grid->orders_count && H; q++)
        grid->relaxation[q] = relaxation_of(contact, H + (size_t)q * n * n * 2);
    return sm_stepper_set(&grid->stepper, contact, SM_TWO_PI / (fine->rates[0] * fine->steps));
}
