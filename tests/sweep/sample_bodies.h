// Bodies of all kinds and sizes, for tests of internal functions.
#ifndef QC_TESTS_SWEEP_SAMPLE_BODIES_H
#define QC_TESTS_SWEEP_SAMPLE_BODIES_H

#include "support/check_ok.h"
#include "support/scenes.h"
#include "support/soups.h"
#include "sweep/bvh/triangle_bvh.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

/// Like ck_assert_msg, which writes to a file even if the condition holds.
#define CHECK_THAT(holds, ...)                                                                                         \
    do                                                                                                                 \
    {                                                                                                                  \
        if (!(holds))                                                                                                  \
            ck_abort_msg(__VA_ARGS__);                                                                                 \
    } while (0)

enum
{
    qc_maxKernels = 8
};

/// Runs the following statement with the kernels of each instruction set of this CPU.
#define FOR_EACH_KERNELS(k)                                                                                            \
    for (size_t kernelIndex = 0; kernelIndex < qc_maxKernels; kernelIndex++)                                           \
        for (const qcTriangleKernels* k = qcTriangleKernels_Nth(kernelIndex); k != NULL; k = NULL)

typedef enum qcSoupKind
{
    qc_soupOne,        ///< one triangle
    qc_soupNodeAndOne, ///< 65: one more than a leaf node has
    qc_soupRandom,
    qc_soupDegenerate,
    qc_soupSphere,
    qc_soupCloth,
    qc_soupFlat,  ///< in one plane
    qc_soupLine,  ///< on one line
    qc_soupPoint, ///< all at one point
    qc_soupFan,   ///< around one vertex, more than a fan may have
    qc_soupTwins, ///< each vertex twice: neighbours by position, not by index
    qc_soupKindCount
} qcSoupKind;

/// Coordinates are at most 1.
static inline qcSoup qcMakeSoup(qcSoupKind kind, uint64_t seed)
{
    qcRandom random = {seed};
    qcSoup soup;
    switch (kind)
    {
        case qc_soupOne: return qcSoup_MakeRandom(seed, 1, 0.5);
        case qc_soupNodeAndOne: return qcSoup_MakeRandom(seed, 65, 0.2);
        case qc_soupRandom: return qcSoup_MakeRandom(seed, 300, 0.1);
        case qc_soupDegenerate: return qcSoup_MakeDegenerate(seed, 200, 0.2, 0.5);
        case qc_soupSphere: return qcSoup_MakeSphere(2, 0.5);
        case qc_soupCloth: return qcSoup_MakeFoldedCloth(seed, 12, 0.02, 0.03);
        case qc_soupFlat: return qcSoup_MakeGrid(11);
        case qc_soupFan:
            soup = qcSoup_MakeRandom(seed, 1200, 0.5);
            for (uint32_t t = 0; t < soup.triangleCount; t++)
                soup.indices[3 * t] = 0;
            return soup;
        case qc_soupTwins:
            soup = qcSoup_MakeSphere(2, 0.5);
            for (uint32_t t = 0; t < soup.triangleCount / 2; t++)
                memcpy(soup.indices + 3 * (t + soup.triangleCount / 2), soup.indices + 3 * t, 3 * sizeof(uint32_t));
            // The second half has its own vertices, at the same positions.
            soup.positions = realloc(soup.positions, 6 * sizeof(double) * soup.vertexCount);
            ck_assert_ptr_nonnull(soup.positions);
            memcpy(soup.positions + 3 * (size_t)soup.vertexCount, soup.positions,
                   3 * sizeof(double) * soup.vertexCount);
            for (size_t i = 3 * (size_t)(soup.triangleCount / 2); i < 3 * (size_t)soup.triangleCount; i++)
                soup.indices[i] += soup.vertexCount;
            soup.vertexCount *= 2;
            return soup;
        case qc_soupLine:
        case qc_soupPoint:
        default:
            soup = qcSoup_MakeRandom(seed, 90, 0.2);
            for (uint32_t v = 0; v < soup.vertexCount; v++)
            {
                double at = kind == qc_soupLine ? qcRandom_Uniform(&random, 0.0, 1.0) : 0.25;
                for (size_t axis = 0; axis < 3; axis++)
                    soup.positions[3 * v + axis] = axis == 1 ? 0.5 : at;
            }
            return soup;
    }
}

/// x -> scale x + offset, rounded.
static inline void qcSoup_Place(qcSoup* soup, double scale, double x, double y, double z)
{
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        soup->positions[i] *= scale;
    qcSoup_Translate(soup, x, y, z);
}

/// Returns the slot.
static inline uint32_t qcAddToBodies(qcBodies* bodies, const qcSoup* soup)
{
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    qcBodyId id;
    CHECK_OK(qcBodies_Add(bodies, &def, &id));
    return id.slot;
}

static inline const qcBody* qcBodyAt(const qcBodies* bodies, uint32_t slot)
{
    return &QC_AT(qcBody, bodies->slots, slot);
}

#endif
