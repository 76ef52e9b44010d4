// Triangles by vertex, then for each vertex the one ring that all its triangles make, if they do.
#include "mesh/vertex_fans.h"

#include "base/status.h"

/// Is it the first corner of the triangle that has its vertex?
static bool IsFirst(const qcCorners* corners, int c)
{
    const uint32_t* v = corners->vertex;
    return (c < 1 || v[c] != v[0]) && (c < 2 || v[2] != v[1]);
}

static qcStatus ListPlaces(qcVertexFans* stars, const qcCorners* corners, size_t placeCount, uint32_t vertexCount)
{
    QC_TRY(qcArray_GrowZeroed(&stars->firstPlace, (size_t)vertexCount + 2, sizeof(uint32_t), "stars of a surface"));
    uint32_t* first = stars->firstPlace.data;
    // Counted two further on, so that filling, which moves each to its end, leaves it where the next one begins. Where
    // there is no triangle nothing is counted.
    for (size_t place = 0; place < placeCount; place++)
        for (int c = 0; c < 3 && corners[place].vertex[0] != vertexCount; c++)
            first[corners[place].vertex[c] + 2] += IsFirst(&corners[place], c);
    for (uint32_t v = 0; v < vertexCount; v++)
        first[v + 2] += first[v + 1];
    QC_TRY(qcArray_Resize(&stars->places, first[vertexCount + 1], sizeof(uint32_t), "stars of a surface"));
    for (size_t place = 0; place < placeCount; place++)
        for (int c = 0; c < 3 && corners[place].vertex[0] != vertexCount; c++)
            if (IsFirst(&corners[place], c))
                QC_AT(uint32_t, stars->places, first[corners[place].vertex[c] + 1]++) = (uint32_t)place;
    return qc_statusOk;
}

/// The two corners of a triangle beside one of its vertices. False: they are not three vertices.
static bool FindSides(const qcCorners* corners, uint32_t vertex, uint32_t sides[2])
{
    int c = corners->vertex[0] == vertex ? 0 : corners->vertex[1] == vertex ? 1 : 2;
    sides[0] = corners->vertex[(c + 1) % 3];
    sides[1] = corners->vertex[(c + 2) % 3];
    return sides[0] != vertex && sides[1] != vertex && sides[0] != sides[1];
}

/// Takes the side that continues the ring at `end` out of those that are left; false: none does.
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

/// The vertices around one, in one direction. False: its triangles are not one closed fan.
static bool FindRing(const qcVertexFans* stars, const qcCorners* corners, uint32_t vertex, uint32_t valence,
                     uint32_t* ring)
{
    uint32_t sides[qc_maxFanSize][2], left = valence;
    const uint32_t* places = &QC_AT(uint32_t, stars->places, QC_AT(uint32_t, stars->firstPlace, vertex));
    for (uint32_t i = 0; i < valence; i++)
        if (!FindSides(&corners[places[i]], vertex, sides[i]))
            return false;
    ring[0] = sides[0][0];
    for (uint32_t i = 0; i < valence; i++)
    {
        uint32_t next;
        if (!TakeNext(sides, &left, ring[i], &next))
            return false;
        // Each vertex once, and back to the first with the last triangle.
        for (uint32_t k = 0; k <= i; k++)
            if (ring[k] == next && (k != 0 || left != 0))
                return false;
        if (left == 0)
            return next == ring[0];
        ring[i + 1] = next;
    }
    return false;
}

/// Adds a star to the last batch, or begins the next.
static qcStatus AddStar(qcVertexFans* stars, uint32_t vertex, const uint32_t* ring, uint32_t valence)
{
    size_t count = stars->batches.count;
    const qcVertexFanBatch* last = count != 0 ? &QC_AT(qcVertexFanBatch, stars->batches, count - 1) : NULL;
    if (last == NULL || last->valence != valence || last->count == qc_fanLanes)
    {
        size_t first = stars->vertices.count;
        QC_TRY(qcArray_Resize(&stars->batches, count + 1, sizeof(qcVertexFanBatch), "stars of a surface"));
        QC_TRY(qcArray_Resize(&stars->vertices, first + (size_t)qc_fanLanes * (1 + valence), sizeof(uint32_t),
                              "stars of a surface"));
        QC_AT(qcVertexFanBatch, stars->batches, count++) = (qcVertexFanBatch){valence, 0, first};
    }
    qcVertexFanBatch* batch = &QC_AT(qcVertexFanBatch, stars->batches, count - 1);
    uint32_t* row = &QC_AT(uint32_t, stars->vertices, batch->firstVertex);
    // The first one in all lanes, until others come.
    uint32_t from = batch->count++, to = from == 0 ? qc_fanLanes : from + 1;
    for (uint32_t lane = from; lane < to; lane++)
        for (uint32_t i = 0; i <= valence; i++)
            row[qc_fanLanes * i + lane] = i == 0 ? vertex : ring[i - 1];
    return qc_statusOk;
}

static qcStatus Make(qcVertexFans* stars, const qcCorners* corners, size_t placeCount, uint32_t vertexCount)
{
    QC_TRY(ListPlaces(stars, corners, placeCount, vertexCount));
    const uint32_t* first = stars->firstPlace.data;
    for (uint32_t valence = qc_minFanSize; valence <= qc_maxFanSize; valence++)
        for (uint32_t v = 0; v < vertexCount; v++)
        {
            uint32_t ring[qc_maxFanSize];
            if (first[v + 1] - first[v] == valence && FindRing(stars, corners, v, valence, ring))
                QC_TRY(AddStar(stars, v, ring, valence));
        }
    stars->made = true;
    return qc_statusOk;
}

qcStatus qcVertexFans_Make(qcVertexFans* stars, const qcCorners* corners, size_t placeCount, uint32_t vertexCount)
{
    if (stars->made)
        return qc_statusOk;
    qcStatus status = Make(stars, corners, placeCount, vertexCount);
    if (status != qc_statusOk)
        qcVertexFans_Free(stars);
    return status;
}

void qcVertexFans_Free(qcVertexFans* stars)
{
    qcArray_Free(&stars->firstPlace);
    qcArray_Free(&stars->places);
    qcArray_Free(&stars->batches);
    qcArray_Free(&stars->vertices);
    stars->made = false;
}
