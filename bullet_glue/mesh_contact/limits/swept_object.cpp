// An object of a world that holds meshes, or cores of convex shapes, with its motion in a step.
#include "mesh_contact/limits/swept_object.h"

#include <LinearMath/btAabbUtil2.h>

bool qcSweptObject::EnclosesAtStart(qcSweptPart core, const qcSweptObject& other) const
{
    for (const qcSweptMesh& own : meshes)
    {
        if (own.part != core)
            continue;
        const btTransform place = start * own.local;
        for (const qcSweptMesh& mesh : other.meshes)
            if (mesh.part == qcSweptPart::mesh && mesh.triangles->count > 0 &&
                own.Encloses(place.invXform(other.start * (mesh.local * mesh.PointOf(0, 0, true)))))
                return true;
    }
    return false;
}

void qcSweptObject::ReadChildren()
{
    const btCollisionShape* shape = object->getCollisionShape();
    if (!moves && shape->isCompound() && !children.AreRead())
        children.Read(shape, cores);
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
