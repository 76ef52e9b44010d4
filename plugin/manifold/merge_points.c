// Merges points that several pairs have found at one position. Points are visited deepest first; one is kept unless a
// kept one is the same. Neighbours by hashing a grid (Teschner, Heidelberger, Mueller, Pomeranets, Gross: Optimized
// spatial hashing, 2003), so that the work is linear.
//
// The tolerance is a share of the size of the region's triangles: a feature found from two triangles differs by
// rounding where their normals agree, else by the distance times the angle between them; and contacts within a small
// share of the mesh's resolution act as one.
#include "manifold/points.h"
#include "manifold/stage_switches.h"
#include "base/point_hash.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

// Cells of this many tolerances: most points are farther than a tolerance from any border, and search one cell.
static const double s_cell = 8.0;
// Distances are equal within this share of the tolerance: a hundred millionth of the size of the triangles.
static const double s_step = 0x1p-20;

/// An entry of a representative in the list of a cell: it has one for each of its two ends.
typedef struct Link
{
    uint32_t raw;
    uint32_t region;
    uint32_t next; ///< the next link plus 1; 0: none
} Link;

/// Sorts by region and, within one, by the keys of the items. Leaves the regions as keys.
static qcStatus SortWithinRegions(const qcContactTopology* topology, qcContactPoints* points)
{
    qcSortItem* items = points->order.data;
    size_t count = points->order.count;
    QC_TRY(qcSort_Items(items, count, &points->sortScratch));
    for (size_t i = 0; i < count; i++)
        items[i].key = qcContactTopology_Pair(topology, qcContactPoints_Raw(points, items[i].value)->pair)->region;
    return qcSort_Items(items, count, &points->sortScratch);
}

/// Distances that differ by rounding only are equal: coplanar points stay in the order of their pairs.
static qcStatus SortDeepestFirst(const qcContactTopology* topology, qcContactPoints* points)
{
    QC_TRY(qcArray_Resize(&points->order, points->raw.count, sizeof(qcSortItem), "contact points"));
    for (size_t i = 0; i < points->raw.count; i++)
    {
        const qcRawPoint* point = qcContactPoints_Raw(points, i);
        double step = s_step * qcContactPoints_Tolerance(points, qcContactTopology_Pair(topology, point->pair)->region);
        double distance = step > 0.0 ? rint(point->distance / step) : point->distance;
        QC_AT(qcSortItem, points->order, i) = (qcSortItem){qcSort_DoubleKey(distance), (uint64_t)i};
    }
    return SortWithinRegions(topology, points);
}

qcStatus qcContactPoints_Order(const qcContactTopology* topology, qcContactPoints* points)
{
    qcSortItem* items = points->order.data;
    size_t count = 0;
    for (size_t i = 0; i < points->order.count; i++)
    {
        uint64_t raw = items[i].value;
        if (QC_AT(uint32_t, points->representatives, raw) == raw)
            items[count++] = (qcSortItem){qcSort_DoubleKey(qcContactPoints_Raw(points, raw)->distance), raw};
    }
    points->order.count = count;
    return SortWithinRegions(topology, points);
}

static uint32_t* HeadOf(const qcContactPoints* points, uint32_t region, int end, double x, double y, double z)
{
    uint64_t hash = qcPointHash_Of((uint64_t)region << 1 | (unsigned)end, x, y, z);
    return &QC_AT(uint32_t, points->heads, hash & (points->heads.count - 1));
}

typedef struct Search
{
    const qcRawPoint* point;
    uint32_t region;
    double tolerance;
} Search;

static uint32_t FindInCell(const qcContactPoints* points, const Search* search, uint32_t head)
{
    for (uint32_t at = head; at != 0; at = QC_AT(Link, points->links, at - 1).next)
    {
        const Link* link = &QC_AT(Link, points->links, at - 1);
        if (link->region == search->region &&
            qcRawPoint_AreSame(search->point, qcContactPoints_Raw(points, link->raw), search->tolerance))
            return link->raw;
    }
    return UINT32_MAX;
}

