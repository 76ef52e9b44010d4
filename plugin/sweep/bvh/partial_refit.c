// Positions are compared as they are, in double: what has not changed in a bit has not moved, so that whatever was
// known of it still holds. Boxes only grow, by rows that are computed as those of a fit: what a fit proves of them
// (sweep/bvh/triangle_bvh.c) stays true.
#include "sweep/bvh/partial_refit.h"

#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    // One vertex of so many may have moved: of a cloth of 20 000 triangles following one twentieth, and searching what
    // moved, takes half of what fitting and searching all of it does (AVX2, one thread).
    qc_strayShare = 8,
    qc_compareRun = 16 ///< vertices that are compared together: most have not moved
};

// Below, rounding counts.
static const double s_leastFar = 1e-300;

/// What depends on the topology alone.
static qcStatus NameVertices(qcTriangleBvh* surface, uint32_t vertexCount)
{
    if (surface->nameOf.count != 0)
        return qc_statusOk;
    QC_TRY(qcVertexFans_Make(&surface->stars, surface->corners.data, surface->corners.count, surface->vertexCount));
    QC_TRY(qcArray_Resize(&surface->nameOf, vertexCount, sizeof(uint32_t), "where a surface is"));
    uint32_t* nameOf = surface->nameOf.data;
    for (uint32_t v = 0; v < vertexCount; v++)
        nameOf[v] = surface->vertexCount;
    for (uint32_t i = 0; i < surface->vertexCount; i++)
        nameOf[QC_AT(uint32_t, surface->vertexOf, i)] = i;
    return qc_statusOk;
}

qcStatus qcTriangleBvh_Note(qcTriangleBvh* surface, const qcBody* body)
{
    size_t count = 3 * (size_t)body->vertexCount;
    qcTriangleBvh_Forget(surface);
    QC_TRY(NameVertices(surface, body->vertexCount));
    QC_TRY(qcArray_Resize(&surface->placeMarks, surface->corners.count, 1, "where a surface is"));
    QC_TRY(qcArray_Resize(&surface->noted, count, sizeof(double), "where a surface is"));
    memset(surface->placeMarks.data, qc_markStill, surface->placeMarks.count);
    memcpy(surface->noted.data, body->world, count * sizeof(double));
    return qc_statusOk;
}

void qcTriangleBvh_Forget(qcTriangleBvh* surface)
{
    surface->noted.count = 0;
    surface->strayed.count = 0;
}

static bool IsInLattice(const qcTriangleBvh* surface, const double x[3])
{
    for (int axis = 0; axis < 3; axis++)
        if (x[axis] < surface->map.origin[axis] ||
            x[axis] + surface->map.margin[axis] - surface->map.origin[axis] > surface->limit[axis])
            return false;
    return true;
}

static qcMotionMark MarkOf(const double from[3], const double to[3], double far)
{
    if (from[0] == to[0] && from[1] == to[1] && from[2] == to[2])
        return qc_markStill;
    double x = fabs(to[0] - from[0]), y = fabs(to[1] - from[1]), z = fabs(to[2] - from[2]);
    double most = x > y ? x : y;
    most = z > most ? z : most;
    // Squares may vanish, or be infinite: where they can't, they are right to 2^-50.
    if (far > 1e-120 && far < 1e120 && most < far)
        return x * x + y * y + z * z <= 0.999 * far * far ? qc_markMoved : qc_markFar;
    return most <= 0.57 * far ? qc_markMoved : qc_markFar; // 1 / sqrt(3)
}

/// Behind those that had strayed before, the vertices that have now. False: too many, or too far.
static bool ListStrayed(qcTriangleBvh* surface, const qcBody* body, size_t room)
{
    const double *noted = surface->noted.data, *now = body->world;
    for (size_t first = 0; first < body->vertexCount; first += qc_compareRun)
    {
        size_t left = body->vertexCount - first, run = left < qc_compareRun ? left : qc_compareRun;
        if (memcmp(noted + 3 * first, now + 3 * first, run * 3 * sizeof(double)) == 0)
            continue;
        for (size_t v = first; v < first + run; v++)
        {
            uint32_t name = QC_AT(uint32_t, surface->nameOf, v);
            if (name == surface->vertexCount || memcmp(noted + 3 * v, now + 3 * v, 3 * sizeof(double)) == 0)
                continue;
            if (surface->strayed.count == room || !IsInLattice(surface, now + 3 * v))
                return false;
            QC_AT(uint32_t, surface->strayed, surface->strayed.count++) = name;
        }
    }
    return true;
}

