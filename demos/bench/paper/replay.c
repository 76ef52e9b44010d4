// Reads a recording's frames, and runs them in a scene.
#include "bench/paper/replay.h"

#include "common/stopwatch.h"

#include <string.h>

static bool Fail(const char* path, qcMessage* message)
{
    return qcMessage_Fail(message, "%s: %s", path, qcLastMessage());
}

/// Counts an operation, and the bodies and triangles that are there.
static void Count(const qcOperation* operation, const qcPaperSoup* soup, qcPaperRecordingInfo* info)
{
    if (operation->kind != qc_operationDetect)
        return;
    uint32_t bodies = 0, triangles = 0, own = 0;
    for (uint32_t slot = 0; slot < soup->bodyCount; ++slot)
    {
        bodies += soup->bodies[slot].isThere;
        triangles += soup->bodies[slot].triangleCount;
        own += soup->bodies[slot].selfCollision ? soup->bodies[slot].triangleCount : 0;
    }
    if (info->frameCount == 0)
        info->isOneSoup = 2 * own > triangles;
    info->bodyCount = bodies > info->bodyCount ? bodies : info->bodyCount;
    info->triangleCount = triangles > info->triangleCount ? triangles : info->triangleCount;
    memcpy(info->views, operation->detect.views, sizeof info->views);
    ++info->frameCount;
}

bool qcPaperRecording_Inspect(const char* path, qcPaperRecordingInfo* info, qcMessage* message)
{
    *info = (qcPaperRecordingInfo){0};
    qcRecording* recording = NULL;
    qcPaperSoup soup = {0};
    const qcOperation* operation = NULL;
    bool done = qcRecording_Open(path, &recording) == qc_statusOk || Fail(path, message);
    while (done && (operation == NULL || operation->kind != qc_operationEnd))
    {
        done = qcRecording_Next(recording, &operation) == qc_statusOk || Fail(path, message);
        if (done && !qcPaperSoup_Apply(&soup, operation))
            done = qcMessage_Fail(message, "out of memory");
        if (done)
            Count(operation, &soup, info);
    }
    qcPaperSoup_Free(&soup);
    qcRecording_Close(recording);
    if (done && info->frameCount == 0)
        done = qcMessage_Fail(message, "%s: no detection is recorded", path);
    return done;
}

bool qcPaperReplay_Open(const char* path, qcDevice* device, qcPaperReplay* replay, qcMessage* message)
{
    *replay = (qcPaperReplay){.path = path};
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    return (qcScene_Create(&def, &replay->scene) == qc_statusOk &&
            qcRecording_Open(path, &replay->recording) == qc_statusOk) ||
           Fail(path, message);
}

bool qcPaperReplay_Next(qcPaperReplay* replay, bool* more, qcMessage* message)
{
    replay->moveMs = 0.0;
    for (;;)
    {
        const qcOperation* operation;
        if (qcRecording_Next(replay->recording, &operation) != qc_statusOk)
            return Fail(replay->path, message);
        *more = operation->kind != qc_operationEnd;
        if (!*more)
            return true;
        if (operation->kind == qc_operationDetect)
        {
            if (replay->frameLimit != 0 && replay->nextFrame >= replay->frameLimit)
                return qcMessage_Fail(message, "%s: it has grown since it was opened", replay->path);
            replay->detection = operation;
            replay->frame = replay->nextFrame++;
            return true;
        }
        double start = qcStopwatch_NowMs();
        if (qcOperation_Apply(operation, replay->scene, NULL) != qc_statusOk)
            return Fail(replay->path, message);
        replay->moveMs += qcStopwatch_NowMs() - start;
        if (replay->soup != NULL && !qcPaperSoup_Apply(replay->soup, operation))
            return qcMessage_Fail(message, "out of memory");
    }
}

qcDetectDef qcPaperReplay_PlainDef(const qcPaperReplay* replay)
{
    const qcDetectDef* recorded = &replay->detection->detect;
    qcDetectDef def = qcDefaultDetectDef();
    memcpy(def.views, recorded->views, sizeof def.views);
    def.pairFilter = recorded->pairFilter;
    def.pairFilterContext = recorded->pairFilterContext;
    return def;
}

bool qcPaperReplay_Detect(qcPaperReplay* replay, const qcDetectDef* def, const qcResult** result, double* ms,
                          qcMessage* message)
{
    double start = qcStopwatch_NowMs();
    if (qcScene_Detect(replay->scene, def, result) != qc_statusOk)
        return qcMessage_Fail(message, "%s, frame %u, %s: %s", replay->path, replay->frame, qcMethod_Name(def->method),
                              qcLastMessage());
    *ms = replay->moveMs + qcStopwatch_NowMs() - start;
    return true;
}

void qcPaperReplay_Close(qcPaperReplay* replay)
{
    qcRecording_Close(replay->recording);
    qcScene_Destroy(replay->scene);
    *replay = (qcPaperReplay){0};
}
