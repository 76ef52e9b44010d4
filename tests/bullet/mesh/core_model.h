// The cores of convex shapes as models, for checks that they pass nothing.
#ifndef QC_TESTS_BULLET_MESH_CORE_MODEL_H
#define QC_TESTS_BULLET_MESH_CORE_MODEL_H

#include "bullet/mesh/mesh_models.h"

#include "mesh_contact/limits/convex_cores.h"

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

/// The cores of a shape as one model.
inline qcModel qcCoreModel(const btCollisionShape* shape, btScalar size = qcCoreSize)
{
    qcConvexCores cores(size);
    qcModel model;
    auto add = [&](const qcConvexCore& core, const btTransform& place)
    {
        ck_assert_double_gt(double(core.halfWidth), 0);
        qcModel part;
        for (uint32_t i = 0; i < core.mesh->getVertexCount(); i++)
        {
            const btVector3& vertex = core.mesh->getVertices()[i];
            part.Add(double(vertex.x()), double(vertex.y()), double(vertex.z()));
        }
        part.indices.assign(core.mesh->getIndices(),
                            core.mesh->getIndices() + 3 * size_t(core.mesh->getTriangleCount()));
        part.Move(place);
        model.Append(part);
    };
    cores.ForEachCore(shape, add);
    ck_assert(!model.indices.empty());
    return model;
}

#endif
