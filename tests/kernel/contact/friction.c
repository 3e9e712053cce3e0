/* Along a slow trajectory: contacts of rigid friction, tanh and Coulomb. */
#include "motion.h"

void check_friction(int times);
void check_friction_refusals(void);

void new_motion(motion_call *c, const sm_contact *contact, size_t samples) {
    const double rise[2][4] = {{0.05, -0.02, 0.03, 0.01}, {-0.04, 0.01, 0.02, -0.03}};
    const size_t n = (size_t)contact->contacts;
    *c = (motion_call){.contact = contact, .segments = SEGMENTS, .samples = samples,
                       .segment = c->two, .start_x = new_doubles(n),
                       .times = new_doubles(samples), .x = new_doubles(samples * n),
                       .v = new_doubles(samples * n), .f = new_doubles(samples * n),
                       .steps_per_period = 64};
    sm_segment *g = c->two;
    for (int k = 0; k < SEGMENTS; k++) {
        const double h = g[0].duration;
        g[k].start = k == 0 ? 3.0 : 14.0;
        g[k].duration = k == 0 ? 11.0 : 17.0;
        for (int p = 0; p < 4; p++) {
            g[k].amplitude_start[p] = k == 0 ? 0.3 * p + 0.5 : g[0].amplitude_end[p];
            g[k].rate_start[p] = g[k].rate_end[p] = rise[k][p];
            g[k].amplitude_end[p] = g[k].amplitude_start[p] + rise[k][p] * g[k].duration;
        }
        for (int j = 0; j < SM_MODES; j++) {
            g[k].frequency_rate[j] = 0.002 * (j + 1);
            g[k].frequency[j] = (j == 0 ? 1.0 : 1.7) + (k == 0 ? 0.0 : g[0].frequency_rate[j] * h);
            g[k].angle[j] = 0.4 * j;
            if (k > 0)
                g[k].angle[j] += h * (g[0].frequency[j] + 0.5 * g[0].frequency_rate[j] * h);
        }
    }
    for (size_t k = 0; k < samples; k++)
        c->times[k] = 3.0 + 28.0 * (double)(k + 1) / (double)samples;
}

sm_status march(void *arguments) {
    motion_call *c = arguments;
    const sm_contact_samples samples = {c->samples, c->times, c->x, c->v, c->f};
    return sm_contact_motion(c->contact, c->segments, c->segment, c->start_x, c->steps_per_period,
                             &samples);
}

double forcing(const motion_call *c, int i, double time) {
    const sm_segment *g = &c->two[time > 14.0];
    const double t = time - g->start;
    double u = 0.0;
    for (int j = 0; j < c->contact->modes; j++) {
        const double *L = c->contact->coupling + 2 * (j * c->contact->contacts + i);
        const double re = g->amplitude_start[2 * j] + t * g->rate_start[2 * j];
        const double im = g->amplitude_start[2 * j + 1] + t * g->rate_start[2 * j + 1];
        const double theta = g->angle[j] + t * (g->frequency[j] + 0.5 * g->frequency_rate[j] * t);
        u -= 2.0 * creal((L[0] + I * L[1]) * (re + I * im) * cexp(I * theta));
    }
    return u;
}

/* D v + K x + f = u at every sample; f = limit tanh(v / alpha), or Coulomb's law, with a stuck
 * contact that does not creep. */
static void check_laws(const problem *p) {
    motion_call c;
    const int n = p->contact.contacts;
    int slips = 0;
    new_motion(&c, &p->contact, SAMPLES);
    CHECK_STATUS(march(&c), SM_OK);
    for (int k = 0; k < SAMPLES * n; k++) {
        const int i = k % n, row = k - i;
        const double v = c.v[k], f = c.f[k], limit = p->limit[i];
        const double u = forcing(&c, i, c.times[k / n]);
        double left = f, scale = limit + fabs(u);
        for (int j = 0; j < n; j++) {
            const double elastic = p->stiffness[i * n + j] * c.x[row + j];
            left += p->damping[i * n + j] * c.v[row + j] + elastic;
            scale += fabs(elastic);
        }
        CHECK_NEAR(left, u, 1e-9 * scale);
        CHECK(fabs(f) <= limit);
        if (p->contact.law == SM_TANH)
            CHECK_NEAR(f, limit * tanh(v / p->contact.alpha), 1e-9 * scale);
        else
            CHECK(fabs(f) < limit * (1.0 - 1e-9) ? v == 0.0 : v * f >= 0.0);
        slips += fabs(v) > 1e-3;
    }
    CHECK(slips > 0);
}

