/* Steady states of a forced slow flow, eqs. (22) to (25), at given parts of its line of inputs.
 *
 * Moduli of the amplitudes that may balance the forces are found on a grid over the friction table.
 * Newton's method on the equations of forced.c starts from them. Python and the explorer start
 * solution curves from the result. */
#include "base/check.h"
#include "slow/branches/forced.h"

/* Cells of the amplitude range: two solutions in one cell may be found as one. Of each of two
 * modes, and of a single mode. */
#define CELLS 32
#define CELLS_ALONE 100
#define CORNERS ((CELLS + 1) * (CELLS + 1))

/* Corners of the cells in the plane of the moduli; the index of mode B varies fastest. */
typedef struct {
    int modes;
    int cells[SM_MODES];                /* 0: a mode without force, or no mode B */
    double range[SM_MODES];             /* of the moduli [kg^1/2 m] */
    sm_complex friction[CORNERS][SM_MODES]; /* S_j */
    unsigned char sides[CORNERS];       /* see `set_sides` */
} grid;

/* The forces at a part of the line. With z the effective amplitudes relative to the limits s, c the
 * coupling ratio and f(|z|) the friction terms, steady states are
 *
 *   stiffness s / c z - c s f(|z|) z / |z| = F (1 / 2 + stiffness shift) = acting.
 *
 * The left-hand side for z = |z| is the force that the moduli need. In it the nonlinear stiffness of
 * the modes has amplitudes without the shift, |a| = s |z / c|. */
typedef struct {
    const sm_slow_flow *flow;
    sm_instant at; /* ratio = c / s, gain = c s */
    sm_complex spring[SM_MODES], acting[SM_MODES];
} load;

/* Returns the number of corners along the axis of a mode. */
static int corners(const grid *g, int mode) { return g->cells[mode] + 1; }

/* Returns the index of a corner. */
static int corner_at(const grid *g, int a, int b) { return a * corners(g, 1) + b; }

/* Returns the modulus of a mode at a position along its cells. */
static double modulus_at(const grid *g, int mode, double place) {
    const int cells = g->cells[mode];
    return place < cells ? place * (g->range[mode] / cells) : cells > 0 ? g->range[mode] : 0.0;
}

/* Evaluates the friction terms S_j at given moduli. */
static sm_status look_up(const sm_table *table, const double *modulus, sm_complex *friction) {
    double columns[SM_MOST_FIELDS];
    SM_TRY(sm_table_lookup(table, 1, modulus, columns));
    for (int j = 0; j < table->modes; j++) friction[j] = sm_pair(columns + 2 * j);
    return SM_OK;
}

/* Computes the friction terms at all corners. */
static sm_status set_grid(grid *g, const sm_forced *forced) {
    g->modes = forced->flow->table.modes;
    for (int j = 0; j < SM_MODES; j++) {
        const int has_force = j < g->modes
                              && (forced->inputs[0].force[j] != 0.0
                                  || forced->inputs[1].force[j] != 0.0);
        g->cells[j] = !has_force ? 0 : g->modes > 1 ? CELLS : CELLS_ALONE;
        g->range[j] = forced->scale[j];
    }
    for (int a = 0; a < corners(g, 0); a++)
        for (int b = 0; b < corners(g, 1); b++) {
            const double modulus[SM_MODES] = {modulus_at(g, 0, a), modulus_at(g, 1, b)};
            SM_TRY(look_up(&forced->flow->table, modulus, g->friction[corner_at(g, a, b)]));
        }
    return SM_OK;
}

/* Computes stiffness and acting force of each mode at given inputs. */
static sm_status set_load(load *l, const sm_slow_flow *flow, const sm_inputs *inputs) {
    SM_TRY(sm_inputs_check(inputs, flow->table.modes));
    l->flow = flow;
    l->at.known = 0;
    sm_instant_set(&l->at, flow, inputs);
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_complex half = sm_cscale(l->at.now.force[j], 0.5);
        l->spring[j] = sm_cdiv(l->at.now.stiffness[j], l->at.ratio[j]);
        l->acting[j] = sm_cadd(half, sm_cmul(l->spring[j], l->at.offset[j]));
    }
    return SM_OK;
}

