/* Steps of an exponential integrator. The linear part of z' = A z + B (F + W u) is exact, forces are
   linear in each step. u is what a contact exerts beyond its stiffness in stick (0 while all sticks),
   a function of the contact coordinates c = R z at the end of the step, solved by Gauss-Seidel.
   A step in which a Coulomb contact sticks, slides or turns, or a tanh force changes by more than
   LARGEST_CHANGE of its limit, is halved, `levels` times at most. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LARGEST_CHANGE 0.2

enum { SLIDERS, TANH, COULOMB, TANGENTIAL, NORMAL };

typedef struct {
    int kind, first, count; /* sliders of this contact DOF */
    double a, b, c; /* Tanh: limit, alpha. Coulomb: limit. Frictional: see below */
} Contact;

static double clip(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* c + D limit tanh(c / alpha) = q: monotone in c */
static double creep(double q, double D, double limit, double alpha) {
    double low = q - D * limit, high = q + D * limit, c = q, last = high - low;
    for (int i = 0; i < 200; ++i) {
        const double t = tanh(c / alpha), miss = c + D * limit * t - q;
        if (miss > 0.0) high = c;
        else low = c;
        double next = c - miss / (1.0 + D * limit * (1.0 - t * t) / alpha);
        if (!(next >= low && next <= high) || fabs(next - c) > 0.5 * last) next = 0.5 * (low + high);
        last = fabs(next - c);
        if (fabs(next - c) <= 1e-15 * (fabs(q) + D * limit)) return next;
        c = next;
    }
    return c;
}

/* NORMAL: a = preload, b = stiffness, c = gap. The TANGENTIAL DOF before it: a = mu, b = stiffness. */
static double normal_force(const Contact *n, double x) { return fmax(0.0, n->a + n->b * (x - n->c)); }

static double beyond(const Contact *k, const double *x, double q, double D, const double *limits,
                     const double *stiffnesses, const double *before, double *after) {
    double u = 0.0;
    switch (k->kind) {
    case SLIDERS:
        for (int s = k->first; s < k->first + k->count; ++s) {
            const double reach = limits[s] / stiffnesses[s];
            after[s] = clip(before[s], x[0] - reach, x[0] + reach);
            u += stiffnesses[s] * after[s];
        }
        return u;
    case TANH: return (creep(q, D, k->a, k->b) - q) / D;
    case COULOMB: return clip(-q / D, -k->a, k->a);
    case TANGENTIAL: {
        const double reach = k->a * normal_force(k + 1, x[1]) / k->b;
        after[k->first] = clip(before[k->first], x[0] - reach, x[0] + reach);
        return k->b * after[k->first];
    }
    default: return k->b * x[0] - (normal_force(k, x[0]) - k->a);
    }
}

typedef struct {
    int n, contacts, forces, sliders, levels;
    /* one after the other for steps h, h / 2, h / 4, ... */
    const double *E, *G0, *G1, *H0, *H1, *D;
    const double *R;
    const Contact *laws;
    const double *limits, *stiffnesses;
    double *z, *u, *memory;
} March;

static int sliding(const Contact *k, double u) {
    return k->kind != COULOMB || fabs(u) < k->a * (1.0 - 1e-12) ? 0 : u > 0.0 ? 1 : -1;
}

/* 0, or 2 if Gauss-Seidel does not converge */
static int advance(const March *m, int level, const double *g0, const double *g1) {
    const int n = m->n, c = m->contacts, f = m->forces;
    const double *E = m->E + level * n * n, *G0 = m->G0 + level * n * c, *G1 = m->G1 + level * n * c;
    const double *H0 = m->H0 + level * n * f, *H1 = m->H1 + level * n * f, *D = m->D + level * c * c;
    double p[n], q[c + 1], x[c + 1], u[c + 1], after[m->sliders + 1];
    for (int i = 0; i < n; ++i) {
        double sum = 0.0;
        for (int j = 0; j < n; ++j) sum += E[i * n + j] * m->z[j];
        for (int j = 0; j < c; ++j) sum += G0[i * c + j] * m->u[j];
        for (int j = 0; j < f; ++j) sum += H0[i * f + j] * g0[j] + H1[i * f + j] * g1[j];
        p[i] = sum;
    }
    for (int i = 0; i < c; ++i) {
        q[i] = 0.0;
        u[i] = m->u[i];
        for (int j = 0; j < n; ++j) q[i] += m->R[i * n + j] * p[j];
    }
    int status = c ? 2 : 0;
    for (int sweep = 0; sweep < 1000 && status; ++sweep) {
        double change = 0.0, size = 1e-300;
        for (int i = 0; i < c; ++i) {
            const int pair = m->laws[i].kind == TANGENTIAL ? 2 : 1;
            for (int l = i; l < i + pair; ++l) {
                x[l] = q[l];
                for (int j = 0; j < c; ++j) x[l] += D[l * c + j] * u[j];
            }
            const double own = D[i * c + i];
            const double next = beyond(m->laws + i, x + i, x[i] - own * u[i], own, m->limits,
                                       m->stiffnesses, m->memory, after);
            change = fmax(change, fabs(next - u[i]));
            size = fmax(size, m->laws[i].kind == TANH ? m->laws[i].a : fabs(next));
            u[i] = next;
        }
        if (change <= 1e-12 * size) status = 0;
    }
    if (status) return status;
    int turns = 0;
    for (int i = 0; i < c; ++i)
        turns |= m->laws[i].kind == TANH
                     ? fabs(u[i] - m->u[i]) > LARGEST_CHANGE * m->laws[i].a
                     : sliding(m->laws + i, u[i]) != sliding(m->laws + i, m->u[i]);
    if (turns && level + 1 < m->levels) {
        double middle[f + 1];
        for (int j = 0; j < f; ++j) middle[j] = 0.5 * (g0[j] + g1[j]);
        status = advance(m, level + 1, g0, middle);
        return status ? status : advance(m, level + 1, middle, g1);
    }
    memcpy(m->memory, after, sizeof(double) * (size_t)m->sliders);
    memcpy(m->u, u, sizeof(double) * (size_t)c);
    memcpy(m->z, p, sizeof(double) * (size_t)n);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < c; ++j) m->z[i] += G1[i * c + j] * u[j];
    return 0;
}

/* `out`: z and u of each `every`-th step, the first after `every` steps. */
int march(const March *m, long steps, const double *force, long every, double *out) {
    for (long step = 0; step < steps; ++step) {
        const double *g = force + step * m->forces;
        const int status = advance(m, 0, g, g + m->forces);
        if (status) return status;
        if ((step + 1) % every) continue;
        memcpy(out, m->z, sizeof(double) * (size_t)m->n);
        memcpy(out + m->n, m->u, sizeof(double) * (size_t)m->contacts);
        out += m->n + m->contacts;
    }
    return 0;
}
