/* Reading .npy arrays. */
#include "resources/files.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC "\x93NUMPY\x01" /* and a minor version 0 */
#define DESCRIPTION 256        /* bytes of the description at most */

uint32_t npy_crc(uint32_t crc, const void *bytes, size_t count) {
    static const uint32_t nibble[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u,
        0x4db26158u, 0x5005713cu, 0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu,
        0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu};
    const unsigned char *byte = bytes;
    crc = ~crc;
    for (size_t k = 0; k < count; k++) {
        crc ^= byte[k];
        crc = (crc >> 4) ^ nibble[crc & 15u];
        crc = (crc >> 4) ^ nibble[crc & 15u];
    }
    return ~crc;
}

static int little_endian(void) {
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* Writes the description that numpy gives an array of this layout. */
static void describe(const npy_layout *layout, char text[DESCRIPTION]) {
    int length = snprintf(text, DESCRIPTION, "{'descr': '%s', 'fortran_order': False, 'shape': (",
                          layout->type == NPY_INT32 ? "<i4" : "<f8");
    for (int k = 0; k < layout->dimensions; k++)
        length += snprintf(text + length, (size_t)(DESCRIPTION - length), k > 0 ? ", %lu" : "%lu",
                           (unsigned long)layout->shape[k]);
    snprintf(text + length, (size_t)(DESCRIPTION - length),
             layout->dimensions == 1 ? ",), }" : "), }");
}

/* Reads up to the array; returns what is wrong, or NULL. */
static const char *read_description(FILE *file, const npy_layout *layout, uint32_t *crc) {
    unsigned char prefix[10];
    char expected[DESCRIPTION], found[DESCRIPTION];
    if (fread(prefix, 1, sizeof prefix, file) != sizeof prefix) return "it is truncated";
    if (memcmp(prefix, MAGIC, 7) != 0 || prefix[7] != 0)
        return "it is not an .npy file of version 1.0";
    const size_t length = prefix[8] + 256u * prefix[9];
    if (length >= DESCRIPTION) return "its header is damaged";
    if (fread(found, 1, length, file) != length) return "it is truncated";
    *crc = npy_crc(npy_crc(0, prefix, sizeof prefix), found, length);
    found[length] = '\0';
    describe(layout, expected);
    const size_t needed = strlen(expected);
    int same = length > needed && memcmp(found, expected, needed) == 0;
    for (size_t k = needed; same && k < length; k++) /* padded with spaces to the end of a line */
        same = found[k] == (k + 1 < length ? ' ' : '\n');
    return same ? NULL : "its header is damaged, or belongs to another model";
}

/* Returns the bytes from the present position to the end of a file; 0 if they are not known. */
static size_t bytes_left(FILE *file) {
    const long here = ftell(file);
    if (here < 0 || fseek(file, 0, SEEK_END) != 0) return 0;
    const long end = ftell(file);
    return fseek(file, here, SEEK_SET) == 0 && end > here ? (size_t)(end - here) : 0;
}

void *npy_read(FILE *file, const npy_layout *layout, uint32_t *crc, const char **reason) {
    if (!little_endian()) {
        *reason = "this machine is not little-endian";
        return NULL;
    }
    *reason = read_description(file, layout, crc);
    if (*reason) return NULL;
    const size_t left = bytes_left(file), most = SIZE_MAX / 2;
    size_t size = layout->type == NPY_INT32 ? sizeof(int32_t) : sizeof(double);
    for (int k = 0; k < layout->dimensions; k++) {
        const size_t extent = layout->shape[k];
        size = extent > 0 && size > most / extent ? most : size * extent;
    }
    if (size != left) {
        *reason = size > left ? "it is truncated" : "there is more in it than its array";
        return NULL;
    }
    void *data = malloc(size + 1);
    if (data && fread(data, 1, size, file) == size) {
        *crc = npy_crc(*crc, data, size);
        return data;
    }
    *reason = data ? "it is truncated" : "out of memory";
    free(data);
    return NULL;
}
