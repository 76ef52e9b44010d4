// Draws the CSV as bars: gnuplot does it, from a script that stays beside the CSV.
#include "bench/peers/peers.h"

#include "common/files.h"
#include "common/output_file.h"

#include <inttypes.h>
#include <string.h>

static const char s_head[] = "# Ours beside peers, drawn from peers.csv beside this file: gnuplot peers.gp\n"
                             "# A row of bars for each number of threads; above the bars, how many times as long as "
                             "ours Embree's best takes.\n";

static const char s_body[] =
    "csv = 'peers.csv'\n"
    "set datafile separator comma\n"
    "set datafile columnheaders\n"
    "place(s, list) = sum [k = 1:words(list)] (word(list, k) eq s ? k : 0)\n"
    "isHere(t, m) = strcol('threads') eq t && strcol('method') eq word(methods, m)\n"
    "count = words(methods)\n"
    "width = 0.8 / count\n"
    "at(m) = place(strcol('scene'), scenes) + (m - 0.5 * (count + 1)) * width\n"
    "\n"
    "cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0\n"
    "ending = cairo ? '.png' : '.svg'\n"
    "high = 420 * words(threads) + 40\n"
    "wide = 400 + 130 * (words(scenes) > 3 ? words(scenes) : 3)\n"
    "if (cairo) { set terminal pngcairo size wide, high font 'sans,11' } \\\n"
    "else { set terminal svg size wide, high font 'sans,11' background 'white' }\n"
    "set output 'peers'.ending\n"
    "\n"
    "set xrange [0.4:words(scenes) + 0.6]\n"
    "set xtics () scale 0 rotate by 0\n"
    "do for [n = 1:words(scenes)] { set xtics add (word(scenes, n).\"\\n\".word(sizes, n) n) }\n"
    "set logscale y\n"
    "set format y '%g'\n"
    "# The bars stand on the lower edge; the ratios need room above the highest.\n"
    "low = 0.5 * least\n"
    "set yrange [low:5 * most]\n"
    "set ytics out nomirror\n"
    "set border 3 lc rgb '#444444'\n"
    "set grid ytics lt 1 lc rgb '#e4e4e4' lw 0.8\n"
    "set style fill solid 1.0 noborder\n"
    "set boxwidth 0.9 * width\n"
    "set key outside right top Left reverse samplen 1.5 spacing 1.2\n"
    "set ylabel 'ms a step: positions in, pairs out'\n"
    "set bmargin 3.5\n"
    "set multiplot layout words(threads), 1 \\\n"
    "    title \"Ours beside peers: median of a step. Above the bars: Embree's best, as a multiple of ours\" font "
    "',12'\n"
    "do for [t in threads] {\n"
    "    set title t eq '1' ? '1 thread' : t.' threads' font ',12'\n"
    "    eval value('labels'.t)\n"
    "    plot for [m = 1:count] csv using (isHere(t, m) ? at(m) : NaN):(column('ms')) \\\n"
    "        with boxes lc rgb word(colors, m) title word(methods, m)\n"
    "    unset label\n"
    "}\n"
    "unset multiplot\n"
    "set output\n"
    "set print '-'\n"
    "print sprintf('Picture: peers%s', ending)\n";

/// A color for each method, by its name: ours stand out, one library's are kin.
static const char* ColorOf(const char* name)
{
    static const char* const colors[][2] = {{"sweep", "#d7191c"},         {"layers", "#1b9e77"},
                                            {"embree-refit", "#08519c"},  {"embree-rebuild", "#4292c6"},
                                            {"embree-medium", "#9ecae1"}, {"bullet-dbvt", "#e6ab02"},
                                            {"cgal-boxes", "#7570b3"}};
    for (size_t i = 0; i < sizeof colors / sizeof colors[0]; ++i)
    {
        if (strcmp(colors[i][0], name) == 0)
            return colors[i][1];
    }
    return "#777777";
}

static bool IsNew(const qcPeersTable* tables, uint32_t table, uint32_t row)
{
    for (uint32_t t = 0; t <= table; ++t)
    {
        for (uint32_t r = 0; r < (t == table ? row : tables[t].rowCount); ++r)
        {
            const qcPeerRow* other = &tables[t].rows[r];
            if (other->skipped[0] == 0 && strcmp(other->entrant.name, tables[table].rows[row].entrant.name) == 0)
                return false;
        }
    }
    return true;
}

static void WriteMethods(FILE* stream, const qcPeersTable* tables, uint32_t tableCount)
{
    for (int list = 0; list < 2; ++list)
    {
        fputs(list == 0 ? "methods = '" : "colors = '", stream);
        for (uint32_t t = 0; t < tableCount; ++t)
        {
            for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            {
                const char* name = tables[t].rows[r].entrant.name;
                if (tables[t].rows[r].skipped[0] == 0 && IsNew(tables, t, r))
                    fprintf(stream, "%s ", list == 0 ? name : ColorOf(name));
            }
        }
        fputs("'\n", stream);
    }
}

static void WriteScenes(FILE* stream, const qcPeersTable* tables, uint32_t tableCount)
{
    fputs("scenes = '", stream);
    for (uint32_t t = 0; t < tableCount; ++t)
        fprintf(stream, "%s ", qcPeerWork_Name(tables[t].work));
    fputs("'\nsizes = '", stream);
    for (uint32_t t = 0; t < tableCount; ++t)
        fprintf(stream, "%" PRIu32 " ", tables[t].triangleCount);
    fputs("'\n", stream);
}

/// The extreme times, and for each number of threads the ratios as labels.
static void WriteTimes(FILE* stream, const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount)
{
    double least = 1e30, most = 0.0;
    fputs("threads = '", stream);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
        fprintf(stream, "%" PRIu32 " ", options->threads[i]);
    fputs("'\n", stream);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        uint32_t threads = options->threads[i];
        fprintf(stream, "labels%" PRIu32 " = \"", threads);
        for (uint32_t t = 0; t < tableCount; ++t)
        {
            double slowest = 0.0;
            for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            {
                const qcPeerRow* row = &tables[t].rows[r];
                if (row->skipped[0] != 0)
                    continue;
                least = row->ms < least ? row->ms : least;
                most = row->ms > most ? row->ms : most;
                if (row->threads == threads && row->ms > slowest)
                    slowest = row->ms;
            }
            const qcPeerRow *ours = qcPeersTable_FindOurs(&tables[t], threads),
                            *embree = qcPeersTable_FindEmbree(&tables[t], threads);
            if (embree != NULL)
                fprintf(stream, "set label '%.3g ×' at %" PRIu32 ", %g center; ", embree->ms / ours->ms, t + 1,
                        1.7 * slowest);
        }
        fputs("\"\n", stream);
    }
    fprintf(stream, "least = %g\nmost = %g\n", least, most);
}

bool qcPeers_Plot(const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount, qcMessage* message)
{
    if (tableCount == 0)
    {
        fprintf(stderr, "nothing ran: no picture\n");
        return true;
    }
    char path[4096];
    snprintf(path, sizeof path, "%s/peers.gp", options->out);
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    fputs(s_head, output.stream);
    WriteScenes(output.stream, tables, tableCount);
    WriteMethods(output.stream, tables, tableCount);
    WriteTimes(output.stream, options, tables, tableCount);
    fputs(s_body, output.stream);
    return qcOutput_Commit(&output, message) && qcFiles_Draw(options->out, "peers.gp", message);
}
