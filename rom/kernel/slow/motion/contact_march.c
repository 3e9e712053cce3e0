/* Time integration of the contacts along a slow trajectory: eq. (12) with slowly varying
 * amplitudes. Steps are parts of a carrier period; elastic contacts are quasi-static. A rigid
 * contact that begins to slip vibrates with its mass on the stiffness of the structure, for a
 * fraction of a period: steps that do not resolve this vibration are halved. contact_motion.c
 * and the component (contact_output.c) call it. */
#include "slow/motion/contact_march.h"

#include "base/check.h"

/* In units of the allowed deviation of a velocity from a straight line [-], which is proportional to
 * the square of the step: the largest deviation in a last step that is read; the deviation above
 * which half the step would deviate too much, so that it is halved twice; the deviation below which
 * the next step is twice as long. */
#define CURVED_LAST 0.3
#define VERY_CURVED 4.0
#define STRAIGHT 0.2
/* Tolerance of the stages before the last step, of the friction limits [-]. */
#define STAGE_TOLERANCE 1e-5

/* Returns the number of doubles of the memory of the contact laws. */
static size_t memory_count(const sm_contact *contact) {
    return contact->law == SM_ELASTIC ? sm_elastic_memory(contact->elastic) : 0;
}

void sm_march_place(sm_march *march, const sm_contact *contact, int orders, sm_block *block) {
    const int contacts = contact->contacts;
    const size_t n = (size_t)contacts;
    sm_forcing_place(&march->forcing, contacts, orders, block);
    march->force = sm_take(block, n);
    if (contact->law == SM_ELASTIC) {
        march->flexibility = sm_take(block, n * n);
        for (size_t k = 0; k < n * n && block->memory; k++)
            march->flexibility[k] = -contact->stiffness[k];
        SM_TAKE_EACH(block, n, &march->u, &march->x, &march->v);
        march->memory = sm_take(block, memory_count(contact));
        sm_elastic_solver_place(&march->solver, contact->elastic, contacts, march->flexibility,
                                block);
        return;
    }
    march->acceleration = sm_take(block, n);
    march->before = sm_take(block, 4 * n); /* rows of keep_rigid */
    for (int level = 0; level < SM_RIGID_LEVELS; level++)
        sm_stepper_place(&march->stepper[level], contacts, block);
    sm_lanes_place(&march->lane, contacts, 1, block);
    march->x = march->lane.x;
    march->v = march->lane.v;
}

size_t sm_march_state_count(const sm_contact *contact) {
    const size_t n = (size_t)contact->contacts;
    return contact->law == SM_ELASTIC ? 3 * n + memory_count(contact) : 5 * n;
}

/* Sets the rows of a state, which have one number per contact; returns the number of rows. */
static int rows_of(const sm_march *march, const sm_contact *contact, double *row[5]) {
    row[0] = march->x;
    row[1] = march->v;
    row[2] = march->force;
    row[3] = march->acceleration;
    row[4] = march->lane.inertia;
    return contact->law == SM_ELASTIC ? 3 : 5;
}

void sm_march_start(sm_march *march, const sm_contact *contact, const double *state) {
    const size_t n = (size_t)contact->contacts;
    double *row[5];
    const int rows = rows_of(march, contact, row);
    for (int k = 0; k < rows; k++)
        for (size_t i = 0; i < n; i++) row[k][i] = state ? state[(size_t)k * n + i] : 0.0;
    for (size_t k = 0; k < memory_count(contact); k++)
        march->memory[k] = state ? state[3 * n + k] : 0.0;
    for (size_t i = 0; contact->law != SM_ELASTIC && i < n; i++)
        march->lane.stage_v[0][i] = march->lane.stage_v[1][i] = march->v[i];
}

void sm_march_read(const sm_march *march, const sm_contact *contact, double *state) {
    const size_t n = (size_t)contact->contacts;
    double *row[5];
    const int rows = rows_of(march, contact, row);
    for (int k = 0; k < rows; k++) memcpy(state + (size_t)k * n, row[k], n * sizeof *state);
    if (contact->law == SM_ELASTIC)
        memcpy(state + 3 * n, march->memory, memory_count(contact) * sizeof *state);
}

