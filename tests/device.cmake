# Devices, and what only GL can do: visibility queries, pictures. Software devices that are missing are skipped.
# Types and enums of GL come through gl/table.h; nothing of GL is linked.
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
foreach(name device visibility growth picture)
  qc_test(test_${name} INTERNAL test_${name}.c LIBRARIES qc_oracle)
  target_include_directories(test_${name} SYSTEM PRIVATE ${EPOXY_INCLUDE_DIRS})
endforeach()
# `layers`: on each software device; its frame needs none.
qc_test(test_layers_frame INTERNAL test_layers_frame.c LIBRARIES qc_oracle)
qc_test(test_fork test_fork.c LIBRARIES qc_oracle)
