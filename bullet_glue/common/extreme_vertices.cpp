// The extreme vertices of a mesh along a direction.
#include "common/extreme_vertices.h"

#include "common/vertex_box.h"

#include <cmath>
#include <limits>

namespace
{
// Vertices of the smallest mesh that has runs: for fewer the boxes take as long as what they save.
constexpr size_t s_minVertices = 512;
// Cells along an axis of a mesh's box. Vertices are put in the order of their cells along a Morton curve.
constexpr uint32_t s_cells = 8;
// No box reaches this.
constexpr btScalar s_unreached = std::numeric_limits<btScalar>::infinity();

size_t PaddedCount(size_t count)
{
    return (count + qcProducts::s_block - 1) / qcProducts::s_block * qcProducts::s_block;
}

/// Calls function(lane) for the lanes that are at level `level`.
template <typename Function> void ForEachAbove(const qcLanes& lanes, btScalar level, Function function)
{
    if (!qcIsAny(lanes >= level))
        return;
    for (size_t lane = 0; lane < qcLaneCount; lane++)
        if (lanes[lane] >= level)
            function(lane);
}

/// The number of a point's cell along the curve.
uint32_t CellOf(const btVector3& point, const btVector3& lower, const btVector3& scale)
{
    const btVector3 at = (point - lower) * scale;
    uint32_t cell = 0;
    for (int axis = 0; axis < 3; axis++)
    {
        // False for what is not a number.
        const uint32_t i = at[axis] > 0 ? std::min(uint32_t(std::min(at[axis], btScalar(s_cells))), s_cells - 1) : 0;
        for (uint32_t bit = 0; s_cells >> bit > 1; bit++)
            cell |= (i >> bit & 1) << (3 * bit + uint32_t(axis));
    }
    return cell;
}

/// The numbers of points, in the order of their cells.
std::vector<uint32_t> SortByCell(const btVector3* points, size_t count)
{
    btVector3 box[2], scale;
    qcFindBox(points, count, box);
    for (int axis = 0; axis < 3; axis++)
        scale[axis] = btScalar(s_cells) / std::max(box[1][axis] - box[0][axis], SIMD_EPSILON);
    uint32_t starts[s_cells * s_cells * s_cells + 1] = {};
    std::vector<uint32_t> cells(count), ids(count);
    for (size_t i = 0; i < count; i++)
    {
        cells[i] = CellOf(points[i], box[0], scale);
        starts[cells[i] + 1]++;
    }
    for (size_t cell = 1; cell < s_cells * s_cells * s_cells; cell++)
        starts[cell] += starts[cell - 1];
    for (size_t i = 0; i < count; i++)
        ids[starts[cells[i]]++] = uint32_t(i);
    return ids;
}
} // namespace

qcProducts qcExtremeVertices::Points::Along(const btVector3& direction) const
{
    return {x.data(), y.data(), z.data(), direction.x(), direction.y(), direction.z()};
}

void qcExtremeVertices::Points::Assign(const btVector3* points, size_t count)
{
    const size_t padded = PaddedCount(count);
    for (std::vector<btScalar>* axis : {&x, &y, &z})
        axis->reserve(padded);
    for (size_t i = 0; i < padded; i++)
    {
        const btVector3& point = points[std::min(i, count - 1)];
        x.push_back(point.x());
        y.push_back(point.y());
        z.push_back(point.z());
    }
}

qcExtremeVertices::qcExtremeVertices(const btVector3* points, size_t count) : m_count(count)
{
    m_vertices.Assign(points, count);
    if (count >= s_minVertices)
        MakeRuns(points);
}

void qcExtremeVertices::MakeRuns(const btVector3* points)
{
    m_ids = SortByCell(points, m_count);
    std::vector<btVector3> inRuns, lower, upper;
    for (uint32_t id : m_ids)
        inRuns.push_back(points[id]);
    m_inRuns.Assign(inRuns.data(), m_count);
    m_ids.resize(PaddedCount(m_count), m_ids.back());
    for (size_t first = 0; first < m_count; first += s_run)
    {
        btVector3 box[2];
        qcFindBox(&inRuns[first], std::min(s_run, m_count - first), box);
        lower.push_back(box[0]);
        upper.push_back(box[1]);
        const auto run = m_ids.begin() + std::ptrdiff_t(first);
        m_firstIds.push_back(*std::min_element(run, run + std::ptrdiff_t(std::min(s_run, m_count - first))));
    }
    static_assert(s_run % qcProducts::s_block == 0, "runs are whole blocks");
    m_runs = lower.size();
    m_lower.Assign(lower.data(), m_runs);
    m_upper.Assign(upper.data(), m_runs);
}

