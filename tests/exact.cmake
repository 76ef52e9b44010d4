# Triangle against triangle: the predicates, the relation and the segment against rational arithmetic.
pkg_check_modules(GMP REQUIRED IMPORTED_TARGET gmp)

# The oracle and the generators, for every group of tests that wants them.
add_library(qc_oracle STATIC oracle.c oracle_distance.c soups.c pairs.c)
target_include_directories(qc_oracle PUBLIC ${PROJECT_SOURCE_DIR}/include ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(qc_oracle PUBLIC PkgConfig::GMP m)
# Seeds mean the same bits everywhere: no fused multiply-add.
target_compile_options(qc_oracle PRIVATE -ffp-contract=off)

qc_test(test_exact_predicates INTERNAL test_exact_predicates.c LIBRARIES qc_oracle)
qc_test(test_exact_relation INTERNAL test_exact_relation.c LIBRARIES qc_oracle)
qc_test(test_exact_segment INTERNAL test_exact_segment.c LIBRARIES qc_oracle)
qc_test(test_exact_distance INTERNAL test_exact_distance.c LIBRARIES qc_oracle)
qc_test(test_proximity INTERNAL test_proximity.c LIBRARIES qc_oracle)
