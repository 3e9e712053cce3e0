/* Contacts marched along a slow trajectory: eq. (12) with the slowly varying amplitudes.
 *
 * The steps follow the carriers. A contact that begins to slip is left with a vibration of its
 * own, of its mass on the stiffness behind it, which decays within a fraction of a period: the
 * steps that would miss it are halved.
 */
#include "slow/motion/contact_march.h"

#include "base/block.h"
#include "base/check.h"
#include "base/exact_sum.h"

#define MAX_STEPS 1e10 /* of one march: hours */
/* Tolerances of v / alpha: S magnifies what it is off by where the force is read. */
#define ON_THE_WAY 1e-5
#define AT_THE_END 1e-10
#define RIGID_HALVINGS (SM_RIGID_LEVELS - 1)
/* Elastic contacts have no inertia: what is between two steps does not matter to what follows.
 * Their velocity is read from a step of this part of the longest, the last. */
#define READ_FROM 0.015625
/* By how much a velocity may part from a straight line in a step, relative to that without
 * friction. */
#define BEND 0.2
#define STRAIGHT 0.2 /* part of that below which the next step is twice as long */
#define AS_READ 0.05 /* part of that in the last step, where the velocity is to be read */
/* Vibrations that have died away to exp(-4) where a march ends are followed less closely: so many
 * halvings keep displacement and force. */
#define DEAD 4.0
#define EARLY_HALVINGS 1

static size_t remembered(const sm_contact *contact) {
    return contact->law == SM_ELASTIC ? sm_elastic_memory(contact->elastic) : 0;
}

size_t sm_march_size(const sm_contact *contact, int orders) {
    const size_t n = (size_t)contact->contacts;
    const size_t common = sm_reaction_size(contact->contacts, orders) + 2 * n;
    if (contact->law == SM_ELASTIC)
        return common + n * n + 4 * n + remembered(contact)
               + sm_elastic_solver_size(contact->elastic, contact->contacts);
    return common + sm_march_state_count(contact)
           + SM_RIGID_LEVELS * sm_stepper_size(contact->contacts)
           + sm_lanes_size(contact->contacts, 1) + sm_warm_size(contact->contacts);
}

void sm_march_place(sm_march *march, const sm_contact *contact, int orders, double *memory) {
    const int contacts = contact->contacts;
    const size_t n = (size_t)contacts;
    march->forcing.found.least = 0.0;
    march->force = sm_take(&memory, n);
    march->acceleration = sm_take(&memory, n);
    sm_reaction_place(&march->reaction, contacts, orders,
                      sm_take(&memory, sm_reaction_size(contacts, orders)));
    if (contact->law == SM_ELASTIC) {
        march->flexibility = sm_take(&memory, n * n);
        for (size_t k = 0; k < n * n; k++) march->flexibility[k] = -contact->stiffness[k];
        double **rows[] = {&march->u, &march->last_u, &march->x, &march->v};
        for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(&memory, n);
        march->memory = sm_take(&memory, remembered(contact));
        sm_elastic_solver_place(&march->solver, contact->elastic, contacts, march->flexibility,
                                memory);
        return;
    }
    march->before = sm_take(&memory, sm_march_state_count(contact));
    for (int level = 0; level < SM_RIGID_LEVELS; level++)
        sm_stepper_place(&march->stepper[level], contacts,
                         sm_take(&memory, sm_stepper_size(contacts)));
    sm_lanes_place(&march->lane, contacts, 1, memory);
    memory += sm_lanes_size(contacts, 1);
    sm_warm_place(&march->warm, contacts, memory);
    march->x = march->lane.x;
    march->v = march->lane.v;
}

size_t sm_march_state_count(const sm_contact *contact) {
    const size_t n = (size_t)contact->contacts;
    return 4 * n + (contact->law == SM_ELASTIC ? n + remembered(contact) : 0);
}

