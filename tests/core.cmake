# The scene, its methods against each other, sets and lemmas, contacts, memory.
qc_test(test_scene test_scene.c LIBRARIES qc_oracle)
qc_test(test_methods test_methods.c LIBRARIES qc_oracle)
qc_test(test_visibility_sets INTERNAL test_visibility_sets.c)
qc_test(test_visibility_culling test_visibility_culling.c LIBRARIES qc_oracle)
qc_test(test_contacts test_contacts.c LIBRARIES qc_oracle)
qc_test(test_out_of_memory test_out_of_memory.c LIBRARIES qc_oracle)
