// Maps bodies and triangles to image space, and the sets found there to the PCS.
// Quick-CULLIDE, VR 2005, sections 3.2 and 4.2.
#include "cull/visibility/image_cull.h"

#include "base/aabb.h"
#include "base/status.h"

#include <assert.h>
#include <string.h>

/// Whether a level draws a triangle with these packed sets of the PCS. Before a level all triangles of a body have the
/// same.
typedef bool IsDrawn(uint8_t sets);

static bool DrawInter(uint8_t sets)
{
    return qcPcs_InterSet(sets) != qc_setBfv;
}

static bool DrawSelf(uint8_t sets)
{
    return qcPcs_SelfSet(sets) != qc_setBfv;
}

// Doubles far below it are subnormal, and half of a subnormal is rounded.
static const double s_minExtent = 0x1p-960;

/// Half the size of the box in an axis; 0 where it is too small to tell positions apart: then all coincide.
static double HalfExtent(const qcBounds* frame, int axis)
{
    // Halves, so that the extent of a scene as large as double allows is still finite.
    double half = 0.5 * frame->upper[axis] - 0.5 * frame->lower[axis];
    return half > s_minExtent ? half : 0.0;
}

/// From world to image space, and three floats.
typedef struct Scale
{
    double begin[3], half[3]; ///< halves, so that no difference overflows
} Scale;

static Scale MakeScale(const qcBounds* frame)
{
    Scale scale;
    for (int axis = 0; axis < 3; axis++)
    {
        scale.begin[axis] = 0.5 * frame->lower[axis];
        scale.half[axis] = HalfExtent(frame, axis);
    }
    return scale;
}

static void WriteVertex(const Scale* scale, const qcBody* body, uint32_t vertex, float* image)
{
    double position[3];
    qcBody_GetVertex(body, vertex, position);
    for (int axis = 0; axis < 3; axis++)
    {
        double half = scale->half[axis];
        double x = half > 0.0 ? (0.5 * position[axis] - scale->begin[axis]) / half * 2.0 - 1.0 : 0.0;
        image[axis] = (float)(x < -1.0 ? -1.0 : x > 1.0 ? 1.0 : x);
    }
}

/// Writes the nine floats of each triangle of a body. `vertices`: scratch.
static qcStatus WriteCorners(const Scale* scale, const qcBody* body, qcArray* vertices, float* corners)
{
    size_t cornerCount = (size_t)3 * body->triangleCount;
    // A body may use few of its vertices.
    if (body->vertexCount > cornerCount)
    {
        for (size_t i = 0; i < cornerCount; i++)
            WriteVertex(scale, body, body->indices[i], corners + 3 * i);
        return qc_statusOk;
    }
    QC_TRY(qcArray_Resize(vertices, (size_t)3 * body->vertexCount, sizeof(float), "image-space vertices"));
    float* image = vertices->data;
    for (uint32_t v = 0; v < body->vertexCount; v++)
        WriteVertex(scale, body, v, image + (size_t)3 * v);
    for (size_t i = 0; i < cornerCount; i++)
        memcpy(corners + 3 * i, image + (size_t)3 * body->indices[i], 3 * sizeof *corners);
    return qc_statusOk;
}

/// Adds a primitive in the set NFV; there is room.
static void AddPrimitive(qcImageCull* cull, uint32_t firstTriangle, uint32_t triangleCount, uint32_t group)
{
    QC_AT(qcCullPrimitive, cull->primitives, cull->primitives.count++) =
        (qcCullPrimitive){firstTriangle, triangleCount, group};
    QC_AT(qcVisibilitySet, cull->sets, cull->sets.count++) = qc_setNfv;
}

/// The box around the level's bodies: in image space it becomes [-1, 1] in each axis.
static qcBounds FindFrame(const qcImageCull* cull, const qcStepTriangles* triangles)
{
    qcBounds frame;
    qcBounds_Clear(frame.lower, frame.upper);
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, QC_AT(uint32_t, cull->bodies, i));
        qcBounds_IncludeBox(body->lower, body->upper, frame.lower, frame.upper);
    }
    return frame;
}

/// Fills primitives and sets with the level's bodies, whose triangles take part as a whole.
static qcStatus ListPrimitives(const qcStepTriangles* triangles, qcCullLevel level, qcImageCull* cull)
{
    cull->primitives.count = cull->sets.count = 0;
    uint32_t first = 0;
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, QC_AT(uint32_t, cull->bodies, i));
        uint32_t end = first + body->triangleCount;
        size_t room = cull->primitives.count + (level == qc_levelObjects ? 1 : body->triangleCount);
        QC_TRY(qcArray_Reserve(&cull->primitives, room, sizeof(qcCullPrimitive), "image-space primitives"));
        QC_TRY(qcArray_Reserve(&cull->sets, room, sizeof(qcVisibilitySet), "image-space primitives"));
        if (level == qc_levelObjects)
            AddPrimitive(cull, first, body->triangleCount, (uint32_t)i);
        for (uint32_t t = first; level != qc_levelObjects && t < end; t++)
            AddPrimitive(cull, t, 1, level == qc_levelSelf ? t : (uint32_t)i);
        first = end;
    }
    return qc_statusOk;
}

/// Fills the corners with the triangles of the level's bodies.
static qcStatus ListCorners(const qcStepTriangles* triangles, const qcBounds* frame, qcImageCull* cull)
{
    const Scale scale = MakeScale(frame);
    cull->corners.count = 0;
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, QC_AT(uint32_t, cull->bodies, i));
        size_t at = cull->corners.count, count = (size_t)9 * body->triangleCount;
        QC_TRY(qcArray_Resize(&cull->corners, at + count, sizeof(float), "image-space triangles"));
        QC_TRY(WriteCorners(&scale, body, &cull->vertices, (float*)cull->corners.data + at));
    }
    return qc_statusOk;
}

