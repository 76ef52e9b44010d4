// CSV columns and tables of compared queries.
#include "common/bullet/query_report.h"

#include "common/stopwatch.h"

#include <cinttypes>

void qcWriteQueryHeading(FILE* stream)
{
    for (const qcComparedQueryDef& query : qcComparedQueries)
        std::fprintf(stream, ",%s_pcs,%s_found,%s_missed,%s_query_ms", query.column, query.column, query.column,
                     query.column);
}

void qcWriteQueryColumns(FILE* stream, const qcQueryResults& results)
{
    for (const qcQueryResult& result : results)
    {
        if (result.ran)
            std::fprintf(stream, ",%" PRIu32 ",%zu,", result.pcs, result.found);
        else
            std::fprintf(stream, ",,,");
        if (result.counted)
            std::fprintf(stream, "%zu", result.missed);
        if (result.ran)
            std::fprintf(stream, ",%.3f", result.ms);
        else
            std::fprintf(stream, ",");
    }
}

void qcPrintQuerySettings(const qcDetectDef& request, uint32_t resolution, const qcDeviceInfo& device)
{
    if (device.kind == qc_deviceNone)
    {
        std::printf("\n  Without a GL device: no pictures, and the methods were not compared.\n");
        return;
    }
    if (resolution == 0)
    {
        std::printf("\n  No frame was reached on which cullide and quick are compared.\n");
        return;
    }
    std::printf("\nAll methods on the same frames, %s (%s); cullide and quick: views %s, %u x %u pixels, ", device.name,
                device.renderer, request.views, resolution, resolution);
    if (request.iterations == 0)
        std::printf("until nothing changes\n\n");
    else
        std::printf("%u round%s\n\n", request.iterations, request.iterations == 1 ? "" : "s");
}

void qcPrintQueryTable(const char* label, const std::vector<const qcQueryResults*>& frames)
{
    if (frames.empty())
        return;
    std::printf("  %s: %zu frame%s\n", label, frames.size(), frames.size() == 1 ? "" : "s");
    std::printf("    %-34s %10s %10s %8s %8s %10s\n", "", "PCS, mean", "ms, median", "found", "missed", "by device");
    for (size_t i = 0; i < qcComparedQueries.size(); i++)
    {
        double pcs = 0;
        std::vector<double> ms;
        size_t found = 0, missed = 0, byDevice = 0;
        for (const qcQueryResults* frame : frames)
        {
            const qcQueryResult& result = (*frame)[i];
            if (!result.counted)
                continue;
            pcs += double(result.pcs);
            ms.push_back(result.ms);
            found += result.found;
            missed += result.missed;
            byDevice += result.byDevice;
        }
        if (!ms.empty())
            std::printf("    %-34s %10.0f %10.1f %8zu %8zu %10zu\n", qcComparedQueries[i].label,
                        pcs / double(ms.size()), qcStopwatch_Median(ms.data(), ms.size()), found, missed, byDevice);
    }
}
