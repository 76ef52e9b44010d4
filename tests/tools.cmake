# The tools: what they read, write and say; and that the rooms keep to themselves.
if(TARGET qc-pairs)
  qc_test(test_mesh_number test_mesh_number.c LIBRARIES qc_demo_support)
  qc_test(test_mesh_file test_mesh_file.c LIBRARIES qc_demo_support)
  qc_test(test_output_file test_output_file.c run_program.c LIBRARIES qc_demo_support PkgConfig::PNG)
  qc_test(test_qc_pairs test_qc_pairs.c run_program.c LIBRARIES PkgConfig::JSON_C PkgConfig::PNG)
  target_compile_definitions(test_qc_pairs PRIVATE QC_PAIRS_PROGRAM="$<TARGET_FILE:qc-pairs>")
  add_dependencies(test_qc_pairs qc-pairs)
  # A file that others wrote, from the package glmark2-data.
  find_file(QC_BUNNY glmark2/models/bunny.obj PATHS /usr/share /usr/local/share)
  if(QC_BUNNY)
    add_test(NAME test_bunny_is_read_whole COMMAND qc-pairs --method sweep ${QC_BUNNY})
    set_tests_properties(test_bunny_is_read_whole PROPERTIES
      PASS_REGULAR_EXPRESSION "69666 triangles, 34835 vertices.*pairs        0:")
  endif()
endif()

add_test(NAME test_layout COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_layout.sh ${PROJECT_SOURCE_DIR})
add_test(NAME test_demos_help COMMAND sh ${PROJECT_SOURCE_DIR}/demos/run.sh --help)
set_tests_properties(test_demos_help PROPERTIES PASS_REGULAR_EXPRESSION "cloth .*pairs ")
add_test(NAME test_demos_refuse_what_is_none COMMAND sh ${PROJECT_SOURCE_DIR}/demos/run.sh coth)
set_tests_properties(test_demos_refuse_what_is_none PROPERTIES PASS_REGULAR_EXPRESSION "there is no demo 'coth'")