/// Finds a representative that is the same point; UINT32_MAX: there is none.
static uint32_t Find(const qcContactPoints* points, const Search* search, double scale)
{
    for (int end = 0; end < 2; end++)
    {
        qcVector p = search->point->end[end];
        double t = search->tolerance;
        double x[2] = {qcFloor((p.x - t) * scale), qcFloor((p.x + t) * scale)};
        double y[2] = {qcFloor((p.y - t) * scale), qcFloor((p.y + t) * scale)};
        double z[2] = {qcFloor((p.z - t) * scale), qcFloor((p.z + t) * scale)};
        for (int i = 0; i < 2; i++)
            for (int j = 0; j < 2; j++)
                for (int k = 0; k < 2; k++)
                {
                    if ((i && x[1] == x[0]) || (j && y[1] == y[0]) || (k && z[1] == z[0]))
                        continue;
                    uint32_t found = FindInCell(points, search, *HeadOf(points, search->region, end, x[i], y[j], z[k]));
                    if (found != UINT32_MAX)
                        return found;
                }
    }
    return UINT32_MAX;
}

static void Insert(qcContactPoints* points, const Search* search, uint32_t raw, double scale)
{
    for (int end = 0; end < 2; end++)
    {
        qcVector p = search->point->end[end];
        uint32_t* head =
            HeadOf(points, search->region, end, qcFloor(p.x * scale), qcFloor(p.y * scale), qcFloor(p.z * scale));
        QC_AT(Link, points->links, points->links.count++) = (Link){raw, search->region, *head};
        *head = (uint32_t)points->links.count;
    }
}

static qcStatus EmptyTable(qcContactPoints* points)
{
    size_t count = points->raw.count, size = 16;
    while (size < 2 * count)
        size *= 2;
    QC_TRY(qcArray_Resize(&points->heads, size, sizeof(uint32_t), "contact points"));
    memset(points->heads.data, 0, size * sizeof(uint32_t));
    QC_TRY(qcArray_Reserve(&points->links, 2 * count, sizeof(Link), "contact points"));
    points->links.count = 0;
    QC_TRY(qcArray_Resize(&points->representatives, count, sizeof(uint32_t), "contact points"));
    return qcArray_Resize(&points->nextMembers, count, sizeof(uint32_t), "contact points");
}

qcStatus qcContactPoints_Merge(const qcContactTopology* topology, qcContactPoints* points)
{
    if (points->raw.count > UINT32_MAX / 4)
        return qcFail(qc_statusOutOfMemory, "out of memory: %zu contact points in one result", points->raw.count);
    QC_TRY(SortDeepestFirst(topology, points));
    QC_TRY(EmptyTable(points));
    uint32_t *representatives = points->representatives.data, *nextMembers = points->nextMembers.data;
    for (size_t i = 0; i < points->order.count; i++)
    {
        qcSortItem item = QC_AT(qcSortItem, points->order, i);
        uint32_t raw = (uint32_t)item.value;
        Search search = {.point = qcContactPoints_Raw(points, raw),
                         .region = (uint32_t)item.key,
                         .tolerance = qcContactPoints_Tolerance(points, item.key)};
        double scale = search.tolerance > 0.0 ? 1.0 / (s_cell * search.tolerance) : 1.0;
        uint32_t same = QC_STAGE_RUNS(merge) ? Find(points, &search, scale) : UINT32_MAX;
        nextMembers[raw] = UINT32_MAX;
        representatives[raw] = same == UINT32_MAX ? raw : same;
        if (same == UINT32_MAX)
        {
            Insert(points, &search, raw, scale);
            continue;
        }
        nextMembers[raw] = nextMembers[same];
        nextMembers[same] = raw;
    }
    return qc_statusOk;
}
