/* All steady states of the forced slow flow at some p.
 *
 * Friction depends on the moduli of the effective amplitudes alone, so the force that a modulus needs
 * can be compared with the force that acts on the mode. Cells of the plane of moduli are searched if
 * the needed force is larger at some corners and smaller at others, for each mode. */
#include <math.h>

#include "base/check.h"
#include "slow/branches/curve.h"
#include "slow/branches/points.h"
#include "slow/instant.h"
#include "table/table.h"

#define CELLS_ONE 100 /* of the modulus of a mode by itself */
#define CELLS 32      /* of each of two */
#define CORNERS ((CELLS + 1) * (CELLS + 1)) /* at most: of cells */
#define ALL ((1 << 2 * SM_MODES) - 1)       /* answers of corners that a steady state may be between */

/* Moduli relative to the limits, up to the range of the table; a mode without force is at rest. */
typedef struct {
    int cells[SM_MODES]; /* 0: at rest */
    int corners;
    double largest[SM_MODES];
    double modulus[SM_MODES][CORNERS];
    double S[SM_MODES][2][CORNERS]; /* (Re, Im); NaN outside the table */
} grid;

/* Of one mode at a p: spring (z - off) = forcing + gain S z / |z|, z its effective amplitude. */
typedef struct {
    sm_complex spring, gain, there; /* forcing + spring off */
} held;

static void look_up(const sm_table *table, const double *modulus, int32_t *cell, sm_complex *S) {
    double columns[SM_MOST_FIELDS];
    const sm_status status = sm_table_slopes_from(table, modulus, 0, cell, columns, NULL);
    for (int j = 0; j < table->modes; j++)
        S[j] = status == SM_OK ? sm_pair(columns + 2 * j) : sm_cx(NAN, NAN);
}

/* Of a mode at one of its corners, or between two. */
static double modulus_at(const grid *moduli, int j, double corner) {
    return moduli->cells[j] ? moduli->largest[j] * (corner / moduli->cells[j]) : 0.0;
}

static void set_grid(const sm_forced *forced, grid *moduli) {
    const sm_table *table = &forced->flow->table;
    int32_t cell[SM_MODES] = {0};
    for (int j = 0; j < SM_MODES; j++) {
        const int rests = forced->inputs[0].force[j] == 0.0 && forced->inputs[1].force[j] == 0.0;
        moduli->cells[j] = j >= table->modes || rests ? 0 : table->modes == 1 ? CELLS_ONE : CELLS;
        moduli->largest[j] = forced->scale[j];
    }
    int corner = 0;
    for (int a = 0; a <= moduli->cells[0]; a++)
        for (int b = 0; b <= moduli->cells[1]; b++, corner++) {
            const double modulus[] = {modulus_at(moduli, 0, a), modulus_at(moduli, 1, b)};
            sm_complex S[SM_MODES] = {{0.0, 0.0}};
            look_up(table, modulus, cell, S);
            for (int j = 0; j < SM_MODES; j++) {
                moduli->modulus[j][corner] = modulus[j];
                moduli->S[j][0][corner] = S[j].re;
                moduli->S[j][1][corner] = S[j].im;
            }
        }
    moduli->corners = corner;
}

static held held_at(const sm_instant *instant, int j) {
    const sm_factors *by = &instant->factor;
    const sm_complex spring = sm_cdiv(sm_of(&by->spring, j), sm_of(&by->amplitude_ratio, j));
    const sm_complex by_spring = sm_cmul(spring, sm_of(&by->off_resonance, j));
    const held mode = {spring, sm_of(&by->rate_ratio, j),
                       sm_cadd(sm_of(&by->forcing, j), by_spring)};
    return mode;
}

/* The force that a modulus needs. */
SM_INLINE sm_complex taken(const held *mode, double modulus, sm_complex S) {
    return sm_csub(sm_cscale(mode->spring, modulus), sm_cmul(mode->gain, S));
}

/* Two bits for each mode at each corner: the force suffices; it does not exceed the need. Both are set
 * for a mode that does not exist. */
