/* The functions of libm that glibc has renewed, in the version that every glibc has: a library
 * built on a new system then loads on an old one. What changed is how they set errno, which nobody
 * reads. CMakeLists.txt includes this before each source. */
#ifndef SLIPMODE_OLDEST_GLIBC_H
#define SLIPMODE_OLDEST_GLIBC_H

#include <math.h>

#if defined(__x86_64__) && defined(__LP64__)
#define SM_OLDEST_GLIBC "GLIBC_2.2.5"
#elif defined(__aarch64__)
#define SM_OLDEST_GLIBC "GLIBC_2.17"
#endif

#if defined(__GLIBC__) && defined(SM_OLDEST_GLIBC)
__asm__(".symver hypot, hypot@" SM_OLDEST_GLIBC);
__asm__(".symver log, log@" SM_OLDEST_GLIBC);
__asm__(".symver pow, pow@" SM_OLDEST_GLIBC);
#endif

#endif
