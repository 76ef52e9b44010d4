// The meshes that move in a step, sorted by their places.
#include "mesh_contact/limits/moving_meshes.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

void qcMovingMeshes::Sort()
{
    std::sort(m_sorted.begin(), m_sorted.end(),
              [](const qcSweptObject* a, const qcSweptObject* b) { return a->lower.x() < b->lower.x(); });
    m_widest = 0;
    for (const qcSweptObject* mesh : m_sorted)
        m_widest = std::max(m_widest, mesh->upper.x() - mesh->lower.x());
}

btScalar qcMovingMeshes::LargestTravelIn(const btVector3& lower, const btVector3& upper) const
{
    btScalar largest = 0;
    auto isBefore = [](const qcSweptObject* mesh, btScalar x) { return mesh->lower.x() < x; };
    auto next = std::lower_bound(m_sorted.begin(), m_sorted.end(), lower.x() - m_widest, isBefore);
    for (; next != m_sorted.end() && (*next)->lower.x() <= upper.x(); next++)
        if ((*next)->travel > largest && TestAabbAgainstAabb2(lower, upper, (*next)->lower, (*next)->upper))
            largest = (*next)->travel;
    return largest;
}
