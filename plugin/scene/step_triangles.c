// Numbering of a step's triangles.
#include "scene/step_triangles.h"

#include "base/aabb.h"
#include "base/related_pair.h"
#include "base/status.h"
#include "scene/float_positions.h"

#include <string.h>

static qcStatus Number(qcStepTriangles* t, const qcBodies* bodies)
{
    uint64_t total = 0;
    for (size_t slot = 0; slot < bodies->slots.count; slot++)
        if (qcBody_IsUsed(&QC_AT(qcBody, bodies->slots, slot)))
            total += QC_AT(qcBody, bodies->slots, slot).triangleCount;
    if (total > qc_maxStepTriangles)
        return qcFail(qc_statusBadInput, "%llu triangles in one scene: at most %d", (unsigned long long)total,
                      qc_maxStepTriangles);

    t->bodyCount = bodies->count;
    t->count = (uint32_t)total;
    QC_TRY(qcArray_Resize(&t->slots, t->bodyCount, sizeof(uint32_t), "bodies of a step"));
    QC_TRY(qcArray_Resize(&t->first, (size_t)t->bodyCount + 1, sizeof(uint32_t), "bodies of a step"));
    uint32_t blocks = t->count / qc_triangleBlock + (t->count % qc_triangleBlock != 0);
    QC_TRY(qcArray_Resize(&t->blockBody, (size_t)blocks + 1, sizeof(uint32_t), "triangles of a step"));
    uint32_t body = 0, global = 0, block = 0;
    for (uint32_t slot = 0; slot < bodies->slots.count; slot++)
    {
        const qcBody* b = &QC_AT(qcBody, bodies->slots, slot);
        if (!qcBody_IsUsed(b))
            continue;
        QC_AT(uint32_t, t->slots, body) = slot;
        QC_AT(uint32_t, t->first, body) = global;
        global += b->triangleCount;
        for (; block < blocks && block * qc_triangleBlock < global; block++)
            QC_AT(uint32_t, t->blockBody, block) = body;
        if (b->triangleCount != 0)
            QC_AT(uint32_t, t->blockBody, blocks) = body;
        body++;
    }
    QC_AT(uint32_t, t->first, body) = global;
    return qc_statusOk;
}

qcStatus qcStepTriangles_Number(qcStepTriangles* t, const qcBodies* bodies)
{
    t->bodies = bodies;
    if (t->numbered == 0 || t->numbered != bodies->added)
    {
        t->numbered = 0;
        QC_TRY(Number(t, bodies));
        t->numbered = bodies->added;
    }
    return qc_statusOk;
}

void qcStepTriangles_GetBodyBox(const qcStepTriangles* t, uint32_t body, double lower[3], double upper[3])
{
    const qcBody* b = qcStepTriangles_Body(t, body);
    memcpy(lower, b->lower, sizeof b->lower);
    memcpy(upper, b->upper, sizeof b->upper);
    if (t->motion && b->start.differs)
        qcBounds_IncludeBox(b->start.lower, b->start.upper, lower, upper);
}

void qcStepTriangles_GetTriangleBox(const qcStepTriangles* t, uint32_t body, uint32_t triangle, double lower[3],
                                    double upper[3])
{
    const qcBody* b = qcStepTriangles_Body(t, body);
    qcBody_GetTriangleBox(b, triangle, lower, upper);
    if (!t->motion || !b->start.differs)
        return;
    double corners[3][3];
    qcBody_GetStartTriangle(b, triangle, corners);
    for (int c = 0; c < 3; c++)
        qcBounds_IncludePoint(corners[c], lower, upper);
}

void qcStepTriangles_Free(qcStepTriangles* t)
{
    qcArray_Free(&t->slots);
    qcArray_Free(&t->first);
    qcArray_Free(&t->blockBody);
}
