// Frames from the middle of a recording, as an animation: the first ones in a row between which no body comes or goes.
#include "bench/gpu/gpu.h"

#include "bench/paper/replay.h"

#include <stdlib.h>
#include <string.h>

typedef struct Reading
{
    const char* path;
    qcRecording* recording;
    qcPaperSoup soup;
    qcAnimation* animation;
    uint32_t frame, changes; ///< the first of the frames, and qcPaperSoup::changes in it
} Reading;

static bool CopyFloats(const qcPaperSoupBody* body, float** floats)
{
    size_t count = 3 * (size_t)body->vertexCount;
    *floats = malloc((count + 1) * sizeof(float));
    for (size_t i = 0; *floats != NULL && i < count; ++i)
        (*floats)[i] = (float)body->positions[i];
    return *floats != NULL;
}

static bool TakeBody(const qcPaperSoupBody* from, qcAnimation* animation)
{
    uint32_t at = animation->bodyCount++;
    qcMesh* mesh = &animation->bodies[at];
    qcBodyDef* def = &animation->definitions[at];
    *def = qcDefaultBodyDef();
    def->deforming = from->deforming;
    def->selfCollision = from->selfCollision;
    def->group = from->group;
    def->mask = from->mask;
    def->owner = from->owner;
    float* positions = NULL;
    bool made = CopyFloats(from, &positions);
    *mesh = (qcMesh){.positions = positions, .vertexCount = from->vertexCount, .triangleCount = from->triangleCount};
    mesh->indices = malloc((3 * (size_t)from->triangleCount + 1) * sizeof(uint32_t));
    if (mesh->indices != NULL)
        memcpy(mesh->indices, from->indices, 3 * (size_t)from->triangleCount * sizeof(uint32_t));
    animation->triangleCount += from->triangleCount;
    return made && mesh->indices != NULL;
}

/// The bodies that are there, before the first of the frames.
static bool TakeBodies(Reading* reading)
{
    qcAnimation* animation = reading->animation;
    const size_t count = reading->soup.bodyCount + (size_t)1;
    qcAnimation_Free(animation);
    *animation = (qcAnimation){.kind = qc_animatedMixed, .frameCount = qc_gpuFrames};
    animation->bodies = calloc(count, sizeof *animation->bodies);
    animation->definitions = calloc(count, sizeof *animation->definitions);
    animation->positions = calloc(qc_gpuFrames * count, sizeof *animation->positions);
    animation->transforms = calloc(qc_gpuFrames * count, sizeof *animation->transforms);
    bool made = animation->bodies != NULL && animation->definitions != NULL && animation->positions != NULL &&
                animation->transforms != NULL;
    for (uint32_t slot = 0; made && slot < reading->soup.bodyCount; ++slot)
        if (reading->soup.bodies[slot].isThere)
            made = TakeBody(&reading->soup.bodies[slot], animation);
    return made;
}

static bool TakeFrame(Reading* reading, uint32_t frame)
{
    qcAnimation* animation = reading->animation;
    size_t at = (size_t)frame * animation->bodyCount;
    bool made = true;
    for (uint32_t slot = 0; made && slot < reading->soup.bodyCount; ++slot)
    {
        const qcPaperSoupBody* body = &reading->soup.bodies[slot];
        if (!body->isThere)
            continue;
        animation->transforms[at] = body->transform;
        made = !body->deforming || CopyFloats(body, &animation->positions[at]);
        ++at;
    }
    return made;
}

/// Follows the recording up to a detection, the frame of that number. False: it can't be read, or it has ended.
static bool Follow(Reading* reading, qcMessage* message)
{
    const qcOperation* operation = NULL;
    while (operation == NULL || operation->kind != qc_operationDetect)
    {
        if (qcRecording_Next(reading->recording, &operation) != qc_statusOk)
            return qcMessage_Fail(message, "%s: %s", reading->path, qcLastMessage());
        if (operation->kind == qc_operationEnd)
            return qcMessage_Fail(message, "%s: no %d frames with the same bodies", reading->path, qc_gpuFrames);
        if (!qcPaperSoup_Apply(&reading->soup, operation))
            return qcMessage_Fail(message, "out of memory");
    }
    return true;
}

static bool Read(Reading* reading, uint32_t middle, qcMessage* message)
{
    for (uint32_t frame = 0, taken = 0; taken < qc_gpuFrames; ++frame)
    {
        if (!Follow(reading, message))
            return false;
        if (frame < middle)
            continue;
        bool made = true;
        if (taken == 0 || reading->soup.changes != reading->changes)
        {
            taken = 0;
            reading->changes = reading->soup.changes;
            made = TakeBodies(reading);
        }
        if (!made || !TakeFrame(reading, taken++))
            return qcMessage_Fail(message, "out of memory");
    }
    return true;
}

qcBenchMade qcGpuRecorded_Make(const char* path, qcAnimation* animation, qcMessage* message)
{
    qcPaperRecordingInfo info;
    Reading reading = {.path = path, .animation = animation};
    *animation = (qcAnimation){.kind = qc_animatedMixed};
    bool made = qcPaperRecording_Inspect(path, &info, message);
    if (made && qcRecording_Open(path, &reading.recording) != qc_statusOk)
        made = qcMessage_Fail(message, "%s: %s", path, qcLastMessage());
    made = made && Read(&reading, info.frameCount / 2, message);
    qcPaperSoup_Free(&reading.soup);
    qcRecording_Close(reading.recording);
    if (!made)
        qcAnimation_Free(animation);
    return made ? qc_benchMade : qc_benchFailed;
}
