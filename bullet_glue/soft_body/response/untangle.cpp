// Works tangled surfaces apart.
//
// If a curve cuts off a part of a surface, the direction is the mean normal of the triangles through which the edges of
// its border pass. Otherwise it is the direction that shortens the curve most: with e an edge that passes through a
// triangle of normal n, and r the direction of the curve from there, a motion d of the edge shortens it by
// d . (r - n (e.r) / (n.e)). Volino, Magnenat-Thalmann: Resolving Surface Collisions through Intersection Contour
// Minimization, 2006.
#include "soft_body/response/untangle.h"

#include <algorithm>

namespace
{
// The relative motion of both sides in a step, and the largest motion of a node, as a share of the thickness.
constexpr btScalar s_shift = btScalar(0.5);
// Edges with a smaller sine to the face give no reliable direction.
constexpr btScalar s_minSlope = btScalar(0.05);
// A mean of unit vectors that is shorter than this has no reliable direction.
constexpr btScalar s_minCoherence = btScalar(0.3);
// Edges from a curve as far as which nodes move with it: with the end of a curve that divides no surface; with a part,
// at least, and for each edge from the border of the part to its far end. Links that this compresses give the nodes a
// velocity: the further, the less.
constexpr uint32_t s_endReach = 3, s_partReach = 32, s_reachPerDepth = 8;

btVector3 NormalOf(const qcSurfaceGraph& graph, uint32_t triangle)
{
    const uint32_t* corners = graph.Corners(triangle);
    btVector3 origin = graph.Position(corners[0]);
    btVector3 normal = (graph.Position(corners[1]) - origin).cross(graph.Position(corners[2]) - origin);
    btScalar length = normal.length();
    return length > 0 ? normal / length : btVector3(0, 0, 0);
}

btVector3 EdgeOf(const qcSurfaceGraph& graph, const qcEdgeCrossing& crossing)
{
    btVector3 edge = graph.Position(crossing.to) - graph.Position(crossing.from);
    btScalar length = edge.length();
    return length > 0 ? edge / length : btVector3(0, 0, 0);
}

/// The direction in which the part of a side leaves the other side, its length at most 1, 0 if there is none.
btVector3 DirectionOfPart(const qcIntersectionCurve& curve, int side, btScalar* distance)
{
    const qcCurveSide &edges = curve.sides[side], &faces = curve.sides[1 - side];
    btVector3 sum(0, 0, 0), center(0, 0, 0);
    btScalar weights = 0;
    int count = 0;
    for (const qcEdgeCrossing& crossing : edges.crossings)
    {
        if (!crossing.bordersPart)
            continue;
        btVector3 normal = NormalOf(*faces.graph, crossing.triangle);
        btScalar slope = normal.dot(EdgeOf(*edges.graph, crossing));
        sum += normal * slope;
        weights += btFabs(slope);
        center += crossing.point;
        count++;
    }
    if (weights <= s_minSlope * btScalar(count))
        return btVector3(0, 0, 0);
    center /= btScalar(count);
    btVector3 direction = sum.normalized();
    *distance = 0;
    for (uint32_t vertex : edges.part)
        *distance = std::max(*distance, direction.dot(center - edges.graph->Position(vertex)));
    return sum / weights;
}

/// The motion of a crossing's edge that shortens the curve most. Its length is at most 1; 0 if there is none.
btVector3 ShorteningMotion(const qcIntersectionCurve& curve, int side, const qcEdgeCrossing& crossing)
{
    btVector3 normal = NormalOf(*curve.sides[1 - side].graph, crossing.triangle);
    btVector3 edge = EdgeOf(*curve.sides[side].graph, crossing);
    btScalar slope = normal.dot(edge);
    if (btFabs(slope) < s_minSlope)
        return btVector3(0, 0, 0);
    btVector3 motion = crossing.along - normal * (edge.dot(crossing.along) / slope);
    btScalar length = motion.length();
    return length > 1 ? motion / length : motion;
}

/// The relative motion of the first side that shortens the curve most, as a mean over its crossings.
btVector3 ShorteningDirection(const qcIntersectionCurve& curve)
{
    btVector3 sum(0, 0, 0);
    for (int side = 0; side < 2; side++)
        for (const qcEdgeCrossing& crossing : curve.sides[side].crossings)
            sum += ShorteningMotion(curve, side, crossing) * btScalar(side == 0 ? 1 : -1);
    return sum / btScalar(curve.sides[0].crossings.size() + curve.sides[1].crossings.size());
}

/// Adds the ends of a curve that divides no surface. False: it is closed.
bool AddEnds(const qcIntersectionCurve& curve, std::vector<qcUntanglement>* untanglements)
{
    bool hasEnds = false;
    for (int side = 0; side < 2; side++)
        for (const qcEdgeCrossing& crossing : curve.sides[side].crossings)
        {
            btVector3 motion = ShorteningMotion(curve, side, crossing);
            btScalar length = motion.length();
            if (!crossing.isEnd || length <= SIMD_EPSILON)
                continue;
            hasEnds = true;
            untanglements->push_back({&curve, side, {false, false}, &crossing, motion / length, BT_LARGE_FLOAT, false});
        }
    return hasEnds;
}

/// True if the curve is around an anchor of one side to the other side's object: a part is anchored, and can't leave
/// the object, or the curve goes on through triangles with an anchored node, which may pass.
bool IsAnchored(const qcIntersectionCurve& curve)
{
    for (int side = 0; side < 2; side++)
    {
        const qcCurveSide& mine = curve.sides[side];
        const qcSceneRigid* rigid = curve.sides[1 - side].graph->rigid;
        if (mine.graph->soft == nullptr || rigid == nullptr)
            continue;
        for (const qcSoftAnchor& anchor : mine.graph->soft->anchors)
        {
            if (anchor.object != rigid->object)
                continue;
            bool isAround = std::find(mine.part.begin(), mine.part.end(), anchor.node) != mine.part.end();
            mine.graph->ForEachNeighbour(anchor.node,
                                         [&](uint32_t neighbour)
                                         {
                                             auto isAt = [neighbour](const qcEdgeCrossing& crossing)
                                             { return crossing.from == neighbour || crossing.to == neighbour; };
                                             isAround = isAround ||
                                                        std::any_of(mine.crossings.begin(), mine.crossings.end(), isAt);
                                         });
            if (isAround)
                return true;
        }
    }
    return false;
}

bool FindUntanglement(const qcIntersectionCurve& curve, qcUntanglement* found)
{
    btScalar distances[2] = {0, 0}, best = BT_LARGE_FLOAT;
    btVector3 directions[2];
    found->curve = &curve;
    found->end = nullptr;
    found->side = -1;
    for (int side = 0; side < 2; side++)
    {
        directions[side] = DirectionOfPart(curve, side, &distances[side]);
        btScalar coherence = directions[side].length();
        found->hasPart[side] = coherence >= s_minCoherence;
        if (!found->hasPart[side])
            continue;
        directions[side] /= coherence;
        if (distances[side] / coherence < best)
        {
            best = distances[side] / coherence;
            found->side = side;
        }
    }
    if (found->side >= 0)
    {
        found->direction = directions[found->side];
        found->distance = distances[found->side];
        int other = 1 - found->side;
        found->hasPart[other] = found->hasPart[other] && directions[other].dot(found->direction) < -s_minCoherence;
        return true;
    }
    return false;
}

bool FindShortening(const qcIntersectionCurve& curve, qcUntanglement* found)
{
    found->side = 0;
    found->distance = BT_LARGE_FLOAT;
    found->direction = ShorteningDirection(curve);
    btScalar length = found->direction.length();
    if (length <= SIMD_EPSILON)
    {
        // Surfaces that coincide.
        for (const qcPair& pair : curve.pairs)
            found->direction += NormalOf(*curve.sides[0].graph, pair.triangleA);
        length = found->direction.length();
    }
    if (length <= SIMD_EPSILON)
        return false;
    found->direction /= length;
    return true;
}

/// The nodes of one side that move, each by a share: 1 at the curve, less further from it.
struct Field
{
    const qcCurveSide* side;
    std::vector<uint32_t> nodes;
    std::vector<btScalar> shares;
    btScalar mass = 0;       ///< sum of mass * share
    btScalar squareMass = 0; ///< sum of mass * share^2
    bool isHeld = false;     ///< a fixed node is among them

