/* The folder of the resource files, and opening them. */
#include "resources/files.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#define SEPARATOR '\\'
#else
#define SEPARATOR '/'
#endif

static char *from_path(const char *path, const char **reason) {
    *reason = "no resource path was given";
    if (!path || !*path) return NULL;
    const size_t length = strlen(path);
    char *folder = malloc(length + 2);
    *reason = folder ? NULL : "out of memory";
    if (!folder) return NULL;
    memcpy(folder, path, length + 1);
    if (folder[length - 1] != '/' && folder[length - 1] != SEPARATOR) {
        folder[length] = SEPARATOR;
        folder[length + 1] = '\0';
    }
    return folder;
}

/* Returns whether the text starts with a word of small letters, in letters of any case. */
static int starts_with(const char *text, const char *word) {
    for (; *word; text++, word++)
        if (tolower((unsigned char)*text) != *word) return 0;
    return 1;
}

/* Decodes %XX in place; 0 if XX are not two hexadecimal digits, or a zero byte. */
static int decode_percents(char *text) {
    char *to = text;
    for (const char *from = text; *from; from++, to++) {
        *to = *from;
        if (*from != '%') continue;
        if (!isxdigit((unsigned char)from[1]) || !isxdigit((unsigned char)from[2])) return 0;
        const char digits[3] = {from[1], from[2], '\0'};
        *to = (char)strtol(digits, NULL, 16);
        if (*to == '\0') return 0;
        from += 2;
    }
    *to = '\0';
    return 1;
}

/* Returns the path after file:, file:// or file://localhost; NULL if it is on another host. */
static const char *path_of(const char *after_scheme) {
    if (after_scheme[0] != '/' || after_scheme[1] != '/') return after_scheme;
    const char *authority = after_scheme + 2;
    if (starts_with(authority, "localhost/")) return authority + strlen("localhost");
    return *authority == '/' ? authority : NULL;
}

char *location_folder(const char *uri, const char **reason) {
    if (!uri || !starts_with(uri, "file:")) {
        if (uri && strstr(uri, "://")) {
            *reason = "the resource location is not a file: URI";
            return NULL;
        }
        return from_path(uri, reason); /* as some importers of FMI 2.0 do */
    }
    const char *path = path_of(uri + strlen("file:"));
    if (!path) {
        *reason = "the resource location is on another host";
        return NULL;
    }
#if defined(_WIN32)
    if (path[0] == '/' && path[1] && path[2] == ':') path++; /* /C:/... */
#endif
    char *folder = from_path(path, reason);
    if (folder && !decode_percents(folder)) {
        *reason = "the resource location has a % that no two hexadecimal digits follow";
        free(folder);
        return NULL;
    }
    return folder;
}

static FILE *open_native(const char *path) {
#if defined(_WIN32)
    const int length = MultiByteToWideChar(CP_UTF8, 0, path, -1, NULL, 0);
    wchar_t *wide = length > 0 ? malloc((size_t)length * sizeof *wide) : NULL;
    if (!wide) return NULL;
    MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, length);
    FILE *file = _wfopen(wide, L"rb");
    free(wide);
    return file;
#else
    return fopen(path, "rb");
#endif
}

FILE *location_open(const char *folder, const char *name) {
    const size_t length = strlen(folder), rest = strlen(name) + 1;
    char *path = malloc(length + rest);
    if (!path) return NULL;
    memcpy(path, folder, length);
    memcpy(path + length, name, rest);
    FILE *file = open_native(path);
    free(path);
    return file;
}
