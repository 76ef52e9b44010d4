// Iteration over the children of compound shapes.
#ifndef QC_GLUE_COMMON_COMPOUND_CHILDREN_H
#define QC_GLUE_COMMON_COMPOUND_CHILDREN_H

#include <BulletCollision/CollisionShapes/btCompoundShape.h>

/// Calls function(shape, transform) for each shape in a compound of any depth that is not a compound, in the order of
/// the children; for any other shape, once with the shape itself. `transform`: from the shape's frame to that of the
/// results.
template <typename Function>
void qcForEachSimpleShape(const btCollisionShape* shape, const btTransform& transform, const Function& function)
{
    if (!shape->isCompound())
    {
        function(shape, transform);
        return;
    }
    const auto* compound = static_cast<const btCompoundShape*>(shape);
    for (int i = 0; i < compound->getNumChildShapes(); i++)
        qcForEachSimpleShape(compound->getChildShape(i), transform * compound->getChildTransform(i), function);
}

#endif
