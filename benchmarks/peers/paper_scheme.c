/* The paper's scheme, Eq. (31): implicit upwind differences on the (t_A, t_B) grid through some
 * periods in each direction; the last period gives the harmonics.
 *
 * With c = (Omega_A + Omega_B) / dt and the base b = (Omega_A x[n-1][m] + Omega_B x[n][m-1]) /
 * (Omega_A + Omega_B) a grid point reads (K / c) v + g(v) = u - K b, x = b + v / c: the stage
 * problem of the core, whose solver and lanes it borrows (one amplitude pair a lane).
 *
 * Where it starts can be read in two ways: x = 0 at the corner t_A = t_B = 0 alone, so that on an
 * axis the difference across it is left out; or x = 0 on both axes.
 */
#include <stdlib.h>

#include "contact/stage/tr_bdf2.h"

#define HARMONICS 2 /* P_10 and P_01 */
#define PI 3.14159265358979323846

/* Forcing at (t_A, t_B): u_i = -2 Re sum_j L_ji a_j exp(i t_j). */
static void load(const sm_contact *contact, const double *amplitudes, const double *angle,
                 sm_lanes *lane) {
    const int n = contact->contacts;
    for (int i = 0; i < n; i++) {
        double reaction[SM_MODES];
        for (int j = 0; j < SM_MODES; j++) {
            const double *L = contact->coupling + 2 * (j * n + i);
            reaction[j] = -2.0 * (L[0] * cos(angle[j]) - L[1] * sin(angle[j]));
        }
        double *restrict u = lane->u + (size_t)i * SM_LANES;
        SM_SIMD
        for (int l = 0; l < SM_LANES; l++)
            u[l] = reaction[0] * amplitudes[l] + reaction[1] * amplitudes[SM_LANES + l];
    }
}

/* Add x exp(-i t_A) and x exp(-i t_B) to the sums, (harmonic, re or im, contact, lane). */
static void project(const double *restrict x, const double *angle, size_t size,
                    double *restrict sums) {
    for (int j = 0; j < HARMONICS; j++) {
        const double factor[2] = {cos(angle[j]), -sin(angle[j])};
        for (int part = 0; part < 2; part++, sums += size)
            for (size_t k = 0; k < size; k++) sums[k] += factor[part] * x[k];
    }
}

typedef struct {
    sm_stepper stepper;
    double from_a, from_b; /* share of x[n-1][m] and of x[n][m-1] in the base */
    double per_c;          /* [s] */
} point_rule;

/* Everything the march of a group of lanes needs. */
typedef struct {
    const sm_contact *contact;
    int steps, periods, corner;
    point_rule inside, on_a, on_b; /* on_a: the axis t_B = 0 */
    sm_lanes lane;
    double *row;  /* x[n-1][m], then x[n][m], for m = 0 ... periods steps */
    double *sums; /* (harmonic, re or im, contact, lane) */
} scheme;

static sm_status set_rule(point_rule *rule, const sm_contact *contact, double rate_a,
                          double rate_b, double dt) {
    const double all = rate_a + rate_b;
    rule->from_a = rate_a / all;
    rule->from_b = rate_b / all;
    rule->per_c = dt / all;
    return sm_stepper_set(&rule->stepper, contact, rule->per_c / SM_GAMMA);
}

/* x[n][m] in place of x[n-1][m]. */
SM_INLINE sm_status solve_point(scheme *s, const point_rule *rule, const double *amplitudes,
                                const double *angle, int m) {
    const int n = s->contact->contacts;
    const size_t size = (size_t)n * SM_LANES;
    double *restrict x = s->row + (size_t)m * size;
    const double *left = m > 0 ? x - size : x; /* of no weight on the axis */
    sm_lanes *lane = &s->lane;
    for (size_t k = 0; k < size; k++)
        lane->base[k] = rule->from_a * x[k] + rule->from_b * left[k];
    load(s->contact, amplitudes, angle, lane);
    sm_times(n, SM_LANES, rule->stepper.stiffness, lane->base, lane->r);
    for (size_t k = 0; k < size; k++) lane->r[k] = lane->u[k] - lane->r[k];
    const sm_status status = sm_solve(n, SM_LANES, &rule->stepper, lane);
    for (size_t k = 0; k < size; k++) x[k] = lane->base[k] + rule->per_c * lane->v[k];
    return status;
}

