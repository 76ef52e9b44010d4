# Soft bodies in Bullet worlds, and on Bullet's threads, for each precision that is there.
foreach(precision bullet bullet_double)
  if(TARGET qc_${precision})
    qc_test(test_soft_body_${precision} test_soft_body.cpp LIBRARIES quickcullide::${precision})
    qc_test(test_task_scheduler_${precision} test_task_scheduler.cpp LIBRARIES quickcullide::${precision})
  endif()
endforeach()
