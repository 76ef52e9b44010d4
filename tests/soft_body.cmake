# Soft bodies in Bullet worlds, and on Bullet's threads, for each precision that is there.
foreach(precision bullet bullet_double)
  if(TARGET qc_${precision})
    qc_test(test_soft_body_${precision} test_soft_body.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_soft_body_mesh_${precision} test_soft_body_mesh.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_soft_body_nodes_${precision} test_soft_body_nodes.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_soft_body_rope_${precision} test_soft_body_rope.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    target_include_directories(test_soft_body_rope_${precision} PRIVATE ${PROJECT_SOURCE_DIR}/demos)
    qc_test(test_soft_body_callbacks_${precision} test_soft_body_callbacks.cpp
      LIBRARIES quickcullide::${precision} qc_oracle)
    if(TARGET qc_demo_support)
      qc_test(test_soft_body_apart_${precision} test_soft_body_apart.cpp
        LIBRARIES quickcullide::${precision} qc_oracle qc_demo_support)
      if(QC_BUNNY)
        target_compile_definitions(test_soft_body_apart_${precision} PRIVATE QC_BUNNY="${QC_BUNNY}")
      endif()
    endif()
    qc_test(test_deformable_${precision} test_deformable.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_debug_draw_${precision} test_debug_draw.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_profile_zones_${precision} test_profile_zones.cpp LIBRARIES quickcullide::${precision})
    qc_test(test_task_scheduler_${precision} test_task_scheduler.cpp LIBRARIES quickcullide::${precision})
  endif()
endforeach()

# The cloth of the demo.
if(TARGET qc_bullet_demo)
  qc_test(test_cloth_rest test_cloth_rest.cpp ${PROJECT_SOURCE_DIR}/demos/cloth_world.cpp LIBRARIES qc_bullet_demo)
endif()

# LinearMath/btModifiedGramSchmidt.h instantiates itself; gcc 12 believes that to read what is not set.
set_source_files_properties(test_deformable.cpp test_profile_zones.cpp test_soft_body_apart.cpp
  test_soft_body_callbacks.cpp test_soft_body_rope.cpp PROPERTIES COMPILE_OPTIONS
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>")