/* Returns the force on a mode that the moduli need. */
static sm_complex force_needed(const load *l, int mode, const double *modulus,
                               sm_complex friction) {
    double hardening = 0.0;
    for (int k = 0; k < l->flow->table.modes; k++)
        hardening += l->flow->hardening[mode][k] * modulus[k] * modulus[k]
                     / sm_cabs2(l->at.ratio[k]);
    const sm_complex added = sm_cdiv(sm_cx(hardening, 0.0), l->at.ratio[mode]);
    const sm_complex spring = sm_cadd(l->spring[mode], added);
    return sm_csub(sm_cscale(spring, modulus[mode]), sm_cmul(l->at.gain[mode], friction));
}

/* Sets two bits per mode at each corner: needed force <= acting force, and needed >= acting. */
static void set_sides(grid *g, const load *l) {
    for (int a = 0; a < corners(g, 0); a++)
        for (int b = 0; b < corners(g, 1); b++) {
            const int corner = corner_at(g, a, b);
            const double modulus[SM_MODES] = {modulus_at(g, 0, a), modulus_at(g, 1, b)};
            unsigned sides = 0;
            for (int j = 0; j < g->modes; j++) {
                const sm_complex friction = g->friction[corner][j];
                const double needed = sm_cabs2(force_needed(l, j, modulus, friction));
                const double acting = sm_cabs2(l->acting[j]);
                sides |= ((needed <= acting ? 1u : 0u) | (needed >= acting ? 2u : 0u)) << 2 * j;
            }
            g->sides[corner] = (unsigned char)sides;
        }
}

/* Returns whether the needed force is below the acting force at some corners of the cell and above
 * it at others, for each mode. */
static int is_candidate(const grid *g, int a, int b) {
    unsigned sides = 0;
    for (int i = 0; i <= (g->cells[0] > 0); i++)
        for (int k = 0; k <= (g->cells[1] > 0); k++) sides |= g->sides[corner_at(g, a + i, b + k)];
    return sides == (g->modes > 1 ? 15u : 3u);
}

/* Computes amplitudes in the middle of a cell whose phases balance the forces, in units of the
 * curve. */
static sm_status guess(const grid *g, const load *l, const sm_table *table, const int *cell,
                       double *z) {
    double modulus[SM_MODES];
    sm_complex friction[SM_MODES];
    for (int j = 0; j < SM_MODES; j++)
        modulus[j] = modulus_at(g, j, cell[j] + (g->cells[j] > 0 ? 0.5 : 0.0));
    SM_TRY(look_up(table, modulus, friction));
    for (int j = 0; j < g->modes; j++) {
        const sm_complex needed = force_needed(l, j, modulus, friction[j]);
        const sm_complex turn = sm_cmul(l->acting[j], sm_conj(needed));
        const double length = sqrt(sm_cabs2(turn));
        const sm_complex unit = length > 0.0 ? sm_cscale(turn, 1.0 / length) : sm_cx(1.0, 0.0);
        const sm_complex unshifted = sm_csub(sm_cscale(unit, modulus[j]), l->at.offset[j]);
        const sm_complex a = sm_cdiv(unshifted, l->at.ratio[j]);
        z[2 * j] = a.re / (l->at.now.limit_scale * g->range[j]);
        z[2 * j + 1] = a.im / (l->at.now.limit_scale * g->range[j]);
    }
    return SM_OK;
}

sm_status sm_forced_solutions(const sm_forced *forced, int32_t sections, size_t most, double *z,
                              size_t *found) {
    sm_curve curve;
    grid g;
    if (!z || !found || sections < 2) return SM_BAD_ARGUMENT;
    *found = 0;
    SM_TRY(sm_forced_curve(forced, 1.0, &curve));
    SM_TRY(set_grid(&g, forced));
    for (int section = 0; section < sections; section++) {
        const double part = section / (double)(sections - 1);
        const sm_inputs inputs = sm_forced_inputs(forced, part);
        load l;
        SM_TRY(set_load(&l, forced->flow, &inputs));
        set_sides(&g, &l);
        for (int a = 0; a < (g.cells[0] > 0 ? g.cells[0] : 1); a++)
            for (int b = 0; b < (g.cells[1] > 0 ? g.cells[1] : 1); b++) {
                double *row = z + *found * (size_t)(curve.unknowns + 1);
                if (*found == most || !is_candidate(&g, a, b)) continue;
                if (guess(&g, &l, &forced->flow->table, (int[]){a, b}, row) != SM_OK) continue;
                row[curve.unknowns] = part;
                if (sm_curve_solved(&curve, row) == SM_OK) ++*found;
            }
    }
    return SM_OK;
}
