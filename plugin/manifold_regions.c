// The connected regions of contact: union-find (Galler, Fischer: An improved equivalence algorithm, 1964), each link
// with a sign.
//
// A body with itself has no A and B: which of two triangles has the lower index is an accident, and the normal from
// the one to the other would flip with it. A region names its sides once: a neighbour that has the common triangle on
// the other side is turned around.
#include "manifold_parts.h"
#include "status.h"

static void SwapSides(qcManifoldPair* pair)
{
    const qcManifoldTriangle* side = pair->side[0];
    pair->side[0] = pair->side[1];
    pair->side[1] = side;
    uint32_t place = pair->place[0];
    pair->place[0] = pair->place[1];
    pair->place[1] = place;
    pair->normal = qcNegated(pair->normal);
    pair->reported = pair->normal;
    pair->swapped = true;
}

static void JoinRing(qcManifolds* m, uint32_t p, int side)
{
    uint32_t *nodes = m->nodes.data, root = qcSigned_Find(nodes, p) >> 1;
    qcRing ring = qcManifolds_Ring(m, qcManifolds_Pair(m, p), side);
    for (uint32_t i = 0; i < ring.count; i++)
    {
        uint32_t q = qcManifolds_Beside(m, ring.entries[i])->pair;
        // The other one sees this one too; and mostly both are known to be in one set already.
        if (q >= p || nodes[q] >> 1 == root)
            continue;
        qcSigned_Unite(nodes, q, p, (ring.entries[i] & qc_ringTurned) != 0);
        root = qcSigned_Find(nodes, p) >> 1;
    }
}

qcStatus qcManifolds_JoinRegions(qcManifolds* m)
{
    size_t count = m->work.count;
    QC_TRY(qcArray_Resize(&m->nodes, count, sizeof(uint32_t), "regions of contact"));
    QC_TRY(qcArray_Resize(&m->regions, count, sizeof(qcSignRegion), "regions of contact"));
    uint32_t* nodes = m->nodes.data;
    for (uint32_t p = 0; p < count; p++)
    {
        nodes[p] = p << 1;
        QC_AT(qcSignRegion, m->regions, p) = (qcSignRegion){.fact = UINT32_MAX};
    }
    for (uint32_t p = 0; p < count; p++)
    {
        JoinRing(m, p, 0);
        JoinRing(m, p, 1);
    }
    for (uint32_t p = 0; p < count; p++)
    {
        uint32_t root = qcSigned_Find(nodes, p);
        qcManifoldPair* pair = qcManifolds_Pair(m, p);
        pair->region = root >> 1;
        if (root & 1u)
            SwapSides(pair);
        qcSignRegion* region = qcManifolds_SignRegion(m, pair);
        region->crossing = region->crossing || pair->crossing;
        region->unsettled = region->unsettled || !pair->parted;
    }
    return qc_statusOk;
}
