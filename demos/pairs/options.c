// The command line of qc-pairs.
#include "pairs/pairs.h"

#include "common/options.h"
#include "common/output_file.h"

#include <string.h>
#include <strings.h>

static const qcWord s_methods[] = {{"brute", qc_methodBrute},
                                   {"sweep", qc_methodSweep},
                                   {"layers", qc_methodLayers},
                                   {"quick", qc_methodQuick},
                                   {"cullide", qc_methodCullide},
                                   {"auto", qc_methodAuto},
                                   {NULL, 0}};

static bool HasEnding(const char* name, const char* ending)
{
    size_t length = strlen(name);
    return length > strlen(ending) && strcasecmp(name + length - strlen(ending), ending) == 0;
}

/// Rejects what the other methods would ignore.
static void CheckVisibilityOptions(const struct argp_state* state, const qcDetectDef* detect)
{
    const qcDetectDef unset = qcDefaultDetectDef();
    const struct
    {
        const char* name;
        bool isSet;
    } options[] = {
        {"views", strcmp(detect->views, unset.views) != 0},     {"resolution", detect->resolution != unset.resolution},
        {"iterations", detect->iterations != unset.iterations}, {"back-to-front", detect->backToFront},
        {"second-pass-from-back", detect->secondPassFromBack},  {"reliable", detect->reliable}};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; ++i)
        if (options[i].isSet)
            argp_error(state, "--%s: it is for quick and cullide, and the method is %s", options[i].name,
                       qcMethod_Name(detect->method));
}

static void CheckOut(const struct argp_state* state, qcPairsOptions* options)
{
    if (options->out != NULL && (strcmp(options->out, "-") == 0 || strcmp(options->out, "/dev/stdout") == 0))
    {
        options->out = NULL;
        options->pairsOnOutput = true;
    }
    if (options->pairsOnOutput && options->json)
        argp_error(state, "--json: the pairs have standard output; name a file with --out");
    // "--out a.ply b.ply" lacks the name of the output and would replace the mesh.
    if (options->out != NULL && (HasEnding(options->out, ".ply") || HasEnding(options->out, ".obj")))
        argp_error(state, "--out: '%s' is named as a mesh; it would be overwritten with pairs", options->out);
    if (options->out != NULL && options->picture != NULL && qcOutput_IsSame(options->out, options->picture))
        argp_error(state, "--out and --picture name the same file");
    if (options->detect.proximities && options->out == NULL && !options->pairsOnOutput)
        argp_error(state, "--proximities: they are written with the pairs; name a file with --out");
}

static void CheckTogether(const struct argp_state* state, void* context)
{
    qcPairsOptions* options = context;
    if (options->deviceName != NULL)
        options->device = (qcDeviceKind)qcOption_ReadWord(state, "--device", options->deviceName, qcDeviceWords);
    if (options->picture != NULL && !HasEnding(options->picture, ".png"))
        argp_error(state, "--picture: '%s' does not end in .png", options->picture);
    CheckOut(state, options);
    bool samples = options->detect.method == qc_methodQuick || options->detect.method == qc_methodCullide;
    if (!samples)
        CheckVisibilityOptions(state, &options->detect);
    if (samples && options->detect.margin > 0.0 && !options->detect.reliable)
        argp_error(state, "--margin: %s needs --reliable for it", qcMethod_Name(options->detect.method));
}

static const char s_help[] =
    "Finds the triangles of some meshes (PLY or OBJ) that intersect, within each mesh and among them.\v"
    "Exit status: 0 done; 1 output could not be written, or out of memory; 2 a mistake on the command line; 3 a mesh "
    "can't be read: file, line or element are named; 4 the device does not work here, or none can draw the picture.";

