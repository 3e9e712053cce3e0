/* Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977). */
#include <string.h>

#include "slow/branches/curve.h"

#define MOST SM_CURVE_UNKNOWNS
#define SHORTEST 1e-7      /* step, and distance of two points */
#define ROW(unknowns) (2 * ((unknowns) + 1) + (unknowns) * (unknowns)) /* doubles */

/* Where points of a branch go: the rows that follow one another by `stride` doubles. */
typedef struct {
    double *row;
    ptrdiff_t stride;
    double sense; /* of the tangent in a row: 1, or -1 where the curve is followed backwards */
} rows;

static void put(const sm_curve *curve, rows out, size_t number, const sm_curve_point *point) {
    const int k = curve->unknowns, n = k + 1;
    double *row = out.row + (ptrdiff_t)number * out.stride;
    memcpy(row, point->z, (size_t)n * sizeof *row);
    for (int i = 0; i < n; i++) row[n + i] = out.sense * point->tangent[i];
    memcpy(row + 2 * n, point->jacobian, (size_t)(k * k) * sizeof *row);
}

/* The point at p = 0 or p = 1 between two. */
static sm_status at_end(const sm_curve *curve, const sm_curve_point *inside,
                        const sm_curve_point *outside, sm_curve_point *found) {
    const int k = curve->unknowns, n = k + 1;
    const double end = outside->z[k] > 1.0 ? 1.0 : 0.0;
    const double part = (end - inside->z[k]) / (outside->z[k] - inside->z[k]);
    double guess[MOST + 1], upwards[MOST + 1] = {0.0};
    for (int r = 0; r < n; r++) guess[r] = inside->z[r] + part * (outside->z[r] - inside->z[r]);
    guess[k] = end;
    upwards[k] = 1.0;
    return sm_curve_corrected(curve, guess, upwards, inside->tangent, found);
}

/* The next point at a distance along the tangent, guessed on the cubic through the last two and their
 * tangents, `before` being NULL at the first; unless the curve bends too much for it. */
static sm_status stepped(const sm_curve *curve, const sm_curve_point *before,
                         const sm_curve_point *last, double step, sm_curve_point *found) {
    const int n = curve->unknowns + 1;
    double guess[MOST + 1];
    for (int r = 0; r < n; r++) guess[r] = last->z[r] + step * last->tangent[r];
    if (before) {
        const double length = sm_curve_distance(n, last->z, before->z), on = step / length;
        for (int r = 0; r < n; r++) {
            const double chord = (last->z[r] - before->z[r]) / length;
            const double turned = last->tangent[r] - chord;
            const double twisted = turned + before->tangent[r] - chord;
            guess[r] += step * on * (turned + (1.0 + on) * twisted);
        }
    }
    const sm_status status =
        sm_curve_corrected(curve, guess, last->tangent, last->tangent, found);
    if (status != SM_OK) return status;
    const double turn = sm_curve_dot(n, found->tangent, last->tangent);
    return turn < cos(0.15) ? SM_NOT_CONVERGED : SM_OK;
}

/* From a start on along its tangent; how many points there are, at most `most`. */
static size_t traced(const sm_curve *curve, const sm_curve_point *start, size_t most, rows out,
                     int *closed) {
    const int k = curve->unknowns, n = k + 1;
    sm_curve_point before, last = *start, next;
    double step = 0.25 * curve->largest_step;
    size_t count = 1;
    int far = 0;
    put(curve, out, 0, start);
    while (count < most) {
        if (stepped(curve, count > 1 ? &before : NULL, &last, step, &next) != SM_OK) {
            step *= 0.5;
            if (step < SHORTEST) break;
            continue;
        }
        if (next.z[k] < 0.0 || next.z[k] > 1.0) {
            sm_curve_point end;
            if (at_end(curve, &last, &next, &end) == SM_OK
                && sm_curve_distance(n, end.z, last.z) > SHORTEST)
                put(curve, out, count++, &end);
            break;
        }
        /* steps grow where Newton's method has little to do */
        if (next.passes <= 3) step = fmin(1.5 * step, curve->largest_step);
        put(curve, out, count++, &next);
        const double away = sm_curve_distance(n, next.z, start->z);
        if (far && away < step && sm_curve_dot(n, next.tangent, start->tangent) > 0.0) {
            *closed = 1;
            break;
        }
        far |= away > 2.0 * step;
        before = last;
        last = next;
    }
    return count;
}

sm_status sm_curve_branch(const sm_curve *curve, const double *start, size_t most, double *points,
                          sm_branch *branch) {
    if (!sm_curve_is_valid(curve) || !start || !points || !branch || most < 1)
        return SM_BAD_ARGUMENT;
    const int k = curve->unknowns, n = k + 1;
    const ptrdiff_t row = ROW(k);
    double upwards[MOST + 1] = {0.0};
    sm_curve_point at;
    upwards[k] = 1.0;
    const sm_status status = sm_curve_corrected(curve, start, upwards, upwards, &at);
    if (status != SM_OK) return status;
    double *middle = points + (ptrdiff_t)(most - 1) * row;
    const rows onwards = {middle, row, 1.0}, back = {middle, -row, -1.0};
    int comes_back = 0;
    branch->after = traced(curve, &at, most, onwards, &comes_back) - 1;
    branch->before = 0;
    branch->closed = comes_back;
    if (branch->closed) return SM_OK;
    for (int i = 0; i < n; i++) at.tangent[i] = -at.tangent[i];
    branch->before = traced(curve, &at, most, back, &comes_back) - 1;
    return SM_OK;
}

sm_status sm_curve_point_near(const sm_curve *curve, const double *guess, const double *normal,
                              const double *onward, double *point) {
    if (!sm_curve_is_valid(curve) || !guess || !normal || !onward || !point) return SM_BAD_ARGUMENT;
    sm_curve_point found;
    const sm_status status = sm_curve_between(curve, guess, normal, onward, &found);
    if (status == SM_OK) put(curve, (rows){point, 0, 1.0}, 0, &found);
    return status;
}