SM_HOT static void answer(const grid *moduli, const held *mode, uint8_t *answers) {
    for (int c = 0; c < moduli->corners; c++) {
        int bits = 0;
        for (int j = 0; j < SM_MODES; j++) {
            const sm_complex S = sm_cx(moduli->S[j][0][c], moduli->S[j][1][c]);
            const double needed = sm_cabs2(taken(mode + j, moduli->modulus[j][c], S));
            const double there = sm_cabs2(mode[j].there);
            bits |= (needed <= there) << (2 * j) | (needed >= there) << (2 * j + 1);
        }
        answers[c] = (uint8_t)bits;
    }
}

/* The bits of all corners of a cell, given its first corner. */
static int around(const grid *moduli, const uint8_t *answers, int corner) {
    const int aside = moduli->cells[1] > 0, ahead = moduli->cells[0] ? moduli->cells[1] + 1 : 0;
    const uint8_t *here = answers + corner, *there = here + ahead;
    return here[0] | here[aside] | there[0] | there[aside];
}

/* Amplitudes with these moduli, in phase with the forces that balance them, scaled as unknowns. */
static void balanced(const sm_forced *forced, const sm_instant *instant, const held *mode,
                     const double *modulus, const sm_complex *S, double *y) {
    for (int j = 0; j < forced->flow->table.modes; j++) {
        const sm_complex along =
            sm_cmul(mode[j].there, sm_conj(taken(mode + j, modulus[j], S[j])));
        const double length = sqrt(sm_cabs2(along));
        const sm_complex z = sm_cscale(along, length > 0.0 ? modulus[j] / length : 0.0);
        const sm_complex a = sm_cdiv(sm_csub(z, sm_of(&instant->factor.off_resonance, j)),
                                     sm_of(&instant->factor.amplitude_ratio, j));
        const double scale = instant->inputs.limit_scale * forced->scale[j];
        y[2 * j] = a.re / scale;
        y[2 * j + 1] = a.im / scale;
    }
}

/* At one p; how many are found. */
static size_t search_at(const sm_curve *curve, const sm_forced *forced, const grid *moduli,
                        sm_instant *instant, double p, double *z) {
    const int modes = forced->flow->table.modes, k = 2 * modes, row = moduli->cells[1] + 1;
    uint8_t answers[CORNERS];
    held mode[SM_MODES] = {{{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}}};
    size_t found = 0;
    for (int j = 0; j < modes; j++) mode[j] = held_at(instant, j);
    answer(moduli, mode, answers);
    for (int a = 0; a < moduli->cells[0] || a == 0; a++)
        for (int b = 0; b < moduli->cells[1] || b == 0; b++) {
            if (around(moduli, answers, a * row + b) != ALL) continue;
            const double middle[] = {modulus_at(moduli, 0, a + 0.5), modulus_at(moduli, 1, b + 0.5)};
            sm_complex S[SM_MODES];
            double *at = z + found * (size_t)(k + 1);
            look_up(&forced->flow->table, middle, instant->cell, S);
            balanced(forced, instant, mode, middle, S, at);
            at[k] = p;
            found += sm_curve_solved(curve, at) == SM_OK;
        }
    return found;
}

sm_status sm_forced_search(const sm_forced *forced, size_t sections, double *z, size_t *found) {
    sm_curve curve;
    sm_status status = z && found && sections > 1 ? sm_forced_curve(forced, 1.0, &curve)
                                                  : SM_BAD_ARGUMENT;
    if (status != SM_OK) return status;
    grid moduli;
    sm_instant instant = {.known = 0};
    set_grid(forced, &moduli);
    *found = 0;
    for (size_t i = 0; i < sections; i++) {
        const double p = (double)i / (double)(sections - 1);
        const sm_inputs inputs = sm_forced_inputs(forced, p);
        status = sm_inputs_check(&inputs, forced->flow->table.modes);
        if (status != SM_OK) return status;
        sm_instant_set(&instant, forced->flow, &inputs);
        *found += search_at(&curve, forced, &moduli, &instant, p,
                            z + *found * (size_t)(curve.unknowns + 1));
    }
    return SM_OK;
}
