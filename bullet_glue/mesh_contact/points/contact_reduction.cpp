// Reduction of contact points: groups by normal, and in each the deepest point and those that span the largest area.
#include "mesh_contact/points/contact_reduction.h"

#include <algorithm>
#include <tuple>

namespace
{
// The cosine of 45 degrees: walls of a corner are groups of their own, a round hollow is a few.
constexpr btScalar s_sameGroup = btScalar(0.7071);

// Among points of equal worth, such as the corners of a ring that lies flat, those of the previous step are chosen,
// with their impulses: they count as nearer by this part of the contact distance, and their extent by this factor. Five
// tori in a bin, 40 starts: mean energy after 4 s 0.012 J without, 0.008 with this; twice as much changes nothing more.
constexpr btScalar s_knownNearer = btScalar(0.05), s_knownWider = 2;
// Points that recede don't carry bodies that turn against each other: their extent counts by this factor. A ball
// that rolls slowly sinks on points behind it, until those ahead, which had no place, push it on: 78 of 360 rolling
// meshes became faster, 7 with this, and without the preference of known ones (test_mesh_rolling).
constexpr btScalar s_recedingWider = btScalar(0.125);

// Parts of the contact distance.
constexpr btScalar s_hardlyDeeper = btScalar(0.1), s_fastClosing = btScalar(0.25);

/// A point with the distance by which it is ranked.
struct RankedPoint
{
    const qcMeshPoint* point;
    btScalar distance;
};

/// The points of a group before reduction.
struct Members
{
    btVector3 normal;
    std::vector<RankedPoint> points;
};

/// Distance of a point from the point, the line or the triangle that the chosen points span.
btScalar ExtentOf(const qcPointGroup& group, const btVector3& normal, const btVector3& point)
{
    btVector3 a = group.points[0]->onB;
    if (group.count == 1)
        return (point - a).length();
    btVector3 b = group.points[1]->onB;
    if (group.count == 2)
    {
        btVector3 along = b - a;
        btScalar length = along.length();
        return length > 0 ? (point - a).cross(along).length() / length : btScalar(0);
    }
    // Outside of the triangle's edges, as seen along the normal.
    btVector3 corner[3] = {a, b, group.points[2]->onB};
    btScalar turn = (b - a).cross(corner[2] - a).dot(normal) >= 0 ? btScalar(1) : btScalar(-1);
    btScalar outside = 0;
    for (int c = 0; c < 3; c++)
    {
        btVector3 edge = corner[(c + 1) % 3] - corner[c];
        btScalar length = edge.length();
        if (length > 0)
            outside = std::max(outside, -turn * edge.cross(point - corner[c]).dot(normal) / length);
    }
    return outside;
}

/// True if bodies close in on a point so fast that where they are at the end of the step matters.
bool IsFast(const qcMeshPoint& point, btScalar contactDistance)
{
    return point.distance - point.endDistance > s_fastClosing * contactDistance;
}

/// The distance by which points are ranked. A point beyond the contact distance, or a fast one, has its distance at the
/// end of the step, but at least half of the contact distance, since others may touch before it.
btScalar EffectiveDistance(const qcMeshPoint& point, const qcReductionDef& def)
{
    const btScalar contactDistance = def.contactDistance;
    btScalar distance = point.distance;
    if (distance > contactDistance)
        distance = std::max(point.endDistance, contactDistance / 2);
    else if (IsFast(point, contactDistance))
        distance = std::min(distance, std::max(point.endDistance, contactDistance / 2));
    return point.isKnown && !def.turns ? distance - s_knownNearer * contactDistance : distance;
}

/// True if Bullet's manifold would replace another point of the group by this one. Bullet compares the points on the
/// first body, which move along the normal with depth, and merges points within the breaking threshold, which is at
/// least their distance.
bool IsNear(const qcPointGroup& group, const qcMeshPoint& point, btScalar minSpacing)
{
    for (int i = 0; i < group.count; i++)
    {
        const qcMeshPoint& other = *group.points[i];
        btScalar near = std::max({minSpacing, point.distance, other.distance});
        if ((other.onA - point.onA).length2() < near * near || (other.onB - point.onB).length2() < near * near)
            return true;
    }
    return false;
}

/// The factor by which a point's extent counts.
btScalar PreferenceFor(const qcMeshPoint& point, const qcReductionDef& def)
{
    if (!def.turns)
        return point.isKnown ? s_knownWider : 1;
    return point.distance > 0 && point.endDistance > point.distance ? s_recedingWider : 1;
}

/// Adds the point that widens the group most. False: none does.
bool ChooseNext(const Members& members, const qcReductionDef& def, qcPointGroup* group)
{
    btScalar deepest = std::max(members.points[0].distance, btScalar(0));
    btScalar span = std::max(def.contactDistance - members.points[0].distance, SIMD_EPSILON);
    const qcMeshPoint* best = nullptr;
    btScalar maxGain = 0;
    for (const auto& [point, distance] : members.points)
    {
        // A wide but distant point carries no load soon: it must not replace those that carry the body.
        btScalar gap = std::min(std::max(distance, btScalar(0)) - deepest, span);
        btScalar weight = (1 - gap / span) * (1 - gap / span);
        btScalar gain = weight * ExtentOf(*group, members.normal, point->onB) * PreferenceFor(*point, def);
        if (gain > maxGain && !IsNear(*group, *point, def.minSpacing))
        {
            maxGain = gain;
            best = point;
        }
    }
    if (best != nullptr)
        group->points[group->count++] = best;
    return best != nullptr;
}

/// True if the first of four points lies within the triangle of the others and is hardly deeper, now and at the end of
/// the step: they carry it.
bool IsFirstCarried(const qcPointGroup& group, const btVector3& normal, const qcReductionDef& def)
{
    const qcMeshPoint* const* points = group.points;
    const qcPointGroup others{3, {points[1], points[2], points[3]}};
    const qcMeshPoint& first = *points[0];
    const btScalar slack = s_hardlyDeeper * def.contactDistance;
    auto carries = [&](const qcMeshPoint* point)
    {
        return EffectiveDistance(*point, def) <= EffectiveDistance(first, def) + slack &&
               (first.distance <= def.contactDistance || point->endDistance <= first.endDistance + slack);
    };
    return ExtentOf(others, normal, points[0]->onB) <= 0 && std::all_of(points + 1, points + 4, carries);
}

/// True if bodies reach a point within the step, at a speed that would matter. What turns about another point may come
/// as much again.
bool IsReached(const qcMeshPoint& point, btScalar contactDistance)
{
    return IsFast(point, contactDistance) && point.distance < 2 * (point.distance - point.endDistance);
}

/// Fills further groups with the points that the first one has left out and that are reached. Returns their number.
int KeepReached(const Members& members, const qcReductionDef& def, qcPointGroup* groups)
{
    int count = 1;
    for (const RankedPoint& ranked : members.points)
    {
        const qcMeshPoint* point = ranked.point;
        auto isNear = [&](const qcPointGroup& group) { return IsNear(group, *point, def.minSpacing); };
        if (!IsReached(*point, def.contactDistance) || std::any_of(groups, groups + count, isNear))
            continue;
        if (count == 1 || groups[count - 1].count == 4)
        {
            if (count == def.maxGroups)
                break;
            groups[count++].count = 0;
        }
        qcPointGroup& last = groups[count - 1];
        last.points[last.count++] = point;
    }
    return count;
}

void ChoosePoints(const Members& members, const qcReductionDef& def, qcPointGroup* group)
{
    group->count = 1;
    group->points[0] = members.points[0].point;
    while (group->count < 4 && ChooseNext(members, def, group))
    {
    }
    if (group->count < 4 || !IsFirstCarried(*group, members.normal, def))
        return;
    // A cube on a floor with a vertex under its middle: four corners, not three and the middle.
    std::swap(group->points[0], group->points[3]);
    group->count = 3;
    if (!ChooseNext(members, def, group))
        group->count = 4;
}
} // namespace

