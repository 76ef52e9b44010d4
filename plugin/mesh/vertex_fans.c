// Chains the triangles around a vertex, edge by edge, to the ring of vertices around it.
#include "mesh/vertex_fans.h"

#include "base/status.h"

/// The two other corners of a triangle, in its direction. False: the three are not different vertices.
static bool FindSides(const qcCorners* corners, uint32_t vertex, uint32_t sides[2])
{
    int c = corners->vertex[0] == vertex ? 0 : corners->vertex[1] == vertex ? 1 : 2;
    sides[0] = corners->vertex[(c + 1) % 3];
    sides[1] = corners->vertex[(c + 2) % 3];
    return sides[0] != vertex && sides[1] != vertex && sides[0] != sides[1];
}

/// Removes from the remaining sides one that begins or ends at `end`. False: there is none.
static bool TakeNext(uint32_t sides[qc_maxFanSize][2], uint32_t* left, uint32_t end, uint32_t* next)
{
    for (uint32_t i = 0; i < *left; i++)
    {
        bool isFirst = sides[i][0] == end;
        if (!isFirst && sides[i][1] != end)
            continue;
        *next = sides[i][isFirst ? 1 : 0];
        (*left)--;
        sides[i][0] = sides[*left][0];
        sides[i][1] = sides[*left][1];
        return true;
    }
    return false;
}

/// The ring of vertices around a vertex, in one direction. False: its triangles are not one closed fan.
static bool ChainRing(const qcVertexFans* fans, const qcCorners* corners, uint32_t vertex, uint32_t valence,
                      uint32_t* ring)
{
    uint32_t sides[qc_maxFanSize][2], left = valence;
    const uint32_t* triangles = &QC_AT(uint32_t, fans->around.triangles, QC_AT(uint32_t, fans->around.first, vertex));
    for (uint32_t i = 0; i < valence; i++)
        if (!FindSides(&corners[triangles[i]], vertex, sides[i]))
            return false;
    ring[0] = sides[0][0];
    for (uint32_t i = 0; i < valence; i++)
    {
        uint32_t next;
        if (!TakeNext(sides, &left, ring[i], &next))
            return false;
        // No vertex twice, except the first again with the last triangle.
        for (uint32_t k = 0; k <= i; k++)
            if (ring[k] == next && (k != 0 || left != 0))
                return false;
        if (left == 0)
            return next == ring[0];
        ring[i + 1] = next;
    }
    return false;
}

/// Adds a fan to the last batch, or to a new one.
static qcStatus AddFan(qcVertexFans* fans, uint32_t vertex, const uint32_t* ring, uint32_t valence)
{
    size_t count = fans->batches.count;
    const qcVertexFanBatch* last = count != 0 ? &QC_AT(qcVertexFanBatch, fans->batches, count - 1) : NULL;
    if (last == NULL || last->valence != valence || last->count == qc_fanLanes)
    {
        size_t first = fans->vertices.count;
        QC_TRY(qcArray_Resize(&fans->batches, count + 1, sizeof(qcVertexFanBatch), "vertex fans"));
        QC_TRY(qcArray_Resize(&fans->vertices, first + (size_t)qc_fanLanes * (1 + valence), sizeof(uint32_t),
                              "vertex fans"));
        QC_AT(qcVertexFanBatch, fans->batches, count++) = (qcVertexFanBatch){valence, 0, first};
    }
    qcVertexFanBatch* batch = &QC_AT(qcVertexFanBatch, fans->batches, count - 1);
    uint32_t* row = &QC_AT(uint32_t, fans->vertices, batch->firstVertex);
    // The first fan fills all lanes; later ones replace its copies.
    uint32_t from = batch->count++, to = from == 0 ? qc_fanLanes : from + 1;
    for (uint32_t lane = from; lane < to; lane++)
        for (uint32_t i = 0; i <= valence; i++)
            row[qc_fanLanes * i + lane] = i == 0 ? vertex : ring[i - 1];
    return qc_statusOk;
}

static qcStatus Make(qcVertexFans* fans, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    QC_TRY(qcVertexTriangles_Build(&fans->around, (const uint32_t*)corners, slotCount, vertexCount));
    for (uint32_t valence = qc_minFanSize; valence <= qc_maxFanSize; valence++)
        for (uint32_t v = 0; v < vertexCount; v++)
        {
            uint32_t ring[qc_maxFanSize];
            if (qcVertexTriangles_Count(&fans->around, v) == valence && ChainRing(fans, corners, v, valence, ring))
                QC_TRY(AddFan(fans, v, ring, valence));
        }
    fans->made = true;
    return qc_statusOk;
}

qcStatus qcVertexFans_Make(qcVertexFans* fans, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    if (fans->made)
        return qc_statusOk;
    qcStatus status = Make(fans, corners, slotCount, vertexCount);
    if (status != qc_statusOk)
        qcVertexFans_Free(fans);
    return status;
}

void qcVertexFans_Free(qcVertexFans* fans)
{
    qcVertexTriangles_Free(&fans->around);
    qcArray_Free(&fans->batches);
    qcArray_Free(&fans->vertices);
    fans->made = false;
}
