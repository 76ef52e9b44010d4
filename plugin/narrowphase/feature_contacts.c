// Vertex against face and edge against edge, by the closest points of the two features.
//
// A vertex is tested with the whole closed face, which covers corners and borders. Two edges have a contact only where
// the closest points lie inside both: an end of an edge is a vertex. Distances are rounded in double; a contact is
// reported if the rounded distance is within the margin.
#include "narrowphase/feature_contacts.h"

#include "triangle/closest_points.h"

#include <math.h>

static const double s_corner[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

static void SetNormal(qcContact* contact, qcVector fromBToA, double distance, qcVector fallback)
{
    qcVector n = distance > 0.0 ? fromBToA : fallback;
    double length = sqrt(qcDot(n, n));
    if (length == 0.0)
    {
        n = (qcVector){0.0, 0.0, 1.0};
        length = 1.0;
    }
    contact->normal[0] = n.x / length;
    contact->normal[1] = n.y / length;
    contact->normal[2] = n.z / length;
    contact->distance = distance;
}

static bool HasVertex(const uint32_t* index, uint32_t vertex)
{
    return index[0] == vertex || index[1] == vertex || index[2] == vertex;
}

static qcVector VertexOf(const qcBody* body, uint32_t vertex)
{
    double position[3];
    qcBody_GetVertex(body, vertex, position);
    return qcVector_Load(position);
}

void qcContactTriangle_Load(qcContactTriangle* cached, const qcContactSide* side)
{
    const qcContactSide* old = &cached->side;
    if (old->body == side->body && old->triangle == side->triangle && old->localMinima == side->localMinima)
        return;
    cached->side = *side;
    cached->index = side->body->indices + 3 * (size_t)side->triangle;
    for (int c = 0; c < 3; c++)
        cached->corner[c] = VertexOf(side->body, cached->index[c]);
    cached->queriedEdges = cached->hasOppositeVertex = 0;
}

/// Fills cached->oppositeVertex[edge] on first use; false: there is none. The side has a filter.
static bool HasOppositeVertex(qcContactTriangle* cached, int edge)
{
    const qcContactSide* side = &cached->side;
    unsigned bit = 1u << edge;
    if ((cached->queriedEdges & bit) == 0)
    {
        cached->queriedEdges |= bit;
        if (qcLocalMinima_GetOppositeVertex(side->localMinima, side->body, side->triangle, edge,
                                            &cached->oppositeVertex[edge]))
            cached->hasOppositeVertex |= bit;
    }
    return (cached->hasOppositeVertex & bit) != 0;
}

/// Whether two intervals, ends in any order, are farther apart than the distance.
static bool AreFar(double a, double b, double c, double d, double distance)
{
    double aLow = a < b ? a : b, aHigh = a < b ? b : a, cLow = c < d ? c : d, cHigh = c < d ? d : c;
    return aLow - cHigh > distance || cLow - aHigh > distance;
}

/// Whether x is farther than the distance from the interval around three numbers.
static bool IsFar(double x, double a, double b, double c, double distance)
{
    return (x - a > distance && x - b > distance && x - c > distance) ||
           (a - x > distance && b - x > distance && c - x > distance);
}

/// Whether the filter keeps a contact at the point of this side with these weights; `outward` leads to the other side.
static bool IsNearest(const qcContactSide* side, const double weights[3], qcVector outward)
{
    return side->localMinima == NULL ||
           qcLocalMinima_IsNearest(side->localMinima, side->body, side->triangle, weights, outward);
}

/// Whether the filter keeps a contact at an edge. `eitherWay`: in one of the directions outward and -outward.
static bool IsNearestEdge(qcContactTriangle* cached, int edge, qcVector outward, bool eitherWay)
{
    const qcContactSide* side = &cached->side;
    qcVector p = cached->corner[edge];
    if (side->localMinima == NULL)
        return true;
    qcVector mine = qcMinus(cached->corner[(edge + 2) % 3], p), inward = qcNegated(outward);
    bool out = qcLocalMinima_LeadsAway(mine, outward), in = eitherWay && qcLocalMinima_LeadsAway(mine, inward);
    if ((!out && !in) || !HasOppositeVertex(cached, edge))
        return out || in;
    qcVector other = qcMinus(cached->oppositeVertex[edge], p);
    return (out && qcLocalMinima_LeadsAway(other, outward)) || (in && qcLocalMinima_LeadsAway(other, inward));
}

static bool VertexFace(const qcContactTriangle* vertexTriangle, int corner, const qcContactTriangle* face,
                       double margin, double boxDistance, qcContact* contact)
{
    const qcContactSide *vertexSide = &vertexTriangle->side, *faceSide = &face->side;
    uint32_t vertex = vertexTriangle->index[corner];
    if (vertexSide->slot == faceSide->slot && HasVertex(face->index, vertex))
        return false;
    qcVector x = vertexTriangle->corner[corner];
    const qcVector* corners = face->corner;
    if (IsFar(x.x, corners[0].x, corners[1].x, corners[2].x, boxDistance) ||
        IsFar(x.y, corners[0].y, corners[1].y, corners[2].y, boxDistance) ||
        IsFar(x.z, corners[0].z, corners[1].z, corners[2].z, boxDistance))
        return false;
    double weights[3];
    qcClosest_OnTriangle(corners, x, weights);
    // Differences first: far from the origin a sum of weighted corners would lose the digits of a small distance.
    qcVector d = qcMinus(x, corners[0]);
    d = qcPlusScaled(d, qcMinus(corners[1], corners[0]), -weights[1]);
    d = qcPlusScaled(d, qcMinus(corners[2], corners[0]), -weights[2]);
    double distance = sqrt(qcDot(d, d));
    if (!(distance <= margin) || !IsNearest(faceSide, weights, d) ||
        !IsNearest(vertexSide, s_corner[corner], qcNegated(d)))
        return false;
    *contact = (qcContact){.bodyA = vertexSide->slot,
                           .bodyB = faceSide->slot,
                           .verticesA = {vertex, vertex, vertex},
                           .verticesB = {face->index[0], face->index[1], face->index[2]},
                           .weightsA = {1.0, 0.0, 0.0},
                           .weightsB = {weights[0], weights[1], weights[2]}};
    SetNormal(contact, d, distance, qcCross(qcMinus(corners[1], corners[0]), qcMinus(corners[2], corners[0])));
    return true;
}

static bool EdgeEdge(qcContactTriangle* a, int edgeA, qcContactTriangle* b, int edgeB, double margin,
                     double boxDistance, qcContact* contact)
{
    int nextA = (edgeA + 1) % 3, nextB = (edgeB + 1) % 3;
    uint32_t p = a->index[edgeA], q = a->index[nextA], r = b->index[edgeB], s = b->index[nextB];
    if (a->side.slot == b->side.slot && (p == r || p == s || q == r || q == s))
        return false;
    qcVector vp = a->corner[edgeA], vq = a->corner[nextA], vr = b->corner[edgeB], vs = b->corner[nextB];
    if (AreFar(vp.x, vq.x, vr.x, vs.x, boxDistance) || AreFar(vp.y, vq.y, vr.y, vs.y, boxDistance) ||
        AreFar(vp.z, vq.z, vr.z, vs.z, boxDistance))
        return false;
    qcVector across = qcCross(qcMinus(vq, vp), qcMinus(vs, vr));
    if (!IsNearestEdge(a, edgeA, across, true) || !IsNearestEdge(b, edgeB, across, true))
        return false;
    double t, u;
    qcClosest_OfSegments(vp, vq, vr, vs, &t, &u);
    if (t == 0.0 || t == 1.0 || u == 0.0 || u == 1.0)
        return false; // at an end of an edge: a contact of a vertex
    qcVector d = qcPlusScaled(qcPlusScaled(qcMinus(vp, vr), qcMinus(vq, vp), t), qcMinus(vs, vr), -u);
    double distance = sqrt(qcDot(d, d));
    if (!(distance <= margin) || !IsNearestEdge(b, edgeB, d, false) || !IsNearestEdge(a, edgeA, qcNegated(d), false))
        return false;
    *contact = (qcContact){.bodyA = a->side.slot,
                           .bodyB = b->side.slot,
                           .verticesA = {p, q, q},
                           .verticesB = {r, s, s},
                           .weightsA = {1.0 - t, t, 0.0},
                           .weightsB = {1.0 - u, u, 0.0}};
    SetNormal(contact, d, distance, across);
    return true;
}

static qcOwnedFeatures OwnedBy(const qcContactSide* side)
{
    return side->localMinima != NULL ? qcLocalMinima_Owned(side->localMinima, side->triangle)
                                     : side->body->owned[side->triangle];
}

/// Corners of a pair relative to the first. They are subtracted in double: the difference alone is rounded.
static void LoadPair(const qcContactPair* pair, size_t at, qcFeaturePairs* loaded)
{
    double a[3][3], b[3][3];
    qcBody_GetTriangle(pair->a.body, pair->a.triangle, a);
    qcBody_GetTriangle(pair->b.body, pair->b.triangle, b);
    for (int axis = 0; axis < 3; axis++)
    {
        loaded->corner[0][axis][at] = (float)(a[1][axis] - a[0][axis]);
        loaded->corner[1][axis][at] = (float)(a[2][axis] - a[0][axis]);
        for (int c = 0; c < 3; c++)
            loaded->corner[2 + c][axis][at] = (float)(b[c][axis] - a[0][axis]);
    }
    loaded->margin[at] = (float)pair->margin;
}

/// The pairs of features that both triangles own.
static qcFeatureMask OwnedByPair(const qcContactPair* pair)
{
    unsigned a = OwnedBy(&pair->a), b = OwnedBy(&pair->b), edgesA = a >> 3, edgesB = b >> 3;
    unsigned edges = edgesB * ((edgesA & 1u) | (edgesA & 2u) << 2 | (edgesA & 4u) << 4);
    return (qcFeatureMask)((a & 7u) | (b & 7u) << qc_nearCornersOfB | edges << qc_nearEdges);
}

void qcContact_FindNear(const qcTriangleKernels* kernels, const qcContactPair* pairs, size_t count,
                        qcFeatureMask near[qc_featurePairs])
{
    qcFeaturePairs loaded;
    for (size_t i = 0; i < qc_featurePairs; i++)
        LoadPair(&pairs[i < count ? i : 0], i, &loaded);
    kernels->findNearFeatures(&loaded, near);
    for (size_t i = 0; i < count; i++)
        near[i] &= OwnedByPair(&pairs[i]);
}

int qcContact_Find(qcContactTriangle* a, qcContactTriangle* b, double margin, qcFeatureMask near, qcContact* contacts)
{
    // Boxes only save work: they change no result. They are wider than the margin by more than rounding, and narrower
    // than the query distance (qcContactDistance), so that all stages that find pairs give the same contacts.
    double boxDistance = margin * (1.0 + 1e-9);
    int count = 0;
    for (unsigned left = near; left != 0; left &= left - 1)
    {
        int at = __builtin_ctz(left), edges = at - qc_nearEdges;
        qcContact* contact = contacts + count;
        if (edges >= 0)
            count += EdgeEdge(a, edges / 3, b, edges % 3, margin, boxDistance, contact);
        else if (at >= qc_nearCornersOfB)
            count += VertexFace(b, at - qc_nearCornersOfB, a, margin, boxDistance, contact);
        else
            count += VertexFace(a, at, b, margin, boxDistance, contact);
    }
    return count;
}
