// Regions that one plane separates: all triangles of side 0 lie above it, all of side 1 below. The separating axis of
// convex bodies (Gottschalk, Lin, Manocha: OBBTree, 1996), for the parts of any two bodies that are near each other.
// How the plane is chosen, and which overlap it allows: plugin/docs/manifolds.md.
#include "manifold/separating_plane.h"
#include "manifold/stage_switches.h"
#include "base/status.h"

#include <math.h>

// Corners given in single precision, and rotated, are off by less than this share of the size of a triangle, unless
// they are far from the origin.
static const double s_rounding = 0x1p-20;
// The shorter separation distance is certain to be the correct one if it is at most this share of the other.
static const double s_shorter = 0.25;

/// The plane of a region lies along a face of its reference pair.
typedef struct Plane
{
    double area;               ///< twice that of the smaller triangle of the reference pair; 0: there is none
    uint32_t reference;        ///< the pair: see IsCoplanar
    bool intersecting;         ///< some pair of the region intersects
    qcHeightRange sides[2][2]; ///< along the face of a side of the reference pair, of a side of the region
} Plane;

/// True if the pair's triangles, parallel to each other, overlap in an area at a small distance.
static bool IsCoplanar(const qcManifoldPair* pair, const qcOverlapKernels* kernels)
{
    qcRawPoint corners[qc_maxOverlapCorners];
    int count = qcProjectedOverlap_FindCorners(kernels, pair, pair->side[1]->normal, corners);
    double nearest = INFINITY;
    for (int i = 0; i < count; i++)
        nearest = fmin(nearest, fabs(corners[i].distance));
    return nearest <= QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair) &&
           qcProjectedOverlap_IsArea(pair, corners, count);
}

/// Each region's coplanar pair with the largest smaller triangle.
static void FindReferencePairs(const qcContactTopology* topology, const qcOverlapKernels* kernels, Plane* planes)
{
    for (uint32_t p = 0; p < topology->pairs.count; p++)
    {
        const qcManifoldPair* pair = qcContactTopology_Pair(topology, p);
        Plane* plane = &planes[pair->region];
        plane->intersecting = plane->intersecting || pair->intersecting;
        if (!(fabs(qcDot(pair->side[0]->normal, pair->side[1]->normal)) >= QC_MANIFOLD_FLAT))
            continue;
        double area = fmin(pair->side[0]->doubleArea, pair->side[1]->doubleArea);
        if (!(area > plane->area) || !IsCoplanar(pair, kernels))
            continue;
        plane->area = area;
        plane->reference = p;
    }
}

static void Widen(qcHeightRange* all, qcHeightRange heights)
{
    all->low = heights.low < all->low ? heights.low : all->low;
    all->high = heights.high > all->high ? heights.high : all->high;
}

/// Heights of the sides of the regions along the faces of the reference pairs. Most triangles are visited once.
static void FindHeights(const qcContactTopology* topology, uint32_t* visitedBy, Plane* planes)
{
    for (size_t i = 0; i < topology->triangles.count; i++)
        visitedBy[i] = UINT32_MAX;
    for (uint32_t p = 0; p < topology->pairs.count; p++)
    {
        const qcManifoldPair* pair = qcContactTopology_Pair(topology, p);
        Plane* plane = &planes[pair->region];
        if (plane->area == 0.0)
            continue;
        const qcManifoldPair* reference = qcContactTopology_Pair(topology, plane->reference);
        for (uint32_t side = 0; side < 2; side++)
        {
            const qcManifoldTriangle* triangle = pair->side[side];
            uint32_t* visited = &visitedBy[qcContactTopology_TriangleOf(topology, triangle)];
            if (*visited == (pair->region << 1 | side))
                continue;
            *visited = pair->region << 1 | side;
            for (int face = 0; face < 2; face++)
            {
                const qcManifoldTriangle* along = reference->side[face];
                Widen(&plane->sides[face][side], qcManifoldTriangle_Heights(triangle, along->corner[0], along->normal));
            }
        }
    }
}

