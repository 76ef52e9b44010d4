// Joins pairs to connected regions of contact. Two pairs are adjacent if they have one triangle in common and their
// other triangles share a vertex. A region names its sides once: in a pair of one body with itself A and B depend on
// indices alone, so an adjacent pair that has the common triangle on the other side is swapped.
//
// Adjacency changes one side at a time, so that the two sides of a thin sheet stay apart: a sheet in a slit touches
// both walls with the same triangles, but the walls are not adjacent, and their normals are opposite.
#include "manifold/topology.h"
#include "base/status.h"
#include "base/union_find.h"

#include <string.h>

/// Joins the pairs of a triangle whose other triangles share a vertex: in the list of a vertex each pair is joined to
/// the previous one. Returns by how many the number of sets falls.
static size_t JoinPairs(const qcManifoldTriangle* triangle, qcContactTopology* topology)
{
    size_t joined = 0;
    uint32_t *nodes = topology->nodes.data, *last = topology->lastEntry.data, first = triangle->firstPair;
    const qcPairEntry* entries = topology->pairsOf.data;
    for (uint32_t i = first; i < first + triangle->pairCount; i++)
    {
        qcPairEntry self = entries[i];
        const uint32_t* vertex = qcContactTopology_Pair(topology, self.pair)->side[1 - self.side]->vertex;
        for (int c = 0; c < 3; c++)
        {
            uint32_t previous = last[vertex[c]];
            last[vertex[c]] = i + 1;
            // From an earlier triangle, or this pair itself: degenerate triangles have a vertex twice.
            if (previous <= first || previous == i + 1)
                continue;
            qcPairEntry other = entries[previous - 1];
            if (nodes[self.pair] >> 1 != nodes[other.pair] >> 1)
                joined += qcUnionFind_Unite(nodes, self.pair, other.pair, self.side ^ other.side);
        }
    }
    return joined;
}

/// Numbers the regions, and swaps the sides of pairs that are opposite to the first one of their region.
static void NumberRegions(qcContactTopology* topology)
{
    uint32_t* nodes = topology->nodes.data;
    qcManifoldPair* pairs = topology->pairs.data;
    topology->regionCount = 0;
    for (uint32_t p = 0; p < topology->pairs.count; p++)
    {
        qcManifoldPair* pair = &pairs[p];
        uint32_t root = qcUnionFind_Find(nodes, p);
        // The root is the lowest pair: it has its number already.
        pair->region = root >> 1 == p ? topology->regionCount++ : pairs[root >> 1].region;
        if ((root & 1u) == 0)
            continue;
        const qcManifoldTriangle* side = pair->side[0];
        pair->side[0] = pair->side[1];
        pair->side[1] = side;
        pair->swapped = true;
    }
}

qcStatus qcContactTopology_JoinRegions(qcContactTopology* topology)
{
    size_t count = topology->pairs.count, vertices = topology->vertices.count;
    QC_TRY(qcArray_Resize(&topology->nodes, count, sizeof(uint32_t), "regions of contact"));
    QC_TRY(qcArray_Resize(&topology->lastEntry, vertices, sizeof(uint32_t), "regions of contact"));
    memset(topology->lastEntry.data, 0, vertices * sizeof(uint32_t));
    qcUnionFind_Init(topology->nodes.data, count);
    // Most bodies have one region of contact, and it is connected long before the last triangle.
    size_t sets = count;
    for (size_t t = 0; t < topology->triangles.count && sets > 1; t++)
        sets -= JoinPairs(&QC_AT(qcManifoldTriangle, topology->triangles, t), topology);
    NumberRegions(topology);
    return qc_statusOk;
}
