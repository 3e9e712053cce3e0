/* Runs one group of checks of the core, or lists them: driver [group [times]].
 *
 * Random calls are made, and the long run is, that many times as often.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void check_friction(void);
void check_frictional_contact(void);
void check_full(void);
void check_elastic(void);
void check_torus(void);
void check_torus_growth(void);
void check_harmonics(void);
void check_motion(void);
void check_table(void);
void check_curves(void);
void check_slow_flow(void);
void check_directional(void);
void check_disk(void);
void check_component(void);
void check_component_refusals(void);
void check_component_trace(void);
void check_long_run(int times);
void check_random_calls(int times);

static int times = 1;

static void long_run(void) { check_long_run(times); }

static void random_calls(void) { check_random_calls(times); }

static const struct {
    const char *name;
    void (*run)(void);
} GROUPS[] = {{"friction", check_friction},
              {"frictional-contact", check_frictional_contact},
              {"full", check_full},
              {"elastic", check_elastic},
              {"torus", check_torus},
              {"torus-growth", check_torus_growth},
              {"motion", check_motion},
              {"harmonics", check_harmonics},
              {"table", check_table},
              {"curves", check_curves},
              {"slow-flow", check_slow_flow},
              {"directional", check_directional},
              {"disk", check_disk},
              {"component", check_component},
              {"component-refusals", check_component_refusals},
              {"component-trace", check_component_trace},
              {"long-run", long_run},
              {"random-calls", random_calls}};

int main(int argc, char **argv) {
    if (argc > 2) times = atoi(argv[2]);
    for (size_t g = 0; g < sizeof GROUPS / sizeof *GROUPS; g++) {
        if (argc < 2) puts(GROUPS[g].name);
        if (argc > 1 && strcmp(argv[1], GROUPS[g].name) == 0) {
            GROUPS[g].run();
            return EXIT_SUCCESS;
        }
    }
    return argc < 2 ? EXIT_SUCCESS : EXIT_FAILURE;
}
