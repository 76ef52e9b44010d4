// Vertex against face and edge against edge, by the closest points of the two features.
//
// A vertex meets the whole closed face, so corner and border cases are found here; two edges meet only where the closest
// points lie inside both, since an end of an edge is a vertex. Distances are rounded in double: a contact is reported
// when the rounded distance is within the margin.
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
    Vector u = Minus(corner[1], corner[0]), v = Minus(corner[2], corner[0]), w = Minus(x, corner[0]);
    Vector n = Cross(u, v);
    double n2 = Dot(n, n);
    if (n2 > 0.0)
    {
        double b = Dot(Cross(w, v), n) / n2, c = Dot(Cross(u, w), n) / n2;
        if (b >= 0.0 && c >= 0.0 && b + c <= 1.0)
        {
            weights[0] = 1.0 - b - c;
            weights[1] = b;
            weights[2] = c;
            return;
        }
    }
    // Outside, or the triangle is flat: then the closest point lies on the border.
    double best = INFINITY;
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
}

/// Parameters of the closest points of two segments' lines, when both lie strictly inside.
static bool ClosestOfSegments(Vector p, Vector q, Vector r, Vector s, double* t, double* u)
{
    Vector d = Minus(q, p), e = Minus(s, r), w = Minus(p, r);
    double a = Dot(d, d), b = Dot(d, e), c = Dot(e, e), f = Dot(d, w), g = Dot(e, w);
    double determinant = a * c - b * b;
    // Parallel edges: their ends, as vertices, say all.
    if (!(determinant > 1e-12 * a * c))
        return false;
    *t = (b * g - c * f) / determinant;
    *u = (a * g - b * f) / determinant;
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

static bool VertexFace(const qcContactSide* vertexSide, int corner, const qcContactSide* faceSide, double margin,
                       qcContact* contact)
{
    uint32_t vertex = vertexSide->body->indices[3 * (size_t)vertexSide->triangle + corner];
    const uint32_t* face = faceSide->body->indices + 3 * (size_t)faceSide->triangle;
    if (vertexSide->slot == faceSide->slot && HasVertex(face, vertex))
        return false;
    Vector x = VertexOf(vertexSide->body, vertex), corners[3];
    for (int c = 0; c < 3; c++)
        corners[c] = VertexOf(faceSide->body, face[c]);
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
                           .verticesB = {face[0], face[1], face[2]},
                           .weightsA = {1.0, 0.0, 0.0},
                           .weightsB = {weights[0], weights[1], weights[2]}};
    SetNormal(contact, d, distance, Cross(Minus(corners[1], corners[0]), Minus(corners[2], corners[0])));
    return true;
}

static bool EdgeEdge(const qcContactSide* a, int edgeA, const qcContactSide* b, int edgeB, double margin, qcContact* contact)
{
    const uint32_t* indexA = a->body->indices + 3 * (size_t)a->triangle;
    const uint32_t* indexB = b->body->indices + 3 * (size_t)b->triangle;
    uint32_t p = indexA[edgeA], q = indexA[(edgeA + 1) % 3], r = indexB[edgeB], s = indexB[(edgeB + 1) % 3];
    if (a->slot == b->slot && (p == r || p == s || q == r || q == s))
        return false;
    Vector vp = VertexOf(a->body, p), vq = VertexOf(a->body, q), vr = VertexOf(b->body, r), vs = VertexOf(b->body, s);
    double t, u;
    if (!ClosestOfSegments(vp, vq, vr, vs, &t, &u))
        return false;
    Vector d = PlusScaled(PlusScaled(Minus(vp, vr), Minus(vq, vp), t), Minus(vs, vr), -u);
    double distance = sqrt(Dot(d, d));
    if (!(distance <= margin))
        return false;
    *contact = (qcContact){.bodyA = a->slot,
                           .bodyB = b->slot,
                           .verticesA = {p, q, q},
                           .verticesB = {r, s, s},
                           .weightsA = {1.0 - t, t, 0.0},
                           .weightsB = {1.0 - u, u, 0.0}};
    SetNormal(contact, d, distance, Cross(Minus(vq, vp), Minus(vs, vr)));
    return true;
}

int qcContact_Find(const qcContactSide* a, const qcContactSide* b, double margin, qcContact* contacts)
{
    qcOwnedFeatures ownedA = a->body->owned[a->triangle], ownedB = b->body->owned[b->triangle];
    int count = 0;
    for (int c = 0; c < 3; c++)
    {
        if (ownedA >> c & 1)
            count += VertexFace(a, c, b, margin, contacts + count);
        if (ownedB >> c & 1)
            count += VertexFace(b, c, a, margin, contacts + count);
    }
    for (int e = 0; e < 3; e++)
        for (int f = 0; f < 3; f++)
            if ((ownedA >> (3 + e) & 1) && (ownedB >> (3 + f) & 1))
                count += EdgeEdge(a, e, b, f, margin, contacts + count);
    return count;
}
