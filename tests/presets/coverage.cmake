# cmake -C tests/presets/coverage.cmake: counts the lines of plugin/ that the core's tests run, see tests/coverage.sh.
# Tests themselves are not counted, which saves their time.
foreach(language C CXX)
  set(CMAKE_${language}_FLAGS "--coverage -fprofile-update=atomic -fprofile-filter-files=.*/plugin/.*" CACHE STRING "")
  set(CMAKE_${language}_FLAGS_RELEASE "-O1 -g1" CACHE STRING "")
endforeach()
set(QC_BUILD_TESTS ON CACHE BOOL "")
set(QC_BUILD_BULLET OFF CACHE BOOL "")
set(QC_BUILD_DEMOS OFF CACHE BOOL "")