    btScalar MassOf(size_t i) const
    {
        btScalar inverse = side->graph->soft->InverseMass(nodes[i]);
        return inverse > 0 ? 1 / inverse : btScalar(0);
    }
};

/// The greatest number of edges from the border of a part to a vertex of it. `hops`: scratch, a value for each vertex,
/// UINT32_MAX before and after.
uint32_t DepthOf(const qcCurveSide& side, std::vector<uint32_t>* hops)
{
    std::vector<uint32_t> queue;
    for (uint32_t vertex : side.part)
        (*hops)[vertex] = 0; // in the part, not reached
    for (const qcEdgeCrossing& crossing : side.crossings)
        if (crossing.bordersPart && (*hops)[crossing.from] == 0)
        {
            (*hops)[crossing.from] = 1;
            queue.push_back(crossing.from);
        }
    uint32_t depth = 1;
    for (size_t i = 0; i < queue.size(); i++)
    {
        depth = (*hops)[queue[i]];
        side.graph->ForEachNeighbour(queue[i],
                                     [&](uint32_t neighbour)
                                     {
                                         if ((*hops)[neighbour] != 0)
                                             return;
                                         (*hops)[neighbour] = depth + 1;
                                         queue.push_back(neighbour);
                                     });
    }
    for (uint32_t vertex : side.part)
        (*hops)[vertex] = UINT32_MAX;
    return depth;
}

/// `hops`: as for DepthOf.
Field MakeField(const qcUntanglement& tangle, int sideIndex, uint32_t reach, std::vector<uint32_t>* hops)
{
    const qcIntersectionCurve& curve = *tangle.curve;
    bool isMoved = sideIndex == tangle.side;
    const qcCurveSide& side = curve.sides[sideIndex];
    Field field;
    field.side = &side;
    if (side.graph->soft == nullptr)
        return field;
    auto add = [&](uint32_t vertex, uint32_t hop)
    {
        if ((*hops)[vertex] != UINT32_MAX)
            return;
        (*hops)[vertex] = hop;
        field.nodes.push_back(vertex);
        field.shares.push_back(std::min(btScalar(1), 2 - 2 * btScalar(hop) / btScalar(reach + 1)));
    };
    auto addTriangle = [&](uint32_t triangle) {
        std::for_each(side.graph->Corners(triangle), side.graph->Corners(triangle) + 3, [&](uint32_t v) { add(v, 0); });
    };
    if (tangle.end != nullptr && isMoved)
    {
        add(tangle.end->from, 0);
        add(tangle.end->to, 0);
    }
    else if (tangle.end != nullptr)
        addTriangle(tangle.end->triangle);
    else
    {
        if (isMoved && tangle.hasPart[sideIndex])
            for (uint32_t vertex : side.part)
                add(vertex, 0);
        for (const qcPair& pair : curve.pairs)
            addTriangle(sideIndex == 0 ? pair.triangleA : pair.triangleB);
    }
    for (size_t i = 0; i < field.nodes.size(); i++)
        if ((*hops)[field.nodes[i]] < reach)
        {
            uint32_t hop = (*hops)[field.nodes[i]] + 1;
            side.graph->ForEachNeighbour(field.nodes[i], [&](uint32_t neighbour) { add(neighbour, hop); });
        }
    for (size_t i = 0; i < field.nodes.size(); i++)
    {
        btScalar mass = field.MassOf(i);
        field.isHeld = field.isHeld || mass == 0;
        field.mass += mass * field.shares[i];
        field.squareMass += mass * field.shares[i] * field.shares[i];
        (*hops)[field.nodes[i]] = UINT32_MAX;
    }
    return field;
}

/// The mean motion of a side's nodes in the step so far along a direction.
btScalar MeanMotion(const Field& field, const btVector3& direction, const btVector3& center)
{
    const qcSurfaceGraph& graph = *field.side->graph;
    if (graph.soft == nullptr)
        return direction.dot(graph.rigid->object->getWorldTransform() * (graph.rigid->start.inverse() * center) -
                             center);
    btScalar sum = 0;
    for (size_t i = 0; i < field.nodes.size(); i++)
        sum += field.MassOf(i) * field.shares[i] *
               direction.dot(graph.soft->MotionOf(field.nodes[i], graph.soft->start[field.nodes[i]]));
    return field.mass > 0 ? sum / field.mass : btScalar(0);
}

/// The mean of the crossings that move.
btVector3 CenterOf(const qcUntanglement& tangle)
{
    if (tangle.end != nullptr)
        return tangle.end->point;
    btVector3 sum(0, 0, 0);
    btScalar count = 0;
    for (const qcCurveSide& side : tangle.curve->sides)
        for (const qcEdgeCrossing& crossing : side.crossings)
        {
            sum += crossing.point;
            count += 1;
        }
    return sum / count;
}

/// Calls function(body, node, displacement) for each node that moves if its side does.
template <typename Function> void ForEachMoved(const Field& field, const btVector3& by, Function function)
{
    qcSceneSoftBody* soft = field.side->graph->soft;
    for (size_t i = 0; i < field.nodes.size(); i++)
        if (soft->InverseMass(field.nodes[i]) > 0)
            function(*soft, field.nodes[i], by * field.shares[i]);
}

btScalar CurveThickness(const qcIntersectionCurve& curve)
{
    btScalar sum = 0;
    for (const qcCurveSide& side : curve.sides)
        sum += side.graph->soft != nullptr ? side.graph->soft->thickness / 2 : side.graph->mesh->shape->getMargin();
    return sum;
}

/// Both sides of a tangle.
struct Fields
{
    Field sides[2]; ///< the side that leaves, and the other
    bool stays[2];  ///< without velocity, the other side alone moves

