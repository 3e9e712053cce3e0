/* Where the resources are: FMI 2.0 gives a URI, FMI 3.0 a native path. */
#ifndef FMU_LOCATION_H
#define FMU_LOCATION_H

#include <stdio.h>

/* The folder as a native path in UTF-8 that ends in a separator, in memory from malloc; NULL:
 * `reason` says why there is none. */
char *location_from_uri(const char *uri, const char **reason);
char *location_from_path(const char *path, const char **reason);

/* A file in the folder, opened for reading in binary; NULL if that is not possible. */
FILE *location_open(const char *folder, const char *name);

#endif