void qcPairs_ReadOptions(int argumentCount, char** arguments, qcPairsOptions* options)
{
    *options = (qcPairsOptions){.detect = qcDefaultDetectDef(), .selfCollision = true, .reps = 1};
    qcDetectDef* detect = &options->detect;
    const qcOption rows[] = {
        {1, "method", "METHOD",
         "brute, sweep, layers, quick (Quick-CULLIDE), cullide (CULLIDE) or auto (the default: picks one that never "
         "misses)",
         qcOption_Method(&detect->method, s_methods)},
        {1, "no-self", NULL, "Leave out pairs of triangles of one mesh", qcOption_Flag(&options->selfCollision, false)},
        {1, "touching", NULL, "Report pairs that only touch too", qcOption_Flag(&detect->touching, true)},
        {1, "neighbours", NULL, "Test triangles of one mesh that share a vertex too",
         qcOption_Flag(&detect->neighbours, true)},
        {1, "margin", "D",
         "Report all pairs no further apart than D, touching ones too, decided exactly; D is in the units of the "
         "meshes. 0, the default: pairs that penetrate each other; see --touching",
         qcOption_Length(&detect->margin)},
        {1, "f64", NULL,
         "Keep every digit of the positions, for meshes far from the origin. By default OBJ is read as float, PLY as "
         "what it declares",
         qcOption_Flag(&options->f64, true)},
        {1, "threads", "N", "Threads; 0, the default: one per core", qcOption_Number(&detect->threads, 0, 1024)},
        {1, "device", "DEVICE",
         "What layers, quick and cullide draw with: auto (the default), egl (a GPU), osmesa or surfaceless (software), "
         "or none (sweep then answers for them)",
         qcOption_Text(&options->deviceName)},
        {.group = 2, .help = "For quick and cullide:"},
        {2, "views", "LETTERS", "Axes to look along, in this order; xyz by default", qcOption_Views(&detect->views)},
        {2, "resolution", "N", "Pixels on a side, 1..4096; 4096 by default",
         qcOption_Number(&detect->resolution, 1, 4096)},
        {2, "iterations", "N", "Rounds over the views; 0, the default: until nothing changes",
         qcOption_Number(&detect->iterations, 0, UINT32_MAX)},
        {2, "back-to-front", NULL, "Draw back to front along the view, and not in the order of the file",
         qcOption_Flag(&detect->backToFront, true)},
        {2, "second-pass-from-back", NULL,
         "Look from the other side in the second pass: what is fully behind is culled too",
         qcOption_Flag(&detect->secondPassFromBack, true)},
        {2, "reliable", NULL,
         "Grow triangles by half a pixel and the margin before they are tested, so that nothing is missed. "
         "Self-collision is left to the sweep",
         qcOption_Flag(&detect->reliable, true)},
        {.group = 3, .help = "Output:"},
        {3, "out", "FILE",
         "Write the pairs, a line each, sorted: bodyA triangleA bodyB triangleB penetrating|touching|near. A body is "
         "the number of its MESH, a triangle its number in the file, both from 0; a polygon is read as the triangles "
         "of its fan, a strip (PLY's tristrips) as its triangles without those that name a vertex twice. -: the "
         "pairs go to standard output, and the report to standard error",
         qcOption_Text(&options->out)},
        {3, "proximities", NULL,
         "Write behind each pair: distance depth pointA pointB normal, three numbers a point. The points are the "
         "closest of A and B; depth is how far A has to move along the normal, which points from B to A, until they "
         "only touch",
         qcOption_Flag(&detect->proximities, true)},
        {3, "picture", "FILE.png", "Draw the meshes, the potentially colliding set in red",
         qcOption_Text(&options->picture)},
        {3, "json", NULL, "Report as one JSON object", qcOption_Flag(&options->json, true)},
        {3, "reps", "N", "Detect N times, and report the least and the median time of each stage",
         qcOption_Number(&options->reps, 1, 1000000)},
        {0}};
    qcCommandLine line = {
        .options = rows, .help = s_help, .arguments = "MESH...", .complete = CheckTogether, .context = options};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    options->paths = line.paths;
    options->pathCount = line.pathCount;
    qcCommandLine_KeepFiles(&line, arguments[0], "--out", options->out);
    qcCommandLine_KeepFiles(&line, arguments[0], "--picture", options->picture);
}