void sm_march_start(sm_march *march, const sm_contact *contact, const double *state) {
    const size_t n = (size_t)contact->contacts;
    for (size_t i = 0; i < n; i++) {
        march->x[i] = state ? state[i] : 0.0;
        march->v[i] = state ? state[n + i] : 0.0;
        march->force[i] = state ? state[2 * n + i] : 0.0;
        march->acceleration[i] = state ? state[3 * n + i] : 0.0;
    }
    if (contact->law == SM_ELASTIC) {
        for (size_t i = 0; i < n; i++) march->last_u[i] = state ? state[4 * n + i] : 0.0;
        for (size_t k = 0; k < remembered(contact); k++)
            march->memory[k] = state ? state[5 * n + k] : 0.0;
        return;
    }
    for (size_t i = 0; i < n; i++)
        march->lane.stage_v[0][i] = march->lane.stage_v[1][i] = march->v[i];
}

SM_INLINE void read_rigid(const int n, const sm_march *march, double *restrict state) {
    for (int i = 0; i < n; i++) {
        state[i] = march->x[i];
        state[n + i] = march->v[i];
        state[2 * n + i] = march->force[i];
        state[3 * n + i] = march->acceleration[i];
    }
}

void sm_march_read(const sm_march *march, const sm_contact *contact, double *state) {
    const size_t n = (size_t)contact->contacts;
    read_rigid(contact->contacts, march, state);
    if (contact->law != SM_ELASTIC) return;
    memcpy(state + 4 * n, march->last_u, n * sizeof(double));
    memcpy(state + 5 * n, march->memory, remembered(contact) * sizeof(double));
}

/* g = r - S v, where rounding must not carry it beyond the limit. */
SM_INLINE void find_force(const int n, const sm_stepper *s, sm_march *march) {
    for (int i = 0; i < n; i++) {
        const double limit = s->laws[i].limit;
        double g = march->warm.r[i];
        for (int j = 0; j < n; j++) g -= s->matrix[i * n + j] * march->warm.v[j];
        march->force[i] = g > limit ? limit : g < -limit ? -limit : g;
    }
}

/* A step to displacements u of contacts that stick; it takes h seconds. */
static sm_status step_elastic(sm_march *march, const sm_contact *contact, double h) {
    const int n = contact->contacts;
    double *moved = march->v;
    for (int i = 0; i < n; i++) {
        moved[i] = march->x[i];
        march->x[i] += march->u[i] - march->last_u[i]; /* as if nothing slipped */
    }
    const sm_status status = sm_elastic_solve(&march->solver, march->u, march->memory, march->x);
    if (status != SM_OK) return status;
    for (int i = 0; i < n; i++) {
        march->v[i] = (march->x[i] - moved[i]) / h;
        march->last_u[i] = march->u[i];
        march->force[i] = march->solver.f[i];
    }
    memcpy(march->memory, march->solver.next, remembered(contact) * sizeof(double));
    return SM_OK;
}

/* Steps of another length: S is another matrix. Contacts go on, or begin anew. */
static sm_status set_level(sm_march *march, const sm_contact *contact, int level, double h) {
    sm_stepper *stepper = &march->stepper[level];
    const sm_status status = sm_stepper_set(stepper, contact, h);
    if (status != SM_OK) return status;
    sm_lanes_forget(&march->lane, contact->contacts, 1);
    if (march->level >= 0)
        sm_warm_resume(stepper, &march->warm, march->force);
    else
        sm_warm_start(stepper, &march->warm, march->lane.v, march->force);
    march->level = level;
    return SM_OK;
}

SM_INLINE sm_status step_rigid(const int n, sm_march *march, int level, double h, double elapsed,
                               double tolerance) {
    sm_status status = SM_OK;
    if (level != march->level) status = set_level(march, march->forcing.contact, level, h);
    const sm_stepper *stepper = &march->stepper[level];
    march->warm.tolerance = tolerance;
    for (int stage = 0; stage < SM_STAGES && status == SM_OK; stage++) {
        const double at = elapsed + (stage == 0 ? SM_GAMMA * h : h);
        sm_forcing_load(n, &march->forcing, level, stage, at, march->lane.u);
        status = sm_stage_one(stepper, &march->warm, &march->lane, stage);
    }
    if (status == SM_OK) find_force(n, stepper, march);
    return status;
}

