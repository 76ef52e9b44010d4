// Soft bodies that touch nothing in a step.
#include "soft_body/scene/lone_bodies.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace
{
/// A bound of the rounding of a few sums and products of lengths like this one.
constexpr btScalar s_rounding = 32 * SIMD_EPSILON;
const btVector3 s_ones(1, 1, 1);
} // namespace

void qcMotionBoxes::Add(const btVector3& lower, const btVector3& upper, bool needsPartner)
{
    m_boxes.push_back({lower, upper, needsPartner});
}

/// The axis on which the boxes' centres are spread most.
int qcMotionBoxes::FindAxis() const
{
    btVector3 lower = m_boxes[0].lower + m_boxes[0].upper, upper = lower;
    for (const Box& box : m_boxes)
    {
        lower.setMin(box.lower + box.upper);
        upper.setMax(box.lower + box.upper);
    }
    return (upper - lower).maxAxis();
}

void qcMotionBoxes::Find()
{
    if (m_boxes == m_foundBoxes)
        return;
    m_foundBoxes = m_boxes;
    m_overlaps.assign(m_boxes.size(), 0);
    if (m_boxes.empty())
        return;
    const int axis = FindAxis();
    m_order.resize(m_boxes.size());
    std::iota(m_order.begin(), m_order.end(), size_t(0));
    std::sort(m_order.begin(), m_order.end(),
              [this, axis](size_t a, size_t b) { return m_boxes[a].lower[axis] < m_boxes[b].lower[axis]; });
    for (size_t i = 0; i < m_order.size(); i++)
    {
        const Box& a = m_boxes[m_order[i]];
        for (size_t k = i + 1; k < m_order.size() && m_boxes[m_order[k]].lower[axis] <= a.upper[axis]; k++)
        {
            const Box& b = m_boxes[m_order[k]];
            bool mayTouch = !(a.needsPartner && b.needsPartner);
            if (mayTouch && TestAabbAgainstAabb2(a.lower, a.upper, b.lower, b.upper))
                m_overlaps[m_order[i]] = m_overlaps[m_order[k]] = 1;
        }
    }
}

bool qcIsStretchedChain(const std::vector<btVector3>& start, const std::vector<btVector3>& end, btScalar distance)
{
    const size_t count = end.size();
    if (count < 4 || start.size() != count)
        return count < 4;
    btVector3 along = end[count - 1] - end[0];
    const btScalar length = along.length();
    if (!(length > 0) || !std::isfinite(length))
        return false;
    along /= length;
    for (size_t i = 0; i + 1 < count; i++)
    {
        const btVector3 atStart = start[i + 1] - start[i], atEnd = end[i + 1] - end[i];
        // Beyond the first and the last link there is no other one.
        const bool isInner = i > 0 && i + 2 < count;
        const btScalar step = isInner ? distance * btScalar(1.01) : btScalar(0);
        if (!(along.dot(atStart) > s_rounding * atStart.absolute().dot(s_ones) &&
              along.dot(atEnd) > step + s_rounding * atEnd.absolute().dot(s_ones)))
            return false;
    }
    return true;
}

bool qcFindMotionBox(const std::vector<btVector3>& start, const std::vector<btVector3>& end, btScalar reach,
                     btVector3 box[2])
{
    if (end.empty())
        return false;
    box[0] = box[1] = end[0];
    btVector3 sum(0, 0, 0);
    for (size_t i = 0; i < end.size(); i++)
    {
        box[0].setMin(start[i]);
        box[0].setMin(end[i]);
        box[1].setMax(start[i]);
        box[1].setMax(end[i]);
        sum += start[i] + end[i];
    }
    qcEnlarge(reach, box);
    return std::isfinite(sum.x() + sum.y() + sum.z());
}

void qcEnlarge(btScalar reach, btVector3 box[2])
{
    btVector3 largest = box[0].absolute();
    largest.setMax(box[1].absolute());
    const btScalar by = reach * btScalar(1.01) + s_rounding * largest[largest.maxAxis()];
    box[0] -= btVector3(by, by, by);
    box[1] += btVector3(by, by, by);
}
