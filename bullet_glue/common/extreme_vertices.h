// The extreme vertices of a mesh along a direction. Boxes around runs of vertices show which ones need not be read.
#ifndef QC_GLUE_COMMON_EXTREME_VERTICES_H
#define QC_GLUE_COMMON_EXTREME_VERTICES_H

#include "common/lanes.h"

#include <LinearMath/btVector3.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

/// Points, and the direction with which their products are compared. Rounding is monotone: the product of a box's
/// corner is no less than those of what the box has.
struct qcProducts
{
    static constexpr size_t s_block = 2 * qcLaneCount; ///< products are compared in blocks of two vectors

    const btScalar *x, *y, *z;
    btScalar dx, dy, dz;

    /// The products of the points from `first` on.
    qcLanes At(size_t first) const
    {
        return qcLoadLanes(x + first) * dx + qcLoadLanes(y + first) * dy + qcLoadLanes(z + first) * dz;
    }

    /// The largest product of points and `max`. `first` and `end` are those of blocks.
    btScalar MaxOf(size_t first, size_t end, btScalar max) const
    {
        qcLanes low = qcLanes{} + max, high = low;
        for (size_t i = first; i < end; i += s_block)
        {
            const qcLanes even = At(i), odd = At(i + qcLaneCount);
            low = even > low ? even : low;
            high = odd > high ? odd : high;
        }
        low = high > low ? high : low;
        max = low[0];
        for (size_t lane = 1; lane < qcLaneCount; lane++)
            max = std::max(max, low[lane]);
        return max;
    }
};

class qcExtremeVertices
{
  public:
    /// Coordinates are finite. O(vertices).
    qcExtremeVertices(const btVector3* points, size_t count);

    /// The largest product of a vertex with the direction. In large meshes it reads the boxes of all runs, and the
    /// vertices of those whose boxes reach further than what is found.
    btScalar Max(const btVector3& direction) const;
    /// The first vertex with that product.
    uint32_t FindMax(const btVector3& direction) const;
    /// Appends the vertices whose product with the direction is at least `level`, in order. O(vertices).
    void AppendAbove(const btVector3& direction, btScalar level, std::vector<uint32_t>* vertices) const;
    /// Likewise, of some runs only. O(their vertices * log).
    void AppendAboveInRuns(const btVector3& direction, btScalar level, const std::vector<size_t>& runs,
                           std::vector<uint32_t>* vertices) const;

    /// Runs are vertices near each other. 0: the mesh is too small to have any.
    size_t RunCount() const
    {
        return m_runs;
    }
    /// Calls function(vertex) for the vertices of a run.
    template <typename Function> void ForEachInRun(size_t run, Function function) const
    {
        for (size_t i = run * s_run; i < std::min((run + 1) * s_run, m_count); i++)
            function(m_ids[i]);
    }

  private:
    static constexpr size_t s_run = 64; ///< vertices of a run

    /// Coordinates of points.
    struct Points
    {
        std::vector<btScalar> x, y, z;

        /// Copies points, padded to whole blocks with copies of the last one.
        void Assign(const btVector3* points, size_t count);
        qcProducts Along(const btVector3& direction) const;
    };

    void MakeRuns(const btVector3* points);
    qcProducts BoxesAlong(const btVector3& direction) const;
    template <typename Visit> void VisitRunsAbove(const qcProducts& boxes, btScalar level, Visit visit) const;

    size_t m_count, m_runs = 0; ///< runs: 0 for a small mesh
    Points m_vertices;
    Points m_inRuns;                  ///< those near each other in one run
    std::vector<uint32_t> m_ids;      ///< of these, padded likewise
    std::vector<uint32_t> m_firstIds; ///< by run: the least of its vertices
    Points m_lower, m_upper;          ///< corners of the runs' boxes
};

#endif
