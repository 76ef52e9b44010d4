# Devices, and what only GL can do: visibility queries, pictures. Devices that are missing are skipped, unless
# QC_TEST_DEVICES requires them: see devices.h.
qc_test(test_gl_devices test_gl_devices.c)
# Types and enums of GL come through gl/table.h; nothing of GL is linked.
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
foreach(name device device_host drivers visibility growth picture gl_timers)
  qc_test(test_${name} INTERNAL test_${name}.c LIBRARIES qc_oracle)
  target_include_directories(test_${name} SYSTEM PRIVATE ${EPOXY_INCLUDE_DIRS})
endforeach()
# The frame of `layers` needs no device.
qc_test(test_layers_frame INTERNAL test_layers_frame.c LIBRARIES qc_oracle)
qc_test(test_fork test_fork.c LIBRARIES qc_oracle)

# A machine with a GPU runs these and the benchmark: demos/gpu.sh takes the programs from the list.
if(TARGET qc-bench)
  set(gpuTargets qc-bench)
  foreach(test gl_devices device device_host drivers visibility growth picture visibility_culling beyond_paper layers
          layers_steps layer_times contacts margin never_miss owners far_away)
    list(APPEND gpuTargets test_${test})
  endforeach()
  add_custom_target(qc-gpu DEPENDS ${gpuTargets})
  set(gpuPrograms)
  foreach(target ${gpuTargets})
    string(APPEND gpuPrograms "$<TARGET_FILE:${target}>\n")
  endforeach()
  file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/gpu_programs.txt CONTENT "${gpuPrograms}")
endif()

# Once more on zink, the second GL compiler that every machine can have: programs in which GL does the work, without the
# longest (test_owners, test_tasks). Its variables are read when Mesa is opened.
set(QC_ZINK LIBGL_ALWAYS_SOFTWARE=1 MESA_LOADER_DRIVER_OVERRIDE=zink GALLIUM_DRIVER=zink)
foreach(test gl_devices device device_host drivers visibility growth picture visibility_culling beyond_paper layers layers_steps)
  add_test(NAME test_${test}_zink COMMAND test_${test})
  set_tests_properties(test_${test}_zink PROPERTIES ENVIRONMENT "${QC_ZINK}")
endforeach()
foreach(test layers layers_steps layer_times contacts margin never_miss)
  add_test(NAME test_${test}_on_device_zink COMMAND test_${test})
  set_tests_properties(test_${test}_on_device_zink PROPERTIES ENVIRONMENT "${QC_ZINK};QC_LAYERS_REFINE=device")
endforeach()
set_tests_properties(test_gl_devices test_gl_devices_zink PROPERTIES SKIP_REGULAR_EXPRESSION "Skipped: no GL device")
# A required device that doesn't open, and one that there isn't, must fail.
add_test(NAME test_gl_devices_that_are_required COMMAND test_gl_devices)
set_tests_properties(test_gl_devices_that_are_required PROPERTIES
  ENVIRONMENT "GALLIUM_DRIVER=none;QC_TEST_DEVICES=osmesa" PASS_REGULAR_EXPRESSION "requires osmesa, which did not open")
add_test(NAME test_gl_devices_that_are_unknown COMMAND test_gl_devices)
set_tests_properties(test_gl_devices_that_are_unknown PROPERTIES
  ENVIRONMENT "QC_TEST_DEVICES=gpu" PASS_REGULAR_EXPRESSION "'gpu' is not one of egl, osmesa, surfaceless, zink")
