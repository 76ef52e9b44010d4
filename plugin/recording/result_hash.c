// Hashes of the arrays of a result. None of their structs has padding.
#include "quickcullide/recording.h"

#include "quickcullide/hash.h"

#include <assert.h>

static_assert(sizeof(qcPair) == 20 && sizeof(qcSegment) == 48 && sizeof(qcProximity) == 88, "no padding");
static_assert(sizeof(qcContact) == 112 && sizeof(qcManifold) == 16 && sizeof(qcManifoldPoint) == 104, "no padding");

qcResultHash qcResult_Hash(const qcResult* r)
{
    size_t segments = r->segments != NULL ? r->pairCount : 0, proximities = r->proximities != NULL ? r->pairCount : 0;
    return (qcResultHash){
        .pairCount = r->pairCount,
        .pairs = qcXxh64(r->pairs, r->pairCount * sizeof *r->pairs, 0),
        .segments = qcXxh64(r->segments, segments * sizeof *r->segments, 0),
        .proximities = qcXxh64(r->proximities, proximities * sizeof *r->proximities, 0),
        .contactCount = r->contactCount,
        .contacts = qcXxh64(r->contacts, r->contactCount * sizeof *r->contacts, 0),
        .manifoldCount = r->manifoldCount,
        .manifolds = qcXxh64(r->manifolds, r->manifoldCount * sizeof *r->manifolds, 0),
        .manifoldPointCount = r->manifoldPointCount,
        .manifoldPoints = qcXxh64(r->manifoldPoints, r->manifoldPointCount * sizeof *r->manifoldPoints, 0),
    };
}
