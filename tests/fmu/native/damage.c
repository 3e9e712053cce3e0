/* Resources that are not what was exported. */
#include <stdio.h>
#include <string.h>

#include "sequence.h"

static const char *const FILES[] = {
    "token.txt", "checksums.npy", "layout.npy", "constants.npy", "inputs.npy", "combinations.npy",
    "node_a.npy", "node_b.npy", "table.npy", "rate_correction.npy", "detuning.npy", "contact_limit.npy",
    "contact_stiffness.npy", "contact_damping.npy", "contact_mass.npy", "contact_coupling.npy",
    "contact_elements.npy", "contact_sliders.npy", "contact_reference.npy",
    "elastic_modes.npy", "elastic_contacts.npy", "elastic_response.npy", "contact_reaction.npy",
    "orders.npy", "tone.npy", "variables.npy", "names.txt"};

static void write_file(const char *path, const unsigned char *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    CHECK(file && fwrite(bytes, 1, size, file) == size, path);
    fclose(file);
}

void run_damage(const char *folder, const char *token) {
    static unsigned char bytes[1 << 22];
    char path[4096];
    const char *name = FILES[below((int)(sizeof FILES / sizeof *FILES))];
    snprintf(path, sizeof path, "%s%s", folder, name);
    FILE *file = fopen(path, "rb");
    CHECK(file, path);
    const size_t size = fread(bytes, 1, sizeof bytes - 1, file);
    fclose(file);
    const int kind = below(8), place = below((int)size);
    const unsigned char kept = bytes[place];
    if (kind == 0)
        CHECK(remove(path) == 0, path);
    else if (kind == 1)
        write_file(path, bytes, (size_t)place);
    else if (kind == 2) {
        bytes[size] = 'x';
        write_file(path, bytes, size + 1);
    } else {
        bytes[place] ^= (unsigned char)(1 << below(8));
        write_file(path, bytes, size);
        bytes[place] = kept;
    }
    const long before = messages.count;
    void *c = fmi->instantiate(below(2), "name", token, folder, &messages);
    CHECK(!c, name);
    CHECK(messages.count == before + 1 && messages.last_status == ERROR, name);
    /* a wrong checksum is known only by the file that it does not fit */
    CHECK(strstr(messages.last, name) || strstr(messages.last, "token") ||
              (strcmp(name, "checksums.npy") == 0 && strstr(messages.last, "resources/")),
          name);
    write_file(path, bytes, size);
}
