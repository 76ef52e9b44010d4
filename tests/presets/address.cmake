# cmake -C tests/presets/address.cmake: address, leak, undefined behaviour, and conversions of floats that overflow.
# Asserts are on. A finding ends the program.
set(sanitize "-fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer")
foreach(language C CXX)
  set(CMAKE_${language}_FLAGS "${sanitize}" CACHE STRING "")
  set(CMAKE_${language}_FLAGS_RELEASE "-O1 -g1" CACHE STRING "")
endforeach()
# Each file is compiled by itself, with what it includes.
set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON CACHE BOOL "")
