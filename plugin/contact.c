// Vertex against face and edge against edge, by the closest points of the two features.
//
// A vertex meets the whole closed face, so corner and border cases are found here; two edges meet only where the
// closest points lie inside both, since an end of an edge is a vertex. Distances are rounded in double: a contact is
// reported when the rounded distance is within the margin.
#include "contact.h"

#include <math.h>
#include <string.h>

typedef struct Vector
{
    double x, y, z;
} Vector;

static Vector Load(const double* p)
{
    return (Vector){p[0], p[1], p[2]};
}

static Vector Minus(Vector a, Vector b)
{
    return (Vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static Vector PlusScaled(Vector a, Vector b, double s)
{
    return (Vector){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static double Dot(Vector a, Vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static Vector Cross(Vector a, Vector b)
{
    return (Vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double Clamp01(double x)
{
    return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
}

/// Parameter of the point of segment p-q closest to x.
static double ClosestOnSegment(Vector p, Vector q, Vector x)
{
    Vector d = Minus(q, p);
    double length2 = Dot(d, d);
    return length2 > 0.0 ? Clamp01(Dot(Minus(x, p), d) / length2) : 0.0;
}

/// Weights of the corners at the point of a triangle closest to x.
static void ClosestOnTriangle(const Vector corner[3], Vector x, double weights[3])
{
    double best = INFINITY;
    weights[0] = 1.0;
    weights[1] = weights[2] = 0.0;
    for (int e = 0; e < 3; e++)
    {
        int f = (e + 1) % 3;
        double t = ClosestOnSegment(corner[e], corner[f], x);
        Vector d = Minus(x, PlusScaled(corner[e], Minus(corner[f], corner[e]), t));
        if (Dot(d, d) < best)
        {
            best = Dot(d, d);
            weights[0] = weights[1] = weights[2] = 0.0;
            weights[e] = 1.0 - t;
            weights[f] = t;
        }
    }
    Vector u = Minus(corner[1], corner[0]), v = Minus(corner[2], corner[0]), w = Minus(x, corner[0]);
    Vector n = Cross(u, v);
    double n2 = Dot(n, n);
    double b = Dot(Cross(w, v), n) / n2, c = Dot(Cross(u, w), n) / n2;
    if (!(b >= 0.0 && c >= 0.0 && b + c <= 1.0))
        return; // outside, or nothing but a line
    // Nearer than the border, too: on a sliver the normal, and all that came of it, may be nothing but rounding.
    Vector d = PlusScaled(PlusScaled(w, u, -b), v, -c);
    if (Dot(d, d) < best)
    {
        weights[0] = 1.0 - b - c;
        weights[1] = b;
        weights[2] = c;
    }
}

/// Parameters of the closest points of two segments' lines, when both lie strictly inside.
static bool ClosestOfSegments(Vector p, Vector q, Vector r, Vector s, double* t, double* u)
{
    Vector d = Minus(q, p), e = Minus(s, r), w = Minus(r, p);
    Vector n = Cross(d, e);
    double n2 = Dot(n, n), d2 = Dot(d, d), e2 = Dot(e, e);
    // Parallel edges, as far as rounding lets us see (1e-14 radians): their ends, as vertices, say all.
    if (!(n2 > 1e-28 * d2 * e2))
        return false;
    *t = Dot(Cross(w, e), n) / n2;
    // The closest to that point, not computed apart from it: nearly parallel edges forgive an error in t that both
    // share.
    *u = (*t * Dot(d, e) - Dot(w, e)) / e2;
    return *t > 0.0 && *t < 1.0 && *u > 0.0 && *u < 1.0;
}

static void SetNormal(qcContact* contact, Vector fromBToA, double distance, Vector fallback)
{
    Vector n = distance > 0.0 ? fromBToA : fallback;
    double length = sqrt(Dot(n, n));
    if (length == 0.0)
    {
        n = (Vector){0.0, 0.0, 1.0};
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

static Vector VertexOf(const qcBody* body, uint32_t vertex)
{
    return Load(body->world + 3 * (size_t)vertex);
}

/// A triangle with its corners at hand.
typedef struct Facet
{
    const qcContactSide* side;
    const uint32_t* index;
    Vector corner[3];
} Facet;

static Facet FacetOf(const qcContactSide* side)
{
    Facet facet;
    facet.side = side;
    facet.index = side->body->indices + 3 * (size_t)side->triangle;
    for (int c = 0; c < 3; c++)
        facet.corner[c] = VertexOf(side->body, facet.index[c]);
    return facet;
}

/// Is one interval, ends in any order, farther than `reach` from the other?
static bool AreApart(double a, double b, double c, double d, double reach)
{
    double aLow = a < b ? a : b, aHigh = a < b ? b : a, cLow = c < d ? c : d, cHigh = c < d ? d : c;
    return aLow - cHigh > reach || cLow - aHigh > reach;
}

/// Is x farther than `reach` from the interval of the three?
static bool IsApart(double x, double a, double b, double c, double reach)
{
    return (x - a > reach && x - b > reach && x - c > reach) || (a - x > reach && b - x > reach && c - x > reach);
}

static bool VertexFace(const Facet* vertexFacet, int corner, const Facet* face, double margin, double reach,
                       qcContact* contact)
{
    const qcContactSide *vertexSide = vertexFacet->side, *faceSide = face->side;
    uint32_t vertex = vertexFacet->index[corner];
    if (vertexSide->slot == faceSide->slot && HasVertex(face->index, vertex))
        return false;
    Vector x = vertexFacet->corner[corner];
    const Vector* corners = face->corner;
    if (IsApart(x.x, corners[0].x, corners[1].x, corners[2].x, reach) ||
        IsApart(x.y, corners[0].y, corners[1].y, corners[2].y, reach) ||
        IsApart(x.z, corners[0].z, corners[1].z, corners[2].z, reach))
        return false;
    double weights[3];
    ClosestOnTriangle(corners, x, weights);
    // Differences first: far from the origin a sum of weighted corners would round away what lies between.
    Vector d = Minus(x, corners[0]);
    d = PlusScaled(d, Minus(corners[1], corners[0]), -weights[1]);
    d = PlusScaled(d, Minus(corners[2], corners[0]), -weights[2]);
    double distance = sqrt(Dot(d, d));
    if (!(distance <= margin))
        return false;
    *contact = (qcContact){.bodyA = vertexSide->slot,
                           .bodyB = faceSide->slot,
                           .verticesA = {vertex, vertex, vertex},
                           .verticesB = {face->index[0], face->index[1], face->index[2]},
                           .weightsA = {1.0, 0.0, 0.0},
                           .weightsB = {weights[0], weights[1], weights[2]}};
    SetNormal(contact, d, distance, Cross(Minus(corners[1], corners[0]), Minus(corners[2], corners[0])));
    return true;
}

static bool EdgeEdge(const Facet* a, int edgeA, const Facet* b, int edgeB, double margin, double reach,
                     qcContact* contact)
{
    int nextA = (edgeA + 1) % 3, nextB = (edgeB + 1) % 3;
    uint32_t p = a->index[edgeA], q = a->index[nextA], r = b->index[edgeB], s = b->index[nextB];
    if (a->side->slot == b->side->slot && (p == r || p == s || q == r || q == s))
        return false;
    Vector vp = a->corner[edgeA], vq = a->corner[nextA], vr = b->corner[edgeB], vs = b->corner[nextB];
    double t, u;
    if (AreApart(vp.x, vq.x, vr.x, vs.x, reach) || AreApart(vp.y, vq.y, vr.y, vs.y, reach) ||
        AreApart(vp.z, vq.z, vr.z, vs.z, reach) || !ClosestOfSegments(vp, vq, vr, vs, &t, &u))
        return false;
    Vector d = PlusScaled(PlusScaled(Minus(vp, vr), Minus(vq, vp), t), Minus(vs, vr), -u);
    double distance = sqrt(Dot(d, d));
    if (!(distance <= margin))
        return false;
    *contact = (qcContact){.bodyA = a->side->slot,
                           .bodyB = b->side->slot,
                           .verticesA = {p, q, q},
                           .verticesB = {r, s, s},
                           .weightsA = {1.0 - t, t, 0.0},
                           .weightsB = {1.0 - u, u, 0.0}};
    SetNormal(contact, d, distance, Cross(Minus(vq, vp), Minus(vs, vr)));
    return true;
}

int qcContact_Find(const qcContactSide* a, const qcContactSide* b, double margin, qcContact* contacts)
{
    Facet p = FacetOf(a), q = FacetOf(b);
    qcOwnedFeatures ownedA = a->body->owned[a->triangle], ownedB = b->body->owned[b->triangle];
    // Boxes only spare work: wider than the margin, so that their rounding decides nothing; and narrower than those
    // that found the pair (qcContact_Reach), so that who found it decides nothing either.
    double reach = margin * (1.0 + 1e-9);
    int count = 0;
    for (unsigned corners = ownedA & 7u; corners != 0; corners &= corners - 1)
        count += VertexFace(&p, __builtin_ctz(corners), &q, margin, reach, contacts + count);
    for (unsigned corners = ownedB & 7u; corners != 0; corners &= corners - 1)
        count += VertexFace(&q, __builtin_ctz(corners), &p, margin, reach, contacts + count);
    for (unsigned edgesA = ownedA >> 3; edgesA != 0; edgesA &= edgesA - 1)
        for (unsigned edgesB = ownedB >> 3; edgesB != 0; edgesB &= edgesB - 1)
            count += EdgeEdge(&p, __builtin_ctz(edgesA), &q, __builtin_ctz(edgesB), margin, reach, contacts + count);
    return count;
}
