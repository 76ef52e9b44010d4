// A translation of all objects of a world by the application.
#include "mesh_contact/limits/common_shift.h"

#include <algorithm>

qcCommonShift qcCommonShift::Find(const std::vector<qcSweptObject*>& objects)
{
    // Bullet computes the places of links along their chain.
    constexpr btScalar rounding = 8 * SIMD_EPSILON, roundingOfLink = 64 * SIMD_EPSILON;
    qcCommonShift shift;
    const qcSweptObject* first = nullptr;
    for (const qcSweptObject* swept : objects)
    {
        if (swept->isNew)
            continue;
        const btVector3 &from = swept->last.getOrigin(), &to = swept->start.getOrigin();
        const bool isLink = swept->isDynamic && swept->body == nullptr;
        shift.error = std::max(shift.error, (isLink ? roundingOfLink : rounding) * (from.length() + to.length()));
        if (first == nullptr && swept->isDynamic)
        {
            first = swept;
            shift.by = to - from;
        }
    }
    for (const qcSweptObject* swept : objects)
        if (swept->isDynamic && !swept->isNew && !shift.IsOf(swept->last, swept->start))
            return qcCommonShift();
    return shift;
}

bool qcCommonShift::IsOf(const btTransform& from, const btTransform& to) const
{
    return by.length() > error && (to.getOrigin() - from.getOrigin() - by).length() <= error &&
           from.getBasis() == to.getBasis();
}
