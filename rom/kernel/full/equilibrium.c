#include <stdlib.h>
#include <string.h>

#include "base/check.h"
#include "contact/elastic/solve.h"

sm_status sm_elastic_equilibrium(const sm_elastic *elastic, int32_t contacts,
                                 const double *flexibility, const double *displacement, double *x,
                                 double *force) {
    const sm_status given = sm_elastic_check(elastic, contacts);
    if (given != SM_OK) return given;
    if (!flexibility || !displacement || !x || !force) return SM_BAD_ARGUMENT;
    const size_t n = (size_t)contacts, solver_size = sm_elastic_solver_size(elastic, contacts);
    if (!sm_all_finite(flexibility, n * n) || !sm_all_finite(displacement, n))
        return SM_NOT_FINITE;
    double *block = calloc(solver_size + sm_elastic_memory(elastic), sizeof(double));
    if (!block) return SM_NO_MEMORY;
    sm_elastic_solver solver;
    sm_elastic_solver_place(&solver, elastic, contacts, flexibility, block);
    memcpy(x, displacement, n * sizeof(double)); /* as if all stuck */
    const sm_status status = sm_elastic_solve(&solver, displacement, block + solver_size, x);
    if (status == SM_OK) memcpy(force, solver.f, n * sizeof(double));
    free(block);
    return status;
}
