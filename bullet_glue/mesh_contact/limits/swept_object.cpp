// An object of a world that holds meshes, or cores of convex shapes, with its motion in a step.
#include "mesh_contact/limits/swept_object.h"

#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btTransformUtil.h>

btTransform qcSweptObject::At(btScalar part) const
{
    if (part >= 1)
        return target;
    if (part <= 0)
        return carried;
    btVector3 axis;
    btScalar angle;
    btTransformUtil::calculateDiffAxisAngle(carried, target, axis, angle);
    btMatrix3x3 turn(btQuaternion(axis, part * angle));
    return btTransform(turn * carried.getBasis(), carried.getOrigin().lerp(target.getOrigin(), part));
}

void qcSweptObject::ReadCores()
{
    const bool isConvex = object->getCollisionShape()->isConvex();
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
        cores->ForEachCore(object->getCollisionShape(), add);
}

bool qcSweptObject::EnclosesAtStart(qcSweptPart core, const qcSweptObject& other) const
{
    for (const qcSweptMesh& own : meshes)
        for (const qcSweptMesh& mesh : other.meshes)
            if (own.part == core && mesh.part == qcSweptPart::mesh && mesh.triangles->count > 0 &&
                own.Encloses((start * own.local).invXform(other.start * (mesh.local * mesh.PointOf(0, 0, true)))))
                return true;
    return false;
}

void qcSweptObject::FindTravel()
{
    travel = qcDisplacementBound(start, target, radius);
}

void qcSweptObject::FindBox()
{
    object->getCollisionShape()->getAabb(start, lower, upper);
    moves = !qcAreSame(start, end) || Deforms();
    if (!moves)
        return;
    for (const qcSweptMesh& mesh : meshes)
        if (mesh.Deforms())
        {
            btVector3 box[2];
            btTransformAabb(mesh.startBox[0], mesh.startBox[1], mesh.shape->getMargin(), start * mesh.local, box[0],
                            box[1]);
            lower.setMin(box[0]);
            upper.setMax(box[1]);
        }
    btVector3 lowerEnd, upperEnd;
    object->getCollisionShape()->getAabb(end, lowerEnd, upperEnd);
    lower.setMin(lowerEnd);
    upper.setMax(upperEnd);
}
