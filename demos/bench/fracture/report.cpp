// The table and the CSV of `qc-bench fracture`.
#include "bench/fracture/report.h"

#include "common/files.h"

#include <cstdio>

namespace
{
const char* ShapesOf(const qcFractureRow& row)
{
    return row.hulls ? "hulls" : "meshes";
}
} // namespace

void qcPrintFractureHead()
{
    std::printf("%-7s %4s %6s %38s %26s %7s %22s %8s %8s %6s %7s\n", "shapes", "seed", "pieces",
                "the break, ms:", "after it, ms a step:", "points", "deepest, mm:", "pairs at", "energy,", "awake",
                "at rest");
    std::printf("%-7s %4s %6s %7s %7s %7s %7s %6s %8s %8s %8s %7s %8s %6s %6s %8s %8s %6s %7s\n", "", "", "", "step",
                "cutting", "bodies", "contact", "solver", "first 40", "later", "longest", "", "max", "mean", "floor",
                "the end", "J", "", "after s");
}

void qcPrintFractureRow(const qcFractureRow& row)
{
    char rest[16] = "-", later[16] = "-";
    if (row.restSeconds >= 0)
        std::snprintf(rest, sizeof rest, "%.2f", row.restSeconds);
    if (row.laterMs > 0)
        std::snprintf(later, sizeof later, "%.1f", row.laterMs);
    std::printf(
        "%-7s %4u %6zu %7.1f %7.1f %7.1f %7.1f %6.1f %8.1f %8s %8.1f %7.0f %8.1f %6.2f %6.1f %8zu %8.2f %6zu %7s\n",
        ShapesOf(row), row.seed, row.pieces, row.breakMs, row.cutMs, row.bodiesMs, row.detectionMs, row.solverMs,
        row.firstMs, later, row.longestMs, row.points, 1000 * row.deepest, 1000 * row.meanDepth, 1000 * row.underFloor,
        row.penetrating, row.energy, row.awake, rest);
}

void qcPrintFractureEnd()
{
    std::printf(
        "\nmeshes: qcMeshShape; hulls: btConvexHullShape. Both with a margin of 1 mm.\n"
        "deepest: of an exact detection of the pieces' meshes in every eighth step, the deepest of all steps and "
        "the mean.\n"
        "floor: depth of the lowest vertex under the floor, the largest of all steps.\n"
        "at rest: from the break until the kinetic energy stays below 10 J.\n");
}

bool qcWriteFractureRows(const char* folder, const std::vector<qcFractureRow>& rows, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(folder, "fracture.csv", &output, message))
        return false;
    std::fprintf(output.stream,
                 "shapes,seed,pieces,steps,break_ms,cut_ms,bodies_ms,detection_ms,solver_ms,first_ms,"
                 "later_ms,longest_ms,points,deepest_mm,mean_depth_mm,under_floor_mm,penetrating,energy,awake,"
                 "rest_seconds\n");
    for (const qcFractureRow& row : rows)
        std::fprintf(output.stream,
                     "%s,%u,%zu,%zu,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.6g,%.6g,%.6g,%.6g,%zu,%.6g,%zu,"
                     "%.5g\n",
                     ShapesOf(row), row.seed, row.pieces, row.steps, row.breakMs, row.cutMs, row.bodiesMs,
                     row.detectionMs, row.solverMs, row.firstMs, row.laterMs, row.longestMs, row.points,
                     1000 * row.deepest, 1000 * row.meanDepth, 1000 * row.underFloor, row.penetrating, row.energy,
                     row.awake, row.restSeconds);
    return qcOutput_Commit(&output, message);
}
