// Points that several pairs say of the same place become one: the deepest first, and then none that says the same as
// one that stays. Places by hashing a grid (Teschner, Heidelberger, Mueller, Pomeranets, Gross: Optimized spatial
// hashing, 2003), so that the work is linear.
//
// The tolerance is a share of the size of the region's triangles. The same feature found from two triangles is off by
// rounding only where their normals agree, but by the gap times the angle between them where they don't; and two
// contacts nearer than a small share of the mesh that found them are one contact to whoever pushes bodies with them.
#include "manifold/manifold_builder.h"
#include "base/radix_sort.h"
#include "base/point_hash.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

// Cells of this many tolerances: a place next to a border is looked for on both sides, most places are in one cell.
static const double s_cell = 8.0;
// What is one distance, by the tolerance: a hundred millionth of the size of the triangles.
static const double s_step = 0x1p-20;

/// A point that stays, in the lists of the cells of its two ends.
typedef struct Link
{
    uint32_t raw;
    uint32_t region;
    uint32_t next; ///< one more than the next link; 0: none
} Link;

static uint32_t RegionOf(const qcManifoldBuilder* m, uint64_t raw)
{
    return qcManifoldBuilder_Pair(m, QC_AT(qcRawPoint, m->raw, raw).pair)->region;
}

/// Sorts the order by region and, within one, by the keys that it comes with. Leaves the regions as keys.
static qcStatus SortWithinRegions(qcManifoldBuilder* m)
{
    QC_TRY(qcSort_Items(m->order.data, m->order.count, &m->scratch));
    for (size_t i = 0; i < m->order.count; i++)
    {
        qcSortItem* item = &QC_AT(qcSortItem, m->order, i);
        item->key = RegionOf(m, item->value);
    }
    return qcSort_Items(m->order.data, m->order.count, &m->scratch);
}

/// Distances that differ by rounding only are equal, so that what lies in one plane keeps the order of its pairs.
static qcStatus SortDeepestFirst(qcManifoldBuilder* m)
{
    QC_TRY(qcArray_Resize(&m->order, m->raw.count, sizeof(qcSortItem), "contact points"));
    for (size_t i = 0; i < m->raw.count; i++)
    {
        const qcRawPoint* point = &QC_AT(qcRawPoint, m->raw, i);
        double step = s_step * QC_AT(qcContactRegion, m->measured, RegionOf(m, i)).tolerance;
        double distance = step > 0.0 ? rint(point->distance / step) : point->distance;
        QC_AT(qcSortItem, m->order, i) = (qcSortItem){qcSort_DoubleKey(distance), (uint64_t)i};
    }
    return SortWithinRegions(m);
}

qcStatus qcManifoldBuilder_OrderKept(qcManifoldBuilder* m)
{
    size_t count = 0;
    for (size_t i = 0; i < m->order.count; i++)
    {
        uint64_t raw = QC_AT(qcSortItem, m->order, i).value;
        if (QC_AT(uint32_t, m->keepers, raw) == raw)
            QC_AT(qcSortItem, m->order, count++) =
                (qcSortItem){qcSort_DoubleKey(QC_AT(qcRawPoint, m->raw, raw).distance), raw};
    }
    m->order.count = count;
    return SortWithinRegions(m);
}

static uint32_t* HeadOf(qcManifoldBuilder* m, uint32_t region, int end, double x, double y, double z)
{
    uint64_t hash = qcPointHash_Of((uint64_t)region << 1 | (unsigned)end, x, y, z);
    return &QC_AT(uint32_t, m->heads, hash & (m->heads.count - 1));
}

typedef struct Search
{
    const qcRawPoint* point;
    uint32_t region;
    double tolerance;
} Search;

static uint32_t FindInCell(const qcManifoldBuilder* m, const Search* search, uint32_t head)
{
    for (uint32_t at = head; at != 0; at = QC_AT(Link, m->links, at - 1).next)
    {
        const Link* link = &QC_AT(Link, m->links, at - 1);
        if (link->region == search->region &&
            qcRawPoint_AreSame(search->point, &QC_AT(qcRawPoint, m->raw, link->raw), search->tolerance))
            return link->raw;
    }
    return UINT32_MAX;
}

/// The point that stays and says the same as this one, or UINT32_MAX.
static uint32_t Find(qcManifoldBuilder* m, const Search* search, double scale)
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
                    uint32_t found = FindInCell(m, search, *HeadOf(m, search->region, end, x[i], y[j], z[k]));
                    if (found != UINT32_MAX)
                        return found;
                }
    }
    return UINT32_MAX;
}

static void Insert(qcManifoldBuilder* m, const Search* search, uint32_t raw, double scale)
{
    for (int end = 0; end < 2; end++)
    {
        qcVector p = search->point->end[end];
        uint32_t* head =
            HeadOf(m, search->region, end, qcFloor(p.x * scale), qcFloor(p.y * scale), qcFloor(p.z * scale));
        QC_AT(Link, m->links, m->links.count++) = (Link){raw, search->region, *head};
        *head = (uint32_t)m->links.count;
    }
}

qcStatus qcManifoldBuilder_MergePoints(qcManifoldBuilder* m)
{
    if (m->raw.count > UINT32_MAX / 4)
        return qcFail(qc_statusOutOfMemory, "out of memory: %zu contact points in one result", m->raw.count);
    QC_TRY(SortDeepestFirst(m));
    size_t size = 16;
    while (size < 2 * m->raw.count)
        size *= 2;
    QC_TRY(qcArray_Resize(&m->heads, size, sizeof(uint32_t), "contact points"));
    memset(m->heads.data, 0, size * sizeof(uint32_t));
    QC_TRY(qcArray_Reserve(&m->links, 2 * m->raw.count, sizeof(Link), "contact points"));
    m->links.count = 0;
    QC_TRY(qcArray_Resize(&m->keepers, m->raw.count, sizeof(uint32_t), "contact points"));
    QC_TRY(qcArray_Resize(&m->members, m->raw.count, sizeof(uint32_t), "contact points"));
    for (size_t i = 0; i < m->raw.count; i++)
    {
        uint32_t raw = (uint32_t)QC_AT(qcSortItem, m->order, i).value;
        Search search = {.point = &QC_AT(qcRawPoint, m->raw, raw)};
        search.region = (uint32_t)QC_AT(qcSortItem, m->order, i).key;
        search.tolerance = QC_AT(qcContactRegion, m->measured, search.region).tolerance;
        double scale = search.tolerance > 0.0 ? 1.0 / (s_cell * search.tolerance) : 1.0;
        uint32_t keeper = Find(m, &search, scale);
        QC_AT(uint32_t, m->members, raw) = UINT32_MAX;
        QC_AT(uint32_t, m->keepers, raw) = keeper == UINT32_MAX ? raw : keeper;
        if (keeper == UINT32_MAX)
        {
            Insert(m, &search, raw, scale);
            continue;
        }
        QC_AT(uint32_t, m->members, raw) = QC_AT(uint32_t, m->members, keeper);
        QC_AT(uint32_t, m->members, keeper) = raw;
    }
    return qc_statusOk;
}