/* Computes the friction force r - S v, and limits it to the friction limit because of rounding. */
SM_INLINE void find_force(const int n, const sm_stepper *s, sm_march *march) {
    for (int i = 0; i < n; i++) {
        const double limit = s->laws[i].limit;
        double g = march->lane.r[i];
        for (int j = 0; j < n; j++) g -= s->matrix[i * n + j] * march->lane.v[j];
        march->force[i] = g > limit ? limit : g < -limit ? -limit : g;
    }
}

/* Makes a step of h seconds of elastic contacts, whose displacements would be u if all stuck. */
static sm_status step_elastic(sm_march *march, const double *u, double h) {
    const sm_contact *contact = march->forcing.contact;
    const int n = contact->contacts;
    double *last_x = march->v;
    memcpy(last_x, march->x, (size_t)n * sizeof *last_x); /* x is also the initial guess */
    SM_TRY(sm_elastic_solve(&march->solver, u, march->memory, march->x));
    for (int i = 0; i < n; i++) {
        march->v[i] = (march->x[i] - last_x[i]) / h;
        march->force[i] = march->solver.f[i];
    }
    memcpy(march->memory, march->solver.next, memory_count(contact) * sizeof(double));
    return SM_OK;
}

/* Keeps the numbers that a rigid step changes, or restores them. */
SM_INLINE void keep_rigid(const int n, sm_march *march, int restores) {
    double *row[] = {march->x, march->v, march->force, march->lane.inertia};
    double *kept = march->before;
    for (size_t k = 0; k < sizeof row / sizeof *row; k++, kept += n)
        memcpy(restores ? row[k] : kept, restores ? kept : row[k], (size_t)n * sizeof *kept);
    for (int i = 0; restores && i < n; i++)
        march->lane.stage_v[0][i] = march->lane.stage_v[1][i] = march->v[i];
}

/* Returns the largest deviation of velocities v from straight lines, h seconds after the start of
 * the step [m/s]. */
SM_INLINE double deviation(const int n, const sm_march *march, const double *v, double h) {
    const double *start = march->before + n, *acceleration = march->acceleration;
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        const double off = fabs(v[i] - start[i] - h * acceleration[i]);
        most = off > most ? off : most;
    }
    return most;
}

/* Makes a step of h seconds of rigid contacts at a level: the fraction `part` of the longest step,
 * which begins at its fraction `at`. If the deviation `curved` of a velocity from a straight line
 * exceeds `allowed`, it returns after this stage. */
SM_INLINE sm_status step_rigid(const int n, sm_march *march, int level, double h, double at,
                               double part, double tolerance, double allowed, double *curved) {
    sm_stepper *stepper = &march->stepper[level];
    sm_lanes *lane = &march->lane;
    if (level != march->level) { /* another step size, and with it another matrix S */
        SM_TRY(sm_stepper_set(stepper, march->forcing.contact, h));
        lane->rows = 0;
        march->level = level;
    }
    stepper->tolerance = tolerance;
    keep_rigid(n, march, 0);
    for (int stage = 0; stage < 2; stage++) {
        const double end = stage == 0 ? SM_FIRST_END : 1.0;
        sm_forcing_load(n, &march->forcing, at + end * part, lane->u);
        SM_TRY(sm_stage_one(stepper, lane, stage));
        *curved = deviation(n, march, lane->v, end * h);
        if (*curved > allowed) return SM_OK;
    }
    find_force(n, stepper, march);
    const double per_h = 1.0 / h;
    for (int i = 0; i < n; i++) {
        const double mean = (march->v[i] - march->before[n + i]) * per_h;
        march->acceleration[i] = isfinite(mean) ? mean : 0.0; /* 1 / h of a very short step */
    }
    return SM_OK;
}