/// The boxes around a place on all levels, as far as they don't hold the row yet.
static void Grow(qcTriangleBvh* surface, size_t place, const qcBoxRow* row)
{
    qcBox8* groups = surface->groups.data;
    for (uint32_t level = 0; level <= surface->levels; level++, place /= qc_groupSize)
    {
        qcBox8* group =
            level == surface->levels ? &surface->whole : &groups[surface->firstGroup[level] + place / qc_groupSize];
        bool grows = false;
        for (int axis = 0; axis < 3; axis++)
            for (int side = 0; side < 2; side++)
            {
                int16_t* end = &group->ends[axis][side * qc_groupSize + (int)(place % qc_groupSize)];
                grows |= row->ends[4 * side + axis] < *end;
                *end = row->ends[4 * side + axis] < *end ? row->ends[4 * side + axis] : *end;
            }
        if (!grows)
            return;
    }
}

static void MarkStar(qcTriangleBvh* surface, uint32_t vertex, qcMotionMark mark, const qcBoxRow* row)
{
    const uint32_t *first = surface->stars.around.first.data, *places = surface->stars.around.triangles.data;
    uint8_t* marks = surface->placeMarks.data;
    for (uint32_t i = first[vertex]; i < first[vertex + 1]; i++)
    {
        marks[places[i]] = marks[places[i]] > mark ? marks[places[i]] : (uint8_t)mark;
        Grow(surface, places[i], row);
    }
}

/// Marks of the triangles around vertices that strayed before.
static void ClearMarks(qcTriangleBvh* surface, size_t count)
{
    const uint32_t *first = surface->stars.around.first.data, *places = surface->stars.around.triangles.data;
    for (size_t k = 0; k < count; k++)
    {
        uint32_t vertex = QC_AT(uint32_t, surface->strayed, k);
        for (uint32_t i = first[vertex]; i < first[vertex + 1]; i++)
            QC_AT(uint8_t, surface->placeMarks, places[i]) = qc_markStill;
    }
}

qcStatus qcTriangleBvh_Follow(qcTriangleBvh* surface, const qcBody* body, double far, const qcTriangleKernels* kernels,
                              qcBvhScratch* scratch, bool* follows)
{
    *follows = false;
    if (!surface->fitted || surface->noted.count == 0 || !(far > s_leastFar))
        return qc_statusOk;
    size_t before = surface->strayed.count, room = before + surface->vertexCount / qc_strayShare;
    QC_TRY(qcArray_Resize(&scratch->vertices, (size_t)surface->vertexCount + 1, sizeof(qcBoxRow), "moving a surface"));
    QC_TRY(qcArray_Reserve(&surface->strayed, room, sizeof(uint32_t), "moving a surface"));
    if (!ListStrayed(surface, body, room))
    {
        // What strayed before may have come back: the list no longer tells.
        qcTriangleBvh_Forget(surface);
        return qc_statusOk;
    }
    ClearMarks(surface, before);
    for (size_t k = 0; k < surface->strayed.count; k++)
    {
        uint32_t i = QC_AT(uint32_t, surface->strayed, k);
        size_t at = 3 * (size_t)QC_AT(uint32_t, surface->vertexOf, i);
        qcVertexRange one = {body->world, surface->vertexOf.data, i, i + 1};
        kernels->map(&surface->map, &one, surface->points.data, scratch->vertices.data);
        MarkStar(surface, i, MarkOf((const double*)surface->noted.data + at, body->world + at, far),
                 &QC_AT(qcBoxRow, scratch->vertices, i));
    }
    // Vertices that strayed before and still do are in the list twice: what was there before goes.
    if (surface->strayed.count > before)
        memmove(surface->strayed.data, &QC_AT(uint32_t, surface->strayed, before),
                (surface->strayed.count - before) * sizeof(uint32_t));
    surface->strayed.count -= before;
    surface->moved = body->moved;
    surface->flatKnown = false;
    *follows = true;
    return qc_statusOk;
}