int qcGroupPoints(const std::vector<qcMeshPoint>& points, const qcReductionDef& def, qcPointGroup* groups)
{
    std::vector<RankedPoint> ranked;
    ranked.reserve(points.size());
    for (const qcMeshPoint& point : points)
        ranked.push_back({&point, EffectiveDistance(point, def)});
    // Points that are reached within the step have equal ranks: the deepest at its end is the first.
    std::sort(ranked.begin(), ranked.end(),
              [](const RankedPoint& a, const RankedPoint& b) {
                  return std::tie(a.distance, a.point->endDistance, a.point) <
                         std::tie(b.distance, b.point->endDistance, b.point);
              });
    std::vector<Members> members;
    for (const RankedPoint& point : ranked)
    {
        const btVector3& normal = point.point->normal;
        auto isLessSimilar = [&](const Members& a, const Members& b)
        { return a.normal.dot(normal) < b.normal.dot(normal); };
        auto nearest = std::max_element(members.begin(), members.end(), isLessSimilar);
        if (nearest == members.end() ||
            (nearest->normal.dot(normal) < s_sameGroup && int(members.size()) < def.maxGroups))
            nearest = members.insert(members.end(), Members{normal, {}});
        nearest->points.push_back(point);
    }
    int count = int(members.size());
    for (size_t g = 0; g < members.size(); g++)
        ChoosePoints(members[g], def, &groups[g]);
    if (def.keepsReached && count == 1)
        count = KeepReached(members[0], def, groups);
    for (int g = 0; g < count; g++)
        std::sort(groups[g].points, groups[g].points + groups[g].count,
                  [](const qcMeshPoint* a, const qcMeshPoint* b) { return a->distance < b->distance; });
    return count;
}

void qcAppendPoints(const qcResult& result, qcBodyId a, const std::vector<qcTriangleSource>& sourcesA, qcBodyId b,
                    const std::vector<qcTriangleSource>& sourcesB, std::vector<qcMeshPoint>* points)
{
    bool swapped = a.slot > b.slot;
    uint32_t low = std::min(a.slot, b.slot), high = std::max(a.slot, b.slot);
    const qcManifold* end = result.manifolds + result.manifoldCount;
    auto isBefore = [](const qcManifold& manifold, const std::pair<uint32_t, uint32_t>& bodies)
    { return std::make_pair(manifold.bodyA, manifold.bodyB) < bodies; };
    const qcManifold* manifold = std::lower_bound(result.manifolds, end, std::make_pair(low, high), isBefore);
    for (; manifold != end && manifold->bodyA == low && manifold->bodyB == high; manifold++)
        for (uint32_t i = 0; i < manifold->pointCount; i++)
        {
            const qcManifoldPoint& found = result.manifoldPoints[manifold->firstPoint + i];
            qcMeshPoint point;
            point.onA = qcVectorOf(swapped ? found.pointB : found.pointA);
            point.onB = qcVectorOf(swapped ? found.pointA : found.pointB);
            point.normal = swapped ? -qcVectorOf(found.normal) : qcVectorOf(found.normal);
            point.distance = btScalar(found.distance);
            point.sourceA = qcSourceOf(sourcesA, swapped ? found.triangleB : found.triangleA);
            point.sourceB = qcSourceOf(sourcesB, swapped ? found.triangleA : found.triangleB);
            point.region = int(manifold - result.manifolds);
            points->push_back(point);
        }
}