/// The products of the boxes' furthest corners.
qcProducts qcExtremeVertices::BoxesAlong(const btVector3& direction) const
{
    return {(direction.x() > 0 ? m_upper : m_lower).x.data(),
            (direction.y() > 0 ? m_upper : m_lower).y.data(),
            (direction.z() > 0 ? m_upper : m_lower).z.data(),
            direction.x(),
            direction.y(),
            direction.z()};
}

/// Calls visit(first, end) for each run of vertices whose box reaches `level`. It returns what the following boxes have
/// to reach.
template <typename Visit>
void qcExtremeVertices::VisitRunsAbove(const qcProducts& boxes, btScalar level, Visit visit) const
{
    for (size_t run = 0; run < m_runs; run += qcLaneCount)
    {
        const qcLanes reached = boxes.At(run);
        if (!qcIsAny(reached >= level))
            continue;
        for (size_t lane = 0; lane < std::min(qcLaneCount, m_runs - run); lane++)
        {
            const size_t first = (run + lane) * s_run;
            if (reached[lane] >= level)
                level = visit(first, std::min(first + s_run, m_inRuns.x.size()));
        }
    }
}

btScalar qcExtremeVertices::Max(const btVector3& direction) const
{
    btScalar max = -BT_LARGE_FLOAT;
    if (m_runs == 0)
        return m_vertices.Along(direction).MaxOf(0, m_vertices.x.size(), max);
    const qcProducts vertices = m_inRuns.Along(direction), boxes = BoxesAlong(direction);
    auto visitOne = [&](size_t first, size_t end)
    {
        max = vertices.MaxOf(first, end, max);
        return s_unreached;
    };
    auto visitAll = [&](size_t first, size_t end)
    {
        max = vertices.MaxOf(first, end, max);
        return std::nextafter(max, s_unreached);
    };
    // The run that reaches furthest mostly leaves few others.
    VisitRunsAbove(boxes, boxes.MaxOf(0, m_lower.x.size(), max), visitOne);
    VisitRunsAbove(boxes, std::nextafter(max, s_unreached), visitAll);
    return max;
}

uint32_t qcExtremeVertices::FindMax(const btVector3& direction) const
{
    const btScalar max = Max(direction);
    uint32_t found = UINT32_MAX;
    if (m_runs == 0)
    {
        const qcProducts vertices = m_vertices.Along(direction);
        for (size_t i = 0; i < m_count && found == UINT32_MAX; i += qcLaneCount)
            ForEachAbove(vertices.At(i), max, [&](size_t lane) { found = std::min(found, uint32_t(i + lane)); });
        return found < m_count ? found : 0;
    }
    const qcProducts vertices = m_inRuns.Along(direction);
    auto visit = [&](size_t first, size_t end)
    {
        // Flat meshes have many vertices at the same height.
        for (size_t i = m_firstIds[first / s_run] < found ? first : end; i < end; i += qcLaneCount)
            ForEachAbove(vertices.At(i), max, [&](size_t lane) { found = std::min(found, m_ids[i + lane]); });
        return max;
    };
    VisitRunsAbove(BoxesAlong(direction), max, visit);
    return found < m_count ? found : 0;
}

void qcExtremeVertices::AppendAbove(const btVector3& direction, btScalar level, std::vector<uint32_t>* vertices) const
{
    const qcProducts products = m_vertices.Along(direction);
    for (size_t i = 0; i < m_count; i += qcLaneCount)
        ForEachAbove(products.At(i), level,
                     [&](size_t lane)
                     {
                         if (i + lane < m_count)
                             vertices->push_back(uint32_t(i + lane));
                     });
}

void qcExtremeVertices::AppendAboveInRuns(const btVector3& direction, btScalar level, const std::vector<size_t>& runs,
                                          std::vector<uint32_t>* vertices) const
{
    const size_t begin = vertices->size();
    const qcProducts products = m_inRuns.Along(direction);
    for (size_t run : runs)
        for (size_t i = run * s_run; i < std::min((run + 1) * s_run, m_count); i += qcLaneCount)
            ForEachAbove(products.At(i), level,
                         [&](size_t lane)
                         {
                             if (i + lane < m_count)
                                 vertices->push_back(m_ids[i + lane]);
                         });
    std::sort(vertices->begin() + std::ptrdiff_t(begin), vertices->end());
}
