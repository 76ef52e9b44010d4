// Small meshes that touch along faces.
#include "mesh_contact/planes/touching_faces.h"

#include <algorithm>

namespace
{
// Two faces may touch if the cosine between their normals is less than this, and their planes are nearer to each other
// than this part of the meshes' size.
constexpr btScalar s_opposite = btScalar(-0.9999), s_nearPlane = btScalar(0.01);
// Most faces of pieces have no more vertices.
constexpr size_t s_fewVertices = 16;

/// A vertex that two meshes have in common, up to rounding.
struct CommonVertex
{
    uint32_t a, b;
    btVector3 point;
};

/// Finds the common vertices next to the plane across a direction, unless the gap along it is not 0 up to rounding.
void FindCommon(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& axis,
                std::vector<CommonVertex>* common)
{
    common->clear();
    btScalar error = qcGapError(a, b);
    btVector3 localA = a.ToLocal(axis), localB = b.ToLocal(-axis);
    btScalar maxA = a.mesh->Max(localA), maxB = b.mesh->Max(localB);
    if (btFabs(axis.dot(b.transform.getOrigin() - a.transform.getOrigin()) - maxB - maxA) > error)
        return;
    std::vector<uint32_t> nearA, nearB;
    nearA.reserve(s_fewVertices);
    nearB.reserve(s_fewVertices);
    a.mesh->Vertices().AppendAbove(localA, maxA - error, &nearA);
    b.mesh->Vertices().AppendAbove(localB, maxB - error, &nearB);
    std::vector<btVector3> points;
    points.reserve(nearB.size());
    for (uint32_t j : nearB)
        points.push_back(b.VertexAt(j));
    common->reserve(nearA.size());
    for (uint32_t i : nearA)
    {
        btVector3 point = a.VertexAt(i);
        auto found = std::find_if(points.begin(), points.end(),
                                  [&](const btVector3& other) { return (other - point).length2() <= error * error; });
        if (found != points.end())
            common->push_back({i, nearB[size_t(found - points.begin())], point});
    }
}

/// Chooses three common vertices that span a large area. False: they lie on a line.
bool ChooseCorners(const std::vector<CommonVertex>& common, btScalar error, qcSeparation* separation)
{
    if (common.size() < 3)
        return false;
    auto farthest = [&](auto distance)
    {
        return &*std::max_element(common.begin(), common.end(),
                                  [&](const CommonVertex& p, const CommonVertex& q)
                                  { return distance(p.point) < distance(q.point); });
    };
    auto farthestFrom = [&](const CommonVertex* from)
    { return farthest([from](const btVector3& point) { return (point - from->point).length2(); }); };
    const CommonVertex *first = farthestFrom(&common.front()), *second = farthestFrom(first);
    btVector3 along = second->point - first->point;
    auto areaWith = [&](const btVector3& point) { return along.cross(point - first->point).length(); };
    const CommonVertex* third = farthest(areaWith);
    if (areaWith(third->point) <= error * along.length())
        return false;
    for (const CommonVertex* corner : {first, second, third})
    {
        separation->cornersA[separation->cornerCount] = corner->a;
        separation->cornersB[separation->cornerCount] = corner->b;
        separation->cornerCount++;
    }
    return true;
}
} // namespace

bool qcFindTouchingFaces(const qcPlacedSupport& a, const qcPlacedSupport& b, qcSeparation* separation)
{
    std::vector<CommonVertex> common;
    btVector3 between = b.transform.getOrigin() - a.transform.getOrigin();
    btScalar nearPlane = s_nearPlane * (a.mesh->Radius() + b.mesh->Radius());
    btMatrix3x3 aToB = b.transform.getBasis().transposeTimes(a.transform.getBasis());
    const std::vector<qcSupportMesh::Face>& others = b.mesh->FacesByMax();
    if (others.empty())
        return false;
    for (const qcSupportMesh::Face& face : a.mesh->Faces())
    {
        btVector3 normal = a.transform.getBasis() * face.normal;
        btScalar lowest = normal.dot(between) - face.max - nearPlane, highest = lowest + 2 * nearPlane;
        if (lowest > b.mesh->Radius())
            return false; // the face separates them
        if (highest < others.front().max)
            continue; // it is nearer to B's centre than each of B's faces
        auto other = std::lower_bound(others.begin(), others.end(), lowest,
                                      [](const qcSupportMesh::Face& some, btScalar max) { return some.max < max; });
        btVector3 inB = aToB * face.normal;
        for (; other != others.end() && other->max <= highest; ++other)
        {
            if (other->normal.dot(inB) > s_opposite)
                continue;
            FindCommon(a, b, normal, &common);
            if (!ChooseCorners(common, qcGapError(a, b), separation))
                continue;
            separation->axis = normal;
            separation->gap = qcGapAlong(a, b, normal);
            return true;
        }
    }
    return false;
}

bool qcTouchAlong(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& axis)
{
    std::vector<CommonVertex> common;
    FindCommon(a, b, axis, &common);
    return !common.empty();
}
