// The curves in which surfaces intersect at the start of a step, and the parts of surfaces that these cut off. Baraff,
// Witkin, Kass: Untangling Cloth, 2003.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_INTERSECTION_CURVES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_INTERSECTION_CURVES_H

#include "soft_body/scene/surface_graph.h"

#include <array>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <vector>

/// An edge of one side of a curve passes through a triangle of the other side.
struct qcEdgeCrossing
{
    uint32_t from, to; ///< of the edge
    uint32_t triangle;
    btVector3 point;
    btVector3 along;  ///< sum of the unit directions from this point to the next ones on the curve
    bool isEnd;       ///< of the curve: one triangle only with this edge is in it
    bool bordersPart; ///< `from` is in the part that the curve cuts off, and `to` isn't
};

struct qcCurveSide
{
    const qcSurfaceGraph* graph = nullptr;
    uint32_t slot = 0;
    std::vector<qcEdgeCrossing> crossings; ///< of this side's edges
    /// Vertices of the smaller of the two parts into which the curve divides the surface. Empty: it doesn't.
    std::vector<uint32_t> part;
};

/// The intersection of two surfaces, or of one with itself, along one curve.
struct qcIntersectionCurve
{
    qcCurveSide sides[2];
    std::vector<qcPair> pairs; ///< triangle A is of the first side
};

/// A curve and the direction in which its first side leaves the other one.
struct qcUntanglement
{
    const qcIntersectionCurve* curve;
    int side;                  ///< which moves along the direction
    bool hasPart[2];           ///< the curve's parts that are on the wrong side of the other surface
    const qcEdgeCrossing* end; ///< the end of the curve that moves; null: all of it does
    btVector3 direction;       ///< unit
    btScalar distance;         ///< that the part has to move; without a part unlimited
    bool stays = false;        ///< it is around an anchor: it may pass, but isn't moved
};

class qcIntersectionCurves
{
  public:
    /// Finds the curves. `pairs`: those that penetrate at the start of the step or are no further apart than four times
    /// the perturbation, the largest displacement by which coordinates are made general: surfaces that touch exactly,
    /// in vertices or along edges, cross or don't. O(triangles of the bodies + size of the parts + pairs log pairs).
    void Find(qcSoftBodyScene& scene, const std::vector<qcPair>& pairs, btScalar perturbation);
    const std::vector<qcIntersectionCurve>& Curves() const
    {
        return m_curves;
    }
    void Clear();

  private:
    /// An edge of a pair's triangle that passes through the other triangle.
    struct PairEdge
    {
        uint32_t slot, from, to; ///< of the edge, from < to
        uint32_t otherSlot, triangle;
        size_t pair;
        int side;        ///< of the pair, which has the edge
        size_t crossing; ///< index in m_crossings

        bool IsSameCrossing(const PairEdge& other) const
        {
            return std::tie(slot, otherSlot, from, to, triangle) ==
                   std::tie(other.slot, other.otherSlot, other.from, other.to, other.triangle);
        }
        bool operator<(const PairEdge& other) const
        {
            return std::tie(slot, otherSlot, from, to, triangle, pair, side) <
                   std::tie(other.slot, other.otherSlot, other.from, other.to, other.triangle, other.pair, other.side);
        }
    };
    /// The edges of pairs that are one edge passing through one triangle.
    struct Crossing
    {
        size_t first, end; ///< in m_pairEdges
        int side;          ///< of its curve
        size_t index;      ///< in the side's crossings; SIZE_MAX: it is on no curve yet
    };
    using CutEdge = std::array<uint32_t, 4>;

    const qcSurfaceGraph* GraphOf(qcSoftBodyScene& scene, uint32_t slot);
    void FindCrossings(const std::vector<qcPair>& pairs, btScalar perturbation);
    void GroupCrossings();
    void Trace(const std::vector<qcPair>& pairs);
    void AddPair(const qcPair& pair, const std::vector<size_t>& edges, int firstSide, qcIntersectionCurve* curve);
    void FindCuts();
    void Divide(qcCurveSide* side, uint32_t otherSlot);

    std::map<uint32_t, std::unique_ptr<qcSurfaceGraph>> m_graphs; ///< by slot
    std::vector<qcIntersectionCurve> m_curves;
    std::vector<PairEdge> m_pairEdges; ///< sorted by crossing
    std::vector<Crossing> m_crossings;
    std::vector<uint8_t> m_floodOf; ///< scratch of Divide: for each vertex, 0 before and after
    std::set<CutEdge> m_cuts; ///< slot, slot of the other surface, ends: edges that cross it an odd number of times
};

#endif
