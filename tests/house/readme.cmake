# The manual: the programs of demos/hello run and return 0, README.md's examples are excerpts of them, Doxygen has no
# warning about the public headers, links in the documents lead somewhere.
function(qc_hello_test program)
  foreach(precision "" -double)
    if(TARGET qc-hello-${program}${precision})
      add_test(NAME test_hello_${program}${precision} COMMAND qc-hello-${program}${precision})
    endif()
  endforeach()
endfunction()
foreach(program core broadphase cloth deformable robot fracture world)
  qc_hello_test(${program})
endforeach()

add_test(NAME test_readme_examples COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_readme_examples.sh ${PROJECT_SOURCE_DIR})
add_test(NAME test_links COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_links.sh ${PROJECT_SOURCE_DIR})
# Exit status 77: Doxygen is not installed.
add_test(NAME test_docs COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_docs.sh ${PROJECT_BINARY_DIR}/plugin/docs/Doxyfile)
set_tests_properties(test_docs PROPERTIES SKIP_RETURN_CODE 77)

qc_test(test_version test_version.c)
target_compile_definitions(test_version PRIVATE QC_PROJECT_VERSION="${PROJECT_VERSION}")
