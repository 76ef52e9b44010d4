# The broadphase inside Bullet, for each precision: by itself, and in worlds beside btDbvtBroadphase.
function(qc_test_broadphase component precision)
  if(NOT TARGET quickcullide::${component})
    return()
  endif()
  qc_test(test_broadphase_${precision} test_broadphase.cpp LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_queries_${precision} test_broadphase_queries.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
  qc_test(test_broadphase_world_${precision} test_broadphase_world.cpp
          LIBRARIES quickcullide::${component} qc_oracle)
endfunction()

qc_test_broadphase(bullet float)
qc_test_broadphase(bullet_double double)
