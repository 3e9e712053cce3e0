#include "fixtures.h"

#include <stdint.h>

#define MOST_BLOCKS 4096
static double *blocks[MOST_BLOCKS];
static size_t block_count;

double *new_doubles(size_t count) {
    double *values = calloc(count, sizeof(double));
    if (!values || block_count == MOST_BLOCKS) abort();
    return blocks[block_count++] = values;
}

void free_doubles(void) {
    while (block_count > 0) free(blocks[--block_count]);
}

problem new_problem(int contacts, int modes, int law) {
    const size_t n = (size_t)contacts;
    problem p = {.limit = new_doubles(n),
                 .stiffness = new_doubles(n * n),
                 .damping = new_doubles(n * n),
                 .coupling = new_doubles(2 * n * (size_t)modes)};
    for (int i = 0; i < contacts; i++) {
        p.limit[i] = 2.0 + 0.1 * i;
        for (int j = 0; j < contacts; j++) {
            const double k = 20.0 * pow(0.9, abs(i - j)) * (i == j ? 1.0 + 0.1 * i : 1.0);
            p.stiffness[i * contacts + j] = k;
            p.damping[i * contacts + j] = 0.01 * k;
        }
        for (int j = 0; j < modes; j++) {
            double *L = p.coupling + 2 * (j * contacts + i);
            L[0] = j == 0 ? -1.0 - 0.1 * i : -2.0 + 0.3 * i;
            L[1] = 0.02 * (i + 1);
        }
    }
    p.contact = (sm_contact){.contacts = contacts,
                             .modes = modes,
                             .law = law,
                             .alpha = 0.02,
                             .limit = p.limit,
                             .stiffness = p.stiffness,
                             .damping = p.damping,
                             .coupling = p.coupling};
    return p;
}

static const double FACTOR[SM_MODES][2] = {{0.03, -0.015}, {0.14, -0.06}};

/* own (1 - own^2 / 60) (1 + other^2 / 20) with d/down, d/dother and the mixed derivative */
static void polynomial(double own, double other, double value[4]) {
    const double f = own - own * own * own / 60.0, slope = 1.0 - own * own / 20.0;
    const double g = 1.0 + other * other / 20.0, g_slope = other / 10.0;
    value[0] = f * g;
    value[1] = slope * g;
    value[2] = f * g_slope;
    value[3] = slope * g_slope;
}

static double *new_nodes(int count) {
    double *node = new_doubles((size_t)count);
    for (int i = 0; i < count; i++) node[i] = 4.0 * pow((double)i / (count - 1), 1.5);
    return node;
}

table new_table(int modes, int count_a, int count_b) {
    const int b_count = modes == 2 ? count_b : 1;
    table t = {.node_a = new_nodes(count_a),
               .node_b = modes == 2 ? new_nodes(b_count) : NULL,
               .values = new_doubles((size_t)(count_a * b_count * 8 * modes))};
    for (int i = 0; i < count_a; i++)
        for (int k = 0; k < b_count; k++)
            for (int j = 0; j < modes; j++) {
                const double a = t.node_a[i], b = modes == 2 ? t.node_b[k] : 0.0;
                double value[4];
                polynomial(j == 0 ? a : b, j == 0 ? b : a, value);
                for (int d = 0; d < 4; d++) {
                    /* d/da is the slope in the other amplitude for mode B */
                    const int from = j == 1 && (d == 1 || d == 2) ? 3 - d : d;
                    double *v = t.values + ((i * b_count + k) * 4 + d) * 2 * modes + 2 * j;
                    v[0] = FACTOR[j][0] * value[from];
                    v[1] = FACTOR[j][1] * value[from];
                }
            }
    t.table = (sm_table){.modes = modes,
                         .count_a = count_a,
                         .count_b = b_count,
                         .node_a = t.node_a,
                         .node_b = t.node_b,
                         .values = t.values};
    return t;
}

table new_rich_table(int count_a, int count_b, int combinations) {
    table t = new_table(2, count_a, count_b);
    const int fields = 2 * (2 + combinations + 1), rows = count_a * count_b * 4;
    double *values = new_doubles((size_t)(rows * fields));
    for (int r = 0; r < rows; r++) {
        for (int f = 0; f < fields - 2; f++)
            values[r * fields + f] = t.values[r * 4 + f % 4] * (f < 4 ? 1.0 : 0.3);
        values[r * fields + fields - 2] = 0.2 * t.values[r * 4];
    }
    t.rate_correction = new_doubles((size_t)(rows * SM_RATE_CORRECTIONS));
    t.detuning = new_doubles((size_t)(rows * SM_RATE_CORRECTIONS));
    for (int r = 0; r < rows * SM_RATE_CORRECTIONS; r++) {
        t.rate_correction[r] = (r % 3 - 0.7) * t.values[r / SM_RATE_CORRECTIONS * 4 + r % 4];
        t.detuning[r] = (r % 5 - 1.9) * t.values[r / SM_RATE_CORRECTIONS * 4 + r % 4];
    }
    t.table.values = t.values = values;
    t.table.rate_correction = t.rate_correction;
    t.table.detuning = t.detuning;
    t.table.combinations = combinations;
    t.table.power = 1;
    return t;
}

sm_slow_flow flow_over(const table *t) {
    return (sm_slow_flow){
        .paper = 0, .natural = {1.0, 1.7}, .damping = {0.01, 0.0289}, .carrier = {1.0, 1.7},
        .table = t->table};
}

sm_inputs resonant_inputs(void) {
    return (sm_inputs){.force = {0.15, 0.25}, .frequency = {0.98, 1.65}, .limit_scale = 1.0};
}

double random_number(void) {
    static uint64_t x = 88172645463325252u; /* Marsaglia's xorshift */
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    return (double)(x >> 11) / 9007199254740992.0;
}

int random_below(int count) { return (int)(random_number() * count); }

double random_sign(void) { return 2.0 * random_number() - 1.0; }

double decades(double from, double count) { return pow(10.0, from + count * random_number()); }

/* Numbers that break naive code. None drives an honest computation into millions of steps. */
void spoil(double *values, size_t count) {
    const double numbers[] = {0.0,    -0.0,   -1.0,  NAN,    INFINITY, -INFINITY, 1e308,
                              -1e308, 1e-308, 1e-12, -1e-12, 5e-324,   1e-3,      3.999999};
    if (random_below(2))
        values[random_below((int)count)] = numbers[random_below((int)COUNT(numbers))];
}

void check_response(sm_status status, const double *values, size_t count) {
    CHECK(status >= SM_OK && status <= SM_STEP_TOO_SMALL);
    if (status == SM_OK) CHECK_FINITE(values, count);
}
