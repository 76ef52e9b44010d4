# Soft bodies in Bullet worlds, for each precision that is there.
foreach(precision bullet bullet_double)
  if(TARGET qc_${precision})
    qc_test(test_soft_body_${precision} test_soft_body.cpp LIBRARIES quickcullide::${precision})
  endif()
endforeach()
