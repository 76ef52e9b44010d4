# The fracture helper: a library of its own, since nothing else needs voro++ and GLU (of which it takes the tesselator).
find_path(VORO_INCLUDE_DIR voro++/voro++.hh)
find_library(VORO_LIBRARY voro++)
pkg_check_modules(GLU QUIET IMPORTED_TARGET GLOBAL glu)

# qc_add_fracture(name glue precision): the library quickcullide_NAME over the glue of one precision.
function(qc_add_fracture name glue precision)
  if(NOT TARGET qc_${glue})
    return()
  endif()
  if(NOT VORO_INCLUDE_DIR OR NOT VORO_LIBRARY OR NOT GLU_FOUND)
    message(STATUS "No voro++ or no GLU: quickcullide::${name} is left out")
    return()
  endif()
  add_library(qc_${name} fracture/fracture.cpp fracture/voronoi_cells.cpp fracture/triangle_edges.cpp
    fracture/mesh_solid.cpp fracture/plane_clip.cpp fracture/open_edges.cpp fracture/loop_groups.cpp
    fracture/triangulate_face.cpp fracture/faceted_mesh.cpp fracture/components.cpp fracture/cell_sites.cpp
    fracture/unit_scale.cpp fracture/parallel_scratch.cpp fracture/bonds.cpp fracture/islands.cpp
    fracture/piece_texture.cpp fracture/piece_writer.cpp fracture/piece_reader.cpp fracture/piece_defects.cpp
    fracture/new_file.cpp
    common/mass_properties.cpp common/weld_vertices.cpp common/parallel_loop.cpp)
  target_include_directories(qc_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  add_library(quickcullide::${name} ALIAS qc_${name})
  set_target_properties(qc_${name} PROPERTIES
    OUTPUT_NAME quickcullide_${name} EXPORT_NAME ${name} INSTALL_RPATH "$ORIGIN"
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_options(qc_${name} PRIVATE -ffp-contract=off) # for sums that are exact (cell_sites.cpp)
  target_include_directories(qc_${name} SYSTEM PRIVATE ${VORO_INCLUDE_DIR})
  target_link_libraries(qc_${name} PUBLIC quickcullide::${glue} PRIVATE ${VORO_LIBRARY} PkgConfig::GLU)
  qc_hide_others(qc_${name})
  qc_precompile_headers(qc_${name} BulletCollision/CollisionDispatch/btCollisionObject.h)
  install(TARGETS qc_${name} EXPORT quickcullide_${name})
  install(EXPORT quickcullide_${name} NAMESPACE quickcullide:: DESTINATION ${QC_PACKAGE_DIR}
          FILE quickcullide_${name}Targets.cmake)

  # What a static library needs. GLU's flags are copied: a user of the shared library may lack its pkg-config file.
  get_filename_component(folder ${VORO_LIBRARY} DIRECTORY)
  list(JOIN GLU_LDFLAGS " " glu)
  set(QC_PC_PRIVATE "-L${folder} -lvoro++ ${glu}")
  set(QC_PC_GLUE quickcullide_${glue})
  set(QC_PC_PRECISION ${precision})
  qc_install_pkgconfig(quickcullide_fracture.pc.in quickcullide_${name})
endfunction()

qc_add_fracture(fracture bullet float)
qc_add_fracture(fracture_double bullet_double double)