/* A chain: each contact joined to the next by `joint` of its own stiffness; 0: as they are. */
static void check_chain(int contacts, int modes, double alpha, double joint) {
    problem p = new_problem(contacts, modes, alpha > 0.0 ? SM_TANH : SM_COULOMB);
    p.contact.alpha = alpha;
    for (int k = 0; k < contacts * contacts && joint > 0.0; k++) {
        const int i = k / contacts, apart = abs(i - k % contacts);
        const double neighbours = (i > 0) + (i < contacts - 1);
        p.stiffness[k] = apart == 0   ? 20.0 * (1.0 + joint * neighbours)
                         : apart == 1 ? -20.0 * joint : 0.0;
        p.damping[k] = 0.01 * p.stiffness[k];
    }
    check_laws(&p);
    free_doubles();
}

/* A single Coulomb contact without damping is the play operator: x stays unless the band
 * (u +- limit) / K around it moves past. */
static void check_play_operator(void) {
    problem p = new_problem(1, 1, SM_COULOMB);
    motion_call c;
    p.damping[0] = 0.0;
    new_motion(&c, &p.contact, SAMPLES);
    double x = c.start_x[0] = 0.03;
    c.steps_per_period = 2048;
    CHECK_STATUS(march(&c), SM_OK);
    for (int step = 1, k = 0; k < SAMPLES; step++) { /* far finer than the core marches */
        const double u = forcing(&c, 0, 3.0 + 28.0 * step / (SAMPLES * 2000.0));
        x = fmax((u - p.limit[0]) / p.stiffness[0], fmin(x, (u + p.limit[0]) / p.stiffness[0]));
        if (step % 2000 == 0) CHECK_NEAR(c.x[k++], x, 1e-6);
    }
    for (int k = 0; k < SAMPLES; k++) c.x[k] = -1.0;
    p.limit[0] = 1e6; /* stuck */
    CHECK_STATUS(march(&c), SM_OK);
    for (int k = 0; k < SAMPLES; k++) CHECK(c.x[k] == 0.03 && c.v[k] == 0.0);
}

void check_friction(int times) {
    const int contacts[] = {1, 2, 3, 7, 40};
    (void)times;
    for (int n = 0; n < 5; n++)
        for (int modes = 1; modes <= (n < 4 ? 2 : 1); modes++) {
            check_chain(contacts[n], modes, 0.02, 0.0);
            check_chain(contacts[n], modes, 1e-6, 0.0);
            check_chain(contacts[n], modes, 0.0, 0.0);
        }
    for (double joint = 1.0; joint < 1e6; joint *= 20.0) { /* up to a bar that is all but rigid */
        check_chain(4, 1, 1e-3, joint);
        check_chain(12, 1, 0.0, joint);
    }
    check_play_operator();
}

/* One signal: the modes, with the coupling to a contact for their shape, and two harmonics with
 * coefficients that are straight in time over a segment. */
typedef struct {
    sm_harmonic_sum sum;
    motion_call along;
    problem p;
    double shape[2], coefficient[(SEGMENTS + 1) * 4];
    int32_t orders[4];
} sum_call;

static void new_sum(sum_call *c) {
    *c = (sum_call){.p = new_problem(1, 2, SM_TANH), .shape = {0.3, -0.8},
                    .orders = {3, -1, 0, 2}};
    new_motion(&c->along, &c->p.contact, SAMPLES);
    memset(c->p.coupling, 0, 4 * sizeof(double));
    for (int j = 0; j < 2; j++) c->p.coupling[2 * j] = c->shape[j];
    for (size_t k = 0; k < COUNT(c->coefficient); k++) c->coefficient[k] = cos(0.7 * (double)k);
    c->sum = (sm_harmonic_sum){2, 2, c->orders, 1, c->shape, c->coefficient};
}

