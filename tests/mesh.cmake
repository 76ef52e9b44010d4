# Meshes in Bullet, for each precision that is there: the shape by itself, at rest, and in contact.
foreach(precision bullet bullet_double)
  if(TARGET qc_${precision})
    qc_test(test_mesh_shape_${precision} test_mesh_shape.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_mesh_rest_${precision} test_mesh_rest.cpp LIBRARIES quickcullide::${precision})
    qc_test(test_mesh_contact_${precision} test_mesh_contact.cpp LIBRARIES quickcullide::${precision} qc_oracle)
    qc_test(test_mesh_threads_${precision} test_mesh_threads.cpp LIBRARIES quickcullide::${precision})
  endif()
endforeach()
