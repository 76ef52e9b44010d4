// All triangles of a step in one numbering.
#ifndef QC_SCENE_STEP_TRIANGLES_H
#define QC_SCENE_STEP_TRIANGLES_H

#include "scene/bodies.h"

enum
{
    // So that the bodies of all triangles fit into the cache next to a core.
    qc_triangleBlock = 64
};

/// Bodies are numbered without gaps, in the order of their slots; triangles by body, then by index in it: the global
/// triangle index. Pairs sorted by global indices are in the order that the ABI promises. Stages read the numbering and
/// change nothing.
typedef struct qcStepTriangles
{
    const qcBodies* bodies;
    qcPairFilter filter; ///< of the step; may be null
    void* filterContext;
    bool motion;       ///< boxes are those of the motion from the start to the present
    uint64_t maxPairs; ///< of the step; UINT64_MAX: no limit
    uint32_t bodyCount, count;
    uint64_t numbered; ///< qcBodies::added at the last numbering; 0: none yet
    qcArray slots;     ///< uint32_t: slot of a body
    qcArray first;     ///< uint32_t: global index of a body's first triangle; one more at the end
    qcArray blockBody; ///< uint32_t: body of each qc_triangleBlock-th triangle, and of the last one
} qcStepTriangles;

/// Numbers bodies and triangles. O(triangles) after a body came or went, otherwise O(1).
qcStatus qcStepTriangles_Number(qcStepTriangles* triangles, const qcBodies* bodies);
void qcStepTriangles_Free(qcStepTriangles* triangles);

static inline uint32_t qcStepTriangles_Slot(const qcStepTriangles* t, uint32_t body)
{
    return QC_AT(uint32_t, t->slots, body);
}

static inline const qcBody* qcStepTriangles_Body(const qcStepTriangles* t, uint32_t body)
{
    return &QC_AT(qcBody, t->bodies->slots, qcStepTriangles_Slot(t, body));
}

static inline uint32_t qcStepTriangles_First(const qcStepTriangles* t, uint32_t body)
{
    return QC_AT(uint32_t, t->first, body);
}

/// The body of a global triangle index. O(1), but O(log bodies) in a block of many bodies.
static inline uint32_t qcStepTriangles_BodyOf(const qcStepTriangles* t, uint32_t global)
{
    uint32_t low = QC_AT(uint32_t, t->blockBody, global / qc_triangleBlock),
             high = QC_AT(uint32_t, t->blockBody, global / qc_triangleBlock + 1);
    while (low < high)
    {
        uint32_t middle = high - (high - low) / 2;
        if (qcStepTriangles_First(t, middle) <= global)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

/// The box of a body in the step.
void qcStepTriangles_GetBodyBox(const qcStepTriangles* t, uint32_t body, double lower[3], double upper[3]);
/// The box of triangle `triangle` of a body in the step.
void qcStepTriangles_GetTriangleBox(const qcStepTriangles* t, uint32_t body, uint32_t triangle, double lower[3],
                                    double upper[3]);

/// The candidate key of two global triangle indices, in any order: lower << 32 | higher.
static inline uint64_t qcStepTriangles_Key(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

#endif
