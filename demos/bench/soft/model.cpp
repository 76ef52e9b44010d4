// The bunny of the package glmark2-data, decimated.
#include "bench/soft/model.h"
#include "bench/soft/soft_scene.h"

#include "bench/scenes/scenes.h"
#include "common/mesh_io/decimate.h"
#include "common/mesh_io/mesh_file.h"

#include <cstdio>

qcSoftModel qcMakeSoftModel(btScalar size)
{
    qcSoftModel model;
    qcMesh mesh, coarse;
    qcMessage message;
    if (qcMesh_ReadFile(QC_BUNNY_PATH, qc_meshAsDeclared, &mesh, &message))
    {
        if (qcMesh_Decimate(&mesh, 1000, &coarse))
        {
            const float* positions = static_cast<const float*>(coarse.positions);
            for (size_t i = 0; i < 3 * size_t(coarse.vertexCount); i++)
                model.positions.push_back(size * btScalar(positions[i]));
            model.indices.assign(coarse.indices, coarse.indices + 3 * size_t(coarse.triangleCount));
            qcMesh_Free(&coarse);
        }
        qcMesh_Free(&mesh);
    }
    if (model.indices.empty())
    {
        std::fprintf(stderr, "%s; tori stand in for bunnies\n", message.text);
        qcTorus torus(size * btScalar(0.7), size * btScalar(0.3), 24, 12);
        model.positions = torus.points;
        model.indices.assign(torus.indices.begin(), torus.indices.end());
    }
    return model;
}
