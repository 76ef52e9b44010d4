# Behaviour, bit by bit: what programs over the public headers print is compared with golden files. A change that is
# meant to change results makes them anew: ninja golden_write.
set(QC_GOLDEN ${CMAKE_CURRENT_LIST_DIR})

add_library(qc_golden_meshes OBJECT ${QC_GOLDEN}/meshes.c)
add_custom_target(golden_write)

# qc_golden_test(test program golden files... [OPTIONS option] [ENVIRONMENT variable=value])
function(qc_golden_test test program)
  cmake_parse_arguments(T "" "OPTIONS;ENVIRONMENT" "" ${ARGN})
  list(TRANSFORM T_UNPARSED_ARGUMENTS PREPEND ${QC_GOLDEN}/ OUTPUT_VARIABLE files)
  list(JOIN files "," files)
  set(compare ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${program}> -D OPTIONS=${T_OPTIONS} -D "GOLDEN=${files}")
  add_test(NAME ${test} COMMAND ${compare} -P ${QC_GOLDEN}/compare.cmake)
  set_tests_properties(${test} PROPERTIES SKIP_REGULAR_EXPRESSION "Skipped:" ENVIRONMENT "${T_ENVIRONMENT}")
  add_custom_target(${test}_write COMMAND ${CMAKE_COMMAND} -E env ${T_ENVIRONMENT} ${compare} -D WRITE=ON
    -P ${QC_GOLDEN}/compare.cmake DEPENDS ${program} VERBATIM)
  add_dependencies(golden_write ${test}_write)
endfunction()

add_executable(core_hashes ${QC_GOLDEN}/core_hashes.c $<TARGET_OBJECTS:qc_golden_meshes>)
target_link_libraries(core_hashes PRIVATE quickcullide::core m)
qc_golden_test(test_behaviour core_hashes core_hashes.txt core_work_fused.txt)
qc_golden_test(test_behaviour_plain core_hashes core_hashes.txt core_work_plain.txt ENVIRONMENT QC_KERNELS=plain)
qc_golden_test(test_behaviour_device core_hashes core_device.txt OPTIONS --device)
# It runs for long in one thread: begun last, it would run on alone.
set_tests_properties(test_behaviour_device PROPERTIES COST 20)
set(QC_GOLDEN_PROGRAMS core_hashes)

foreach(precision single double)
  set(suffix "")
  if(precision STREQUAL double)
    set(suffix _double)
  endif()
  if(TARGET qc_bullet${suffix})
    set(program bullet_hashes_${precision})
    add_executable(${program} ${QC_GOLDEN}/bullet_hashes.cpp $<TARGET_OBJECTS:qc_golden_meshes>)
    target_link_libraries(${program} PRIVATE quickcullide::bullet${suffix})
    # In half the time; single operations have the same results.
    target_compile_options(${program} PRIVATE $<$<CONFIG:Release>:-Og>)
    # LinearMath/btModifiedGramSchmidt.h instantiates itself; gcc 12 believes that to read what is not set.
    target_compile_options(${program} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>")
    if(TARGET quickcullide::fracture${suffix})
      target_link_libraries(${program} PRIVATE quickcullide::fracture${suffix})
      target_compile_definitions(${program} PRIVATE QC_GOLDEN_FRACTURE)
    endif()
    qc_golden_test(test_behaviour_${program} ${program} ${program}.txt)
    list(APPEND QC_GOLDEN_PROGRAMS ${program})
  endif()
endforeach()

# Inputs and results are those of single operations: no fused multiply-add.
foreach(target qc_golden_meshes ${QC_GOLDEN_PROGRAMS})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_options(${target} PRIVATE -ffp-contract=off)
endforeach()
