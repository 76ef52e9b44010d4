// What two triangles have in common, seen along a direction: the corners of that common part, with the gap there.
//
// Over the common part the gap between the two planes is linear, so its least and its largest values are at corners: a
// corner of one triangle over the other's face, or two edges that cross. A face seen edge-on has several heights over
// one place; the crossings with its three edges name them all.
#include "manifold_parts.h"

#include <math.h>

// A face steeper than this along the direction (89.9 degrees) has no inside to stand over.
static const double s_edgeOn = 1e-3;
/// Two triangles and the corners found so far.
typedef struct Sight
{
    const qcManifoldPair* pair;
    qcVector corner[2][3], edge[2][3]; ///< edge c: from corner c to the next
    qcVector across[2][3];             ///< an edge x the direction
    qcVector face[2];                  ///< normals, not of unit length
    qcVector normal;
    qcRawPoint* found;
    int count;
} Sight;

static void Keep(Sight* sight, const qcRawPoint* point)
{
    if (isfinite(point->distance))
        sight->found[sight->count++] = *point;
}

static void CornersOverFace(Sight* sight, int side)
{
    const qcVector *face = sight->corner[1 - side], *edges = sight->edge[1 - side];
    qcVector n = sight->normal, m = sight->face[1 - side];
    double m2 = qcDot(m, m), facing = qcDot(m, n);
    if (!(facing * facing > s_edgeOn * s_edgeOn * m2))
        return;
    for (int c = 0; c < 3; c++)
    {
        qcVector x = sight->corner[side][c];
        double height = qcDot(m, qcMinus(x, face[0])) / facing;
        qcVector foot = qcPlusScaled(x, n, -height);
        // A corner over the common edge of two faces is found over at least one of them, in spite of rounding.
        bool inside = true;
        for (int e = 0; e < 3 && inside; e++)
            inside = qcDot(m, qcCross(edges[e], qcMinus(foot, face[e]))) >= -QC_MANIFOLD_ROUNDING * m2;
        if (!inside)
            continue;
        uint32_t vertex = qcManifoldPair_Vertex(sight->pair, side, c);
        qcRawPoint point = {.normal = n, .distance = side == 0 ? height : -height};
        point.end[side] = x;
        point.end[1 - side] = foot;
        point.feature[side][0] = point.feature[side][1] = vertex;
        point.feature[1 - side][0] = point.feature[1 - side][1] = UINT32_MAX;
        Keep(sight, &point);
    }
}

static void NameEdge(const qcManifoldPair* pair, int side, int e, uint32_t feature[2])
{
    uint32_t v = qcManifoldPair_Vertex(pair, side, e), w = qcManifoldPair_Vertex(pair, side, (e + 1) % 3);
    feature[0] = v < w ? v : w;
    feature[1] = v < w ? w : v;
}

static bool ClampToEdge(double* t)
{
    if (!(*t >= -QC_MANIFOLD_ROUNDING && *t <= 1.0 + QC_MANIFOLD_ROUNDING))
        return false;
    *t = *t < 0.0 ? 0.0 : *t > 1.0 ? 1.0 : *t;
    return true;
}

static void EdgeOverEdge(Sight* sight, int e, int f)
{
    qcVector a = sight->corner[0][e], b = sight->corner[1][f], u = sight->edge[0][e], v = sight->edge[1][f];
    double cross = qcDot(u, sight->across[1][f]);
    double parallel = QC_MANIFOLD_ROUNDING * QC_MANIFOLD_ROUNDING * qcDot(u, u) * qcDot(v, v);
    if (!(cross * cross > parallel))
        return;
    qcVector w = qcMinus(b, a);
    double s = qcDot(w, sight->across[1][f]) / cross, t = qcDot(w, sight->across[0][e]) / cross;
    if (!ClampToEdge(&s) || !ClampToEdge(&t))
        return;
    qcRawPoint point = {.end = {qcPlusScaled(a, u, s), qcPlusScaled(b, v, t)}, .normal = sight->normal};
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), sight->normal);
    NameEdge(sight->pair, 0, e, point.feature[0]);
    NameEdge(sight->pair, 1, f, point.feature[1]);
    Keep(sight, &point);
}

/// Seen along the direction, is the other triangle beyond the line through an edge of this side's?
static bool AreBeside(const Sight* sight, int side)
{
    const qcVector *corner = sight->corner[side], *other = sight->corner[1 - side];
    for (int e = 0; e < 3; e++)
    {
        qcVector across = sight->across[side][e];
        double inner = qcDot(across, qcMinus(corner[(e + 2) % 3], corner[e]));
        double x = qcDot(across, qcMinus(other[0], corner[e])), y = qcDot(across, qcMinus(other[1], corner[e]));
        double z = qcDot(across, qcMinus(other[2], corner[e])), border = QC_MANIFOLD_ROUNDING * fabs(inner);
        if ((inner > 0.0 && x < -border && y < -border && z < -border) ||
            (inner < 0.0 && x > border && y > border && z > border))
            return true;
    }
    return false;
}

int qcManifoldPair_FindCommonPart(const qcManifoldPair* pair, qcVector normal, qcRawPoint corners[qc_maxCommonCorners])
{
    Sight sight;
    sight.pair = pair;
    sight.normal = normal;
    sight.found = corners;
    sight.count = 0;
    for (int side = 0; side < 2; side++)
    {
        qcVector* corner = sight.corner[side];
        qcManifoldPair_GetCorners(pair, side, corner);
        for (int c = 0; c < 3; c++)
        {
            sight.edge[side][c] = qcMinus(corner[(c + 1) % 3], corner[c]);
            sight.across[side][c] = qcCross(sight.edge[side][c], normal);
        }
        sight.face[side] = qcCross(sight.edge[side][0], sight.edge[side][1]);
    }
    if (AreBeside(&sight, 0) || AreBeside(&sight, 1))
        return 0;
    // Corners of triangles first: where one also lies on an edge of the other, a vertex is the steadier name.
    CornersOverFace(&sight, 0);
    CornersOverFace(&sight, 1);
    for (int e = 0; e < 3; e++)
        for (int f = 0; f < 3; f++)
            EdgeOverEdge(&sight, e, f);
    return sight.count;
}
