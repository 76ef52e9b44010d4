// All triangles of a step in one numbering, and what is known of each: the PCS.
#ifndef QC_SCENE_STEP_TRIANGLES_H
#define QC_SCENE_STEP_TRIANGLES_H

#include "scene/bodies.h"
#include "scene/visibility_sets.h"

/// Bodies are numbered by slot without gaps, triangles by body, then by index in it: the rank. Pairs sorted by ranks
/// are sorted as the ABI promises.
typedef struct qcStepTriangles
{
    const qcBodies* bodies;
    qcPairFilter filter; ///< of the step; may be null
    void* filterContext;
    uint32_t bodyCount, count;
    uint64_t numbered; ///< qcBodies::added of what the arrays say; 0: nothing
    qcArray slots;     ///< uint32_t: slot of a body
    qcArray first;     ///< uint32_t: rank of a body's first triangle; one more at the end
    qcArray bodyOf;    ///< uint32_t: body of a rank
    qcArray bodySet;   ///< uint8_t: qcVisibilitySet of a body among bodies
    qcArray pcs;       ///< uint8_t: of a rank, see qcStepTriangles_InterSet
} qcStepTriangles;

/// Numbers bodies and triangles; every body is in NFV, every triangle in BFV.
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

/// Of a pair of ranks, whichever comes first: lower << 32 | higher.
static inline uint64_t qcStepTriangles_Key(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static inline uint32_t qcStepTriangles_BodyOf(const qcStepTriangles* t, uint32_t rank)
{
    return QC_AT(uint32_t, t->bodyOf, rank);
}

/// The set of a triangle against triangles of other bodies.
static inline unsigned qcStepTriangles_InterSet(uint8_t pcs)
{
    return pcs & 3u;
}

/// The set of a triangle against triangles of its own body.
static inline unsigned qcStepTriangles_SelfSet(uint8_t pcs)
{
    return pcs >> 2 & 3u;
}

static inline uint8_t qcStepTriangles_Pcs(unsigned interSet, unsigned selfSet)
{
    return (uint8_t)(interSet | selfSet << 2);
}

#endif
