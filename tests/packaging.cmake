# What is installed, used from outside.
set(QC_PACKAGED)
foreach(component bullet bullet_double fracture fracture_double)
  if(TARGET qc_${component})
    list(APPEND QC_PACKAGED ${component})
  endif()
endforeach()
add_test(NAME test_packaging
  COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_packaging.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR}
          ${CMAKE_INSTALL_LIBDIR} ${CMAKE_C_COMPILER} ${CMAKE_CXX_COMPILER} ${QC_PACKAGED})
set_tests_properties(test_packaging PROPERTIES TIMEOUT 600)
