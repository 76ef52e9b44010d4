// qcProfile::layerTimes on each device.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

static const qcLayerTime* FindPart(const qcProfile* profile, const char* name)
{
    for (size_t i = 0; i < profile->layerTimeCount; i++)
        if (strcmp(profile->layerTimes[i].name, name) == 0)
            return &profile->layerTimes[i];
    ck_abort_msg("no part %s", name);
    return NULL;
}

/// A deforming soup with itself, and a rigid copy of it where that is requested.
static qcScene* MakeScene(qcDevice* device, const qcSoup* soup, bool rigid, qcBodyId* id)
{
    qcScene* scene = qcMakeScene(device);
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(scene, &def, id));
    if (rigid)
        qcAddSoup(scene, soup);
    return scene;
}

static const qcResult* Detect(qcScene* scene, qcMethod method, bool times)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.layerTimes = times;
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    return result;
}

/// Whether the device applies the frame to all vertices. Software GL shares them with the processor, which does.
static bool HasFrameOnDevice(const qcDeviceInfo* info)
{
    const char* refiner = getenv("QC_LAYERS_REFINE");
    return refiner != NULL ? strcmp(refiner, "device") == 0 : !info->software;
}

/// `transforms`: the device has vertices to transform.
static void CheckTimes(const qcProfile* profile, bool transforms)
{
    static const char* const always[] = {"prepare", "hand-over", "upload", "nodes", "wait", "hand-back", "refine"};
    double sum = 0.0;
    for (size_t i = 0; i < profile->layerTimeCount; i++)
    {
        const qcLayerTime* part = &profile->layerTimes[i];
        ck_assert(isfinite(part->threadMs) && isfinite(part->deviceMs));
        ck_assert_msg(part->threadMs >= 0.0 || part->deviceMs < 0.0, "%s ran on the device alone", part->name);
        sum += part->threadMs > 0.0 ? part->threadMs : 0.0;
    }
    for (size_t i = 0; i < sizeof always / sizeof always[0]; i++)
        ck_assert_msg(FindPart(profile, always[i])->threadMs >= 0.0, "%s did not run", always[i]);
    ck_assert((FindPart(profile, "vertices")->threadMs >= 0.0) == transforms);
    // The parts of one stage follow each other on one clock.
    ck_assert_double_gt(sum, 0.0);
    ck_assert_double_le(sum, profile->cullTrianglesMs);
}

START_TEST(a_step_of_layers_reports_its_times_only_on_request)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        CHECK_OK(qcDevice_GetInfo(device, &info));
        for (int rigid = 0; info.compute && rigid < 2; rigid++)
        {
            qcSoup soup = qcSoup_MakeFoldedCloth(77, 12, 0.05, 0.06);
            qcBodyId id;
            qcScene* scene = MakeScene(device, &soup, rigid, &id);
            size_t pairCount = Detect(scene, qc_methodSweep, true)->pairCount;
            ck_assert_uint_eq(Detect(scene, qc_methodSweep, true)->profile.layerTimeCount, 0);
            for (int step = 0; step < 6; step++)
            {
                CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
                bool times = step % 3 != 2;
                const qcResult* result = Detect(scene, qc_methodLayers, times);
                ck_assert_ptr_null(result->profile.fallback);
                ck_assert_uint_eq(result->pairCount, pairCount);
                ck_assert((result->profile.layerTimeCount != 0) == times);
                ck_assert((result->profile.layerTimes != NULL) == times);
                // A rigid body's vertices come into the frame once.
                if (times)
                    CheckTimes(&result->profile, HasFrameOnDevice(&info) || (rigid && step == 0));
            }
            CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
            ck_assert_uint_ne(Detect(scene, qc_methodLayers, true)->profile.layerTimeCount, 0);
            const qcProfile* again = &Detect(scene, qc_methodLayers, true)->profile;
            ck_assert(again->reused && again->layerTimeCount == 0 && again->layerTimes == NULL);
            qcScene_Destroy(scene);
            qcSoup_Free(&soup);
        }
    }
}
END_TEST

QC_RUN_TESTS("layers, times", a_step_of_layers_reports_its_times_only_on_request)
