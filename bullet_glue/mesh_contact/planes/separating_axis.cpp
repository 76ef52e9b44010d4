// A direction that separates two small meshes as a whole.
#include "mesh_contact/planes/separating_axis.h"

#include <algorithm>
#include <limits>

namespace
{
constexpr int s_maxIterations = 24;
// The search ends when the gap is within this part of the distance, or of the meshes' size.
constexpr btScalar s_relative = btScalar(1e-3), s_absolute = btScalar(1e-6);
// A face's normal is tried if its cosine with the axis is more than this.
constexpr btScalar s_aligned = btScalar(0.9);
// Hulls that overlap are moved apart by this factor of their overlap, as long as that makes it less by this factor.
constexpr btScalar s_moveFactor = 4, s_worthMoving = btScalar(0.7);
constexpr int s_maxMoves = 4;

/// A vertex of the set of differences of B's and A's points.
struct Corner
{
    btVector3 point;
    uint32_t a, b;
};

/// Up to four corners, and the point of their hull next to the origin.
struct Simplex
{
    int count = 0;
    Corner corners[4];
    btVector3 nearest;

    bool Has(const Corner& corner) const
    {
        return std::any_of(corners, corners + count,
                           [&](const Corner& mine) { return mine.a == corner.a && mine.b == corner.b; });
    }
};

/// The simplex of some corners of another one, if its nearest point is nearer than that of `best`.
void Take(const Simplex& all, std::initializer_list<int> kept, const btVector3& nearest, Simplex* best)
{
    if (best->count > 0 && nearest.length2() >= best->nearest.length2())
        return;
    best->count = 0;
    for (int i : kept)
        best->corners[best->count++] = all.corners[i];
    best->nearest = nearest;
}

void TakeSegment(const Simplex& all, int i, int j, Simplex* best)
{
    const btVector3 &a = all.corners[i].point, &b = all.corners[j].point;
    btVector3 along = b - a;
    btScalar length2 = along.length2(), t = -a.dot(along);
    if (t <= 0)
        Take(all, {i}, a, best);
    else if (t >= length2)
        Take(all, {j}, b, best);
    else
        Take(all, {i, j}, a + along * (t / length2), best);
}

void TakeTriangle(const Simplex& all, int i, int j, int k, Simplex* best)
{
    const btVector3 &a = all.corners[i].point, &b = all.corners[j].point, &c = all.corners[k].point;
    btVector3 normal = (b - a).cross(c - a);
    btScalar size2 = normal.length2();
    bool inside =
        size2 > 0 && a.cross(b).dot(normal) >= 0 && b.cross(c).dot(normal) >= 0 && c.cross(a).dot(normal) >= 0;
    if (inside)
        Take(all, {i, j, k}, normal * (a.dot(normal) / size2), best);
    else
    {
        TakeSegment(all, i, j, best);
        TakeSegment(all, j, k, best);
        TakeSegment(all, k, i, best);
    }
}

/// True if the origin is inside of the tetrahedron: on the inner side of each face.
bool IsInside(const Simplex& all)
{
    for (int i = 0; i < 4; i++)
    {
        const btVector3 &a = all.corners[i].point, &b = all.corners[(i + 1) % 4].point,
                        &c = all.corners[(i + 2) % 4].point, &d = all.corners[(i + 3) % 4].point;
        btVector3 normal = (b - a).cross(c - a);
        if (!(normal.dot(d - a) * -normal.dot(a) > 0))
            return false;
    }
    return true;
}

/// Reduces the simplex to the corners that its nearest point needs. False: the origin is inside.
bool Reduce(Simplex* simplex)
{
    Simplex best;
    switch (simplex->count)
    {
        case 1: Take(*simplex, {0}, simplex->corners[0].point, &best); break;
        case 2: TakeSegment(*simplex, 0, 1, &best); break;
        case 3: TakeTriangle(*simplex, 0, 1, 2, &best); break;
        default:
            if (IsInside(*simplex))
                return false;
            TakeTriangle(*simplex, 0, 1, 2, &best);
            TakeTriangle(*simplex, 0, 1, 3, &best);
            TakeTriangle(*simplex, 0, 2, 3, &best);
            TakeTriangle(*simplex, 1, 2, 3, &best);
    }
    *simplex = best;
    return true;
}

/// Weights of a simplex's corners at its nearest point.
void FindWeights(const Simplex& simplex, btScalar weights[3])
{
    const Corner* corners = simplex.corners;
    weights[0] = 1;
    weights[1] = weights[2] = 0;
    if (simplex.count == 2)
    {
        btVector3 along = corners[1].point - corners[0].point;
        weights[1] = (simplex.nearest - corners[0].point).dot(along) / along.length2();
        weights[0] = 1 - weights[1];
    }
    else if (simplex.count == 3)
    {
        const btVector3 &p = simplex.nearest, &q = corners[0].point, &r = corners[1].point, &s = corners[2].point;
        btVector3 normal = (r - q).cross(s - q);
        weights[1] = (s - p).cross(q - p).dot(normal) / normal.length2();
        weights[2] = (q - p).cross(r - p).dot(normal) / normal.length2();
        weights[0] = 1 - weights[1] - weights[2];
    }
}

template <typename A, typename B>
void SetClosest(const A& a, const B& b, const Simplex& simplex, qcSeparation* separation)
{
    if (simplex.count == 0 || simplex.count > 3)
        return;
    btScalar weights[3];
    FindWeights(simplex, weights);
    separation->cornerCount = simplex.count;
    separation->onA = separation->onB = btVector3(0, 0, 0);
    for (int i = 0; i < simplex.count; i++)
    {
        separation->cornersA[i] = simplex.corners[i].a;
        separation->cornersB[i] = simplex.corners[i].b;
        separation->onA += weights[i] * a.VertexAt(simplex.corners[i].a);
        separation->onB += weights[i] * b.VertexAt(simplex.corners[i].b);
    }
}

/// A triangle in place of a hull.
struct Triangle
{
    const btVector3* corners;

