# What is installed, used from outside.
set(QC_PACKAGED)
foreach(component bullet bullet_double fracture fracture_double)
  if(TARGET qc_${component})
    list(APPEND QC_PACKAGED ${component})
  endif()
endforeach()
if(BUILD_SHARED_LIBS AND CMAKE_SYSTEM_NAME STREQUAL "Linux")
  set(QC_SHARED_LIBRARIES $<TARGET_FILE:quickcullide>)
  foreach(component ${QC_PACKAGED})
    list(APPEND QC_SHARED_LIBRARIES $<TARGET_FILE:qc_${component}>)
  endforeach()
  add_test(NAME test_symbols
    COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_symbols.sh qc ${QC_SHARED_LIBRARIES})
  foreach(name qc-preload qc-preload-double)
    if(TARGET ${name})
      add_test(NAME test_symbols_${name}
        COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_symbols.sh btDbvtBroadphase $<TARGET_FILE:${name}>)
    endif()
  endforeach()
endif()
add_test(NAME test_packaging
  COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_packaging.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR}
          ${CMAKE_INSTALL_LIBDIR} ${CMAKE_C_COMPILER} ${CMAKE_CXX_COMPILER} ${QC_PACKAGED})
# It compiles for long in one thread: begun last, it would run on alone.
set_tests_properties(test_packaging PROPERTIES TIMEOUT 600 COST 100)
