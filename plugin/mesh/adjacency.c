// Searches the triangles around one end of each edge.
#include "mesh/adjacency.h"

#include "base/parallel_for.h"
#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    // An edge both of whose vertices have more triangles is treated as a border.
    qc_maxAround = 64,
    // Slots whose edges are searched in about 50 microseconds.
    qc_acrossBlock = 1024
};

/// The only other triangle with the edge u v, if it has the edge in the opposite direction; otherwise QC_NO_SLOT.
static uint32_t FindAcross(const qcAdjacency* a, const qcCorners* corners, uint32_t slot, uint32_t u, uint32_t v)
{
    const uint32_t *first = a->around.first.data, *around = a->around.triangles.data;
    uint32_t at = first[v + 1] - first[v] < first[u + 1] - first[u] ? v : u, found = QC_NO_SLOT;
    if (u == v || first[at + 1] - first[at] > qc_maxAround)
        return QC_NO_SLOT;
    for (uint32_t i = first[at]; i < first[at + 1]; i++)
    {
        const uint32_t* w = corners[around[i]].vertex;
        bool has = (w[0] == u || w[1] == u || w[2] == u) && (w[0] == v || w[1] == v || w[2] == v);
        if (around[i] == slot || !has)
            continue;
        bool opposite = (w[0] == v && w[1] == u) || (w[1] == v && w[2] == u) || (w[2] == v && w[0] == u);
        bool proper = w[0] != w[1] && w[1] != w[2] && w[2] != w[0];
        if (found != QC_NO_SLOT || !opposite || !proper)
            return QC_NO_SLOT;
        found = around[i];
    }
    return found;
}

static qcStatus Begin(qcAdjacency* a, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    QC_TRY(qcVertexTriangles_Build(&a->around, (const uint32_t*)corners, slotCount, vertexCount));
    QC_TRY(qcArray_Resize(&a->across, 3 * slotCount, sizeof(uint32_t), "triangles over edges"));
    if (slotCount != 0)
        memset(a->across.data, 0xff, 3 * slotCount * sizeof(uint32_t));
    return qc_statusOk;
}

qcStatus qcAdjacency_Begin(qcAdjacency* adjacency, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    *adjacency = (qcAdjacency){.across = {0}};
    qcStatus status = Begin(adjacency, corners, slotCount, vertexCount);
    if (status != qc_statusOk)
        qcAdjacency_Free(adjacency);
    return status;
}

typedef struct Finding
{
    qcAdjacency* adjacency;
    const qcCorners* corners;
    uint32_t vertexCount;
    size_t first, end; ///< slots
} Finding;

/// Writes to slots of the block alone: edges between blocks are searched from both sides.
static void FindAcrossBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Finding* f = context;
    uint32_t* across = f->adjacency->across.data;
    size_t first = f->first + block * qc_acrossBlock, left = f->end - first;
    size_t end = first + (left < qc_acrossBlock ? left : qc_acrossBlock);
    for (size_t slot = first; slot < end; slot++)
    {
        const uint32_t* v = f->corners[slot].vertex;
        bool proper = v[0] != f->vertexCount && v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
        for (size_t c = 0; c < 3 && proper; c++)
        {
            uint32_t u = v[c], w = v[(c + 1) % 3];
            if (across[3 * slot + c] != QC_NO_SLOT)
                continue;
            uint32_t other = FindAcross(f->adjacency, f->corners, (uint32_t)slot, u, w);
            across[3 * slot + c] = other;
            // Each is the only other triangle of the other one's edge.
            for (size_t k = 0; k < 3 && other >= first && other < end; k++)
                if (f->corners[other].vertex[k] == w)
                    across[3 * (size_t)other + k] = (uint32_t)slot;
        }
    }
}

void qcAdjacency_FindAcross(qcAdjacency* adjacency, const qcCorners* corners, uint32_t vertexCount, size_t first,
                            size_t end, uint32_t threads)
{
    Finding finding = {adjacency, corners, vertexCount, first, end};
    size_t blocks = (end - first + qc_acrossBlock - 1) / qc_acrossBlock;
    qcParallel_For(threads, blocks, 2, FindAcrossBlock, &finding);
}

qcStatus qcAdjacency_Build(qcAdjacency* adjacency, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    QC_TRY(qcAdjacency_Begin(adjacency, corners, slotCount, vertexCount));
    qcAdjacency_FindAcross(adjacency, corners, vertexCount, 0, slotCount, 1);
    return qc_statusOk;
}

void qcAdjacency_Free(qcAdjacency* adjacency)
{
    qcVertexTriangles_Free(&adjacency->around);
    qcArray_Free(&adjacency->across);
}
