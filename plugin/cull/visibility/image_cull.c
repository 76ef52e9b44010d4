// Puts bodies and triangles into image space, and the sets that come back into the PCS.
// Quick-CULLIDE, VR 2005, sections 3.2 and 4.2.
#include "cull/visibility/image_cull.h"

#include "base/status.h"

#include <string.h>

/// Which triangles of a body a level draws: all, or those whose set in the PCS is not BFV.
typedef bool IsDrawn(uint8_t pcs);

static bool DrawAll(uint8_t pcs)
{
    (void)pcs;
    return true;
}

static bool DrawInter(uint8_t pcs)
{
    return qcStepTriangles_InterSet(pcs) != qc_setBfv;
}

static bool DrawSelf(uint8_t pcs)
{
    return qcStepTriangles_SelfSet(pcs) != qc_setBfv;
}

// Far below it doubles are denormal, and halves of them are rounded.
static const double s_leastExtent = 0x1p-960;

/// From world to image space: the box around the bodies of the level becomes [-1, 1] in each axis.
typedef struct Frame
{
    double lower[3], upper[3];
} Frame;

/// Half the size of the box in an axis; 0 where it is too small to tell places apart: then all are at the same one.
static double HalfExtent(const Frame* frame, int axis)
{
    // Halves, so that the extent of a scene as large as double allows is still finite.
    double half = 0.5 * frame->upper[axis] - 0.5 * frame->lower[axis];
    return half > s_leastExtent ? half : 0.0;
}

static float ToImage(const Frame* frame, int axis, double x)
{
    double half = HalfExtent(frame, axis);
    double place = half > 0.0 ? (0.5 * x - 0.5 * frame->lower[axis]) / half * 2.0 - 1.0 : 0.0;
    return (float)(place < -1.0 ? -1.0 : place > 1.0 ? 1.0 : place);
}

static qcStatus AddCorners(qcCull* cull, const Frame* frame, const qcBody* body, uint32_t triangle)
{
    size_t at = cull->corners.count;
    QC_TRY(qcArray_Reserve(&cull->corners, at + 9, sizeof(float), "image-space triangles"));
    double corners[3][3];
    qcBody_GetTriangle(body, triangle, corners);
    for (int i = 0; i < 9; i++)
        QC_AT(float, cull->corners, at + (size_t)i) = ToImage(frame, i % 3, corners[i / 3][i % 3]);
    cull->corners.count = at + 9;
    return qc_statusOk;
}

static qcStatus AddPrimitive(qcCull* cull, uint32_t firstTriangle, uint32_t triangleCount, uint32_t group)
{
    size_t at = cull->primitives.count;
    QC_TRY(qcArray_Reserve(&cull->primitives, at + 1, sizeof(qcCullPrimitive), "image-space primitives"));
    QC_TRY(qcArray_Reserve(&cull->sets, at + 1, sizeof(qcVisibilitySet), "image-space primitives"));
    QC_AT(qcCullPrimitive, cull->primitives, at) = (qcCullPrimitive){firstTriangle, triangleCount, group};
    QC_AT(qcVisibilitySet, cull->sets, at) = qc_setNfv;
    cull->primitives.count = cull->sets.count = at + 1;
    return qc_statusOk;
}

/// The box around the level's bodies.
static Frame FindFrame(const qcCull* cull, const qcStepTriangles* triangles)
{
    Frame frame = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, QC_AT(uint32_t, cull->bodies, i));
        for (int axis = 0; axis < 3; axis++)
        {
            frame.lower[axis] = i == 0 || body->lower[axis] < frame.lower[axis] ? body->lower[axis] : frame.lower[axis];
            frame.upper[axis] = i == 0 || body->upper[axis] > frame.upper[axis] ? body->upper[axis] : frame.upper[axis];
        }
    }
    return frame;
}

/// Fills corners and primitives with the triangles of the level's bodies.
static qcStatus Gather(qcCull* cull, const qcStepTriangles* triangles, const Frame* frame, qcCullLevel level,
                       IsDrawn* isDrawn)
{
    cull->corners.count = cull->primitives.count = cull->sets.count = 0;
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        uint32_t number = QC_AT(uint32_t, cull->bodies, i), first = qcStepTriangles_First(triangles, number);
        const qcBody* body = qcStepTriangles_Body(triangles, number);
        uint32_t begin = (uint32_t)(cull->corners.count / 9);
        for (uint32_t t = 0; t < body->triangleCount; t++)
        {
            if (!isDrawn(QC_AT(uint8_t, triangles->pcs, first + t)))
                continue;
            uint32_t place = (uint32_t)(cull->corners.count / 9);
            QC_TRY(AddCorners(cull, frame, body, t));
            if (level != qc_levelObjects)
                QC_TRY(AddPrimitive(cull, place, 1, level == qc_levelSelf ? place : (uint32_t)i));
        }
        if (level == qc_levelObjects)
            QC_TRY(AddPrimitive(cull, begin, (uint32_t)(cull->corners.count / 9) - begin, (uint32_t)i));
    }
    return qc_statusOk;
}

/// Half the margin in image space, a little more than less.
static double FindGrowth(const Frame* frame, int axis, double margin)
{
    double half = HalfExtent(frame, axis);
    return half > 0.0 ? 0.5 * margin / half * (1.0 + 0x1p-40) : 0.0;
}