static sm_status add_up(void *arguments) {
    sum_call *c = arguments;
    return sm_harmonic_motion(&c->sum, c->along.segments, c->along.segment, SAMPLES,
                              c->along.times, c->along.x);
}

static sm_status call_contact_check(void *contact) { return sm_contact_check(contact); }

void check_friction_refusals(void) {
    problem p = new_problem(2, 2, SM_TANH);
    motion_call c;
    sm_contact *contact = &p.contact;
    double H[2 * 8] = {0.1}, mass[] = {1.0, 0.1, 0.1, 1.0};
    int32_t orders[] = {2, -1, 3, 0};
    sm_modal_response response = {.orders_count = 2, .orders = orders, .dynamic_stiffness = H};
    const entry check = call_contact_check;
    contact->mass = mass;
    contact->response = &response;
    CHECK_STATUS(sm_contact_check(contact), SM_OK);
    CHECK_STATUS(sm_contact_check(NULL), SM_BAD_ARGUMENT);
    REFUSES_NULL(check, contact, &contact->limit, &contact->stiffness, &contact->damping,
                 &contact->coupling, &response.orders);
    REFUSES_NOT_FINITE(check, contact, {p.limit, 2}, {p.stiffness, 4}, {p.damping, 4},
                       {p.coupling, 8}, {mass, 4}, {&contact->alpha, 1}, {H, COUNT(H)});
    REFUSES_INTS(&contact->contacts, check, contact, 0, -1, INT32_MIN, INT32_MAX, 32769);
    REFUSES_INTS(&contact->modes, check, contact, 0, -1, 3, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&contact->law, check, contact, -1, 3, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&response.orders_count, check, contact, -1, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&orders[1], check, contact, -100000, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&response.requested, check, contact, -1, 3);
    REFUSES(&contact->alpha, check, contact, 0.0, -0.02);
    REFUSES(&p.limit[1], check, contact, -1e-9);
    REFUSES(&p.stiffness[3], check, contact, 0.0);
    REFUSES(&p.stiffness[1], check, contact, 18.1); /* not symmetric */
    REFUSES(&p.damping[1], check, contact, 0.17);
    REFUSES(&mass[1], check, contact, 0.2);
    contact->mass = NULL;
    contact->response = NULL;
    new_motion(&c, &p.contact, SAMPLES);
    REFUSES_NULL(march, &c, &c.segments, &c.segment, &c.times);
    REFUSES_INTS(&c.steps_per_period, march, &c, 3, 0, -1, 65537, INT32_MAX, INT32_MIN);
    REFUSES(&c.times[4], march, &c, c.times[5]);
    REFUSES(&c.times[0], march, &c, 2.999);
    REFUSES(&c.times[SAMPLES - 1], march, &c, 31.1);
    REFUSES(&c.two[0].duration, march, &c, 0.0, -11.0, 10.9);
    REFUSES(&c.two[1].start, march, &c, 2.0);
    /* more steps than anybody can wait for, or than an integer counts */
    REFUSES(&c.two[0].frequency[0], march, &c, 1e15, -1e300);
    CHECK_WITH(&c.two[0].amplitude_start[0], 1e308, march(&c), SM_NOT_FINITE);
    for (int k = 0; k < SEGMENTS; k++)
        REFUSES_NOT_FINITE(march, &c, {(double *)&c.two[k], SEGMENT_COUNT});
    REFUSES_NOT_FINITE(march, &c, {c.times, SAMPLES}, {c.start_x, 2}, {p.limit, 2});
    check_no_memory(march, &c);
    sum_call s;
    new_sum(&s);
    REFUSES_NULL(add_up, &s, &s.along.segment, &s.along.times, &s.along.x, &s.sum.shape,
                 &s.sum.coefficient, &s.sum.orders, &s.sum.signals);
    REFUSES_NOT_FINITE(add_up, &s, {s.shape, 2}, {s.coefficient, COUNT(s.coefficient)},
                       {s.along.times, SAMPLES});
    REFUSES_INTS(&s.sum.modes, add_up, &s, 0, 3);
    REFUSES_INTS(&s.sum.orders_count, add_up, &s, -1, INT32_MAX);
    REFUSES_INTS(&s.orders[0], add_up, &s, 129);
}
