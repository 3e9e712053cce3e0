/* Elastic contacts with random parameters on random structures: motion, refusals. */
#include "motion.h"

void check_elastic(int times);
void check_elastic_refusals(void);
int random_elastic_call(void);

#define N 6       /* contact DOFs */
#define SLIDERS 4 /* of the second contact */

typedef struct {
    sm_contact contact;
    sm_elastic elastic;
    sm_element element[3];
    double *slider, *reference, *stiffness, *coupling; /* stiffness: -R */
} joints;

/* A preloaded frictional contact in two directions, sliders, and a frictional contact with a gap,
 * on a structure of stiffness K: R = (diag(k_ref) + K)^-1, K a diagonal matrix and one of rank
 * one. `j` must stay where it is. */
static void new_joints(joints *j, int modes) {
    double soft = decades(-2.5, 4.0), w[N], whole = 1.0;
    *j = (joints){.slider = new_doubles(2 * SLIDERS), .reference = new_doubles(N),
                  .stiffness = new_doubles(N * N), .coupling = new_doubles(2 * N * (size_t)modes)};
    j->element[0] = (sm_element){.law = SM_FRICTIONAL, .column = {0, 1, 2}, .tangents = 2,
                                 .preload = random_below(5) ? decades(-1.5, 2.0) : 0.0};
    j->element[1] = (sm_element){.law = SM_SLIDERS, .column = {3}, .sliders = SLIDERS};
    j->element[2] = (sm_element){.law = SM_FRICTIONAL, .column = {4, 5}, .tangents = 1,
                                 .gap = decades(-2.0, 2.0)};
    for (int e = 0; e < 3; e += 2) {
        j->element[e].friction = random_number();
        j->element[e].tangential_stiffness = decades(-1.5, 3.0);
        j->element[e].normal_stiffness = decades(-1.5, 3.0);
    }
    for (int k = 0; k < SLIDERS; k++) {
        j->slider[2 * k] = random_below(10) ? decades(-1.5, 2.0) : 0.0;
        j->reference[3] += j->slider[2 * k + 1] = decades(-1.5, 3.0);
    }
    j->reference[0] = j->reference[1] = j->element[0].tangential_stiffness;
    j->reference[2] = j->element[0].normal_stiffness;
    for (int i = 0; i < N; i++) {
        w[i] = random_sign() * sqrt(soft);
        whole += w[i] * w[i] / (soft + j->reference[i]);
    }
    for (int k = 0; k < N * N; k++) {
        const double a = soft + j->reference[k / N], b = soft + j->reference[k % N];
        j->stiffness[k] = w[k / N] * w[k % N] / (a * b * whole) - (k / N == k % N ? 1.0 / a : 0.0);
    }
    for (int k = 0; k < 2 * N * modes; k++)
        j->coupling[k] = (k % 2 ? 0.01 : 1.0) * (random_number() - 0.5);
    j->elastic = (sm_elastic){3, SLIDERS, j->element, j->slider, j->reference};
    j->contact = (sm_contact){.contacts = N, .modes = modes, .law = SM_ELASTIC,
                              .stiffness = j->stiffness, .coupling = j->coupling,
                              .elastic = &j->elastic};
}

/* x - R y - u at each contact, with the force deficit y = k x - f of the reference springs. */
static double deviation(const joints *j, int i, const double *x, const double *f, double u) {
    double sum = x[i] - u;
    for (int k = 0; k < N; k++) sum += j->stiffness[i * N + k] * (j->reference[k] * x[k] - f[k]);
    return sum;
}

/* Along a trajectory the contacts are in equilibrium with the structure, and no force is beyond
 * its law: sliders side by side, no tension, or the cone of friction. */
static void check_motion(void) {
    joints j;
    motion_call c;
    new_joints(&j, 1 + random_below(2));
    new_motion(&c, &j.contact, SAMPLES);
    CHECK_STATUS(march(&c), SM_OK);
    for (int s = 0; s < SAMPLES; s++) {
        const double *x = c.x + s * N, *f = c.f + s * N;
        double most = 0.0;
        for (int i = 0; i < N; i++)
            CHECK_NEAR(deviation(&j, i, x, f, forcing(&c, i, c.times[s])), 0.0,
                       1e-8 * (1.0 + fabs(x[i])));
        for (int k = 0; k < SLIDERS; k++) most += j.slider[2 * k];
        CHECK(fabs(f[3]) <= most * (1.0 + 1e-9));
        for (int k = 0; k < 3; k += 2) {
            const sm_element *e = &j.element[k];
            const int first = e->column[0], normal = e->column[e->tangents];
            const double load = e->preload + e->normal_stiffness * (x[normal] - e->gap);
            const double size = k ? fabs(f[first]) : hypot(f[first], f[first + 1]);
            CHECK_NEAR(f[normal], fmax(load, 0.0) - e->preload, 1e-9 * (1.0 + fabs(load)));
            CHECK(size <= e->friction * fmax(load, 0.0) + 1e-9 * (1.0 + size));
        }
    }
    free_doubles();
}

void check_elastic(int times) {
    (void)times;
    for (int k = 0; k < 60; k++) check_motion();
}

static sm_status check_call(void *j) { return sm_contact_check(&((joints *)j)->contact); }

