// Helpers of tests of the C API: soups as bodies of a scene, comparison of results.
#ifndef QC_TESTS_SUPPORT_SCENES_H
#define QC_TESTS_SUPPORT_SCENES_H

#include "support/check_ok.h"
#include "quickcullide/quickcullide.h"
#include "support/soups.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

static inline qcBodyDef qcBodyDefOf(const qcSoup* soup)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = soup->positions;
    def.positionType = qc_positionF64;
    def.vertexCount = soup->vertexCount;
    def.indices = soup->indices;
    def.triangleCount = soup->triangleCount;
    return def;
}

static inline qcScene* qcMakeScene(qcDevice* device)
{
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    qcScene* scene = NULL;
    CHECK_OK(qcScene_Create(&def, &scene));
    return scene;
}

static inline qcBodyId qcAddSoup(qcScene* scene, const qcSoup* soup)
{
    qcBodyDef def = qcBodyDefOf(soup);
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

static inline qcBodyId qcAddDeformingSoup(qcScene* scene, const qcSoup* soup)
{
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

/// Runs so many steps that the sweep has built all that it keeps of a body: it builds the adjacency of triangles in
/// parts, one a step.
static inline void qcLetBodiesLive(qcScene* scene, qcDetectDef def)
{
    for (int step = 0; step < 40; step++)
    {
        // Another request in each step: the last result is not reused.
        const qcResult* result;
        def.candidates = step % 2 == 0;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
    }
}

/// A copy of a result's pairs, since the next detection overwrites them.
typedef struct qcPairList
{
    qcPair* pairs;
    size_t count;
} qcPairList;

/// A result's own pairs, not copied.
static inline qcPairList qcListOf(const qcResult* result)
{
    return (qcPairList){(qcPair*)result->pairs, result->pairCount};
}

static inline qcPairList qcDetectPairs(qcScene* scene, const qcDetectDef* def)
{
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(scene, def, &result));
    qcPairList list = {malloc((result->pairCount + 1) * sizeof(qcPair)), result->pairCount};
    if (list.count != 0)
        memcpy(list.pairs, result->pairs, list.count * sizeof(qcPair));
    return list;
}

static inline int qcComparePairs(const void* x, const void* y)
{
    const qcPair *a = x, *b = y;
    const uint32_t p[4] = {a->bodyA, a->triangleA, a->bodyB, a->triangleB};
    const uint32_t q[4] = {b->bodyA, b->triangleA, b->bodyB, b->triangleB};
    for (int i = 0; i < 4; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return 0;
}

/// Checks that both have the same pairs; reports the first difference.
static inline void qcCheckSamePairs(const qcPairList* expected, const qcPairList* found, const char* what)
{
    for (size_t i = 0; i < expected->count && i < found->count; i++)
    {
        const qcPair *e = &expected->pairs[i], *f = &found->pairs[i];
        // No assertion for each: passing ones write to a file.
        if (qcComparePairs(e, f) != 0 || e->relation != f->relation)
            ck_abort_msg("%s: pair %zu is %u %u %u %u %s, expected %u %u %u %u %s", what, i, f->bodyA, f->triangleA,
                         f->bodyB, f->triangleB, qcRelation_Name(f->relation), e->bodyA, e->triangleA, e->bodyB,
                         e->triangleB, qcRelation_Name(e->relation));
    }
    ck_assert_msg(expected->count == found->count, "%s: %zu pairs, expected %zu", what, found->count, expected->count);
}

#endif
