// The output of qc-pairs: the pairs as lines, the profile as a readable report or as JSON. The names in the JSON object
// are those of qcProfile and qcPassRecord.
#include "pairs/pairs.h"

#include "common/output_file.h"

#include <iconv.h>
#include <inttypes.h>
#include <json-c/json.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_minTriangles = 10000 ///< for memory by the triangle
};

static void WriteProximity(FILE* stream, const qcProximity* proximity)
{
    // 17 digits: each number can be read back as it is.
    fprintf(stream, " %.17g %.17g", proximity->distance, proximity->depth);
    const double* const vectors[] = {proximity->pointA, proximity->pointB, proximity->normal};
    for (int i = 0; i < 9; ++i)
        fprintf(stream, " %.17g", vectors[i / 3][i % 3]);
}

static void PrintPairs(const qcPairsRun* run, FILE* stream)
{
    for (size_t i = 0; i < run->result->pairCount; ++i)
    {
        const qcPair* pair = &run->result->pairs[i];
        fprintf(stream, "%" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %s", pair->bodyA, pair->triangleA, pair->bodyB,
                pair->triangleB, qcRelation_Name(pair->relation));
        if (run->result->proximities != NULL)
            WriteProximity(stream, &run->result->proximities[i]);
        putc('\n', stream);
    }
}

bool qcPairs_WritePairs(const qcPairsRun* run, qcMessage* message)
{
    if (run->options->pairsOnOutput)
    {
        PrintPairs(run, stdout);
        return true;
    }
    qcOutput output;
    if (!qcOutput_Open(run->options->out, &output, message))
        return false;
    PrintPairs(run, output.stream);
    return qcOutput_Commit(&output, message);
}

//  ---- for a reader --------------------------------------------------------------------------------

static void PrintMeshes(const qcPairsRun* run, FILE* stream)
{
    for (uint32_t i = 0; i < run->options->pathCount; ++i)
        fprintf(stream, "%-12s %s: %" PRIu32 " triangles, %" PRIu32 " vertices\n", i == 0 ? "meshes" : "",
                run->options->paths[i], run->meshes[i].triangleCount, run->meshes[i].vertexCount);
}

static void PrintStages(const qcPairsRun* run, FILE* stream)
{
    uint32_t reps = run->options->reps;
    for (size_t i = 0; i < qc_stageCount; ++i)
    {
        const qcPairsStage* stage = &run->stages[i];
        // Stages that did not run are left out; the total stays.
        if (stage->median < 0.0005 && i + 1 < qc_stageCount)
            continue;
        fprintf(stream, "  %-14s %10.3f ms", stage->name, stage->median);
        if (reps > 1)
            fprintf(stream, " median, %10.3f ms least of %" PRIu32, stage->min, reps);
        putc('\n', stream);
    }
}

static void PrintText(const qcPairsRun* run, FILE* stream)
{
    const qcProfile* profile = &run->result->profile;
    PrintMeshes(run, stream);
    fprintf(stream, "%-12s %s", "method", qcMethod_Name(profile->method));
    if (profile->fallback != NULL)
        fprintf(stream, " instead of %s: %s", qcMethod_Name(run->options->detect.method), profile->fallback);
    fprintf(stream, "\n%-12s %s", "device", profile->device);
    if (strcmp(profile->device, run->deviceInfo.name) == 0 && run->deviceInfo.renderer[0] != 0)
        fprintf(stream, " (%s)", run->deviceInfo.renderer);
    if (profile->resolution != 0)
        fprintf(stream, ", %" PRIu32 " x %" PRIu32 " pixels", profile->resolution, profile->resolution);
    if (profile->columns != 0)
        fprintf(stream,
                "\n%-12s %" PRIu32 " x %" PRIu32 " pixels, %" PRIu32 " slices of depth, %" PRIu64 " fragments, %" PRIu64
                " pairs of triangles",
                "image", profile->columns, profile->rows, profile->slices, profile->fragments, profile->listPairs);
    fprintf(stream, "\n%-12s %zu bytes on the host, %" PRIu64 " on the device", "memory", qcGetByteCount(),
            profile->deviceBytes);
    // What a scene holds without triangles would be most of it.
    if (profile->triangles >= qc_minTriangles)
        fprintf(stream, ", %.1f and %.1f a triangle", (double)qcGetByteCount() / profile->triangles,
                (double)profile->deviceBytes / profile->triangles);
    fprintf(stream, "\n%-12s %" PRIu32 " of %" PRIu32 " bodies, %zu of %" PRIu32 " triangles\n", "PCS",
            profile->objectPcs, profile->bodies, run->result->pcsCount, profile->triangles);
    fprintf(stream, "%-12s %" PRIu64 " pairs of triangles, %" PRIu64 " of them decided in exact arithmetic\n",
            "candidates", profile->candidates, profile->exactFallbacks);
    fprintf(stream, "%-12s %zu: %" PRIu64 " penetrating", "pairs", run->result->pairCount,
            run->relations[qc_relationPenetrating]);
    if (run->options->detect.touching || run->options->detect.margin > 0.0)
        fprintf(stream, ", %" PRIu64 " touching", run->relations[qc_relationTouching]);
    if (run->options->detect.margin > 0.0)
        fprintf(stream, ", %" PRIu64 " near", run->relations[qc_relationNear]);
    fprintf(stream, "\ntime\n");
    PrintStages(run, stream);
}