    uint32_t FindMax(const btVector3& direction) const
    {
        return uint32_t(
            btVector3(direction.dot(corners[0]), direction.dot(corners[1]), direction.dot(corners[2])).maxAxis());
    }
    const btVector3& VertexAt(uint32_t index) const
    {
        return corners[index];
    }
    btScalar Radius() const
    {
        return std::max(corners[0].distance(corners[1]), corners[0].distance(corners[2]));
    }
};

/// Iterates to the largest gap. Ends early where the hulls touch or overlap: false.
template <typename A, typename B>
bool Iterate(const A& a, const B& b, btScalar enough, Simplex* simplex, qcSeparation* separation)
{
    btScalar tiny = s_absolute * (a.Radius() + b.Radius());
    btVector3 axis = separation->axis;
    for (int i = 0; i < s_maxIterations; i++)
    {
        Corner corner;
        corner.a = a.FindMax(axis);
        corner.b = b.FindMax(-axis);
        corner.point = b.VertexAt(corner.b) - a.VertexAt(corner.a);
        btScalar gap = corner.point.dot(axis);
        if (gap > separation->gap)
        {
            separation->gap = gap;
            separation->axis = axis;
        }
        if (gap > enough || simplex->Has(corner) ||
            (simplex->count > 0 && simplex->nearest.length() - gap <= s_relative * gap + tiny))
            break;
        simplex->corners[simplex->count++] = corner;
        if (!Reduce(simplex) || simplex->nearest.length() <= tiny)
            return false;
        axis = simplex->nearest.normalized();
    }
    SetClosest(a, b, *simplex, separation);
    return separation->gap > tiny;
}

/// Takes the normal of a face if its gap is larger than `bestGap`, which becomes that gap. `closest`: corners of which
/// some are where the meshes are close.
void TryFaces(const qcPlacedSupport& a, const qcPlacedSupport& b, bool ofA, const Simplex& closest,
              const btVector3& near, btScalar aligned, btScalar* bestGap, btVector3* best)
{
    const qcPlacedSupport &own = ofA ? a : b, &other = ofA ? b : a;
    btVector3 from = own.transform.getOrigin(), localNear = own.ToLocal(ofA ? near : -near);
    btVector3 corners[4];
    for (int i = 0; i < closest.count; i++)
        corners[i] = own.ToLocal(other.VertexAt(ofA ? closest.corners[i].b : closest.corners[i].a) - from);
    for (const qcSupportMesh::Face& face : own.mesh->Faces())
    {
        bool isLess = face.normal.dot(localNear) < aligned;
        for (int i = 0; i < closest.count; i++)
            isLess = isLess || face.normal.dot(corners[i]) - face.max <= *bestGap;
        if (isLess)
            continue;
        btVector3 axis = own.transform.getBasis() * face.normal * btScalar(ofA ? 1 : -1);
        btScalar gap = qcGapAlong(a, b, axis);
        if (gap <= *bestGap)
            continue;
        *bestGap = gap;
        *best = axis;
    }
}

/// Moves hulls that overlap apart, and takes the axis between them if its gap without the move is larger than
/// `bestGap`, which becomes that gap: convex pieces that meet at an edge have a plane between them that no face lies
/// in.
void TryMovedApart(const qcPlacedSupport& a, const qcPlacedSupport& b, btScalar* bestGap, btVector3* best)
{
    btVector3 apart = b.transform.getOrigin() - a.transform.getOrigin();
    if (apart.fuzzyZero())
        return;
    apart.normalize();
    for (int i = 0; i < s_maxMoves; i++)
    {
        qcPlacedSupport moved = b;
        moved.transform.getOrigin() += apart * (s_moveFactor * -*bestGap);
        Simplex closest;
        qcSeparation separation;
        separation.axis = *best;
        Iterate(a, moved, BT_LARGE_FLOAT, &closest, &separation);
        btScalar gap = qcGapAlong(a, b, separation.axis);
        if (gap <= *bestGap)
            return;
        bool isBetter = gap > *bestGap * s_worthMoving;
        *bestGap = gap;
        *best = separation.axis;
        if (!isBetter || gap >= 0)
            return;
    }
}

/// The direction to begin with.
btVector3 FirstAxis(const btVector3& guess, const btVector3& centres)
{
    btVector3 axis = !guess.fuzzyZero() ? guess : !centres.fuzzyZero() ? centres : btVector3(0, 1, 0);
    return axis.normalized();
}
} // namespace

