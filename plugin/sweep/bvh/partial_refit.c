// Positions are compared bit by bit. A vertex without a changed bit has not moved, and the proofs about it still hold.
// Boxes only grow, by rows computed like those of a fit, so the guarantees of a fit (sweep/bvh/triangle_bvh.c) still
// hold.
#include "sweep/bvh/partial_refit.h"

#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    // At most one in so many vertices may have moved. A cloth of 20 000 triangles with one twentieth of them moved
    // takes half the time of a whole fit and search (AVX2, one thread).
    qc_maxMovedShare = 8,
    qc_compareRun = 16 ///< vertices that are compared together: most have not moved
};

// For smaller motions rounding errors are not negligible.
static const double s_minMotion = 1e-300;

static bool IsInLattice(const qcTriangleBvh* bvh, const double x[3])
{
    for (int axis = 0; axis < 3; axis++)
        if (x[axis] < bvh->fit.lattice.origin[axis] ||
            x[axis] + bvh->fit.lattice.margin[axis] - bvh->fit.lattice.origin[axis] > bvh->fit.latticeExtent[axis])
            return false;
    return true;
}

static qcMotionFlag FlagOf(const double from[3], const double to[3], double maxMotion)
{
    if (from[0] == to[0] && from[1] == to[1] && from[2] == to[2])
        return qc_motionNone;
    double x = fabs(to[0] - from[0]), y = fabs(to[1] - from[1]), z = fabs(to[2] - from[2]);
    double largest = x > y ? x : y;
    largest = z > largest ? z : largest;
    // Squares may underflow or overflow; within these limits they are right to 2^-50.
    if (maxMotion > 1e-120 && maxMotion < 1e120 && largest < maxMotion)
        return x * x + y * y + z * z <= 0.999 * maxMotion * maxMotion ? qc_motionSmall : qc_motionLarge;
    return largest <= 0.57 * maxMotion ? qc_motionSmall : qc_motionLarge; // 1 / sqrt(3)
}

/// Appends the vertices that differ from the reference to those of the previous step. False: too many, or too far.
static bool FindMovedVertices(qcBodyBvh* bodyBvh, const qcBody* body, size_t maxCount)
{
    qcVerletReference* reference = &bodyBvh->verlet;
    const double *positions = reference->positions.data, *now = body->world;
    for (size_t first = 0; first < body->vertexCount; first += qc_compareRun)
    {
        size_t left = body->vertexCount - first, run = left < qc_compareRun ? left : qc_compareRun;
        if (memcmp(positions + 3 * first, now + 3 * first, run * 3 * sizeof(double)) == 0)
            continue;
        for (size_t v = first; v < first + run; v++)
        {
            uint32_t vertex = QC_AT(uint32_t, reference->bvhVertex, v);
            if (vertex == bodyBvh->bvh.vertexCount || memcmp(positions + 3 * v, now + 3 * v, 3 * sizeof(double)) == 0)
                continue;
            if (reference->movedVertices.count == maxCount || !IsInLattice(&bodyBvh->bvh, now + 3 * v))
                return false;
            QC_AT(uint32_t, reference->movedVertices, reference->movedVertices.count++) = vertex;
        }
    }
    return true;
}

/// Enlarges the boxes around a slot by the row, level by level, up to the first that contains it.
static void Grow(qcTriangleBvh* bvh, size_t slot, const qcBoxRow* row)
{
    qcBox8* boxes = bvh->fit.boxes.data;
    for (uint32_t level = 0; level <= bvh->levels; level++, slot /= qc_boxLanes)
    {
        qcBox8* box8 = level == bvh->levels ? &bvh->fit.root : &boxes[bvh->firstBox8[level] + slot / qc_boxLanes];
        bool grows = false;
        for (int axis = 0; axis < 3; axis++)
            for (int side = 0; side < 2; side++)
            {
                int16_t* end = &box8->ends[axis][side * qc_boxLanes + (int)(slot % qc_boxLanes)];
                grows |= row->ends[4 * side + axis] < *end;
                *end = row->ends[4 * side + axis] < *end ? row->ends[4 * side + axis] : *end;
            }
        if (!grows)
            return;
    }
}

