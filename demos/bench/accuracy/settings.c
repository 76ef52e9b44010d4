// The settings tried on a scene: a pure function of the options and the scene's size, so that runs on two machines have
// equal rows.
#include "bench/accuracy/accuracy.h"

#include <string.h>

enum
{
    // Brute force takes about a second a 30 000 triangles squared on two cores: half a minute for the pile.
    qc_bruteTriangles = 50000,
    qc_bruteTrianglesFull = 300000,
    // On software GL a view of `quick` costs 10 s and more for a million triangles.
    qc_someTriangles = 100000,
    qc_fewTriangles = 500000,
    qc_noneTriangles = 1000000
};

const qcAccuracySeries qcAccuracySeries_all[qc_accuracySeriesCount] = {
    {{.method = qc_methodCullide}, "cullide", 0x8c6d31},
    {{.method = qc_methodQuick}, "quick, as published", 0xe7298a},
    {{.method = qc_methodQuick, .backToFront = true}, "quick, back to front", 0xd95f02},
    {{.method = qc_methodQuick, .backToFront = true, .secondPassFromBack = true},
     "... and 2nd pass from the back",
     0xe6ab02},
    {{.method = qc_methodQuick, .backToFront = true, .secondPassFromBack = true, .reliable = true},
     "... and reliable",
     0x7570b3},
    {{.method = qc_methodQuick, .secondPassFromBack = true}, "quick, only 2nd pass from the back", 0xa6761d},
    {{.method = qc_methodQuick, .reliable = true}, "quick, only reliable", 0xb3a2d6},
    {{.method = qc_methodQuick, .backToFront = true, .reliable = true}, "quick, back to front, reliable", 0xf4a582},
    {{.method = qc_methodQuick, .secondPassFromBack = true, .reliable = true},
     "quick, 2nd pass from the back, reliable",
     0x9e9ac8},
    {{.method = qc_methodLayers}, "layers", 0x1b9e77},
    {{.method = qc_methodSweep}, "sweep", 0x1f78b4},
    {{.method = qc_methodBrute}, "brute", 0x555555},
};

bool qcAccuracy_IsOf(const qcAccuracySeries* series, const qcAccuracySetting* setting)
{
    const qcAccuracySetting* s = &series->setting;
    return s->method == setting->method && s->backToFront == setting->backToFront &&
           s->secondPassFromBack == setting->secondPassFromBack && s->reliable == setting->reliable;
}

bool qcAccuracy_IsSampled(qcMethod method)
{
    return method == qc_methodCullide || method == qc_methodQuick;
}

static bool CanBrute(const qcAccuracyOptions* options, uint32_t triangleCount)
{
    return triangleCount <= (options->full ? qc_bruteTrianglesFull : qc_bruteTriangles);
}

qcMethod qcAccuracy_ChooseReference(const qcAccuracyOptions* options, uint32_t triangleCount)
{
    return CanBrute(options, triangleCount) ? qc_methodBrute : qc_methodSweep;
}

/// True if a run of a few minutes includes this image of a sampled method. The first scene includes all.
static bool IsKept(int scene, uint32_t triangleCount, uint32_t resolution, const char* views)
{
    size_t viewCount = strlen(views);
    if (scene == 0)
        return true;
    if (triangleCount > qc_noneTriangles)
        return false;
    if (triangleCount > qc_fewTriangles)
        return viewCount == 1 && resolution == 4096;
    if (triangleCount > qc_someTriangles)
        return viewCount == 1 && (resolution == 1024 || resolution == 4096);
    return (viewCount == 1 && (resolution == 256 || resolution == 1024 || resolution == 4096)) ||
           (viewCount == 3 && resolution == 1024);
}

typedef struct List
{
    const qcAccuracyOptions* options;
    int scene;
    uint32_t triangleCount;
    qcAccuracySetting* settings;
    uint32_t count;
} List;

static void AddImages(List* list, const qcAccuracySetting* base)
{
    const qcAccuracyOptions* options = list->options;
    bool layers = base->method == qc_methodLayers;
    const uint32_t* resolutions = layers ? options->layerResolutions : options->resolutions;
    uint32_t count = layers ? options->layerResolutionCount : options->resolutionCount;
    for (uint32_t v = 0; v < options->viewCount; ++v)
    {
        // `layers` draws one view only.
        if (layers && options->views[v][1] != 0)
            continue;
        for (uint32_t r = 0; r < count; ++r)
        {
            if (options->thin && !layers &&
                !IsKept(list->scene, list->triangleCount, resolutions[r], options->views[v]))
                continue;
            qcAccuracySetting* setting = &list->settings[list->count++];
            *setting = *base;
            setting->resolution = resolutions[r];
            memcpy(setting->views, options->views[v], sizeof setting->views);
        }
    }
}

static void AddQuick(List* list)
{
    for (unsigned switches = 0; switches < qc_switchCount; ++switches)
    {
        // 0, 1, 3, 7: as published, then with one more switch each time.
        if (!list->options->full && (switches & (switches + 1)) != 0)
            continue;
        qcAccuracySetting base = {.method = qc_methodQuick,
                                  .backToFront = (switches & 1) != 0,
                                  .secondPassFromBack = (switches & 2) != 0,
                                  .reliable = (switches & 4) != 0};
        AddImages(list, &base);
    }
}

uint32_t qcAccuracy_ListSettings(const qcAccuracyOptions* options, int scene, uint32_t triangleCount,
                                 qcAccuracySetting* settings)
{
    static const qcMethod order[qc_methodCount] = {qc_methodAuto,  qc_methodSweep,   qc_methodLayers,
                                                   qc_methodBrute, qc_methodCullide, qc_methodQuick};
    List list = {options, scene, triangleCount, settings, 0};
    for (int i = 0; i < qc_methodCount; ++i)
    {
        qcAccuracySetting base = {.method = order[i]};
        if (!options->methods[base.method] || (base.method == qc_methodBrute && !CanBrute(options, triangleCount)))
            continue;
        if (!qcAccuracy_IsSampled(base.method))
            list.settings[list.count++] = base;
        if (base.method == qc_methodQuick)
            AddQuick(&list);
        else if (base.method == qc_methodCullide || base.method == qc_methodLayers)
            AddImages(&list, &base);
    }
    return list.count;
}
