// Which free pairs lie beside which, in parallel. (What is beside: manifold/contact_regions.c.)
//
// Each triangle looks at its own pairs only: they are listed by the vertices of their other triangles, and whoever
// stands near in a list is a neighbour.
#include "manifold/manifold_builder.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // A block takes some 100 microseconds.
    qc_ringBlock = 64,
    qc_leastRingBlocks = 4,
    // Room is made for so many pairs at once.
    qc_ringRoom = 64
};

/// Of a vertex: the pairs of the triangle whose other triangle has it.
typedef struct Fan
{
    uint32_t first, count;
} Fan;

/// Of a pair in turn: whether it is in the ring already, and where.
typedef struct Seen
{
    uint32_t by; ///< one more than the pair that saw it
    uint32_t entry;
} Seen;

/// The pairs of one triangle, numbered from 0.
typedef struct Wheel
{
    qcManifoldWorker* worker;
    qcManifoldPlace* places;
    uint32_t first, count; ///< of the places
    Fan* fans;
    uint32_t* fanOf;    ///< three a pair
    uint32_t* position; ///< three a pair: where it stands among the members
    uint32_t* members;  ///< of all fans
    Seen* seen;
} Wheel;

static qcStatus MakeWheel(const qcManifoldBuilder* m, qcManifoldWorker* worker, const qcManifoldTriangle* triangle,
                          Wheel* wheel)
{
    size_t corners = 3 * (size_t)triangle->count;
    QC_TRY(qcArray_Reserve(&worker->fans, corners, sizeof(Fan), "neighbours in manifolds"));
    QC_TRY(qcArray_Reserve(&worker->lists, 3 * corners, sizeof(uint32_t), "neighbours in manifolds"));
    QC_TRY(qcArray_Reserve(&worker->seen, triangle->count, sizeof(Seen), "neighbours in manifolds"));
    uint32_t* lists = worker->lists.data;
    *wheel = (Wheel){.worker = worker,
                     .first = triangle->first,
                     .places = &QC_AT(qcManifoldPlace, m->places, triangle->first),
                     .count = triangle->count,
                     .fans = worker->fans.data,
                     .fanOf = lists,
                     .position = lists + corners,
                     .members = lists + 2 * corners,
                     .seen = worker->seen.data};
    return qc_statusOk;
}

static void ListFans(Wheel* wheel)
{
    uint32_t* listOf = wheel->worker->listOf.data;
    uint32_t fans = 0, first = 0;
    for (uint32_t i = 0; i < wheel->count; i++)
    {
        wheel->seen[i].by = 0;
        const uint32_t* vertex = wheel->places[i].moved->vertex;
        for (uint32_t c = 0; c < 3; c++)
        {
            uint32_t* list = &listOf[vertex[c]];
            if (*list == 0)
            {
                wheel->fans[fans].count = 0;
                *list = ++fans;
            }
            wheel->fanOf[3 * i + c] = *list - 1;
            wheel->fans[*list - 1].count++;
        }
    }
    for (uint32_t f = 0; f < fans; f++)
    {
        wheel->fans[f].first = first;
        first += wheel->fans[f].count;
        wheel->fans[f].count = 0;
    }
    for (uint32_t i = 0; i < wheel->count; i++)
    {
        const uint32_t* vertex = wheel->places[i].moved->vertex;
        for (uint32_t c = 0; c < 3; c++)
        {
            Fan* fan = &wheel->fans[wheel->fanOf[3 * i + c]];
            wheel->position[3 * i + c] = fan->first + fan->count;
            wheel->members[fan->first + fan->count++] = i;
            listOf[vertex[c]] = 0;
        }
    }
}

/// Adds the neighbours of a pair through one corner; returns the new number.
static uint32_t AddFan(const Wheel* wheel, uint32_t i, uint32_t corner, uint32_t* ring, uint32_t count)
{
    const Fan* fan = &wheel->fans[wheel->fanOf[3 * i + corner]];
    uint32_t place = wheel->position[3 * i + corner], end = fan->first + fan->count;
    uint32_t first = place - fan->first > qc_besideReach ? place - qc_besideReach : fan->first;
    uint32_t last = end - place > qc_besideReach ? place + qc_besideReach + 1 : end;
    for (uint32_t k = first; k < last; k++)
    {
        uint32_t j = wheel->members[k];
        Seen* seen = &wheel->seen[j];
        if (j == i)
            continue;
        if (seen->by != i + 1)
        {
            *seen = (Seen){i + 1, count};
            ring[count++] = (wheel->first + j) * qc_ringOne + 1;
        }
        // Of a degenerate triangle a vertex counts twice.
        else if ((ring[seen->entry] & qc_ringShared) < 3)
            ring[seen->entry]++;
    }
    return count;
}

static qcStatus FindRings(const qcManifoldBuilder* m, uint32_t worker, const qcManifoldTriangle* triangle)
{
    // Its pairs are all settled.
    if (triangle->count == 0)
        return qc_statusOk;
    Wheel wheel;
    qcManifoldWorker* self = &QC_AT(qcManifoldWorker, m->workers, worker);
    QC_TRY(MakeWheel(m, self, triangle, &wheel));
    ListFans(&wheel);
    for (uint32_t i = 0; i < wheel.count; i++)
    {
        qcManifoldPlace* place = &wheel.places[i];
        place->heights = qcManifoldTriangle_Heights(place->moved, triangle->corner[0], triangle->normal);
        size_t first = self->rings.count;
        if (i % qc_ringRoom == 0)
            QC_TRY(qcArray_Reserve(&self->rings, first + (size_t)qc_ringRoom * qc_maxRing, sizeof(uint32_t),
                                   "neighbours in manifolds"));
        uint32_t count = 0;
        for (uint32_t c = 0; c < 3; c++)
            count = AddFan(&wheel, i, c, &QC_AT(uint32_t, self->rings, first), count);
        self->rings.count = first + count;
        place->worker = (uint16_t)worker;
        place->ringCount = (uint8_t)count;
        place->ringFirst = first;
    }
    return qc_statusOk;
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    const qcManifoldBuilder* m = context;
    qcWorkerResult* result = &QC_AT(qcManifoldWorker, m->workers, worker).result;
    size_t end = (block + 1) * qc_ringBlock < m->triangles.count ? (block + 1) * qc_ringBlock : m->triangles.count;
    for (size_t t = block * qc_ringBlock; t < end && qcWorkerResult_IsOk(result); t++)
        (void)qcWorkerResult_Add(result, FindRings(m, worker, &QC_AT(qcManifoldTriangle, m->triangles, t)));
}

qcStatus qcManifoldBuilder_FindRings(qcManifoldBuilder* m, uint32_t threads)
{
    for (uint32_t i = 0; i < threads; i++)
    {
        qcArray* listOf = &QC_AT(qcManifoldWorker, m->workers, i).listOf;
        QC_TRY(qcArray_Resize(listOf, m->vertices.count, sizeof(uint32_t), "neighbours in manifolds"));
        memset(listOf->data, 0, m->vertices.count * sizeof(uint32_t));
    }
    size_t blocks = (m->triangles.count + qc_ringBlock - 1) / qc_ringBlock;
    qcParallel_For(threads, blocks, qc_leastRingBlocks, TakeBlock, m);
    return qcManifoldBuilder_LoopStatus(m);
}
