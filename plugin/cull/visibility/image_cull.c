// Maps bodies and triangles to image space, and the sets found there to the PCS.
// Quick-CULLIDE, VR 2005, sections 3.2 and 4.2.
#include "cull/visibility/image_cull.h"

#include "base/status.h"

#include <assert.h>

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

/// From world to image space: the box around the bodies of the level becomes [-1, 1] in each axis.
typedef struct Frame
{
    double lower[3], upper[3];
} Frame;

/// Half the size of the box in an axis; 0 where it is too small to tell positions apart: then all coincide.
static double HalfExtent(const Frame* frame, int axis)
{
    // Halves, so that the extent of a scene as large as double allows is still finite.
    double half = 0.5 * frame->upper[axis] - 0.5 * frame->lower[axis];
    return half > s_minExtent ? half : 0.0;
}

static float ToImage(const Frame* frame, int axis, double x)
{
    double half = HalfExtent(frame, axis);
    double inImage = half > 0.0 ? (0.5 * x - 0.5 * frame->lower[axis]) / half * 2.0 - 1.0 : 0.0;
    return (float)(inImage < -1.0 ? -1.0 : inImage > 1.0 ? 1.0 : inImage);
}

static qcStatus AddCorners(qcImageCull* cull, const Frame* frame, const qcBody* body, uint32_t triangle)
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

static qcStatus AddPrimitive(qcImageCull* cull, uint32_t firstTriangle, uint32_t triangleCount, uint32_t group)
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
static Frame FindFrame(const qcImageCull* cull, const qcStepTriangles* triangles)
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

/// Fills corners and primitives with the triangles of the level's bodies, which take part as a whole.
static qcStatus Gather(const qcStepTriangles* triangles, const Frame* frame, qcCullLevel level, qcImageCull* cull)
{
    cull->corners.count = cull->primitives.count = cull->sets.count = 0;
    for (size_t i = 0; i < cull->bodies.count; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, QC_AT(uint32_t, cull->bodies, i));
        uint32_t begin = (uint32_t)(cull->corners.count / 9);
        for (uint32_t t = 0; t < body->triangleCount; t++)
        {
            uint32_t drawn = (uint32_t)(cull->corners.count / 9);
            QC_TRY(AddCorners(cull, frame, body, t));
            if (level != qc_levelObjects)
                QC_TRY(AddPrimitive(cull, drawn, 1, level == qc_levelSelf ? drawn : (uint32_t)i));
        }
        if (level == qc_levelObjects)
            QC_TRY(AddPrimitive(cull, begin, (uint32_t)(cull->corners.count / 9) - begin, (uint32_t)i));
    }
    return qc_statusOk;
}

/// Half the margin in image space, rounded up a little.
static double FindGrowth(const Frame* frame, int axis, double margin)
{
    double half = HalfExtent(frame, axis);
    return half > 0.0 ? 0.5 * margin / half * (1.0 + 0x1p-40) : 0.0;
}

/// Fills cull->sets, one for each primitive. `slot` names the records of qc_levelSelf.
static qcStatus RunLevel(const qcImageCullJob* job, const qcStepTriangles* triangles, qcCullLevel level, uint32_t slot,
                         qcImageCull* cull)
{
    const qcDetectDef* def = job->def;
    Frame frame = FindFrame(cull, triangles);
    QC_TRY(Gather(triangles, &frame, level, cull));
    if (cull->primitives.count < 2)
        return qc_statusOk; // a single primitive stays in NFV: no other one can hide it
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
    qcArray_Free(&cull->primitives);
    qcArray_Free(&cull->sets);
    qcArray_Free(&cull->bodies);
    qcArray_Free(&cull->records);
    qcCullScratch_Free(&cull->scratch);
}
