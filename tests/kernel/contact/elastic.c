/* Elastic contacts with random laws on structures of random stiffness: motion, statics, refusals. */
#include "motion.h"

void check_elastic(int times);
void check_elastic_refusals(void);
int random_elastic_call(void);

#define MOST_SLIDERS 5

typedef struct {
    sm_contact contact;
    sm_elastic elastic;
    sm_element *element;
    double *slider, *reference, *stiffness, *coupling, *flexibility; /* flexibility: R */
} joints;

static void add_element(joints *j, sm_element *e, int first, double mu) {
    const int column = j->contact.contacts, open = !first && random_below(3) == 0;
    if (mu == 0.0 || random_below(3) == 0) {
        *e = (sm_element){.law = SM_SLIDERS, .column = {column},
                          .first_slider = j->elastic.sliders,
                          .sliders = 1 + random_below(MOST_SLIDERS)};
        for (int k = 0; k < e->sliders; k++, j->elastic.sliders++) {
            double *slider = j->slider + 2 * j->elastic.sliders;
            slider[0] = random_below(10) ? decades(-1.5, 2.0) : 0.0;
            slider[1] = decades(-1.5, 3.0);
            j->reference[column] += slider[1];
        }
        j->contact.contacts += 1;
        return;
    }
    *e = (sm_element){.law = SM_FRICTIONAL, .column = {column, column + 1, column + 2},
                      .tangents = 1 + random_below(2), .friction = mu * random_number(),
                      .tangential_stiffness = decades(-1.5, 3.0),
                      .normal_stiffness = decades(-1.5, 3.0)};
    if (open) e->gap = decades(-2.0, 2.0);
    else if (random_below(5)) e->preload = decades(-1.5, 2.0);
    for (int k = 0; k <= e->tangents && !open; k++)
        j->reference[column + k] = k < e->tangents ? e->tangential_stiffness : e->normal_stiffness;
    j->contact.contacts += e->tangents + 1;
}

/* R = (K + diag(k_ref))^-1 with a random K, by Gauss and Jordan. */
static void find_flexibility(joints *j, size_t n) {
    double *R = j->flexibility, *g = new_doubles(n * n);
    const double soft = decades(-2.5, 4.0);
    for (size_t k = 0; k < n * n; k++) g[k] = random_sign();
    for (size_t k = 0; k < n * n; k++) {
        double sum = 0.0;
        for (size_t m = 0; m < n; m++) sum += g[k / n * n + m] * g[k % n * n + m];
        R[k] = 1.5 * soft * sum / (double)n + (k / n == k % n ? 0.5 * soft + j->reference[k / n] : 0.0);
    }
    for (size_t p = 0; p < n; p++) {
        const double pivot = 1.0 / R[p * n + p];
        R[p * n + p] = 1.0;
        for (size_t k = 0; k < n; k++) R[p * n + k] *= pivot;
        for (size_t r = 0; r < n; r++) {
            const double factor = R[r * n + p];
            if (r == p) continue;
            R[r * n + p] = 0.0;
            for (size_t k = 0; k < n; k++) R[r * n + k] -= factor * R[p * n + k];
        }
    }
    for (size_t k = 0; k < n * n; k++) R[k] = R[k / n > k % n ? k % n * n + k / n : k];
    for (size_t k = 0; k < n * n; k++) j->stiffness[k] = -R[k];
}

