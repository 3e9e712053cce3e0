/* Runs one group of checks of the core, or lists them: driver [group]. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void check_friction(void);
void check_torus(void);
void check_torus_growth(void);
void check_harmonics(void);
void check_motion(void);
void check_table(void);
void check_slow_flow(void);
void check_directional(void);
void check_component(void);
void check_component_refusals(void);
void check_long_run(void);
void check_random_calls(void);

static const struct {
    const char *name;
    void (*run)(void);
} GROUPS[] = {{"friction", check_friction},
              {"torus", check_torus},
              {"torus-growth", check_torus_growth},
              {"motion", check_motion},
              {"harmonics", check_harmonics},
              {"table", check_table},
              {"slow-flow", check_slow_flow},
              {"directional", check_directional},
              {"component", check_component},
              {"component-refusals", check_component_refusals},
              {"long-run", check_long_run},
              {"random-calls", check_random_calls}};

int main(int argc, char **argv) {
    for (size_t g = 0; g < sizeof GROUPS / sizeof *GROUPS; g++) {
        if (argc < 2) puts(GROUPS[g].name);
        if (argc == 2 && strcmp(argv[1], GROUPS[g].name) == 0) {
            GROUPS[g].run();
            return EXIT_SUCCESS;
        }
    }
    return argc < 2 ? EXIT_SUCCESS : EXIT_FAILURE;
}