SM_HOT static sm_status march(scheme *s, const double *amplitudes) {
    const size_t size = (size_t)s->contact->contacts * SM_LANES;
    const double dt = 2.0 * PI / s->steps;
    const int last = s->periods * s->steps, first = last - s->steps;
    for (int n = s->corner ? 0 : 1; n <= last; n++)
        for (int m = s->corner ? n == 0 : 1; m <= last; m++) {
            const point_rule *rule = n == 0 ? &s->on_b : m == 0 ? &s->on_a : &s->inside;
            const double angle[SM_MODES] = {n * dt, m * dt};
            const sm_status status = solve_point(s, rule, amplitudes, angle, m);
            if (status != SM_OK) return status;
            if (n > first && m > first)
                project(s->row + (size_t)m * size, angle, size, s->sums);
        }
    return SM_OK;
}

static void place(scheme *s, sm_block *block, size_t rows, size_t sums) {
    const int contacts = s->contact->contacts;
    point_rule *rules[] = {&s->inside, &s->on_a, &s->on_b};
    s->row = sm_take(block, rows);
    s->sums = sm_take(block, sums);
    for (int k = 0; k < 3; k++) sm_stepper_place(&rules[k]->stepper, contacts, block);
    sm_lanes_place(&s->lane, contacts, SM_LANES, block);
}

/* P_10 and P_01, (points, 2, contacts) complex, at amplitudes (points, 2). */
SM_API sm_status peer_paper_scheme(const sm_contact *contact, const double *rates, int32_t steps,
                                   int32_t periods, int32_t corner, size_t points,
                                   const double *amplitudes, double *harmonics) {
    const size_t n = (size_t)contact->contacts, size = n * SM_LANES;
    const size_t rows = ((size_t)periods * (size_t)steps + 1) * size, sums = HARMONICS * 2 * size;
    sm_block block = {NULL, 0};
    scheme s = {.contact = contact, .steps = steps, .periods = periods, .corner = corner};
    place(&s, &block, rows, sums);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    place(&s, &block, rows, sums);
    const double dt = 2.0 * PI / steps;
    sm_status status = set_rule(&s.inside, contact, rates[0], rates[1], dt);
    if (status == SM_OK) status = set_rule(&s.on_a, contact, rates[0], 0.0, dt);
    if (status == SM_OK) status = set_rule(&s.on_b, contact, 0.0, rates[1], dt);
    for (size_t first = 0; first < points && status == SM_OK; first += SM_LANES) {
        double pair[SM_MODES * SM_LANES];
        for (size_t l = 0; l < SM_LANES; l++) /* a group that is not full repeats the last point */
            for (size_t j = 0; j < SM_MODES; j++)
                pair[j * SM_LANES + l] =
                    amplitudes[2 * (first + l < points ? first + l : points - 1) + j];
        memset(s.row, 0, (rows + sums) * sizeof(double));
        memset(s.lane.v, 0, size * sizeof(double));
        status = march(&s, pair);
        for (size_t l = 0; l < SM_LANES && first + l < points; l++)
            for (size_t k = 0; k < HARMONICS * n; k++)
                for (size_t part = 0; part < 2; part++)
                    harmonics[2 * ((first + l) * HARMONICS * n + k) + part] =
                        s.sums[((k / n * 2 + part) * n + k % n) * SM_LANES + l]
                        / ((double)steps * steps);
    }
    free(block.memory);
    return status;
}
