# qc-preload: qcBroadphase in programs that were built without it (LD_PRELOAD), for each precision of Bullet.
function(qc_add_preload name component)
  # Interposition is the affair of ELF's dynamic linkers, and needs a Bullet that is a shared library as well.
  if(NOT TARGET quickcullide::${component} OR NOT BUILD_SHARED_LIBS OR NOT CMAKE_SYSTEM_NAME STREQUAL "Linux")
    return()
  endif()
  add_library(${name} MODULE preload/preload.cpp)
  set_target_properties(${name} PROPERTIES
    INSTALL_RPATH "$ORIGIN" CXX_VISIBILITY_PRESET default
    LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/preload/preload.map)
  target_link_libraries(${name} PRIVATE quickcullide::${component} ${CMAKE_DL_LIBS})
  target_link_options(${name} PRIVATE -Wl,--version-script=${CMAKE_CURRENT_SOURCE_DIR}/preload/preload.map)
  install(TARGETS ${name} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()

qc_add_preload(qc-preload bullet)
qc_add_preload(qc-preload-double bullet_double)