    Fields(const qcUntanglement& tangle, uint32_t reach, std::vector<uint32_t>* hops)
        : sides{MakeField(tangle, tangle.side, reach, hops), MakeField(tangle, 1 - tangle.side, reach, hops)}
    {
        // A side with fixed nodes stays if the other one can move freely.
        for (int i = 0; i < 2; i++)
            stays[i] = sides[i].isHeld && !sides[1 - i].isHeld && sides[1 - i].mass > 0;
    }

    /// The displacement of a side by a unit of momentum.
    btScalar Mobility(int i) const
    {
        return sides[i].mass > 0 ? 1 / sides[i].mass : btScalar(0);
    }
    btScalar ShiftMobility(int i) const
    {
        return stays[i] ? btScalar(0) : Mobility(i);
    }
    /// Calls function(body, node, displacement) for each node that an impulse, times the time step, moves.
    template <typename Function> void ForEachMoved(const btVector3& impulse, Function function) const
    {
        ::ForEachMoved(sides[0], impulse * Mobility(0), function);
        ::ForEachMoved(sides[1], impulse * -Mobility(1), function);
    }
    template <typename Function> void ForEachShifted(const btVector3& impulse, Function function) const
    {
        for (int i = 0; i < 2; i++)
            if (!stays[i])
                ::ForEachMoved(sides[i], impulse * (i == 0 ? Mobility(i) : -Mobility(i)), function);
    }
};

/// Ends motion that tangles further, as in an inelastic contact. Returns the relative motion that is left.
btScalar StopTangling(const qcUntanglement& tangle, const Fields& fields)
{
    btVector3 center = CenterOf(tangle);
    btScalar motion =
        MeanMotion(fields.sides[0], tangle.direction, center) - MeanMotion(fields.sides[1], tangle.direction, center);
    if (motion >= 0)
        return motion;
    btScalar effective = 0;
    qcSceneRigid* rigids[2];
    btVector3 arms[2];
    for (int i = 0; i < 2; i++)
    {
        effective += fields.Mobility(i) * fields.Mobility(i) * fields.sides[i].squareMass;
        rigids[i] = fields.sides[i].side->graph->rigid;
        if (rigids[i] == nullptr)
            continue;
        arms[i] = center - rigids[i]->object->getWorldTransform().getOrigin();
        effective += rigids[i]->DisplacementAt(arms[i], tangle.direction).dot(tangle.direction);
    }
    if (effective <= 0)
        return motion;
    btVector3 impulse = tangle.direction * (-motion / effective);
    fields.ForEachMoved(impulse,
                        [](qcSceneSoftBody& soft, uint32_t node, const btVector3& by) { soft.positions[node] += by; });
    for (int i = 0; i < 2; i++)
        if (rigids[i] != nullptr)
            rigids[i]->Push(arms[i], i == 0 ? impulse : -impulse);
    return 0;
}

/// A motion without velocity.
struct Shift
{
    Fields fields;
    btVector3 impulse; ///< times the time step
    btScalar thickness;
};

Shift MakeShift(const qcUntanglement& tangle, std::vector<uint32_t>* hops)
{
    const qcCurveSide* sides = tangle.curve->sides;
    uint32_t reach = tangle.end != nullptr ? s_endReach
                     : tangle.hasPart[tangle.side]
                         ? DepthOf(sides[tangle.side], hops)
                         : uint32_t(sides[0].crossings.size() + sides[1].crossings.size()) / 2;
    Shift shift = {Fields(tangle, reach, hops), btVector3(0, 0, 0), CurveThickness(*tangle.curve)};
    btScalar motion = StopTangling(tangle, shift.fields);
    if (tangle.hasPart[tangle.side] && sides[0].slot != sides[1].slot)
        shift.fields = Fields(tangle, std::max(s_partReach, s_reachPerDepth * reach), hops);
    btScalar missing = std::min(s_shift * shift.thickness, tangle.distance + shift.thickness) - motion;
    btScalar mobility = shift.fields.ShiftMobility(0) + shift.fields.ShiftMobility(1);
    if (missing > 0 && mobility > 0)
        shift.impulse = tangle.direction * (missing / mobility);
    return shift;
}

/// The sums of the shifts. A shift is reduced as a whole, so that momentum is kept, if the sum of all would move one of
/// its nodes further than a single one may.
void Add(const std::vector<Shift>& shifts, qcNodeShifts* sums)
{
    qcNodeShifts all;
    auto add = [](qcNodeShifts* to, qcSceneSoftBody& soft, uint32_t node, const btVector3& by)
    {
        std::vector<btVector3>& sum = (*to)[&soft];
        sum.resize(soft.positions.size(), btVector3(0, 0, 0));
        sum[node] += by;
    };
    for (const Shift& shift : shifts)
        shift.fields.ForEachShifted(shift.impulse, [&](qcSceneSoftBody& soft, uint32_t node, const btVector3& by)
                                    { add(&all, soft, node, by); });
    for (const Shift& shift : shifts)
    {
        btScalar factor = 1;
        shift.fields.ForEachShifted(
            shift.impulse, [&](qcSceneSoftBody& soft, uint32_t node, const btVector3&)
            { factor = std::max(factor, all[&soft][node].length() / (s_shift * shift.thickness)); });
        shift.fields.ForEachShifted(shift.impulse / factor, [&](qcSceneSoftBody& soft, uint32_t node,
                                                                const btVector3& by) { add(sums, soft, node, by); });
    }
}
} // namespace

