// The connected regions of contact: union-find (Galler, Fischer: An improved equivalence algorithm, 1964), each link
// with a sign.
//
// Two pairs are neighbours if one of their triangles is the same and the other two share a vertex: one foot stays, the
// other takes a step. Asking for the step on one side only keeps two sides of one sheet apart: a sheet in a slit
// touches both walls with the same triangles, but the walls are not beside each other, and what they say of the sheet
// may well be opposite. Each triangle lists its pairs by the vertices of their other triangles: of a list, whoever
// follows another one is joined to it, and so all are one.
//
// A body with itself has no A and B: which of two triangles has the lower index is an accident, and the normal from
// the one to the other would flip with it. A region names its sides once: a neighbour that has the common triangle on
// the other side is turned around.
#include "manifold/manifold_builder.h"
#include "base/status.h"

#include <string.h>

/// Joins the pairs of a triangle whose other triangles share a vertex; returns by how many sets that makes fewer.
/// `last`: of a vertex, one more than the entry of the last pair that had it.
static size_t JoinPairs(qcManifoldBuilder* m, const qcManifoldTriangle* triangle, uint32_t* last)
{
    size_t joined = 0;
    uint32_t *nodes = m->nodes.data, first = triangle->firstPair;
    const qcPairSide* entries = m->pairsOf.data;
    for (uint32_t i = first; i < first + triangle->pairCount; i++)
    {
        qcPairSide self = entries[i];
        const uint32_t* vertex = qcManifoldBuilder_Pair(m, self.pair)->side[1 - self.side]->vertex;
        for (int c = 0; c < 3; c++)
        {
            uint32_t before = last[vertex[c]];
            last[vertex[c]] = i + 1;
            // From an earlier triangle, or of this pair: degenerate triangles have a vertex twice.
            if (before <= first || before == i + 1)
                continue;
            qcPairSide other = entries[before - 1];
            if (nodes[self.pair] >> 1 != nodes[other.pair] >> 1)
                joined += qcSigned_Unite(nodes, self.pair, other.pair, self.side ^ other.side);
        }
    }
    return joined;
}

/// Numbers the regions, and names the sides of their pairs.
static qcStatus TakeRegions(qcManifoldBuilder* m)
{
    uint32_t* nodes = m->nodes.data;
    size_t count = 0;
    for (uint32_t p = 0; p < m->work.count; p++)
        count += nodes[p] >> 1 == p;
    QC_TRY(qcArray_Reserve(&m->regions, count, sizeof(qcPairRegion), "regions of contact"));
    m->regions.count = 0;
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        uint32_t root = qcSigned_Find(nodes, p);
        // The lowest is the root: it has its number already.
        if (root >> 1 == p)
        {
            pair->region = (uint32_t)m->regions.count++;
            *qcManifoldBuilder_PairRegion(m, pair) = (qcPairRegion){.first = p, .fact = UINT32_MAX};
        }
        pair->region = qcManifoldBuilder_Pair(m, root >> 1)->region;
        qcPairRegion* region = qcManifoldBuilder_PairRegion(m, pair);
        region->meets = region->meets || pair->meets;
        if ((root & 1u) == 0)
            continue;
        const qcManifoldTriangle* side = pair->side[0];
        pair->side[0] = pair->side[1];
        pair->side[1] = side;
        pair->swapped = true;
    }
    return qc_statusOk;
}

qcStatus qcManifoldBuilder_JoinRegions(qcManifoldBuilder* m)
{
    QC_TRY(qcArray_Resize(&m->nodes, m->work.count, sizeof(uint32_t), "regions of contact"));
    QC_TRY(qcArray_Resize(&m->last, m->vertices.count, sizeof(uint32_t), "regions of contact"));
    memset(m->last.data, 0, m->vertices.count * sizeof(uint32_t));
    qcSigned_Init(m->nodes.data, m->work.count);
    // Most bodies meet in one region, and long before all triangles have said so.
    size_t sets = m->work.count;
    for (size_t t = 0; t < m->triangles.count && sets > 1; t++)
        sets -= JoinPairs(m, &QC_AT(qcManifoldTriangle, m->triangles, t), m->last.data);
    return TakeRegions(m);
}
