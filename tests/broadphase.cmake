# The broadphase inside Bullet, for each precision: by itself, and in worlds beside btDbvtBroadphase.
function(qc_test_broadphase component precision)
  if(NOT TARGET quickcullide::${component})
    return()
  endif()
  qc_test(test_broadphase_${precision} test_broadphase.cpp LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_work_${precision} test_broadphase_work.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_callbacks_${precision} test_broadphase_callbacks.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_queries_${precision} test_broadphase_queries.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_world_${precision} test_broadphase_world.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_kinds_${precision} test_broadphase_kinds.cpp world_kinds.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_rest_${precision} test_broadphase_rest.cpp world_kinds.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_random_worlds_${precision} test_broadphase_random_worlds.cpp random_worlds.cpp
          world_kinds.cpp LIBRARIES quickcullide::${component} qc_oracle)
endfunction()

qc_test_broadphase(bullet float)
qc_test_broadphase(bullet_double double)

# The benchmark measures something, and what it measures is right.
if(TARGET qc-bench AND TARGET qc_bullet)
  add_test(NAME test_qc_bench_broadphase COMMAND qc-bench broadphase --boxes 300 --moving 0,50 --frames 3
    --out ${CMAKE_CURRENT_BINARY_DIR}/bench_broadphase)
  set_tests_properties(test_qc_bench_broadphase PROPERTIES
    PASS_REGULAR_EXPRESSION "300 boxes, 50 % moving, setAabb for all; 3 frames, [1-9][0-9]* pairs overlap"
    FAIL_REGULAR_EXPRESSION "qcBroadphase holds")
endif()

# Source that was not written for it: the header in front is all that differs.
function(qc_test_swapped_broadphase component package)
  if(NOT TARGET qc_${component})
    return()
  endif()
  add_executable(plain_client_${component} swapped_client.cpp)
  target_link_libraries(plain_client_${component} PRIVATE PkgConfig::${package})
  add_executable(swapped_client_${component} swapped_client.cpp)
  target_link_libraries(swapped_client_${component} PRIVATE quickcullide::${component})
  target_compile_options(swapped_client_${component} PRIVATE
    -include ${CMAKE_CURRENT_SOURCE_DIR}/swapped_broadphase.h)
  add_test(NAME test_swapped_broadphase_${component}
    COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_swapped_broadphase.sh
            $<TARGET_FILE:plain_client_${component}> $<TARGET_FILE:swapped_client_${component}>)
endfunction()

qc_test_swapped_broadphase(bullet BULLET)
qc_test_swapped_broadphase(bullet_double BULLET_DOUBLE)
