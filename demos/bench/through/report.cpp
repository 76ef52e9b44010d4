// The table of `qc-bench through`.
#include "bench/through/report.h"

#include "common/output_file.h"
#include "through_script.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace
{
// Rounding of sums over thousands of nodes in single precision stays below.
constexpr double s_energyTolerance = 1e-3;

const char s_header[] = "scene,world,precision,hz,runs,failing_runs,steps,ends,inside,tangled,uncertified,unproven,"
                        "exempt,planes,zone_nodes,momentum,energy,detect_ms,respond_ms,step_ms";
constexpr size_t s_columns = 20;

std::vector<std::string> Split(const std::string& line)
{
    std::vector<std::string> fields(1);
    for (char c : line)
        if (c == ',')
            fields.emplace_back();
        else
            fields.back() += c;
    return fields;
}

double NumberOf(const std::string& text)
{
    return text == "-" ? double(NAN) : std::strtod(text.c_str(), nullptr);
}

qcThroughRow RowOf(const std::vector<std::string>& fields)
{
    qcThroughRow row;
    row.scene = fields[0];
    row.world = fields[1];
    row.precision = fields[2];
    row.hz = std::atoi(fields[3].c_str());
    row.runs = std::atoi(fields[4].c_str());
    row.failingRuns = std::atoi(fields[5].c_str());
    size_t* counts[] = {&row.steps, &row.ends, &row.inside, &row.tangled, &row.uncertified, &row.unproven, &row.exempt};
    for (size_t i = 0; i < 7; i++)
        *counts[i] = std::strtoull(fields[6 + i].c_str(), nullptr, 10);
    double* numbers[] = {&row.planes,   &row.zoneNodes, &row.momentum, &row.energy,
                         &row.detectMs, &row.respondMs, &row.stepMs};
    for (size_t i = 0; i < 7; i++)
        *numbers[i] = NumberOf(fields[13 + i]);
    return row;
}

/// "-" for NaN.
std::string TextOf(const char* format, double value)
{
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return std::isnan(value) ? "-" : text;
}

/// "before > now"; "? > now" if there is no row of before.
std::string Both(const qcThroughRow* before, const char* format, double old, double now)
{
    return (before != nullptr ? TextOf(format, old) : std::string("?")) + " > " + TextOf(format, now);
}

std::string RunsOf(const qcThroughRow& row)
{
    return std::to_string(row.failingRuns) + "/" + std::to_string(row.runs);
}
} // namespace

std::vector<qcThroughRow> qcReadThroughCsv(const char* text)
{
    std::vector<qcThroughRow> rows;
    std::string line;
    for (const char* c = text; *c != 0; c++)
    {
        if (*c != '\n')
        {
            line += *c;
            continue;
        }
        std::vector<std::string> fields = Split(line);
        if (line[0] != '#' && fields.size() == s_columns && fields[0] != "scene")
            rows.push_back(RowOf(fields));
        line.clear();
    }
    return rows;
}

const std::vector<qcThroughRow>& qcThroughRowsBefore()
{
    static const std::vector<qcThroughRow> rows = qcReadThroughCsv(s_throughScript);
    return rows;
}

void qcPrintThroughHead()
{
    std::printf("%-49s %-10s %4s | %-14s %-15s %-13s | %-14s %-14s | %7s %7s %8s %7s %7s %6s | %-15s %-14s\n",
                "0.2.0 > this version; pairs: sums over all runs", "world", "Hz", "pairs at ends", "pairs inside",
                "failing runs", "momentum kept", "energy, max", "planes", "zone", "unproven", "uncer-", "tangled",
                "exempt", "detection, ms", "response, ms");
    std::printf("%-49s %-10s %4s | %-14s %-15s %-13s | %-14s %-14s | %7s %7s %8s %7s %7s %6s | %-15s %-14s\n", "", "",
                "", "", "", "", "", "", "a step", "nodes", "", "tified", "", "", "a step", "a step");
}

void qcPrintThroughRow(const qcThroughRow& row)
{
    const std::vector<qcThroughRow>& all = qcThroughRowsBefore();
    auto found = std::find_if(all.begin(), all.end(), [&row](const qcThroughRow& old) { return old.IsOf(row); });
    const qcThroughRow* before = found == all.end() ? nullptr : &*found;
    const qcThroughRow old = before != nullptr ? *before : qcThroughRow();
    const qcThroughScene* scene = qcFindThroughScene(row.scene.c_str());
    std::string name = row.scene + ": " + (scene != nullptr ? scene->title : "");
    std::string failing = (before != nullptr ? RunsOf(old) : "?") + " > " + RunsOf(row);
    std::printf("%-49s %-10s %4d | %-14s %-15s %-13s | %-14s %-14s | %7.4g %7.4g %8zu %7zu %7zu %6zu | %-15s %-14s\n",
                name.c_str(), row.world.c_str(), row.hz,
                Both(before, "%.0f", double(old.ends), double(row.ends)).c_str(),
                Both(before, "%.0f", double(old.inside), double(row.inside)).c_str(), failing.c_str(),
                Both(before, "%.3f", old.momentum, row.momentum).c_str(),
                Both(before, "%.3f", old.energy, row.energy).c_str(), row.planes, row.zoneNodes, row.unproven,
                row.uncertified, row.tangled, row.exempt, Both(before, "%.1f", old.detectMs, row.detectMs).c_str(),
                Both(before, "%.1f", old.respondMs, row.respondMs).c_str());
    std::fflush(stdout);
}

bool qcIsThroughFree(const qcThroughRow& row)
{
    return row.failingRuns == 0;
}

void qcPrintThroughEnd(const std::vector<qcThroughRow>& rows)
{
    size_t free = 0, before = 0, beforeFree = 0;
    for (const qcThroughRow& row : rows)
    {
        free += qcIsThroughFree(row);
        if (row.energy > 1 + s_energyTolerance)
            std::printf("Energy grew: %s, %s, %d Hz, by a factor of %.4f\n", row.scene.c_str(), row.world.c_str(),
                        row.hz, row.energy);
        for (const qcThroughRow& old : qcThroughRowsBefore())
        {
            before += old.IsOf(row);
            beforeFree += old.IsOf(row) && qcIsThroughFree(old);
        }
    }
    std::printf("%zu of %zu rows without a penetrating pair; version 0.2.0: %zu of %zu\n", free, rows.size(),
                beforeFree, before);
}

bool qcWriteThroughCsv(const char* path, const std::vector<qcThroughRow>& rows, qcMessage* message)
{
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    std::fprintf(output.stream, "%s\n", s_header);
    for (const qcThroughRow& row : rows)
        std::fprintf(output.stream, "%s,%s,%s,%d,%d,%d,%zu,%zu,%zu,%zu,%zu,%zu,%zu,%.6g,%.6g,%s,%s,%.4g,%.4g,%.4g\n",
                     row.scene.c_str(), row.world.c_str(), row.precision.c_str(), row.hz, row.runs, row.failingRuns,
                     row.steps, row.ends, row.inside, row.tangled, row.uncertified, row.unproven, row.exempt,
                     row.planes, row.zoneNodes, TextOf("%.6g", row.momentum).c_str(),
                     TextOf("%.6g", row.energy).c_str(), row.detectMs, row.respondMs, row.stepMs);
    return qcOutput_Commit(&output, message);
}