//  ---- JSON ----------------------------------------------------------------------------------------

static void AddNumber(json_object* object, const char* name, uint64_t value)
{
    json_object_object_add(object, name, json_object_new_uint64(value));
}

static void AddText(json_object* object, const char* name, const char* text)
{
    json_object_object_add(object, name, text != NULL ? json_object_new_string(text) : NULL);
}

/// Names of files may hold any bytes, JSON only UTF-8: each byte that is none becomes U+FFFD.
static void AddPath(json_object* object, const char* name, const char* path)
{
    static const char replacement[] = "\xef\xbf\xbd";
    const size_t length = strlen(path);
    iconv_t converter = iconv_open("UTF-8", "UTF-8");
    char* text = malloc(3 * length + 1);
    if (text == NULL || converter == (iconv_t)-1)
        AddText(object, name, NULL);
    else
    {
        char *from = (char*)path, *to = text;
        size_t fromLeft = length, toLeft = 3 * length;
        while (iconv(converter, &from, &fromLeft, &to, &toLeft) == (size_t)-1 && fromLeft > 0)
        {
            memcpy(to, replacement, 3);
            to += 3;
            toLeft -= 3;
            ++from;
            --fromLeft;
        }
        *to = 0;
        AddText(object, name, text);
    }
    free(text);
    if (converter != (iconv_t)-1)
        iconv_close(converter);
}

static void AddFlag(json_object* object, const char* name, bool value)
{
    json_object_object_add(object, name, json_object_new_boolean(value));
}

static void AddReal(json_object* object, const char* name, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    json_object_object_add(object, name, json_object_new_double_s(value, text));
}

static void AddMs(json_object* object, const char* name, double ms)
{
    // Nanoseconds, the resolution of the clock.
    char text[32];
    snprintf(text, sizeof text, "%.6f", ms);
    json_object_object_add(object, name, json_object_new_double_s(ms, text));
}

static json_object* DescribeMeshes(const qcPairsRun* run)
{
    json_object* meshes = json_object_new_array();
    for (uint32_t i = 0; i < run->options->pathCount; ++i)
    {
        json_object* mesh = json_object_new_object();
        AddPath(mesh, "file", run->options->paths[i]);
        AddNumber(mesh, "vertices", run->meshes[i].vertexCount);
        AddNumber(mesh, "triangles", run->meshes[i].triangleCount);
        AddText(mesh, "positions", run->meshes[i].isDouble ? "double" : "float");
        json_object_array_add(meshes, mesh);
    }
    return meshes;
}

static json_object* DescribeStages(const qcPairsRun* run)
{
    json_object* stages = json_object_new_object();
    for (size_t i = 0; i < qc_stageCount; ++i)
    {
        json_object* stage = json_object_new_object();
        AddMs(stage, "min", run->stages[i].min);
        AddMs(stage, "median", run->stages[i].median);
        json_object_object_add(stages, run->stages[i].name, stage);
    }
    return stages;
}

static json_object* DescribeSkips(const qcProfile* profile)
{
    json_object* skips = json_object_new_object();
    AddNumber(skips, "skippedStaticPairs", profile->skippedStaticPairs);
    AddNumber(skips, "skippedFilteredPairs", profile->skippedFilteredPairs);
    AddNumber(skips, "skippedSetPairs", profile->skippedSetPairs);
    AddNumber(skips, "skippedBodies", profile->skippedBodies);
    AddNumber(skips, "skippedTriangles", profile->skippedTriangles);
    AddNumber(skips, "skippedSetCandidates", profile->skippedSetCandidates);
    AddNumber(skips, "skippedNeighbours", profile->skippedNeighbours);
    AddNumber(skips, "fittedTriangles", profile->fittedTriangles);
    AddNumber(skips, "followedTriangles", profile->followedTriangles);
    AddNumber(skips, "flatTriangles", profile->flatTriangles);
    return skips;
}