static void MoveFan(qcBodyBvh* bodyBvh, uint32_t vertex, qcMotionFlag flag, const qcBoxRow* row)
{
    const uint32_t *first = bodyBvh->fans.around.first.data, *slots = bodyBvh->fans.around.triangles.data;
    uint8_t* flags = bodyBvh->verlet.motionFlags.data;
    for (uint32_t i = first[vertex]; i < first[vertex + 1]; i++)
    {
        flags[slots[i]] = flags[slots[i]] > flag ? flags[slots[i]] : (uint8_t)flag;
        Grow(&bodyBvh->bvh, slots[i], row);
    }
}

/// Clears the flags of triangles around the first `count` moved vertices.
static void ClearFlags(qcBodyBvh* bodyBvh, size_t count)
{
    const uint32_t *first = bodyBvh->fans.around.first.data, *slots = bodyBvh->fans.around.triangles.data;
    for (size_t k = 0; k < count; k++)
    {
        uint32_t vertex = QC_AT(uint32_t, bodyBvh->verlet.movedVertices, k);
        for (uint32_t i = first[vertex]; i < first[vertex + 1]; i++)
            QC_AT(uint8_t, bodyBvh->verlet.motionFlags, slots[i]) = qc_motionNone;
    }
}

/// Points, boxes and flags of all moved vertices.
static void MoveVertices(qcBodyBvh* bodyBvh, const qcBody* body, double maxMotion, const qcTriangleKernels* kernels,
                         qcBoxRow* rows)
{
    qcTriangleBvh* bvh = &bodyBvh->bvh;
    const qcVerletReference* reference = &bodyBvh->verlet;
    const double* positions = reference->positions.data;
    for (size_t k = 0; k < reference->movedVertices.count; k++)
    {
        uint32_t vertex = QC_AT(uint32_t, reference->movedVertices, k);
        size_t at = 3 * (size_t)QC_AT(uint32_t, bvh->vertexOf, vertex);
        const qcVertexRange one = {{.doubles = body->world, .vertexOf = bvh->vertexOf.data}, vertex, vertex + 1};
        kernels->transformVertices(&bvh->fit.lattice, &one, bvh->fit.points.data, rows);
        MoveFan(bodyBvh, vertex, FlagOf(positions + at, body->world + at, maxMotion), &rows[vertex]);
    }
}

qcStatus qcBodyBvh_PartialRefit(qcBodyBvh* bodyBvh, const qcBody* body, double maxMotion,
                                const qcTriangleKernels* kernels, qcBvhScratch* scratch, bool* refitted)
{
    qcTriangleBvh* bvh = &bodyBvh->bvh;
    qcVerletReference* reference = &bodyBvh->verlet;
    qcArray* moved = &reference->movedVertices;
    *refitted = false;
    if (!qcVerletReference_IsValid(reference, bvh) || !(maxMotion > s_minMotion))
        return qc_statusOk;
    size_t previous = moved->count, maxCount = previous + bvh->vertexCount / qc_maxMovedShare;
    QC_TRY(qcArray_Resize(&scratch->vertices, (size_t)bvh->vertexCount + 1, sizeof(qcBoxRow), "refitting a BVH"));
    QC_TRY(qcArray_Reserve(moved, maxCount, sizeof(uint32_t), "refitting a BVH"));
    if (!FindMovedVertices(bodyBvh, body, maxCount))
    {
        // The new list is incomplete, and vertices of the previous one may have returned to the reference.
        qcVerletReference_Clear(reference);
        return qc_statusOk;
    }
    ClearFlags(bodyBvh, previous);
    MoveVertices(bodyBvh, body, maxMotion, kernels, scratch->vertices.data);
    // Drops the previous part of the list: vertices that still differ from the reference are in the new part too.
    if (moved->count > previous)
        memmove(moved->data, &QC_AT(uint32_t, *moved, previous), (moved->count - previous) * sizeof(uint32_t));
    moved->count -= previous;
    bvh->fit.revision = body->moved;
    reference->fitCount = bvh->fit.fitCount = ++bvh->fitCount;
    *refitted = true;
    return qc_statusOk;
}
