# cmake -C tests/presets/memory.cmake: reads of uninitialised memory, in the core and its tests (clang 14 or later). Bullet,
# drivers of GL and the demos' libraries are not built for this sanitizer: what they write would count as uninitialised.
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
# The test library, Check, is not built for it either.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR})
set(writes ${CMAKE_BINARY_DIR}/unpoisoned_writes.o)
execute_process(COMMAND ${QC_CLANG} -fsanitize=memory -O1 -c ${CMAKE_CURRENT_LIST_DIR}/../support/unpoisoned_writes.c -o ${writes}
  COMMAND_ERROR_IS_FATAL ANY)
set(CMAKE_EXE_LINKER_FLAGS "-Wl,--wrap=fwrite ${writes}" CACHE STRING "")