static json_object* DescribePass(const qcPassRecord* record)
{
    static const char* levels[] = {"objects", "triangles", "self"};
    json_object* pass = json_object_new_object();
    AddText(pass, "level", levels[record->level]);
    if (record->level == qc_levelSelf)
        AddNumber(pass, "body", record->body);
    AddText(pass, "axis", (const char[]){record->axis, 0});
    AddNumber(pass, "iteration", record->iteration);
    AddNumber(pass, "pass", record->pass);
    AddNumber(pass, "queries", record->queries);
    AddNumber(pass, "rendered", record->rendered);
    AddNumber(pass, "bfv", record->bfv);
    AddNumber(pass, "ffv", record->ffv);
    AddNumber(pass, "sfv", record->sfv);
    AddNumber(pass, "nfv", record->nfv);
    AddNumber(pass, "pcs", record->pcs);
    return pass;
}

static json_object* DescribeRun(const qcPairsRun* run)
{
    const qcProfile* profile = &run->result->profile;
    json_object* object = json_object_new_object();
    json_object_object_add(object, "meshes", DescribeMeshes(run));
    AddText(object, "methodAsked", qcMethod_Name(run->options->detect.method));
    AddText(object, "method", qcMethod_Name(profile->method));
    AddText(object, "fallback", profile->fallback);
    AddReal(object, "margin", run->options->detect.margin);
    AddFlag(object, "backToFront", run->options->detect.backToFront);
    AddFlag(object, "secondPassFromBack", run->options->detect.secondPassFromBack);
    AddFlag(object, "reliable", run->options->detect.reliable);
    AddText(object, "device", profile->device);
    AddText(object, "renderer", run->deviceInfo.renderer);
    AddNumber(object, "bodies", profile->bodies);
    AddNumber(object, "triangles", profile->triangles);
    AddNumber(object, "objectPcs", profile->objectPcs);
    AddNumber(object, "bodyPairs", profile->bodyPairs);
    AddNumber(object, "selfBodies", profile->selfBodies);
    AddNumber(object, "trianglePcs", profile->trianglePcs);
    AddNumber(object, "pcs", run->result->pcsCount);
    AddNumber(object, "candidates", profile->candidates);
    AddNumber(object, "exactFallbacks", profile->exactFallbacks);
    AddNumber(object, "pairs", run->result->pairCount);
    AddNumber(object, "penetrating", run->relations[qc_relationPenetrating]);
    AddNumber(object, "touching", run->relations[qc_relationTouching]);
    AddNumber(object, "near", run->relations[qc_relationNear]);
    AddNumber(object, "resolution", profile->resolution);
    AddNumber(object, "queries", profile->queries);
    AddNumber(object, "rendered", profile->rendered);
    AddNumber(object, "columns", profile->columns);
    AddNumber(object, "rows", profile->rows);
    AddNumber(object, "slices", profile->slices);
    AddNumber(object, "fragments", profile->fragments);
    AddNumber(object, "listPairs", profile->listPairs);
    AddNumber(object, "reruns", profile->reruns);
    AddNumber(object, "uploadedBytes", profile->uploadedBytes);
    AddNumber(object, "hostBytes", qcGetByteCount());
    AddNumber(object, "deviceBytes", profile->deviceBytes);
    AddFlag(object, "softwareDevice", profile->softwareDevice);
    AddNumber(object, "reps", run->options->reps);
    json_object_object_add(object, "milliseconds", DescribeStages(run));
    json_object_object_add(object, "skips", DescribeSkips(profile));
    json_object* passes = json_object_new_array();
    for (size_t i = 0; i < profile->passCount; ++i)
        json_object_array_add(passes, DescribePass(&profile->passes[i]));
    json_object_object_add(object, "passes", passes);
    return object;
}

bool qcPairs_WriteReport(const qcPairsRun* run, qcMessage* message)
{
    if (run->options->json)
    {
        json_object* object = DescribeRun(run);
        int flags = JSON_C_TO_STRING_PRETTY | JSON_C_TO_STRING_NOSLASHESCAPE;
        const char* text = json_object_to_json_string_ext(object, flags);
        bool described = text != NULL;
        if (described)
            puts(text);
        json_object_put(object);
        if (!described)
            return qcMessage_Fail(message, "out of memory for the report");
    }
    else
        PrintText(run, run->options->pairsOnOutput ? stderr : stdout);
    return true;
}