void check_elastic_refusals(void) {
    joints j;
    new_joints(&j, 2);
    sm_element *f = &j.element[0], *s = &j.element[1];
    CHECK_STATUS(check_call(&j), SM_OK);
    REFUSES_NULL(check_call, &j, &j.contact.elastic, &j.contact.stiffness, &j.contact.coupling,
                 &j.elastic.element, &j.elastic.slider, &j.elastic.reference);
    REFUSES_INTS(&j.elastic.elements, check_call, &j, 0, -1, 2, INT32_MAX);
    REFUSES_INTS(&j.elastic.sliders, check_call, &j, 0, -1, INT32_MAX);
    REFUSES_INTS(&f->law, check_call, &j, -1, 2);
    REFUSES_INTS(&f->column[0], check_call, &j, -1, N, f->column[1], s->column[0]);
    REFUSES_INTS(&f->tangents, check_call, &j, 0, 3);
    REFUSES_INTS(&s->sliders, check_call, &j, 0, INT32_MAX);
    REFUSES_INTS(&s->first_slider, check_call, &j, -1, INT32_MAX);
    REFUSES(&f->tangential_stiffness, check_call, &j, 0.0, -1.0);
    REFUSES(&f->normal_stiffness, check_call, &j, 0.0, -1.0);
    REFUSES(&j.slider[1], check_call, &j, 0.0, -1.0);
    REFUSES(&j.stiffness[0], check_call, &j, 1.0);
    REFUSES(&j.stiffness[1], check_call, &j, j.stiffness[1] + 1e3);
    double *const numbers[] = {&f->friction, &f->preload, &f->gap, &j.slider[0], &j.reference[0],
                               &f->tangential_stiffness, &f->normal_stiffness};
    for (size_t k = 0; k < COUNT(numbers); k++) {
        REFUSES(numbers[k], check_call, &j, -0.1);
        REFUSES_NOT_FINITE(check_call, &j, {numbers[k], 1});
    }
    REFUSES_NOT_FINITE(check_call, &j, {j.stiffness, N * N}, {j.coupling, 4 * N});
    double x[N] = {NAN}, law[N], *memory = new_doubles(sm_elastic_memory(&j.elastic));
    CHECK_STATUS(sm_elastic_force(&j.elastic, N, x, memory, law), SM_NOT_FINITE);
    CHECK_STATUS(sm_elastic_force(&j.elastic, N, x, NULL, law), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_elastic_force(&j.elastic, N, x, memory, NULL), SM_BAD_ARGUMENT);
}

/* Something of it wrong, or extreme, most times. */
static void spoil_joints(joints *j) {
    const int32_t number = (int32_t[]){-1, 0, 2, 7, INT32_MAX, INT32_MIN}[random_below(6)];
    sm_element *e = &j->element[random_below(3)];
    double *const numbers[] = {&e->friction, &e->preload, &e->gap, &e->tangential_stiffness,
                               &e->normal_stiffness, j->reference, j->stiffness, j->coupling,
                               j->slider};
    int32_t *const counts[] = {&e->column[0], &e->sliders, &e->first_slider, &e->tangents,
                               &e->law};
    const int which = random_below(30);
    if (which < 9) spoil(numbers[which], which > 4 ? N : 1);
    else if (which < 14) *counts[which - 9] = number;
}

/* Torus, growth and motion of spoiled contacts under random responses; whether the torus was
 * solved. */
int random_elastic_call(void) {
    joints j;
    motion_call c;
    new_joints(&j, 1 + random_below(2));
    const size_t points = (size_t)random_below(3), all = 8 * N;
    const int32_t orders[] = {1, 0, 0, 1, 0, 0, 2, 0}, count = 4;
    const double rates[] = {1.0, 1.7}, smallest[] = {0.0, 0.1};
    double *H = new_doubles(all * N), *start = new_doubles(all), *prescribed = new_doubles(all);
    for (size_t k = 0; k < all * N; k++) H[k] = 0.01 * random_sign();
    for (size_t k = 0; k < all; k++) prescribed[k] = 0.1 * (start[k] = 0.5 * random_sign());
    if (random_below(16) == 0) spoil(random_below(2) ? start : prescribed, all);
    const sm_modal_response response = {.orders_count = count, .orders = orders,
                                        .requested = random_below(count + 1),
                                        .dynamic_stiffness = H,
                                        .start = random_below(2) ? start : NULL,
                                        .prescribed = random_below(2) ? prescribed : NULL};
    double *amplitudes = new_doubles(points * 2), *P = new_doubles(points * all);
    double *square = new_doubles(points * N), *residual = new_doubles(points);
    for (size_t k = 0; k < points * 2; k++) amplitudes[k] = 3.0 * random_number();
    if (random_below(2)) j.contact.response = &response;
    spoil_joints(&j);
    const sm_discretisation grid = {rates,  4 + random_below(9), 1 << random_below(4), count,
                                    orders, 1e-3, smallest, 1 + random_below(6)};
    const sm_torus_points where = {points, amplitudes, NULL};
    const sm_torus_motion motion = {P, square, residual, (int32_t *)(void *)new_doubles(points)};
    const sm_status status = sm_torus_harmonics(&j.contact, &grid, &where, &motion);
    check_response(status, P, points * all);
    check_response(status, square, points * N);
    j.contact.response = NULL;
    check_response(sm_torus_growing(&j.contact, &grid, points, amplitudes, amplitudes, P), P,
                   points * all);
    new_motion(&c, &j.contact, 3);
    spoil(c.start_x, N);
    c.steps_per_period = 4 + random_below(60);
    check_response(march(&c), c.x, 3 * N);
    free_doubles();
    return status == SM_OK;
}
