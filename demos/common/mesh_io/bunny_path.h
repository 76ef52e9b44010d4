// The Stanford bunny, which Debian packages.
#ifndef QC_DEMOS_COMMON_MESH_IO_BUNNY_PATH_H
#define QC_DEMOS_COMMON_MESH_IO_BUNNY_PATH_H

/// The file of the package glmark2-data: 69 666 triangles.
#define QC_BUNNY_PATH "/usr/share/glmark2/models/bunny.obj"

#endif
