# cmake -C tests/presets/memory.cmake: reads of uninitialised memory, in the core and its tests (clang 14 or later). Bullet and
# the demos' libraries are not built for this sanitizer: what they write would count as uninitialised.
find_program(QC_CLANG NAMES clang clang-19 clang-16 clang-14 REQUIRED)
find_program(QC_CLANGXX NAMES clang++ clang++-19 clang++-16 clang++-14 REQUIRED)
set(CMAKE_C_COMPILER "${QC_CLANG}" CACHE STRING "")
set(CMAKE_CXX_COMPILER "${QC_CLANGXX}" CACHE STRING "")
set(sanitize "-fsanitize=memory -fsanitize-memory-track-origins -fno-omit-frame-pointer")
foreach(language C CXX)
  set(CMAKE_${language}_FLAGS "${sanitize} -fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/memory.supp" CACHE STRING "")
  set(CMAKE_${language}_FLAGS_RELEASE "-O1 -g1" CACHE STRING "")
endforeach()
set(QC_BUILD_BULLET OFF CACHE BOOL "")
set(QC_BUILD_DEMOS OFF CACHE BOOL "")