/* So many elements, with friction up to `mu`; 0: sliders alone. `j` must stay where it is. */
static void new_joints(joints *j, int elements, int modes, double mu) {
    *j = (joints){.element = (sm_element *)(void *)new_doubles(
                      (size_t)elements * sizeof(sm_element) / sizeof(double)),
                  .slider = new_doubles(2 * MOST_SLIDERS * (size_t)elements),
                  .reference = new_doubles(3 * (size_t)elements)};
    for (int e = 0; e < elements; e++) add_element(j, &j->element[e], e == 0, mu);
    const size_t n = (size_t)j->contact.contacts, exact = 2 * (size_t)j->elastic.sliders;
    double *slider = new_doubles(exact), *reference = new_doubles(n); /* of their sizes */
    j->slider = memcpy(slider, j->slider, exact * sizeof(double));
    j->reference = memcpy(reference, j->reference, n * sizeof(double));
    j->flexibility = new_doubles(n * n);
    j->stiffness = new_doubles(n * n);
    j->coupling = new_doubles(2 * n * (size_t)modes);
    for (size_t k = 0; k < 2 * n * (size_t)modes; k++)
        j->coupling[k] = (k % 2 ? 0.01 : 1.0) * (random_number() - 0.5);
    find_flexibility(j, n);
    j->elastic = (sm_elastic){elements, j->elastic.sliders, j->element, j->slider, j->reference};
    j->contact = (sm_contact){.contacts = (int32_t)n, .modes = modes, .law = SM_ELASTIC,
                              .stiffness = j->stiffness, .coupling = j->coupling,
                              .elastic = &j->elastic};
}

/* x - R y - u at each contact, with the force deficit y = k x - f of the reference springs. */
static double deviation(const joints *j, size_t i, const double *x, const double *f, double u) {
    const size_t n = (size_t)j->contact.contacts;
    double sum = x[i] - u;
    for (size_t k = 0; k < n; k++)
        sum -= j->flexibility[i * n + k] * (j->reference[k] * x[k] - f[k]);
    return sum;
}

/* Along a trajectory the contacts are in equilibrium with the structure, and no force is beyond its
 * law: that of sliders side by side, no tension, or the cone of friction. */
static void check_motion(double mu) {
    joints j;
    motion_call c;
    new_joints(&j, 1 + random_below(6), 1 + random_below(2), mu);
    const size_t n = (size_t)j.contact.contacts;
    new_motion(&c, &j.contact, SAMPLES);
    CHECK_STATUS(march(&c), SM_OK);
    for (size_t s = 0; s < SAMPLES; s++) {
        const double *x = c.x + s * n, *f = c.f + s * n;
        for (size_t i = 0; i < n; i++) {
            const double u = forcing(&c, (int)i, c.times[s]);
            CHECK_NEAR(deviation(&j, i, x, f, u), 0.0, 1e-8 * (1.0 + fabs(x[i])));
        }
        for (int k = 0; k < j.elastic.elements; k++) {
            const sm_element *e = &j.element[k];
            double most = 0.0, size = 0.0;
            if (e->law == SM_FRICTIONAL) {
                const int normal = e->column[e->tangents];
                const double N = e->preload + e->normal_stiffness * (x[normal] - e->gap);
                CHECK_NEAR(f[normal], fmax(N, 0.0) - e->preload, 1e-9 * (1.0 + fabs(N)));
                most = e->friction * fmax(N, 0.0);
            }
            for (int i = 0; i < e->sliders; i++) most += j.slider[2 * (e->first_slider + i)];
            for (int i = 0; i < (e->law == SM_SLIDERS ? 1 : e->tangents); i++)
                size = hypot(size, f[e->column[i]]);
            CHECK(size <= most * (1.0 + 1e-9) + 1e-9);
        }
    }
    free_doubles();
}

