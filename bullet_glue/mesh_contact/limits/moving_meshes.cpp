// The meshes that move in a step, sorted by their places.
#include "mesh_contact/limits/moving_meshes.h"

#include "mesh_contact/limits/box_sweep.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

void qcMovingMeshes::Sort()
{
    m_axis = qcAxisOfSpread(m_sorted);
    std::sort(m_sorted.begin(), m_sorted.end(),
              [this](const qcSweptObject* a, const qcSweptObject* b) { return a->lower[m_axis] < b->lower[m_axis]; });
    m_widest = 0;
    for (const qcSweptObject* mesh : m_sorted)
        m_widest = std::max(m_widest, mesh->upper[m_axis] - mesh->lower[m_axis]);
}

btScalar qcMovingMeshes::LargestTravelIn(const btVector3& lower, const btVector3& upper) const
{
    btScalar largest = 0;
    auto isBefore = [this](const qcSweptObject* mesh, btScalar x) { return mesh->lower[m_axis] < x; };
    auto next = std::lower_bound(m_sorted.begin(), m_sorted.end(), lower[m_axis] - m_widest, isBefore);
    for (; next != m_sorted.end() && (*next)->lower[m_axis] <= upper[m_axis]; next++)
        if ((*next)->travel > largest && TestAabbAgainstAabb2(lower, upper, (*next)->lower, (*next)->upper))
            largest = (*next)->travel;
    return largest;
}
