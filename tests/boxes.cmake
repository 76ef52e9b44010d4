# A set of moving boxes against brute force; the forest below it; casts against rational arithmetic.
qc_test(test_boxes INTERNAL test_boxes.c LIBRARIES qc_oracle)
qc_test(test_box_forest INTERNAL test_box_forest.c LIBRARIES qc_oracle)
qc_test(test_box_casts INTERNAL test_box_casts.c LIBRARIES qc_oracle)