/* One Jenkins element on a structure: in terms of u, elastic and perfectly plastic, df = k du. */
static void check_jenkins_element(void) {
    joints j;
    motion_call c;
    do new_joints(&j, 1, 1, 0.0);
    while (j.elastic.sliders > 1);
    j.slider[0] = 0.1 * j.slider[1];
    j.coupling[0] = 0.5;
    new_motion(&c, &j.contact, SAMPLES);
    c.steps_per_period = 4096;
    CHECK_STATUS(march(&c), SM_OK);
    double f = 0.0, last = 0.0, least = 0.0, most = 0.0;
    for (int step = 0, k = 0; k < SAMPLES; step++) {
        const double u = forcing(&c, 0, 3.0 + 28.0 * step / (SAMPLES * 2000.0));
        f = fmax(-j.slider[0], fmin(f + j.slider[1] * (u - last), j.slider[0]));
        last = u;
        if (step > 0 && step % 2000 == 0) {
            CHECK_NEAR(c.f[k], f, 1e-5 * j.slider[0]);
            least = fmin(least, c.f[k]);
            most = fmax(most, c.f[k++]);
        }
    }
    CHECK_NEAR(least, -j.slider[0], 1e-9 * j.slider[0]);
    CHECK_NEAR(most, j.slider[0], 1e-9 * j.slider[0]);
    free_doubles();
}

/* Statics in one step from rest: in balance, under the forces of the law. */
static void check_equilibrium(void) {
    joints j;
    new_joints(&j, 1 + random_below(6), 1, 0.3);
    const size_t n = (size_t)j.contact.contacts;
    double *u = new_doubles(n), *x = new_doubles(n), *f = new_doubles(n), *law = new_doubles(n);
    double *memory = new_doubles(sm_elastic_memory(&j.elastic));
    for (size_t i = 0; i < n; i++) u[i] = random_sign();
    CHECK_STATUS(sm_elastic_equilibrium(&j.elastic, (int32_t)n, j.flexibility, u, x, f), SM_OK);
    CHECK_STATUS(sm_elastic_force(&j.elastic, (int32_t)n, x, memory, law), SM_OK);
    for (size_t i = 0; i < n; i++) {
        CHECK_NEAR(f[i], law[i], 1e-9 * (1.0 + fabs(f[i])));
        CHECK_NEAR(deviation(&j, i, x, f, u[i]), 0.0, 1e-8 * (1.0 + fabs(x[i])));
    }
    x[0] = NAN;
    CHECK_STATUS(sm_elastic_force(&j.elastic, (int32_t)n, x, memory, law), SM_NOT_FINITE);
    CHECK_STATUS(sm_elastic_force(&j.elastic, (int32_t)n, u, NULL, law), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_elastic_force(&j.elastic, (int32_t)n, u, memory, NULL), SM_BAD_ARGUMENT);
    free_doubles();
}

void check_elastic(int times) {
    (void)times;
    check_jenkins_element();
    for (int k = 0; k < 60; k++) {
        check_motion(k % 3 ? 0.3 : 0.0);
        check_equilibrium();
    }
}

static sm_status check_call(void *j) { return sm_contact_check(&((joints *)j)->contact); }

void check_elastic_refusals(void) {
    joints j;
    do new_joints(&j, 5, 2, 0.5); /* until a frictional contact comes first, and sliders next */
    while (j.element[0].law != SM_FRICTIONAL || j.element[1].law != SM_SLIDERS);
    const size_t n = (size_t)j.contact.contacts;
    sm_element *f = &j.element[0], *s = &j.element[1];
    CHECK_STATUS(check_call(&j), SM_OK);
    REFUSES_NULL(&j.contact.elastic, check_call, &j);
    REFUSES_NULL(&j.contact.stiffness, check_call, &j);
    REFUSES_NULL(&j.contact.coupling, check_call, &j);
    REFUSES_NULL(&j.elastic.element, check_call, &j);
    REFUSES_NULL(&j.elastic.slider, check_call, &j);
    REFUSES_NULL(&j.elastic.reference, check_call, &j);
    REFUSES_INTS(&j.elastic.elements, check_call, &j, 0, -1, 4, INT32_MAX);
    REFUSES_INTS(&j.elastic.sliders, check_call, &j, 0, -1, INT32_MAX);
    REFUSES_INTS(&f->law, check_call, &j, -1, 2);
    REFUSES_INTS(&f->column[0], check_call, &j, -1, (int32_t)n, f->column[1], s->column[0]);
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
        REFUSES_NOT_FINITE(numbers[k], 1, check_call, &j);
    }
    REFUSES_NOT_FINITE(j.stiffness, n * n, check_call, &j);
    REFUSES_NOT_FINITE(j.coupling, 4 * n, check_call, &j);
}