std::vector<qcUntanglement> qcFindUntanglements(const qcIntersectionCurves& curves)
{
    std::vector<qcUntanglement> untanglements;
    for (const qcIntersectionCurve& curve : curves.Curves())
    {
        const size_t first = untanglements.size();
        qcUntanglement found;
        if (FindUntanglement(curve, &found) || (!AddEnds(curve, &untanglements) && FindShortening(curve, &found)))
            untanglements.push_back(found);
        const bool stays = first < untanglements.size() && IsAnchored(curve);
        for (size_t i = first; i < untanglements.size(); i++)
            untanglements[i].stays = stays;
    }
    return untanglements;
}

qcNodeShifts qcUntangle(const std::vector<qcUntanglement>& untanglements)
{
    uint32_t vertexCount = 0;
    for (const qcUntanglement& tangle : untanglements)
        for (const qcCurveSide& side : tangle.curve->sides)
            vertexCount = std::max(vertexCount, side.graph->VertexCount());
    std::vector<uint32_t> hops(vertexCount, UINT32_MAX);
    std::vector<Shift> shifts;
    for (const qcUntanglement& tangle : untanglements)
        if (!tangle.stays)
            shifts.push_back(MakeShift(tangle, &hops));
    qcNodeShifts sums;
    Add(shifts, &sums);
    return sums;
}