/// The overlap of the region's sides along a face of the reference pair, in the direction in which it is smaller;
/// infinity if it is too large.
static double FindOverlap(const qcManifoldPair* reference, const Plane* plane, int face, bool* against)
{
    const qcManifoldTriangle* triangle = reference->side[face];
    qcSeparation all = qcSeparation_Of(plane->sides[face][0], plane->sides[face][1]);
    qcSeparation own = qcManifoldPair_Separation(reference, triangle->corner[0], triangle->normal);
    *against = all.against < all.along;
    double shorter = *against ? all.against : all.along, longer = *against ? all.along : all.against;
    double size = qcManifoldPair_SmallerSize(reference), allowed = s_rounding * size;
    if (plane->intersecting)
        allowed = fmin(fmax(allowed, 2.0 * (*against ? own.against : own.along)), QC_MANIFOLD_AREA * size);
    return shorter <= allowed && shorter <= s_shorter * longer ? shorter : INFINITY;
}

static bool HasPoint(const qcManifoldPair* pair, qcVector normal, const qcOverlapKernels* kernels, double margin)
{
    qcRawPoint corners[qc_maxOverlapCorners];
    int count = qcProjectedOverlap_FindCorners(kernels, pair, normal, corners);
    bool found = false;
    for (int i = 0; i < count; i++)
        found = found || corners[i].distance <= qcManifoldPair_Limit(pair, margin);
    return found;
}

/// Finds the plane of a region, along a face of the reference pair. The pair must have a point along the plane's
/// normal.
static void FindPlane(const qcContactTopology* topology, const Plane* plane, const qcOverlapKernels* kernels,
                      double margin, qcContactRegion* region)
{
    region->hasSeparatingPlane = false;
    if (plane->area == 0.0 || !QC_STAGE_RUNS(separatingPlane))
        return;
    const qcManifoldPair* reference = qcContactTopology_Pair(topology, plane->reference);
    bool against[2];
    double overlap[2];
    for (int face = 0; face < 2; face++)
        overlap[face] = FindOverlap(reference, plane, face, &against[face]);
    int face = overlap[1] < overlap[0] ? 1 : 0;
    qcVector n = reference->side[face]->normal;
    region->normal = against[face] ? qcNegated(n) : n;
    region->hasSeparatingPlane = overlap[face] < INFINITY && HasPoint(reference, region->normal, kernels, margin);
}

static qcStatus ListUnsettledPairs(const qcContactTopology* topology, qcContactRegions* regions)
{
    qcArray* unsettled = &regions->unsettledPairs;
    QC_TRY(qcArray_Reserve(unsettled, topology->pairs.count, sizeof(uint32_t), "planes of contact"));
    unsettled->count = 0;
    for (uint32_t p = 0; p < topology->pairs.count; p++)
        if (!qcContactRegions_IsSettled(regions, qcContactTopology_Pair(topology, p)))
            QC_AT(uint32_t, *unsettled, unsettled->count++) = p;
    return qc_statusOk;
}

qcStatus qcContactRegions_Find(const qcContactTopology* topology, const qcOverlapKernels* kernels, double margin,
                               qcContactRegions* regions)
{
    static const qcHeightRange nothing = {INFINITY, -INFINITY};
    uint32_t count = topology->regionCount;
    QC_TRY(qcArray_Resize(&regions->regions, count, sizeof(qcContactRegion), "regions of contact"));
    QC_TRY(qcArray_Resize(&regions->planes, count, sizeof(Plane), "planes of contact"));
    QC_TRY(qcArray_Resize(&regions->visitedBy, topology->triangles.count, sizeof(uint32_t), "planes of contact"));
    Plane* planes = regions->planes.data;
    for (uint32_t r = 0; r < count; r++)
        planes[r] = (Plane){.sides = {{nothing, nothing}, {nothing, nothing}}};
    FindReferencePairs(topology, kernels, planes);
    FindHeights(topology, regions->visitedBy.data, planes);
    for (uint32_t r = 0; r < count; r++)
        FindPlane(topology, &planes[r], kernels, margin, &QC_AT(qcContactRegion, regions->regions, r));
    return ListUnsettledPairs(topology, regions);
}

void qcContactRegions_Free(qcContactRegions* regions)
{
    qcArray* arrays[] = {&regions->regions, &regions->unsettledPairs, &regions->planes, &regions->visitedBy};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