/* A step of h seconds, of that level, from `elapsed` on. */
SM_INLINE sm_status step(const int n, sm_march *march, int level, double h, double elapsed,
                         double tolerance) {
    const sm_contact *contact = march->forcing.contact;
    sm_status status;
    for (int i = 0; i < n; i++) march->acceleration[i] = -march->v[i];
    if (contact->law == SM_ELASTIC) {
        sm_forcing_load(n, &march->forcing, level, SM_STAGES - 1, elapsed + h, march->u);
        status = step_elastic(march, contact, h);
    } else {
        status = step_rigid(n, march, level, h, elapsed, tolerance);
    }
    for (int i = 0; i < n; i++) {
        const double mean = (march->acceleration[i] + march->v[i]) / h;
        march->acceleration[i] = isfinite(mean) ? mean : 0.0; /* steps of next to nothing */
    }
    return status;
}

/* The velocity that the fastest rigid contact would have without friction. */
static double free_velocity(const sm_contact *contact, const sm_segment *g) {
    const size_t n = (size_t)contact->contacts;
    double fastest = 0.0;
    for (size_t i = 0; i < n; i++) {
        double force_rate = 0.0;
        for (size_t j = 0; j < (size_t)contact->modes; j++) {
            const double *L = contact->coupling + 2 * (j * n + i), *a = g->amplitude_end + 2 * j;
            force_rate += 2.0 * g->frequency[j]
                          * sqrt((L[0] * L[0] + L[1] * L[1]) * (a[0] * a[0] + a[1] * a[1]));
        }
        fastest = fmax(fastest, force_rate / contact->stiffness[i * (n + 1)]);
    }
    return fastest;
}

/* Seconds in which the slowest to die away of the rigid contacts' own vibrations has done so;
 * infinite: it does not. */
static double lasting(const sm_contact *contact) {
    const size_t n = (size_t)contact->contacts;
    double longest = 0.0;
    for (size_t k = 0; k < n * n; k += n + 1) {
        const double mass = contact->mass ? contact->mass[k] : 0.0;
        longest = fmax(longest, mass > 0.0 ? 2.0 * mass / contact->damping[k] : INFINITY);
    }
    return DEAD * longest;
}

/* By how much velocities parted from straight lines in a step of h seconds, at most. */
SM_INLINE double bend(const int n, const sm_march *march, double h) {
    const double *v = march->before + n, *acceleration = march->before + 3 * n;
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        const double bent = fabs(march->v[i] - v[i] - h * acceleration[i]);
        most = bent > most ? bent : most;
    }
    return most;
}

/* Steps of h 2^-level seconds, of rigid contacts; time is counted in the finest of them. */
typedef struct {
    double from, h;
    int finest;         /* level */
    int64_t whole, end; /* a step of level 0, and all */
    int64_t lasting;    /* from where on vibrations last to the end */
    double bend;        /* of a velocity that is allowed; infinite: any */
    int to_be_read;
    double last; /* elastic contacts: the part of the last step that is left to be read from */
} sm_steps;

static sm_status divide(const sm_contact *contact, const sm_segment *segment, double from,
                        double to, int steps_per_period, sm_detail detail, sm_steps *steps) {
    double fastest = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        const double end = segment->frequency[j] + segment->frequency_rate[j] * segment->duration;
        fastest = fmax(fastest, fmax(fabs(segment->frequency[j]), fabs(end)));
    }
    const double longest = SM_TWO_PI / (fastest * steps_per_period);
    const double count = ceil((to - from) / longest * (1.0 - 1e-9));
    if (!(count <= MAX_STEPS)) return SM_BAD_ARGUMENT;
    const int elastic = contact->law == SM_ELASTIC;
    *steps = (sm_steps){.from = from,
                        .h = (to - from) / fmax(count, 1.0),
                        .finest = !elastic && detail != SM_UNHALVED ? RIGID_HALVINGS : 0,
                        .bend = INFINITY,
                        .to_be_read = detail == SM_TO_BE_READ};
    if (elastic && steps->to_be_read && steps->h > 1.2 * READ_FROM * longest)
        steps->last = READ_FROM * longest;
    /* steps that are short already need fewer halvings */
    while (steps->finest > 0 && steps->h <= ldexp(0.6 * longest, steps->finest - RIGID_HALVINGS))
        steps->finest--;
    steps->whole = (int64_t)1 << steps->finest;
    steps->end = steps->whole * (int64_t)fmax(count, 1.0);
    if (steps->finest > 0) {
        steps->bend = BEND * free_velocity(contact, segment);
        const double before = 1.0 - lasting(contact) / (to - from);
        steps->lasting = before > 0.0 ? (int64_t)(before * (double)steps->end) : 0;
    }
    return SM_OK;
}

