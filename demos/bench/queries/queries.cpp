// qc-bench queries: rays, sweeps and boxes on qcMeshShape, beside btBvhTriangleMeshShape.
#include "bench/queries/measure.h"

#include "bench/bench.h"
#include "common/files.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"

#include <cstdio>
#include <iterator>
#include <new>

namespace
{
struct Options
{
    bool meshes[queries::meshCount] = {};
    uint32_t budget = 400;
    uint32_t threads[8] = {1, 2}, threadCount = 2;
    const char* out = "out/bench";
};

const char s_help[] =
    "Rays, convex sweeps, contactTest and box queries on static meshes 60 m long, on qcMeshShape and on "
    "btBvhTriangleMeshShape (quantized) in turns.\v"
    "differ: queries with another result, lost: those among them in which qcMeshShape has no hit or one behind "
    "Bullet's. Batches are those of qcCastRays and qcCastShape. Exit status: as for qc-bench; 1 too if a query is lost "
    "or a batch has other hits than single calls.";

/// Rays and spheres in batches: a line for each, and a line of the CSV for each number of threads.
bool MeasureBatches(const Options& options, int index, queries::Comparison* comparison, FILE* stream)
{
    std::vector<uint32_t> threads(options.threads, options.threads + options.threadCount);
    std::printf("%-22s %10s", "in batches", "one by one");
    for (uint32_t count : threads)
        std::printf(" %7u %s", count, count == 1 ? "thread " : "threads");
    std::printf("\n");
    bool same = true;
    for (const queries::Case& kind : queries::cases)
    {
        bool isSphere = kind.kind == queries::Kind::sphere;
        if ((!isSphere && kind.kind != queries::Kind::closestRay) || kind.misses || qcInterrupt_Signal() != 0)
            continue;
        queries::BatchRow row = comparison->MeasureBatch(kind, threads, options.budget);
        std::printf("%-22s %10.3f", kind.name, row.single);
        for (size_t i = 0; i < threads.size(); i++)
        {
            std::printf(" %15.3f", row.batch[i]);
            std::fprintf(stream, "%s,%s,%u,%u,%.6f,%.6f,%d\n", queries::NameOfMesh(index), kind.name, row.queries,
                         threads[i], row.single, row.batch[i], row.same);
        }
        std::printf("\n");
        std::fflush(stdout);
        same = same && row.same;
    }
    return same;
}

bool MeasureMesh(const Options& options, int index, FILE* stream, FILE* batches)
{
    const char* name = queries::NameOfMesh(index);
    queries::Mesh mesh = queries::MakeMesh(index);
    queries::Comparison comparison(mesh);
    std::printf("\n%s: %zu triangles; built in %.1f ms, Bullet's in %.1f ms\n", name, mesh.indices.size() / 3,
                comparison.oursBuildMs(), comparison.bulletBuildMs());
    std::printf("%-22s %10s %10s %7s %9s %8s %7s %6s\n", "microseconds a query", "ours", "Bullet", "ratio", "hits",
                "queries", "differ", "lost");
    bool right = true;
    for (const queries::Case& kind : queries::cases)
    {
        if (qcInterrupt_Signal() != 0)
            return right;
        queries::Row row = comparison.Measure(kind, options.budget);
        std::printf("%-22s %10.3f %10.3f %7.2f %9.2f %8u %7u %6u\n", kind.name, row.ours, row.bullet, row.ratio,
                    row.hits, row.queries, row.differ, row.lost);
        std::fflush(stdout);
        std::fprintf(stream, "%s,%zu,", name, mesh.indices.size() / 3);
        qcFiles_WriteQuoted(stream, kind.name);
        std::fprintf(stream, ",%.6f,%.6f,%.6f,%.6f,%u,%u,%u\n", row.ours, row.bullet, row.ratio, row.hits, row.queries,
                     row.differ, row.lost);
        right = right && row.lost == 0;
    }
    return MeasureBatches(options, index, &comparison, batches) && right;
}

bool Run(const Options& options, qcMessage* message)
{
    qcInterrupt_Watch();
    qcOutput output, batches;
    if (!qcFiles_Check(options.out, "queries.csv", message) ||
        !qcFiles_Open(options.out, "queries.csv", &output, message))
        return false;
    if (!qcFiles_Open(options.out, "queries_batches.csv", &batches, message))
    {
        qcOutput_Abort(&output);
        return false;
    }
    std::fputs("mesh,triangles,query,ours us,bullet us,ratio,hits,queries,differ,lost\n", output.stream);
    std::fputs("mesh,query,queries,threads,single us,batch us,same\n", batches.stream);
    bool right = true;
    for (int mesh = 0; mesh < queries::meshCount; mesh++)
        if (options.meshes[mesh] && qcInterrupt_Signal() == 0)
            right = MeasureMesh(options, mesh, output.stream, batches.stream) && right;
    bool written = qcOutput_Commit(&output, message);
    return qcOutput_Commit(&batches, message) && written &&
           (right || qcMessage_Fail(message, "qcMeshShape has lost hits, or batches differ from single calls"));
}
} // namespace

extern "C" qcExitStatus qcBench_RunQueries(int argumentCount, char** arguments)
{
    Options options;
    qcWord words[queries::meshCount + 1] = {};
    for (int mesh = 0; mesh < queries::meshCount; mesh++)
        words[mesh] = {queries::NameOfMesh(mesh), mesh};
    const qcOption table[] = {
        {1, "mesh", "NAME", "hills-5k, bunny-70k, hills-500k, or several with commas; all by default",
         qcOption_Marks(options.meshes, queries::meshCount, words)},
        {1, "budget", "MS", "Milliseconds for each row; %s by default", qcOption_Number(&options.budget, 1, 100000)},
        {1, "threads", "LIST", "Numbers of threads for batches; %s by default",
         qcOption_Numbers(options.threads, &options.threadCount, 8, 1, 256, false)},
        {2, "out", "FOLDER", "Where queries.csv and queries_batches.csv go; %s by default, made if it is missing",
         qcOption_Folder(&options.out)},
        {}};
    qcCommandLine line = {table, s_help, nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    qcMessage message;
    try
    {
        if (Run(options, &message))
            return qcInterrupt_ExitStatus();
    }
    catch (const std::bad_alloc&)
    {
        qcMessage_Fail(&message, "out of memory");
    }
    std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return qc_exitFailed;
}
