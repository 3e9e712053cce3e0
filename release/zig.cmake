# Toolchain file: zig compiles C for another platform. wheels.py sets the ZIG variables.
set(CMAKE_SYSTEM_NAME $ENV{ZIG_SYSTEM})
set(CMAKE_SYSTEM_PROCESSOR $ENV{ZIG_PROCESSOR})
set(CMAKE_C_COMPILER $ENV{ZIG} cc -target $ENV{ZIG_TARGET})
set(CMAKE_MODULE_LINKER_FLAGS_INIT -s) # no names but those exported, no paths
set(CMAKE_AR $ENV{ZIG})
set(CMAKE_RANLIB $ENV{ZIG})
set(CMAKE_INSTALL_NAME_TOOL $ENV{ZIG}) # asked for on macOS; what is installed has no name to change
set(CMAKE_USER_MAKE_RULES_OVERRIDE ${CMAKE_CURRENT_LIST_DIR}/zig_rules.cmake)
# Clang clones a function only if the headers say so too, and on few platforms.
set(HAS_TARGET_CLONES OFF CACHE BOOL "")
