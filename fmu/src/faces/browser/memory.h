/* Resource files in memory, for a model that no file system holds. */
#ifndef FMU_MEMORY_H
#define FMU_MEMORY_H

#include <stddef.h>

/* The files one after the other, each a header and its content, filled up to whole headers. */
typedef struct {
    const char *bytes;
    size_t size;
} memory_files;

/* What `location_open` takes for the folder of these files, which must stay where they are. */
#define MEMORY_LOCATION 32 /* characters */
void memory_location(const memory_files *files, char location[MEMORY_LOCATION]);

#endif