static qcStatus RunLevel(qcCull* cull, const qcStepTriangles* triangles, qcCullLevel level, IsDrawn* isDrawn,
                         uint32_t slot, qcDevice* device, const qcPlan* plan, const qcDetectDef* def)
{
    Frame frame = FindFrame(cull, triangles);
    QC_TRY(Gather(cull, triangles, &frame, level, isDrawn));
    if (cull->primitives.count < 2)
        return qc_statusOk; // nothing to collide with; the caller leaves it in NFV
    qcCullJob job = {.device = device,
                     .quick = plan->method == qc_methodQuick,
                     .level = level,
                     .body = slot,
                     .views = def->views,
                     .resolution = plan->resolution,
                     .iterations = def->iterations,
                     .backToFront = def->backToFront,
                     .secondPassFromBack = def->secondPassFromBack,
                     .reliable = def->reliable,
                     .corners = cull->corners.data,
                     .triangleCount = (uint32_t)(cull->corners.count / 9),
                     .primitives = cull->primitives.data,
                     .primitiveCount = (uint32_t)cull->primitives.count};
    for (int axis = 0; axis < 3; axis++)
        job.growth[axis] = FindGrowth(&frame, axis, def->margin);
    return qcCullVisibility_Run(&job, &cull->scratch, cull->sets.data, &cull->records);
}

static qcStatus TakeBody(qcCull* cull, uint32_t body)
{
    QC_TRY(qcArray_Reserve(&cull->bodies, cull->bodies.count + 1, sizeof(uint32_t), "bodies in the image"));
    QC_AT(uint32_t, cull->bodies, cull->bodies.count++) = body;
    return qc_statusOk;
}

qcStatus qcCull_Objects(qcCull* cull, qcStepTriangles* triangles, qcDevice* device, const qcPlan* plan,
                        const qcDetectDef* def)
{
    cull->records.count = cull->bodies.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (qcStepTriangles_Body(triangles, body)->triangleCount != 0)
            QC_TRY(TakeBody(cull, body));
    QC_TRY(RunLevel(cull, triangles, qc_levelObjects, DrawAll, 0, device, plan, def));
    for (size_t i = 0; i < cull->bodies.count; i++)
        QC_AT(uint8_t, triangles->bodySet, QC_AT(uint32_t, cull->bodies, i)) =
            (uint8_t)QC_AT(qcVisibilitySet, cull->sets, i);
    return qc_statusOk;
}

/// Writes the sets of the level's primitives, triangle by triangle, where they came from.
static void KeepSets(qcCull* cull, qcStepTriangles* triangles, bool self)
{
    size_t at = 0;
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        uint32_t body = QC_AT(uint32_t, cull->bodies, i);
        for (uint32_t r = qcStepTriangles_First(triangles, body); r < qcStepTriangles_First(triangles, body + 1); r++)
        {
            uint8_t* pcs = &QC_AT(uint8_t, triangles->pcs, r);
            unsigned inter = qcStepTriangles_InterSet(*pcs), own = qcStepTriangles_SelfSet(*pcs);
            if ((self ? own : inter) == qc_setBfv)
                continue;
            unsigned set = QC_AT(qcVisibilitySet, cull->sets, at++);
            *pcs = self ? qcStepTriangles_Pcs(inter, set) : qcStepTriangles_Pcs(set, own);
        }
    }
}

static bool TakesPart(const qcStepTriangles* triangles, uint32_t body, bool self)
{
    for (uint32_t r = qcStepTriangles_First(triangles, body); r < qcStepTriangles_First(triangles, body + 1); r++)
    {
        uint8_t pcs = QC_AT(uint8_t, triangles->pcs, r);
        if ((self ? qcStepTriangles_SelfSet(pcs) : qcStepTriangles_InterSet(pcs)) != qc_setBfv)
            return true;
    }
    return false;
}

qcStatus qcCull_Triangles(qcCull* cull, qcStepTriangles* triangles, qcDevice* device, const qcPlan* plan,
                          const qcDetectDef* def)
{
    cull->bodies.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (TakesPart(triangles, body, false))
            QC_TRY(TakeBody(cull, body));
    if (cull->bodies.count != 0)
    {
        QC_TRY(RunLevel(cull, triangles, qc_levelTriangles, DrawInter, 0, device, plan, def));
        KeepSets(cull, triangles, false);
    }
    // Grown, neighbours meet in every view, and nothing of a mesh would be fully visible.
    if (def->reliable)
        return qc_statusOk;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (!TakesPart(triangles, body, true))
            continue;
        cull->bodies.count = 0;
        QC_TRY(TakeBody(cull, body));
        QC_TRY(RunLevel(cull, triangles, qc_levelSelf, DrawSelf, qcStepTriangles_Slot(triangles, body), device, plan,
                        def));
        KeepSets(cull, triangles, true);
    }
    return qc_statusOk;
}

void qcCull_Free(qcCull* cull)
{
    qcArray_Free(&cull->corners);
    qcArray_Free(&cull->primitives);
    qcArray_Free(&cull->sets);
    qcArray_Free(&cull->bodies);
    qcArray_Free(&cull->records);
    qcCullScratch_Free(&cull->scratch);
}
