# cmake -C tests/presets/thread.cmake: data races, and locks taken in an order that can block. Asserts are on.
foreach(language C CXX)
  set(CMAKE_${language}_FLAGS "-fsanitize=thread -fno-omit-frame-pointer" CACHE STRING "")
  set(CMAKE_${language}_FLAGS_RELEASE "-O1 -g1" CACHE STRING "")
endforeach()
# Each file is compiled by itself, with what it includes.
set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON CACHE BOOL "")
