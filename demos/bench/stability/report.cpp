// The table, the CSV and the pictures of long runs.
#include "bench/stability/report.h"

#include "common/files.h"
#include "stability_script.h"

#include <algorithm>
#include <cstdio>

namespace
{
const char s_header[] =
    "scene,step,seconds,energy,contacts,depth,remaining,pairs,soft_pairs,bytes,resident,ms,kinetic,hanging,below";

struct Maxima
{
    int contacts = 0;
    size_t pairs = 0;
    double ms = 0; ///< mean
};

Maxima MaximaOf(const qcStabilityHistory& history)
{
    Maxima maxima;
    for (const qcStabilityRow& row : history.Rows())
    {
        maxima.contacts = std::max(maxima.contacts, row.world.contacts);
        maxima.pairs = std::max(maxima.pairs, row.pairs.all);
        maxima.ms += row.ms / double(history.Rows().size());
    }
    return maxima;
}

/// The first row at rest, if there are two of them; null otherwise.
const qcStabilityRow* FindRest(const qcStabilityHistory& history)
{
    const std::vector<qcStabilityRow>& rows = history.Rows();
    for (size_t i = 0; i + 1 < rows.size(); i++)
        if (rows[i].step >= history.SettledStep())
            return &rows[i];
    return nullptr;
}

std::string VerdictOf(const qcStabilityHistory& history)
{
    if (!history.Complaints().empty())
        return "NOT STABLE";
    if (history.Def().driven != nullptr)
        return std::string("stable; energy not judged: ") + history.Def().driven;
    return history.IsSettled() ? "stable" : "stable, but too short for the energy";
}

/// A text with one number or two.
std::string TextOf(const char* format, double a, double b = 0)
{
    char text[64];
    std::snprintf(text, sizeof text, format, a, b);
    return text;
}
} // namespace

void qcPrintStabilityHead()
{
    std::printf("%-11s %6s %8s %10s %10s %8s %17s %13s %13s %15s %15s %8s  %s\n", "scene", "steps", "seconds",
                "released,", "growth,", "as lift,",
                "deepest, mm:", "penetrating:", "contacts:", "library, KiB:", "process, MiB:", "ms", "verdict");
    std::printf("%-11s %6s %8s %10s %10s %8s %17s %13s %13s %15s %15s %8s\n", "", "", "", "J", "J", "mm",
                "ever > at rest", "max > end", "max > end", "early > late", "early > late", "a step");
}

void qcPrintStabilityRow(const qcStabilityHistory& history)
{
    Maxima maxima = MaximaOf(history);
    const qcStabilityRow& end = history.Rows().back();
    qcStabilityHistory::Memory bytes = history.Bytes(), resident = history.Resident();
    constexpr double kib = 1024, mib = 1024 * 1024;
    bool isJudged = history.IsSettled() && history.Def().driven == nullptr;
    auto judged = [isJudged](const char* format, double value)
    { return isJudged ? TextOf(format, value) : std::string("-"); };
    std::printf("%-11s %6u %8.1f %10.4g %10s %8s %17s %13s %13s %15s %15s %8.3f  %s\n", history.Def().name,
                history.Steps(), history.Seconds(history.Steps()), history.Released(),
                judged("%.3g", history.Growth()).c_str(), judged("%.3g", 1e3 * history.Lift()).c_str(),
                TextOf("%.2f > %.2f", 1e3 * history.DeepestEver(), 1e3 * history.DeepestSettled()).c_str(),
                TextOf("%.0f > %.0f", double(maxima.pairs), double(end.pairs.all)).c_str(),
                TextOf("%.0f > %.0f", double(maxima.contacts), double(end.world.contacts)).c_str(),
                TextOf("%.0f > %.0f", double(bytes.early) / kib, double(bytes.late) / kib).c_str(),
                TextOf("%.1f > %.1f", double(resident.early) / mib, double(resident.late) / mib).c_str(), maxima.ms,
                VerdictOf(history).c_str());
    std::fflush(stdout);
}

void qcPrintStabilityEnd(const std::vector<qcStabilityHistory>& histories)
{
    std::printf(
        "\nReleased: kinetic energy and that of gravity given off since the start; what stretched or bent bodies "
        "store is left out.\n"
        "Growth: its largest rise after the scene has come to rest; lift: by how much that would raise the "
        "whole scene.\n"
        "Deepest: of Bullet's contact points, margins and the thickness of cloth included, before the "
        "response. Penetrating: pairs of\n"
        "triangles of meshes and soft bodies, by the exact test at the end of every row's step. Early, late: "
        "maxima of the second\n"
        "and the last quarter. No body may sleep.\n\n");
    size_t stable = 0;
    for (const qcStabilityHistory& history : histories)
    {
        std::vector<std::string> complaints = history.Complaints();
        stable += complaints.empty();
        for (const std::string& complaint : complaints)
            std::printf("%s: %s\n", history.Def().name, complaint.c_str());
    }
    std::printf("%zu of %zu scenes are stable\n", stable, histories.size());
}

bool qcWriteStabilityCsv(const char* folder, const std::vector<qcStabilityHistory>& histories, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(folder, "stability.csv", &output, message))
        return false;
    std::fprintf(output.stream, "%s\n", s_header);
    for (const qcStabilityHistory& history : histories)
        for (const qcStabilityRow& row : history.Rows())
            std::fprintf(output.stream, "%s,%u,%.4f,%.9g,%d,%.6g,%d,%zu,%zu,%zu,%zu,%.5g,%.6g,%zu,%.6g\n",
                         history.Def().name, row.step, history.Seconds(row.step), row.world.energy, row.world.contacts,
                         row.world.depth, row.remaining, row.pairs.all, row.pairs.soft, row.bytes, row.resident, row.ms,
                         row.world.kinetic, row.support.hanging, row.support.below);
    return qcOutput_Commit(&output, message);
}

bool qcPlotStability(const char* folder, const std::vector<qcStabilityHistory>& histories, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(folder, "stability.gp", &output, message))
        return false;
    size_t count = histories.size();
    std::fprintf(output.stream,
                 "# What was measured.\narray scenes[%zu]\narray titles[%zu]\narray settled[%zu]\narray "
                 "atRest[%zu]\narray isSoft[%zu]\n",
                 count, count, count, count, count);
    for (size_t i = 0; i < count; i++)
    {
        const qcStabilityHistory& history = histories[i];
        const qcStabilityRow* rest = FindRest(history);
        std::fprintf(
            output.stream,
            "scenes[%zu] = '%s'\ntitles[%zu] = '%s: %s'\nsettled[%zu] = %g\natRest[%zu] = %.9g\nisSoft[%zu] = %d\n",
            i + 1, history.Def().name, i + 1, history.Def().name, history.Def().title, i + 1,
            rest != nullptr ? history.Seconds(rest->step) : -1, i + 1, rest != nullptr ? rest->world.energy : 0, i + 1,
            history.Rows().back().remaining >= 0);
    }
    std::fprintf(output.stream, "\n%s", s_stabilityScript);
    return qcOutput_Commit(&output, message) && qcFiles_Draw(folder, "stability.gp", message);
}
