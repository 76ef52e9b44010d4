// The table and the CSV of `qc-bench piles`.
#include "bench/piles/report.h"

#include "common/files.h"

#include <cstdio>

namespace
{
/// The share of collision detection, in percent.
double ShareOf(const qcPilesPhase& phase)
{
    return phase.ms > 0 ? 100 * phase.detectionMs / phase.ms : 0;
}

std::string RestOf(const qcPilesFigures& figures)
{
    char text[64] = "never";
    const size_t restless = figures.RestlessStarts(), starts = figures.ends.size();
    if (restless == 0)
        std::snprintf(text, sizeof text, "%.1f", figures.RestSeconds());
    else if (restless < starts)
        std::snprintf(text, sizeof text, "%zu never", restless);
    return text;
}
} // namespace

const char* qcPilesName(qcPilesContestant contestant)
{
    switch (contestant)
    {
        case qcPilesContestant::ours: return "qcMeshShape";
        case qcPilesContestant::gimpact: return "btGImpactMeshShape";
        default: return "btConvexHullShape";
    }
}

void qcPrintPilesHead(unsigned threads)
{
    std::printf("Threads of qcMeshContact: %s\n\n", threads == 0 ? "one per core" : std::to_string(threads).c_str());
    std::printf("%-10s %-18s %8s %8s %8s %8s %13s %13s %9s %8s %6s %8s %8s\n", "scene", "shapes", "falling,",
                "at rest,", "asleep,", "longest,", "detection, %:", "points:", "deepest,", "under,", "pairs", "at rest",
                "drift,");
    std::printf("%-10s %-18s %8s %8s %8s %8s %13s %13s %9s %8s %6s %8s %8s\n", "", "", "ms", "ms", "ms", "ms",
                "falling, rest", "falling, rest", "mm", "mm", "inside", "from, s", "mm");
}

void qcPrintPiles(const std::vector<qcPilesFigures>& scene)
{
    for (const qcPilesFigures& row : scene)
    {
        const qcPilesPhase &fall = row.phases[qc_pilesFalling], &rest = row.phases[qc_pilesRest],
                           &asleep = row.phases[qc_pilesAsleep];
        std::printf("%-10s %-18s %8.3f %8.3f %8.4f %8.2f %6.0f, %5.0f %6.1f, %5.1f %9.2f %8.2f %6zu %8s %8.2f\n",
                    row.scene->name, qcPilesName(row.contestant), fall.Mean(fall.ms), rest.Mean(rest.ms),
                    asleep.Mean(asleep.ms), row.longestMs, ShareOf(fall), ShareOf(rest), fall.Mean(fall.points),
                    rest.Mean(rest.points), 1e3 * row.deepest, 1e3 * row.underGround, row.penetrating,
                    RestOf(row).c_str(), 1e3 * row.Drift());
    }
    std::printf("\n");
    std::fflush(stdout);
}

void qcPrintPilesEnd()
{
    std::printf("Milliseconds: mean of a step; falling: the first third, at rest: the last one, in which no body "
                "sleeps; asleep: after these, all\nbodies sleep. Detection: its share of the step. Points: in Bullet's "
                "manifolds, mean. Deepest: of the meshes' triangles in each\nother and the bin, without margins, by an "
                "exact query each eighth step; under: the lowest vertex under the ground, a plane, in\nthe same steps; "
                "inside: pairs of triangles that penetrate at the end. At rest from: no body is faster than 0.1 m/s "
                "any\nmore. Drift: the longest way of a body at rest. Of several starts the means, the longest step, "
                "the deepest, all pairs\ninside, the last to come to rest or the number of those that never do, and "
                "the mean drift.\n");
}

bool qcWritePilesCsv(const char* folder, unsigned threads, const std::vector<qcPilesFigures>& rows, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(folder, "piles.csv", &output, message))
        return false;
    std::fputs("scene,shapes,bodies,triangles,threads,steps,falling_ms,rest_ms,asleep_ms,longest_ms,"
               "falling_detection_ms,rest_detection_ms,falling_points,rest_points,deepest,under_ground,penetrating,"
               "rest_seconds,drift,starts,restless\n",
               output.stream);
    for (const qcPilesFigures& row : rows)
    {
        const qcPilesPhase &fall = row.phases[qc_pilesFalling], &rest = row.phases[qc_pilesRest],
                           &asleep = row.phases[qc_pilesAsleep];
        std::fprintf(output.stream,
                     "%s,%s,%zu,%zu,%u,%u,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.6g,%.6g,%zu,%.4g,%.6g,%zu,%zu\n",
                     row.scene->name, qcPilesName(row.contestant), row.bodies, row.triangles, threads,
                     fall.steps + row.phases[qc_pilesSettling].steps + rest.steps, fall.Mean(fall.ms),
                     rest.Mean(rest.ms), asleep.Mean(asleep.ms), row.longestMs, fall.Mean(fall.detectionMs),
                     rest.Mean(rest.detectionMs), fall.Mean(fall.points), rest.Mean(rest.points), row.deepest,
                     row.underGround, row.penetrating, row.RestSeconds(), row.Drift(), row.ends.size(),
                     row.RestlessStarts());
    }
    return qcOutput_Commit(&output, message);
}
