// A pair of triangles and its relation in one word. Their order is that of the pairs' keys.
#ifndef QC_BASE_RELATED_PAIR_H
#define QC_BASE_RELATED_PAIR_H

#include "quickcullide/scene.h"

enum
{
    /// The most triangles of a step: two indices and a relation fit into 64 bits, and counts of up to seven things for
    /// each triangle into 32.
    qc_maxStepTriangles = 1 << 29
};

/// Fails if there are more pairs than allowed.
qcStatus qcRelatedPair_CheckCount(uint64_t count, uint64_t maxPairs);

/// `key`: lower global triangle index << 32 | higher one.
static inline uint64_t qcRelatedPair_Make(uint64_t key, qcRelation relation)
{
    return (key >> 32) << 33 | (key & UINT32_MAX) << 2 | (uint64_t)relation;
}

static inline uint64_t qcRelatedPair_Key(uint64_t pair)
{
    return (pair >> 33) << 32 | (pair >> 2 & INT32_MAX);
}

static inline qcRelation qcRelatedPair_Relation(uint64_t pair)
{
    return (qcRelation)(pair & 3);
}

#endif
