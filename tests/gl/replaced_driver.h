// Devices with some functions replaced, so that they behave like other drivers. Shared by the tests of drivers.
#ifndef QC_TESTS_GL_REPLACED_DRIVER_H
#define QC_TESTS_GL_REPLACED_DRIVER_H

#include "gl/device.h"
#include "gl/gl_functions.h"
#include "support/devices.h"
#include "support/scenes.h"

#include <stdio.h>

/// The driver's own functions.
static struct qcGlFunctions s_real;

typedef void qcReplace(struct qcGlFunctions* gl);

typedef struct Replacement
{
    qcReplace* replace;
} Replacement;

static inline qcStatus Replace(const struct qcGlFunctions* gl, void* context)
{
    s_real = *gl;
    // The device's own functions, which are not const.
    ((const Replacement*)context)->replace((struct qcGlFunctions*)gl);
    return qc_statusOk;
}

/// Replaces functions of a device. False: the device has no compute shaders.
static inline bool MakeDriver(qcDevice* device, qcReplace* replace)
{
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    Replacement replacement = {replace};
    CHECK_OK(qcDevice_Run(device, Replace, &replacement, "a test"));
    return info.compute;
}

enum
{
    qc_soupCount = 4
};

typedef struct World
{
    qcScene* scene;
    qcBodyId ids[qc_soupCount];
    uint32_t steps;
} World;

/// Moves every body a little, each along another axis.
static inline void MoveAll(World* world)
{
    world->steps++;
    for (int i = 0; i < qc_soupCount; i++)
    {
        qcTransform transform = qcIdentityTransform();
        transform.translation[i % 3] = 0.3 * i + 0.001 * world->steps;
        CHECK_OK(qcScene_SetTransform(world->scene, world->ids[i], &transform));
    }
}

/// A scene of rigid soups that intersect, of `triangles` of a size each.
static inline World MakeWorldOf(qcDevice* device, uint32_t triangles, double size)
{
    World world = {.scene = qcMakeScene(device)};
    for (int i = 0; i < qc_soupCount; i++)
    {
        qcSoup soup = qcSoup_MakeRandom(7 + (uint64_t)i, triangles, size);
        world.ids[i] = qcAddSoup(world.scene, &soup);
        qcSoup_Free(&soup);
    }
    MoveAll(&world);
    return world;
}

static inline World MakeWorld(qcDevice* device)
{
    return MakeWorldOf(device, 200, 0.15);
}

/// Compares `layers` with the sweep. Returns the reason for the fallback; null: the device found the pairs.
static inline const char* CheckPairs(qcScene* scene, double margin)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.margin = margin;
    def.method = qc_methodSweep;
    qcPairList expected = qcDetectPairs(scene, &def);
    ck_assert_uint_gt(expected.count, 30);
    def.method = qc_methodLayers;
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    qcPairList found = qcListOf(result);
    qcCheckSamePairs(&expected, &found, "layers");
    free(expected.pairs);
    ck_assert_int_eq(result->profile.method, result->profile.fallback == NULL ? qc_methodLayers : qc_methodSweep);
    return result->profile.fallback;
}

/// `fallback`: of CheckPairs. The device has answered.
static inline void CheckAnswered(const char* fallback)
{
    ck_assert_msg(fallback == NULL, "%s", fallback);
}

static inline void CheckReason(const char* fallback, const char* part)
{
    ck_assert_ptr_nonnull(fallback);
    ck_assert_msg(strstr(fallback, part) != NULL, "'%s' lacks '%s'", fallback, part);
}

#endif
