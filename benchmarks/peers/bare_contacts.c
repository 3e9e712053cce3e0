/* The least cost of marching two tanh contacts: the arithmetic of the core's stages on one group of
 * lanes, written out for two contacts, with a fixed number of Chebyshev steps and no tests. The
 * cost of a friction table over this loop is the cost of its generality and its checks.
 */
#include <math.h>

#include "contact/stepper.h"

#define STEPS_OF_CHEBYSHEV 3 /* the core's most frequent number */

typedef struct {
    double S00, S01, S11, K00, K01, K11, limit[2], alpha[2];
    const sm_resolvent *laws;
} two_contacts;

/* Velocities of every lane, from u - K x and the previous velocities. */
SM_INLINE void solve_pair(const two_contacts *c, const double *restrict u,
                          const double *restrict x, double *restrict v) {
    SM_SIMD
    for (int l = 0; l < SM_LANES; l++) {
        const double x0 = x[l], x1 = x[SM_LANES + l];
        const double r0 = u[l] - c->K00 * x0 - c->K01 * x1;
        const double r1 = u[SM_LANES + l] - c->K01 * x0 - c->K11 * x1;
        const double y0 = r0 - c->S01 * v[SM_LANES + l], y1 = r1 - c->S01 * v[l];
        const double w0 = sm_tanh_guess(&c->laws[0], fabs(y0) / c->limit[0]);
        const double w1 = sm_tanh_guess(&c->laws[1], fabs(y1) / c->limit[1]);
        v[l] = copysign(c->alpha[0] * w0, y0);
        v[SM_LANES + l] = copysign(c->alpha[1] * w1, y1);
    }
    for (int k = 0; k < STEPS_OF_CHEBYSHEV; k++) {
        SM_SIMD
        for (int l = 0; l < SM_LANES; l++) {
            const double x0 = x[l], x1 = x[SM_LANES + l];
            const double v0 = v[l], v1 = v[SM_LANES + l];
            const double w0 = v0 / c->alpha[0], w1 = v1 / c->alpha[1];
            const double e0 = sm_exp_negative(-2.0 * fabs(w0));
            const double e1 = sm_exp_negative(-2.0 * fabs(w1));
            const double i0 = 1.0 / (1.0 + e0), i1 = 1.0 / (1.0 + e1);
            const double g0 = copysign(c->limit[0] * (1.0 - e0) * i0, w0);
            const double g1 = copysign(c->limit[1] * (1.0 - e1) * i1, w1);
            const double s0 = 4.0 * e0 * i0 * i0, s1 = 4.0 * e1 * i1 * i1;
            const double f0 = u[l] - c->K00 * x0 - c->K01 * x1 - g0 - c->S00 * v0 - c->S01 * v1;
            const double f1 =
                u[SM_LANES + l] - c->K01 * x0 - c->K11 * x1 - g1 - c->S01 * v0 - c->S11 * v1;
            const double J0 = c->S00 + c->limit[0] / c->alpha[0] * s0;
            const double J1 = c->S11 + c->limit[1] / c->alpha[1] * s1;
            const double inverse = 1.0 / (J0 * J1 - c->S01 * c->S01);
            const double d0 = (J1 * f0 - c->S01 * f1) * inverse;
            const double d1 = (J0 * f1 - c->S01 * f0) * inverse;
            const double z0 = d0 / c->alpha[0], z1 = d1 / c->alpha[1];
            const double b0 = z0 * z0 < 1.0 ? g0 * s0 * z0 * z0 : 0.0;
            const double b1 = z1 * z1 < 1.0 ? g1 * s1 * z1 * z1 : 0.0;
            v[l] = v0 + d0 + (J1 * b0 - c->S01 * b1) * inverse;
            v[SM_LANES + l] = v1 + d1 + (J0 * b1 - c->S01 * b0) * inverse;
        }
    }
}

/* u = Re sum_q reaction_q turn_q, sums_q += x weight_q: SM_LANES lanes of two contacts. */
SM_INLINE void load_pair(int orders, const double *restrict reaction, const double *restrict phasor,
                         double *restrict u) {
    for (int i = 0; i < 2; i++) {
        double sum[SM_LANES] = {0.0};
        for (int q = 0; q < orders; q++) {
            const double *restrict re = reaction + (size_t)(2 * q + i) * 2 * SM_LANES;
            SM_SIMD
            for (int l = 0; l < SM_LANES; l++)
                sum[l] = sum[l] + re[l] * phasor[2 * q] - re[SM_LANES + l] * phasor[2 * q + 1];
        }
        memcpy(u + i * SM_LANES, sum, sizeof sum);
    }
}

SM_INLINE void sum_pair(int orders, const double *restrict x, const double *restrict phasor,
                        double *restrict sums) {
    for (int q = 0; q < orders; q++)
        for (int i = 0; i < 2; i++) {
            double *restrict re = sums + (size_t)(2 * q + i) * 2 * SM_LANES;
            SM_SIMD
            for (int l = 0; l < SM_LANES; l++) {
                re[l] += phasor[2 * q] * x[i * SM_LANES + l];
                re[SM_LANES + l] -= phasor[2 * q + 1] * x[i * SM_LANES + l];
            }
        }
}

/* `steps` steps of SM_LANES lanes, around and around a table of `period` steps:
 *   phasor (period, 2 stages, orders, 2), reaction and sums (orders, 2 contacts, 2, SM_LANES),
 *   x (2 contacts, SM_LANES). */
SM_API SM_HOT sm_status peer_bare_contacts(const sm_contact *contact, double h, int32_t steps,
                                           int32_t period, int32_t orders, const double *phasor,
                                           const double *reaction, double *sums, double *x) {
    if (contact->contacts != 2 || contact->law != SM_TANH) return SM_BAD_ARGUMENT;
    const double *K = contact->stiffness, *D = contact->damping, scale = SM_GAMMA * h;
    const sm_resolvent laws[2] = {
        sm_resolvent_make(SM_TANH, D[0] + scale * K[0], contact->limit[0], contact->alpha),
        sm_resolvent_make(SM_TANH, D[3] + scale * K[3], contact->limit[1], contact->alpha)};
    const two_contacts c = {.S00 = laws[0].s, .S01 = D[1] + scale * K[1], .S11 = laws[1].s,
                            .K00 = K[0], .K01 = K[1], .K11 = K[3],
                            .limit = {contact->limit[0], contact->limit[1]},
                            .alpha = {contact->alpha, contact->alpha}, .laws = laws};
    double base[2 * SM_LANES], u[2 * SM_LANES], v[2][2 * SM_LANES] = {{0.0}};
    for (int32_t k = 0; k < steps; k++) {
        const double *now = phasor + (size_t)(k % period) * 4 * (size_t)orders;
        load_pair(orders, reaction, now, u);
        for (int l = 0; l < 2 * SM_LANES; l++) base[l] = x[l] + scale * v[1][l];
        solve_pair(&c, u, base, v[0]);
        for (int l = 0; l < 2 * SM_LANES; l++)
            base[l] = x[l] + SM_BDF_WEIGHT * h * (v[0][l] + v[1][l]);
        load_pair(orders, reaction, now + 2 * orders, u);
        solve_pair(&c, u, base, v[1]);
        for (int l = 0; l < 2 * SM_LANES; l++) x[l] = base[l] + scale * v[1][l];
        sum_pair(orders, x, now + 2 * orders, sums);
    }
    return SM_OK;
}