/// Half the margin in image space, rounded up a little.
static double FindGrowth(const qcBounds* frame, int axis, double margin)
{
    double half = HalfExtent(frame, axis);
    return half > 0.0 ? 0.5 * margin / half * (1.0 + 0x1p-40) : 0.0;
}

/// Fills cull->sets, one for each primitive. `slot` names the records of qc_levelSelf.
static qcStatus RunLevel(const qcImageCullJob* job, const qcStepTriangles* triangles, qcCullLevel level, uint32_t slot,
                         qcImageCull* cull)
{
    const qcDetectDef* def = job->def;
    QC_TRY(ListPrimitives(triangles, level, cull));
    if (cull->primitives.count < 2)
        return qc_statusOk; // a single primitive stays in NFV: no other one can hide it
    qcBounds frame = FindFrame(cull, triangles);
    QC_TRY(ListCorners(triangles, &frame, cull));
    qcCullJob twoPass = {.device = job->device,
                         .quick = job->plan->method == qc_methodQuick,
                         .level = level,
                         .body = slot,
                         .views = def->views,
                         .resolution = job->plan->resolution,
                         .iterations = def->iterations,
                         .backToFront = def->backToFront,
                         .secondPassFromBack = def->secondPassFromBack,
                         .reliable = def->reliable,
                         .corners = cull->corners.data,
                         .triangleCount = (uint32_t)(cull->corners.count / 9),
                         .primitives = cull->primitives.data,
                         .primitiveCount = (uint32_t)cull->primitives.count};
    for (int axis = 0; axis < 3; axis++)
        twoPass.growth[axis] = FindGrowth(&frame, axis, def->margin);
    return qcCullVisibility_Run(&twoPass, &cull->scratch, cull->sets.data, &cull->records);
}

static qcStatus AddBody(qcImageCull* cull, uint32_t body)
{
    QC_TRY(qcArray_Reserve(&cull->bodies, cull->bodies.count + 1, sizeof(uint32_t), "bodies in the image"));
    QC_AT(uint32_t, cull->bodies, cull->bodies.count++) = body;
    return qc_statusOk;
}

qcStatus qcImageCull_Bodies(const qcImageCullJob* job, const qcStepTriangles* triangles, qcImageCull* cull, qcPcs* pcs)
{
    cull->records.count = cull->bodies.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (qcStepTriangles_Body(triangles, body)->triangleCount != 0)
            QC_TRY(AddBody(cull, body));
    QC_TRY(RunLevel(job, triangles, qc_levelObjects, 0, cull));
    for (size_t i = 0; i < cull->bodies.count; i++)
        QC_AT(uint8_t, pcs->bodySets, QC_AT(uint32_t, cull->bodies, i)) =
            (uint8_t)QC_AT(qcVisibilitySet, cull->sets, i);
    return qc_statusOk;
}

/// Writes the sets of the level's primitives, one a triangle, to the PCS.
static void StoreSets(const qcImageCull* cull, const qcStepTriangles* triangles, bool self, qcPcs* pcs)
{
    size_t at = 0;
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        uint32_t body = QC_AT(uint32_t, cull->bodies, i);
        for (uint32_t t = qcStepTriangles_First(triangles, body); t < qcStepTriangles_First(triangles, body + 1); t++)
        {
            uint8_t* sets = &QC_AT(uint8_t, pcs->triangleSets, t);
            unsigned inter = qcPcs_InterSet(*sets), own = qcPcs_SelfSet(*sets);
            assert((self ? own : inter) != qc_setBfv);
            unsigned set = QC_AT(qcVisibilitySet, cull->sets, at++);
            *sets = self ? qcPcs_Pack(inter, set) : qcPcs_Pack(set, own);
        }
    }
}

static bool TakesPart(const qcStepTriangles* triangles, const qcPcs* pcs, uint32_t body, IsDrawn* isDrawn)
{
    uint32_t first = qcStepTriangles_First(triangles, body);
    return first != qcStepTriangles_First(triangles, body + 1) && isDrawn(QC_AT(uint8_t, pcs->triangleSets, first));
}

qcStatus qcImageCull_Triangles(const qcImageCullJob* job, const qcStepTriangles* triangles, qcImageCull* cull,
                               qcPcs* pcs)
{
    cull->bodies.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (TakesPart(triangles, pcs, body, DrawInter))
            QC_TRY(AddBody(cull, body));
    if (cull->bodies.count != 0)
    {
        QC_TRY(RunLevel(job, triangles, qc_levelTriangles, 0, cull));
        StoreSets(cull, triangles, false, pcs);
    }
    // Dilated neighbours overlap in every view: no triangle of a mesh would be fully visible.
    if (job->def->reliable)
        return qc_statusOk;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (!TakesPart(triangles, pcs, body, DrawSelf))
            continue;
        cull->bodies.count = 0;
        QC_TRY(AddBody(cull, body));
        QC_TRY(RunLevel(job, triangles, qc_levelSelf, qcStepTriangles_Slot(triangles, body), cull));
        StoreSets(cull, triangles, true, pcs);
    }
    return qc_statusOk;
}

void qcImageCull_Free(qcImageCull* cull)
{
    qcArray_Free(&cull->corners);
    qcArray_Free(&cull->vertices);
    qcArray_Free(&cull->primitives);
    qcArray_Free(&cull->sets);
    qcArray_Free(&cull->bodies);
    qcArray_Free(&cull->records);
    qcCullScratch_Free(&cull->scratch);
}
