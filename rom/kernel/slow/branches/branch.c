/* Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977). */
#include <string.h>

#include "slow/branches/curve.h"

#define MOST SM_CURVE_UNKNOWNS
#define SHORTEST 1e-7      /* step, and distance of two points */
#define ROW(unknowns) (4 * (unknowns) + 2) /* doubles */
#define LARGEST_TURN 0.15  /* of the tangent between two points [rad] */
#define NEAR 1e-9          /* where a curve folds, or its stability changes */
#define SAME 1e-6          /* distance of solutions that are one */
#define BEND 0.05          /* of the length of a chord: how far the curve may be from it */

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
    sm_eigenvalues(k, point->jacobian, row + 2 * n);
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
    return turn < cos(LARGEST_TURN) ? SM_NOT_CONVERGED : SM_OK;
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

static int growing(int k, const double *eigenvalues) {
    int count = 0;
    for (int i = 0; i < k; i++) count += eigenvalues[2 * i] > 0.0;
    return count;
}

/* Where it changes from a row to the next what growing() counts, or, if it folds, turns back. */
static void bisect(const sm_curve *curve, const double *row, int folds, double *z) {
    const int k = curve->unknowns, n = k + 1, unstable = growing(k, row + 2 * n);
    const double *next = row + ROW(k), *onward = row + n;
    double low[MOST + 1], high[MOST + 1];
    memcpy(low, row, (size_t)n * sizeof *low);
    memcpy(high, next, (size_t)n * sizeof *high);
    for (int i = 0; i < 40; i++) {
        const double length = sm_curve_distance(n, low, high);
        double guess[MOST + 1], normal[MOST + 1], eigenvalues[2 * MOST];
        sm_curve_point at;
        for (int r = 0; r < n; r++) {
            guess[r] = 0.5 * (low[r] + high[r]);
            normal[r] = (high[r] - low[r]) / length;
        }
        if (length < NEAR
            || sm_curve_between(curve, guess, normal, onward, &at) != SM_OK)
            break;
        sm_eigenvalues(k, at.jacobian, eigenvalues);
        const int is_before =
            folds ? at.tangent[k] * onward[k] > 0.0 : growing(k, eigenvalues) == unstable;
        memcpy(is_before ? low : high, at.z, (size_t)n * sizeof *at.z);
    }
    memcpy(z, low, (size_t)n * sizeof *z);
}

sm_status sm_curve_specials(const sm_curve *curve, size_t count, const double *points,
                            uint8_t *folds, double *z, size_t *found) {
    if (!sm_curve_is_valid(curve) || !points || !folds || !z || !found) return SM_BAD_ARGUMENT;
    const int k = curve->unknowns, n = k + 1;
    *found = 0;
    for (size_t i = 0; i + 1 < count; i++) {
        const double *row = points + (ptrdiff_t)i * ROW(k), *next = row + ROW(k);
        const int change = growing(k, next + 2 * n) - growing(k, row + 2 * n);
        folds[*found] = row[n + k] * next[n + k] < 0.0;
        if (!folds[*found] && change != 2 && change != -2) continue;
        bisect(curve, row, folds[*found], z + *found * (size_t)n);
        ++*found;
    }
    return SM_OK;
}

/* Distance of z from the chord between two points, of that length. */
static double from_chord(int n, const double *z, const double *from, const double *to,
                         double length) {
    double along = 0.0, square = 0.0;
    for (int i = 0; i < n; i++) along += (z[i] - from[i]) * (to[i] - from[i]);
    const double part = fmax(0.0, fmin(1.0, along / (length * length)));
    for (int i = 0; i < n; i++) {
        const double apart = z[i] - from[i] - part * (to[i] - from[i]);
        square += apart * apart;
    }
    return sqrt(square);
}

sm_status sm_curve_passes(int32_t unknowns, size_t count, const double *points, size_t solutions,
                          const double *z, uint8_t *passed) {
    if (unknowns < 1 || unknowns > MOST || !points || !z || !passed) return SM_BAD_ARGUMENT;
    const int n = unknowns + 1;
    memset(passed, 0, solutions);
    for (size_t i = 0; i + 1 < count; i++) {
        const double *from = points + (ptrdiff_t)i * ROW(unknowns);
        const double *to = from + ROW(unknowns);
        const double length = sm_curve_distance(n, from, to), away = SAME + BEND * length;
        for (size_t s = 0; s < solutions; s++) {
            const double *at = z + s * (size_t)n;
            if (!passed[s] && fabs(at[unknowns] - from[unknowns]) <= length + away)
                passed[s] = from_chord(n, at, from, to, length) <= away;
        }
    }
    return SM_OK;
}
