/* Resource files in memory: takes the place of resources/location.c in a browser. */
#define _POSIX_C_SOURCE 200809L /* fmemopen */
#include "faces/browser/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "resources/files.h"

typedef struct {
    char name[56]; /* zero-terminated */
    uint64_t size; /* of the content */
} header;

void memory_location(const memory_files *files, char location[MEMORY_LOCATION]) {
    snprintf(location, MEMORY_LOCATION, "%lx", (unsigned long)(uintptr_t)files);
}

char *location_folder(const char *location, const char **reason) {
    char *folder = malloc(strlen(location) + 1);
    *reason = folder ? NULL : "out of memory";
    return folder ? strcpy(folder, location) : NULL;
}

FILE *location_open(const char *folder, const char *name) {
    const memory_files *files = (const void *)(uintptr_t)strtoul(folder, NULL, 16);
    header file;
    for (size_t at = 0; files->size - at >= sizeof file;) {
        memcpy(&file, files->bytes + at, sizeof file);
        at += sizeof file;
        if (file.size > files->size - at) return NULL;
        char *content = (char *)(uintptr_t)(files->bytes + at);
        if (strncmp(file.name, name, sizeof file.name) == 0)
            return fmemopen(content, (size_t)file.size, "rb");
        const size_t filled = ((size_t)file.size + sizeof file - 1) / sizeof file * sizeof file;
        if (filled > files->size - at) return NULL;
        at += filled;
    }
    return NULL;
}
