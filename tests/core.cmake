# The scene, its methods against each other, sets and lemmas, contacts, memory.
qc_test(test_scene test_scene.c LIBRARIES qc_oracle)
qc_test(test_methods test_methods.c LIBRARIES qc_oracle)
qc_test(test_far_away test_far_away.c LIBRARIES qc_oracle)
qc_test(test_plan INTERNAL test_plan.c)
qc_test(test_skips test_skips.c LIBRARIES qc_oracle)
qc_test(test_tasks INTERNAL test_tasks.c LIBRARIES qc_oracle)
qc_test(test_clusters INTERNAL test_clusters.c LIBRARIES qc_oracle)
qc_test(test_visibility_sets INTERNAL test_visibility_sets.c)
qc_test(test_visibility_culling test_visibility_culling.c LIBRARIES qc_oracle)
qc_test(test_beyond_paper test_beyond_paper.c LIBRARIES qc_oracle)
qc_test(test_contacts test_contacts.c LIBRARIES qc_oracle)
qc_test(test_margin test_margin.c LIBRARIES qc_oracle)
# Their own roundings are those of the core: no fused multiply-add.
qc_test(test_never_miss test_never_miss.c LIBRARIES qc_oracle)
target_compile_options(test_never_miss PRIVATE -ffp-contract=off)
qc_test(test_layers test_layers.c LIBRARIES qc_oracle)
qc_test(test_layers_steps test_layers_steps.c LIBRARIES qc_oracle)
# Software devices leave pairs of triangles to the processor; the kernels that a GPU finds them with are run here.
foreach(test test_methods test_contacts test_margin test_never_miss test_layers test_layers_steps)
  add_test(NAME ${test}_on_device COMMAND ${test})
  set_tests_properties(${test}_on_device PROPERTIES ENVIRONMENT QC_LAYERS_REFINE=device)
endforeach()
qc_test(test_manifolds test_manifolds.c LIBRARIES qc_oracle)
qc_test(test_manifold_rules test_manifold_rules.c LIBRARIES qc_oracle)
qc_test(test_manifold_depth test_manifold_depth.c LIBRARIES qc_oracle)
qc_test(test_out_of_memory test_out_of_memory.c LIBRARIES qc_oracle)
# Kernels, surfaces and what is found with them. Their models are of single operations: no fused multiply-add.
foreach(test test_surface_kernels test_surface_mapped test_surface_filter test_surface_flat test_surface_near
        test_stars test_surface_neighbours test_surface test_surface_pairs test_surface_pairs_between test_surface_scenes
        test_placement test_placement_scenes)
  qc_test(${test} INTERNAL ${test}.c LIBRARIES qc_oracle)
  target_compile_options(${test} PRIVATE -ffp-contract=off)
endforeach()