/* Integrates rigid contacts over the steps. */
SM_INLINE sm_status integrate_rigid(const int n, sm_march *march, const sm_steps *steps) {
    const double least = ldexp(1.0, -steps->finest);
    int level = 0;
    int64_t known = 0; /* time up to which the forcing is known */
    march->level = -1;
    sm_forcing_find(n, 1, &march->forcing, steps->from);
    for (int64_t at = 0; at < steps->end;) {
        if (at == known) {
            known += steps->whole;
            sm_forcing_advance(n, &march->forcing,
                               steps->from + steps->h * least * (double)known);
        }
        level = sm_next_level(steps, level, at);
        const int64_t parts = steps->whole >> level;
        const double part = least * (double)parts;
        const double within = 1.0 - least * (double)(known - at);
        const int last = at + parts == steps->end;
        const int finest = at < steps->resolved ? 0 : steps->finest;
        const double allowed = (last && steps->to_be_read ? CURVED_LAST : 1.0) * steps->allowed;
        const double tolerance = last ? SM_READ_TOLERANCE : STAGE_TOLERANCE;
        double curved;
        SM_TRY(step_rigid(n, march, level, steps->h * part, within, part, tolerance,
                          level < finest ? allowed : INFINITY, &curved));
        if (level < finest && curved > allowed) {
            keep_rigid(n, march, 1);
            level += curved > VERY_CURVED * allowed && level + 1 < finest ? 2 : 1;
            continue;
        }
        at += parts;
        if (curved < STRAIGHT * steps->allowed && level > 0) level--;
    }
    return SM_OK;
}

/* Makes `count` equal steps of elastic contacts. */
SM_INLINE sm_status integrate_elastic(const int n, sm_march *march, const sm_steps *steps,
                                 int64_t count) {
    for (int64_t k = 1; k <= count; k++) {
        const double elapsed = steps->from + steps->h * (double)k;
        sm_forcing_turn(&march->forcing, elapsed);
        sm_forcing_find(n, 0, &march->forcing, elapsed);
        SM_TRY(step_elastic(march, march->forcing.value, steps->h));
    }
    return SM_OK;
}

/* Makes the last step of elastic contacts as a long and a short step: the velocity, which is read,
 * is the mean over the short one. */
SM_INLINE sm_status finish_elastic(const int n, sm_march *march, const sm_steps *steps,
                                int64_t count) {
    sm_forcing *forcing = &march->forcing;
    sm_forcing_find(n, 1, forcing, steps->from + steps->h * (double)(count - 1));
    sm_forcing_advance(n, forcing, steps->from + steps->h * (double)count);
    const double part = ldexp(1.0, -steps->finest);
    sm_forcing_load(n, forcing, 1.0 - part, march->u);
    SM_TRY(step_elastic(march, march->u, steps->h * (1.0 - part)));
    return step_elastic(march, forcing->value, steps->h * part);
}

SM_HOT_ONE sm_status sm_march_along(sm_march *march, const sm_contact *contact,
                                    const sm_segment *segment, double from, double to,
                                    int steps_per_period, sm_detail detail) {
    sm_steps steps = {.from = from, .to = to};
    SM_TRY(sm_choose_steps(contact, segment, steps_per_period, detail, &steps));
    const int n = contact->contacts;
    sm_forcing_start(&march->forcing, contact, segment, from, steps.h);
    if (contact->law == SM_ELASTIC) {
        const int64_t count = steps.end / steps.whole, same = steps.finest > 0 ? count - 1 : count;
        SM_TRY(integrate_elastic(n, march, &steps, same));
        if (same < count) SM_TRY(finish_elastic(n, march, &steps, count));
    } else {
        SM_TRY(n == 2 ? integrate_rigid(2, march, &steps) : integrate_rigid(n, march, &steps));
    }
    /* a NaN or infinity during the integration remains in the displacement */
    const size_t count = (size_t)n;
    const int finite = sm_all_finite(march->x, count) && sm_all_finite(march->v, count)
                       && sm_all_finite(march->force, count);
    return finite ? SM_OK : SM_NOT_FINITE;
}