btScalar qcGapAlong(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& axis)
{
    return axis.dot(b.transform.getOrigin() - a.transform.getOrigin()) - b.mesh->Max(b.ToLocal(-axis)) -
           a.mesh->Max(a.ToLocal(axis));
}

btScalar qcGapError(const qcPlacedSupport& a, const qcPlacedSupport& b)
{
    btScalar size = a.mesh->Radius() + b.mesh->Radius() + (b.transform.getOrigin() - a.transform.getOrigin()).length();
    return 32 * std::numeric_limits<btScalar>::epsilon() * size;
}

qcSeparation qcSeparateHulls(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& guess,
                             btScalar enough)
{
    qcSeparation separation;
    separation.axis = FirstAxis(guess, b.transform.getOrigin() - a.transform.getOrigin());
    Simplex closest;
    Iterate(a, b, enough, &closest, &separation);
    return separation;
}

qcSeparation qcSeparateFromTriangle(const qcPlacedSupport& hull, const btVector3 corners[3], const btVector3& guess)
{
    qcSeparation separation;
    separation.axis = FirstAxis(guess, corners[0] - hull.transform.getOrigin());
    Simplex closest;
    Iterate(hull, Triangle{corners}, BT_LARGE_FLOAT, &closest, &separation);
    return separation;
}

bool qcMovedHulls::AreSeparated(const qcSeparation& atStart) const
{
    if (atStart.gap <= error)
        return false;
    if (AreSeparatedAlong(atStart.axis))
        return true;
    const qcSeparation atEnd = qcSeparateHulls(endA, endB, atStart.axis, BT_LARGE_FLOAT);
    const btVector3 between = atStart.axis + atEnd.axis;
    return atEnd.gap > error &&
           (AreSeparatedAlong(atEnd.axis) || (!between.fuzzyZero() && AreSeparatedAlong(between.normalized())));
}

qcSeparation qcFindSeparation(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& guess,
                              btScalar enough, btScalar slack)
{
    qcSeparation separation;
    btVector3 centres = b.transform.getOrigin() - a.transform.getOrigin();
    separation.axis = FirstAxis(guess, centres);
    separation.gap = qcGapAlong(a, b, separation.axis);
    if (separation.gap > enough)
        return separation;
    Simplex closest;
    bool isApart = Iterate(a, b, enough, &closest, &separation);
    btScalar tiny = std::min(s_absolute * (a.mesh->Radius() + b.mesh->Radius()), qcGapError(a, b));
    if (separation.gap > enough || (!isApart && separation.gap > -tiny))
        return separation;
    btScalar bestGap = isApart ? separation.gap - slack : separation.gap;
    btVector3 best = separation.axis, near = isApart ? separation.axis : centres;
    for (bool ofA : {true, false})
        TryFaces(a, b, ofA, closest, near, isApart ? s_aligned : btScalar(0), &bestGap, &best);
    if (!isApart && bestGap < -tiny)
        TryMovedApart(a, b, &bestGap, &best);
    if (!isApart || best != separation.axis)
        separation.gap = bestGap;
    separation.axis = best;
    return separation;
}