/* Of the next step: that level, or a finer one where longer steps are to follow. */
SM_INLINE int next_level(const sm_steps *steps, int level, int64_t at) {
    while (level < steps->finest && (at & ((steps->whole >> level) - 1)) != 0) level++;
    return level;
}

/* Of elastic contacts; the last one in two where they are to be read at its end. */
SM_INLINE sm_status take_elastic_steps(const int n, sm_march *march, const sm_steps *steps) {
    const double length[] = {steps->h - steps->last, steps->last};
    for (int64_t k = 0; k < steps->end; k++) {
        const int split = steps->last > 0.0 && k + 1 == steps->end;
        double elapsed = steps->from + steps->h * (double)k;
        for (int part = 0; part < 1 + split; part++) {
            const double h = split ? length[part] : steps->h;
            const int level = split ? part : steps->last > 0.0 ? 2 : 0;
            const sm_status status = step(n, march, level, h, elapsed, ON_THE_WAY);
            if (status != SM_OK) return status;
            elapsed += h;
            sm_forcing_advance(&march->forcing, level, elapsed);
        }
    }
    return SM_OK;
}

SM_INLINE sm_status take_steps(const int n, sm_march *march, const sm_steps *steps) {
    const sm_contact *contact = march->forcing.contact;
    const int watched = isfinite(steps->bend);
    const int early_finest = steps->finest < EARLY_HALVINGS ? steps->finest : EARLY_HALVINGS;
    const double least = ldexp(steps->h, -steps->finest);
    int level = 0;
    march->level = -1;
    for (int64_t at = 0; at < steps->end;) {
        level = next_level(steps, level, at);
        const int64_t parts = steps->whole >> level;
        const double h = least * (double)parts, elapsed = steps->from + least * (double)at;
        const int last = at + parts == steps->end;
        const double allowed = last && steps->to_be_read ? AS_READ * steps->bend : steps->bend;
        const int finest = at < steps->lasting ? early_finest : steps->finest;
        if (watched) read_rigid(n, march, march->before);
        const sm_status status =
            step(n, march, level, h, elapsed, last ? AT_THE_END : ON_THE_WAY);
        if (status != SM_OK) return status;
        const double bent = watched ? bend(n, march, h) : 0.0;
        if (bent > allowed && level < finest) {
            sm_march_start(march, contact, march->before);
            march->level = -1;
            level += bent > 4.0 * allowed && level + 1 < finest ? 2 : 1;
            continue;
        }
        sm_forcing_advance(&march->forcing, level, elapsed + h);
        at += parts;
        if (bent < STRAIGHT * steps->bend && level > 0) level--;
    }
    return SM_OK;
}

SM_HOT_ONE sm_status sm_march_along(sm_march *march, const sm_contact *contact,
                                    const sm_segment *segment, double from, double to,
                                    int steps_per_period, sm_detail detail) {
    sm_steps steps;
    sm_status status = divide(contact, segment, from, to, steps_per_period, detail, &steps);
    if (status != SM_OK) return status;
    const int n = contact->contacts;
    const int reacting = contact->response && segment->reaction_start && segment->reaction_end;
    sm_reaction *reaction = reacting ? &march->reaction : NULL;
    if (steps.last > 0.0) {
        const double length[] = {steps.h - steps.last, steps.last};
        sm_forcing_start_two(&march->forcing, contact, segment, reaction, from, length);
    } else {
        sm_forcing_start(&march->forcing, contact, segment, reaction, from, steps.h, steps.finest);
    }
    if (contact->law == SM_ELASTIC)
        status = take_elastic_steps(n, march, &steps);
    else
        status = n == 2 ? take_steps(2, march, &steps) : take_steps(n, march, &steps);
    if (status != SM_OK) return status;
    /* a NaN or infinity anywhere on the way is still in the displacement */
    const size_t count = (size_t)n;
    const int finite = sm_all_finite(march->x, count) && sm_all_finite(march->v, count)
                       && sm_all_finite(march->force, count);
    return finite ? SM_OK : SM_NOT_FINITE;
}
