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
    qcTriangleView* view[2];
    double beyond[2][3][3]; ///< across edge e of a side, from it: corner c of the other side
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
    double facing = sight->view[1 - side]->facing, border = 2.0 * QC_MANIFOLD_ROUNDING * fabs(facing);
    for (int e = 0; e < 3; e++)
        if ((facing > 0.0 ? sight->beyond[1 - side][e][c] : -sight->beyond[1 - side][e][c]) > border)
            return true;
    return false;
}

/// Is a foot in the plane of a side's face within it? A corner over the common edge of two faces is found over at least
/// one of them, in spite of rounding.
static bool IsInside(const Sight* sight, int side, qcVector foot)
{
    const qcTriangleView* view = sight->view[side];
    qcVector m = view->face;
    double border = -QC_MANIFOLD_ROUNDING * qcDot(m, m);
    for (int e = 0; e < 3; e++)
        if (!(qcDot(m, qcCross(view->edge[e], qcMinus(foot, view->triangle->corner[e]))) >= border))
            return false;
    return true;
}

static void CornersOverFace(Sight* sight, int side)
{
    const qcTriangleView* under = sight->view[1 - side];
    qcVector n = sight->normal, m = under->face;
    double facing = under->facing;
    if (!(facing * facing > s_edgeOn * s_edgeOn * qcDot(m, m)))
        return;
    for (int c = 0; c < 3; c++)
    {
        if (IsOutsideFace(sight, side, c))
            continue;
        qcVector x = sight->view[side]->triangle->corner[c];
        double height = qcDot(m, qcMinus(x, under->triangle->corner[0])) / facing;
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
    qcVector u = sight->view[0]->edge[e], v = sight->view[1]->edge[f];
    double cross = qcDot(u, sight->view[1]->across[f]);
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
    qcRawPoint point = {.end = {qcPlusScaled(sight->view[0]->triangle->corner[e], u, s),
                                qcPlusScaled(sight->view[1]->triangle->corner[f], v, t)},
                        .normal = sight->normal};
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), sight->normal);
    NameEdge(sight, 0, e, point.feature[0]);
    NameEdge(sight, 1, f, point.feature[1]);
    Keep(sight, &point);
}

static void SeeEdge(qcTriangleView* view, int e, qcVector normal)
{
    const qcVector* corner = view->triangle->corner;
    view->edge[e] = qcMinus(corner[(e + 1) % 3], corner[e]);
    view->across[e] = qcCross(view->edge[e], normal);
    view->inner[e] = qcDot(view->across[e], qcMinus(corner[(e + 2) % 3], corner[e]));
    view->edges = e + 1;
}

static void SeeFace(qcTriangleView* view, qcVector normal)
{
    if (view->hasFace)
        return;
    view->face = qcCross(view->edge[0], view->edge[1]);
    view->facing = qcDot(view->face, normal);
    view->hasFace = true;
}

/// Seen along the direction, is the other triangle beyond the line through an edge of this side's? Fills what is known
/// of this side until it says so.
static bool AreBeside(Sight* sight, int side)
{
    qcTriangleView* view = sight->view[side];
    const qcVector *corner = view->triangle->corner, *other = sight->view[1 - side]->triangle->corner;
    for (int e = 0; e < 3; e++)
    {
        if (view->edges == e)
            SeeEdge(view, e, sight->normal);
        qcVector across = view->across[e];
        double* beyond = sight->beyond[side][e];
        for (int c = 0; c < 3; c++)
            beyond[c] = qcDot(across, qcMinus(other[c], corner[e]));
        double x = beyond[0], y = beyond[1], z = beyond[2], inner = view->inner[e];
        double border = QC_MANIFOLD_ROUNDING * fabs(inner);
        if ((inner > 0.0 && x < -border && y < -border && z < -border) ||
            (inner < 0.0 && x > border && y > border && z > border))
            return true;
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

int qcManifoldPair_FindCommonPartSeen(const qcManifoldPair* pair, qcVector normal, qcTriangleView* views[2],
                                      qcRawPoint corners[qc_maxCommonCorners])
{
    Sight sight;
    sight.pair = pair;
    sight.normal = normal;
    sight.found = corners;
    sight.count = 0;
    sight.view[0] = views[0];
    sight.view[1] = views[1];
    if (AreBeside(&sight, 0) || AreBeside(&sight, 1))
        return 0;
    SeeFace(views[0], normal);
    SeeFace(views[1], normal);
    // Corners of triangles first: where one also lies on an edge of the other, a vertex is the steadier name.
    CornersOverFace(&sight, 0);
    CornersOverFace(&sight, 1);
    for (int e = 0; e < 3; e++)
        for (int f = 0; f < 3; f++)
            EdgeOverEdge(&sight, e, f);
    return sight.count;
}

int qcManifoldPair_FindCommonPart(const qcManifoldPair* pair, qcVector normal, qcRawPoint corners[qc_maxCommonCorners])
{
    qcTriangleView views[2];
    for (int side = 0; side < 2; side++)
        qcTriangleView_Begin(&views[side], pair->side[side]);
    return qcManifoldPair_FindCommonPartSeen(pair, normal, (qcTriangleView* [2]){&views[0], &views[1]}, corners);
}
