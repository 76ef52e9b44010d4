// The Stanford bunny, coarse enough for piles.
#ifndef QC_TESTS_BULLET_MESH_MESH_BUNNY_H
#define QC_TESTS_BULLET_MESH_MESH_BUNNY_H

#include "bullet/mesh/mesh_world.h"

#include "common/mesh_io/decimate.h"
#include "common/mesh_io/mesh_file.h"

/// The bunny with its centre of mass at the origin, 1 high, with about this many triangles.
inline qcModel qcBunnyModel(const char* path, uint32_t triangles = 2000)
{
    qcMesh mesh, coarse;
    qcMessage message;
    ck_assert_msg(qcMesh_ReadFile(path, qc_meshAsDeclared, &mesh, &message), "%s", message.text);
    ck_assert(qcMesh_Decimate(&mesh, triangles, &coarse));
    qcModel model;
    const float* positions = static_cast<const float*>(coarse.positions);
    for (uint32_t v = 0; v < coarse.vertexCount; v++, positions += 3)
        model.Add(0.5 * double(positions[0]), 0.5 * double(positions[1]), 0.5 * double(positions[2]));
    model.indices.assign(coarse.indices, coarse.indices + 3 * size_t(coarse.triangleCount));
    qcMesh_Free(&coarse);
    qcMesh_Free(&mesh);
    qcMassProperties mass = model.MakeShape()->getMassProperties();
    ck_assert(mass.closed);
    model.Move(mass.principalFrame.inverse());
    return model;
}

#endif