/* Something of it wrong, or extreme, most times. */
static void spoil_joints(joints *j) {
    const int32_t number = (int32_t[]){-1, 0, 2, 7, INT32_MAX, INT32_MIN}[random_below(6)];
    sm_element *e = &j->element[random_below(j->elastic.elements)];
    const size_t n = (size_t)j->contact.contacts;
    double *const numbers[] = {&e->friction, &e->preload, &e->gap, &e->tangential_stiffness,
                               &e->normal_stiffness, j->reference, j->stiffness, j->coupling,
                               j->elastic.sliders ? j->slider : j->reference};
    int32_t *const counts[] = {&e->column[0], &e->sliders, &e->first_slider, &e->tangents, &e->law};
    const int which = random_below(30);
    if (which < 9) spoil(numbers[which], which > 5 && which < 8 ? n : 1);
    else if (which < 14) *counts[which - 9] = number;
}

/* Torus, growth and motion of spoiled contacts under random responses; whether the torus was solved. */
int random_elastic_call(void) {
    joints j;
    motion_call c;
    new_joints(&j, 1 + random_below(4), 1 + random_below(2), 0.6);
    const size_t n = (size_t)j.contact.contacts, points = (size_t)random_below(3), all = 8 * n;
    const int32_t orders[] = {1, 0, 0, 1, 0, 0, 2, 0}, count = 4;
    const double rates[] = {1.0, 1.7}, smallest[] = {0.0, 0.1};
    double *H = new_doubles(all * n), *start = new_doubles(all), *held = new_doubles(all);
    for (size_t k = 0; k < all * n; k++) H[k] = 0.01 * random_sign();
    for (size_t k = 0; k < all; k++) held[k] = 0.1 * (start[k] = 0.5 * random_sign());
    if (random_below(16) == 0) spoil(random_below(2) ? start : held, all);
    const sm_modal_response response = {.orders_count = count, .orders = orders,
                                        .asked = random_below(count + 1),
                                        .dynamic_stiffness = H,
                                        .start = random_below(2) ? start : NULL,
                                        .held = random_below(2) ? held : NULL};
    double *amplitudes = new_doubles(points * 2), *P = new_doubles(points * all);
    double *near = new_doubles(points * all), *square = new_doubles(points * n);
    double *residual = new_doubles(points);
    for (size_t k = 0; k < points * 2; k++) amplitudes[k] = 3.0 * random_number();
    for (size_t k = 0; k < points * all; k++) near[k] = 0.5 * random_sign();
    if (points > 0 && random_below(8) == 0) spoil(near, points * all);
    if (random_below(2)) j.contact.response = &response;
    spoil_joints(&j);
    sm_discretisation grid = {rates, 4 + random_below(9), 1 << random_below(4), count, orders,
                              1e-3,  smallest,            1 + random_below(6)};
    const sm_torus_points where = {points, amplitudes, random_below(2) ? near : NULL};
    const sm_torus_motion motion = {P, square, residual, (int32_t *)(void *)new_doubles(points)};
    const sm_status status = sm_torus_harmonics(&j.contact, &grid, &where, &motion);
    check_response(status, P, points * all);
    check_response(status, square, points * n);
    for (size_t k = 0; k < points && status == SM_OK; k++) CHECK(residual[k] >= 0.0);
    check_response(sm_torus_growing(&j.contact, &grid, points, amplitudes, amplitudes, P), P,
                   points * all);
    j.contact.response = NULL;
    new_motion(&c, &j.contact, 3);
    spoil(c.start_x, n);
    c.steps_per_period = 4 + random_below(60);
    check_response(march(&c), c.x, 3 * n);
    free_doubles();
    return status == SM_OK;
}
