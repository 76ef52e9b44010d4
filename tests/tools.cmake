# The tools: what they read, write and say; and that the rooms keep to themselves.
if(TARGET qc-pairs)
  qc_test(test_mesh_number test_mesh_number.c LIBRARIES qc_demo_support)
  qc_test(test_mesh_file test_mesh_file.c run_program.c LIBRARIES qc_demo_support)
  qc_test(test_output_file test_output_file.c run_program.c LIBRARIES qc_demo_support PkgConfig::PNG)
  qc_test(test_qc_pairs test_qc_pairs.c run_program.c LIBRARIES PkgConfig::JSON_C PkgConfig::PNG)
  target_compile_definitions(test_qc_pairs PRIVATE QC_PAIRS_PROGRAM="$<TARGET_FILE:qc-pairs>")
  add_dependencies(test_qc_pairs qc-pairs)
  qc_test(test_qc_bench test_qc_bench.c run_program.c LIBRARIES qc_demo_support)
  target_compile_definitions(test_qc_bench PRIVATE QC_BENCH_PROGRAM="$<TARGET_FILE:qc-bench>")
  add_dependencies(test_qc_bench qc-bench)
  # As a user's build: beside the peers that were found; and a peer that errs, as a module like theirs.
  add_library(liar_peer MODULE liar_peer.c)
  target_include_directories(liar_peer PRIVATE ${PROJECT_SOURCE_DIR}/demos)
  qc_test(test_qc_bench_peers test_qc_bench_peers.c run_program.c LIBRARIES qc_demo_support qc_oracle)
  get_property(peers GLOBAL PROPERTY QC_PEERS)
  list(LENGTH peers peerCount)
  target_compile_definitions(test_qc_bench_peers PRIVATE
    QC_BENCH_PROGRAM="$<TARGET_FILE:qc-bench>" QC_LIAR_PEER="$<TARGET_FILE:liar_peer>" QC_BENCH_PEERS=${peerCount})
  add_dependencies(test_qc_bench_peers qc-bench liar_peer)
  qc_test(test_qc_bench_scaling test_qc_bench_scaling.c ${PROJECT_SOURCE_DIR}/demos/qc_bench_scaling_report.c
          run_program.c LIBRARIES qc_demo_support)
  target_compile_definitions(test_qc_bench_scaling PRIVATE QC_BENCH_PROGRAM="$<TARGET_FILE:qc-bench>")
  add_dependencies(test_qc_bench_scaling qc-bench)
  # A file that others wrote, from the package glmark2-data.
  find_file(QC_BUNNY glmark2/models/bunny.obj PATHS /usr/share /usr/local/share)
  if(QC_BUNNY)
    add_test(NAME test_bunny_is_read_whole COMMAND qc-pairs --method sweep ${QC_BUNNY})
    set_tests_properties(test_bunny_is_read_whole PROPERTIES
      PASS_REGULAR_EXPRESSION "69666 triangles, 34835 vertices.*pairs        0:")
    add_executable(test_bunny test_bunny.c)
    target_link_libraries(test_bunny PRIVATE quickcullide::core qc_demo_support qc_oracle PkgConfig::CHECK)
    add_test(NAME test_bunny COMMAND test_bunny ${QC_BUNNY})
  endif()
endif()

if(TARGET qc-fracture)
  qc_test(test_demos test_demos.c run_program.c)
  target_compile_definitions(test_demos PRIVATE
    QC_CLOTH_PROGRAM="$<TARGET_FILE:qc-cloth>" QC_FRACTURE_PROGRAM="$<TARGET_FILE:qc-fracture>")
  add_dependencies(test_demos qc-cloth qc-fracture)
endif()

add_test(NAME test_layout COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test_layout.sh ${PROJECT_SOURCE_DIR})
add_test(NAME test_demos_help COMMAND sh ${PROJECT_SOURCE_DIR}/demos/run.sh --help)
set_tests_properties(test_demos_help PROPERTIES PASS_REGULAR_EXPRESSION "cloth .*fracture.*pairs ")
add_test(NAME test_demos_refuse_what_is_none COMMAND sh ${PROJECT_SOURCE_DIR}/demos/run.sh coth)
set_tests_properties(test_demos_refuse_what_is_none PROPERTIES PASS_REGULAR_EXPRESSION "there is no demo 'coth'")
