// The triangles of an object that are swept.
#include "mesh_contact/limits/swept_shape.h"

void qcSweptShape::ReadCores(const btCollisionShape* shape)
{
    const bool isConvex = shape->isConvex();
    const bool anyMesh = hasMesh;
    halfWidth = hasMesh ? btScalar(0) : BT_LARGE_FLOAT;
    hulls.clear();
    if (hull != nullptr)
        hulls.push_back({hull, btTransform::getIdentity()});
    auto add = [&](const qcConvexCore& core, const btTransform& place)
    {
        hasMesh = true;
        if (!anyMesh)
            hulls.push_back({core.hull.get(), place});
        halfWidth = std::min(halfWidth, core.halfWidth);
        if (isConvex)
            hull = core.hull.get();
    };
    if (cores != nullptr)
        cores->ForEachCore(shape, add);
}
