# What CMake knows of a platform's own tools, said again for zig: read after the platform's rules.
# ar and ranlib are commands of the one program.
set(CMAKE_C_ARCHIVE_CREATE "<CMAKE_AR> ar qc <TARGET> <OBJECTS>")
set(CMAKE_C_ARCHIVE_APPEND "<CMAKE_AR> ar q <TARGET> <OBJECTS>")
set(CMAKE_C_ARCHIVE_FINISH "<CMAKE_RANLIB> ranlib <TARGET>")
set(CMAKE_SHARED_MODULE_CREATE_C_FLAGS -shared) # on macOS it makes no bundles
