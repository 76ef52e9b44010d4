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
    const qcVector* corner[2];
    qcVector edge[2][3];    ///< edge e: from corner e to the next
    qcVector across[2][3];  ///< an edge x the direction
    double beyond[2][3][3]; ///< across edge e of a side, from it: corner c of the other side
    double facing[2];       ///< a face's normal, not of unit length, along the direction
    qcVector face[2];
    qcVector normal;
    qcRawPoint* found;
    int count;
} Sight;

static void Keep(Sight* sight, const qcRawPoint* point)
{
    if (isfinite(point->distance))
        sight->found[sight->count++] = *point;
}

static uint32_t VertexOf(const Sight* sight, int side, int corner)
{
    const qcManifoldTriangle* triangle = sight->pair->side[side];
    return triangle->body->indices[3 * (size_t)triangle->index + (unsigned)corner];
}

/// Is corner c of a side surely outside of the other's face, as seen along the direction? Settles most.
static bool IsOutsideFace(const Sight* sight, int side, int c)
{
    double facing = sight->facing[1 - side], border = 2.0 * QC_MANIFOLD_ROUNDING * fabs(facing);
    for (int e = 0; e < 3; e++)
        if ((facing > 0.0 ? sight->beyond[1 - side][e][c] : -sight->beyond[1 - side][e][c]) > border)
            return true;
    return false;
}

/// Is a foot in the plane of a side's face within it? A corner over the common edge of two faces is found over at least
/// one of them, in spite of rounding.
static bool IsInside(const Sight* sight, int side, qcVector foot)
{
    qcVector m = sight->face[side];
    double border = -QC_MANIFOLD_ROUNDING * qcDot(m, m);
    for (int e = 0; e < 3; e++)
        if (!(qcDot(m, qcCross(sight->edge[side][e], qcMinus(foot, sight->corner[side][e]))) >= border))
            return false;
    return true;
}

static void CornersOverFace(Sight* sight, int side)
{
    const qcVector* face = sight->corner[1 - side];
    qcVector n = sight->normal, m = sight->face[1 - side];
    double facing = sight->facing[1 - side];
    if (!(facing * facing > s_edgeOn * s_edgeOn * qcDot(m, m)))
        return;
    for (int c = 0; c < 3; c++)
    {
        if (IsOutsideFace(sight, side, c))
            continue;
        qcVector x = sight->corner[side][c];
        double height = qcDot(m, qcMinus(x, face[0])) / facing;
        qcVector foot = qcPlusScaled(x, n, -height);
        if (!IsInside(sight, 1 - side, foot))
            continue;
        uint32_t vertex = VertexOf(sight, side, c);
        qcRawPoint point = {.normal = n, .distance = side == 0 ? height : -height};
        point.end[side] = x;
        point.end[1 - side] = foot;
        point.feature[side][0] = point.feature[side][1] = vertex;
        point.feature[1 - side][0] = point.feature[1 - side][1] = UINT32_MAX;
        Keep(sight, &point);
    }
}

static void NameEdge(const Sight* sight, int side, int e, uint32_t feature[2])
{
    uint32_t v = VertexOf(sight, side, e), w = VertexOf(sight, side, (e + 1) % 3);
    feature[0] = v < w ? v : w;
    feature[1] = v < w ? w : v;
}

/// Surely no parameter of an edge? Settles most without a division.
static bool IsOutsideEdge(double numerator, double denominator)
{
    double n = denominator < 0.0 ? -numerator : numerator, d = fabs(denominator);
    return n < -2.0 * QC_MANIFOLD_ROUNDING * d || n > d + 2.0 * QC_MANIFOLD_ROUNDING * d;
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
    qcVector u = sight->edge[0][e], v = sight->edge[1][f];
    double cross = qcDot(u, sight->across[1][f]);
    double s = -sight->beyond[1][f][e], t = sight->beyond[0][e][f];
    if (IsOutsideEdge(s, cross) || IsOutsideEdge(t, cross))
        return;
    double parallel = QC_MANIFOLD_ROUNDING * QC_MANIFOLD_ROUNDING * qcDot(u, u) * qcDot(v, v);
    if (!(cross * cross > parallel))
        return;
    s /= cross;
    t /= cross;
    if (!ClampToEdge(&s) || !ClampToEdge(&t))
        return;
    qcRawPoint point = {.end = {qcPlusScaled(sight->corner[0][e], u, s), qcPlusScaled(sight->corner[1][f], v, t)},
                        .normal = sight->normal};
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), sight->normal);
    NameEdge(sight, 0, e, point.feature[0]);
    NameEdge(sight, 1, f, point.feature[1]);
    Keep(sight, &point);
}

/// Seen along the direction, is the other triangle beyond the line through an edge of this side's? Fills what is known
/// of this side until it says so.
static bool AreBeside(Sight* sight, int side)
{
    const qcVector *corner = sight->corner[side], *other = sight->corner[1 - side];
    for (int e = 0; e < 3; e++)
    {
        sight->edge[side][e] = qcMinus(corner[(e + 1) % 3], corner[e]);
        qcVector across = qcCross(sight->edge[side][e], sight->normal);
        double* beyond = sight->beyond[side][e];
        for (int c = 0; c < 3; c++)
            beyond[c] = qcDot(across, qcMinus(other[c], corner[e]));
        double inner = qcDot(across, qcMinus(corner[(e + 2) % 3], corner[e]));
        double x = beyond[0], y = beyond[1], z = beyond[2], border = QC_MANIFOLD_ROUNDING * fabs(inner);
        if ((inner > 0.0 && x < -border && y < -border && z < -border) ||
            (inner < 0.0 && x > border && y > border && z > border))
            return true;
        sight->across[side][e] = across;
    }
    return false;
}

bool qcManifoldPair_CoversArea(const qcManifoldPair* pair, const qcRawPoint* corners, int count)
{
    qcVector longest = {0.0, 0.0, 0.0};
    for (int i = 1; i < count; i++)
    {
        qcVector d = qcMinus(corners[i].end[0], corners[0].end[0]);
        longest = qcDot(d, d) > qcDot(longest, longest) ? d : longest;
    }
    double width = QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair), length2 = qcDot(longest, longest);
    for (int i = 1; i < count; i++)
    {
        qcVector across = qcCross(longest, qcMinus(corners[i].end[0], corners[0].end[0]));
        if (qcDot(across, across) > width * width * length2)
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
    sight.corner[0] = pair->side[0]->corner;
    sight.corner[1] = pair->side[1]->corner;
    if (AreBeside(&sight, 0) || AreBeside(&sight, 1))
        return 0;
    for (int side = 0; side < 2; side++)
    {
        sight.face[side] = qcCross(sight.edge[side][0], sight.edge[side][1]);
        sight.facing[side] = qcDot(sight.face[side], normal);
    }
    // Corners of triangles first: where one also lies on an edge of the other, a vertex is the steadier name.
    CornersOverFace(&sight, 0);
    CornersOverFace(&sight, 1);
    for (int e = 0; e < 3; e++)
        for (int f = 0; f < 3; f++)
            EdgeOverEdge(&sight, e, f);
    return sight.count;
}
