// The command line of qc-pairs. A word that is not known is refused with the words that are.
#include "pairs/pairs.h"

#include "common/option_values.h"

#include <string.h>
#include <strings.h>

enum
{
    qc_maxResolution = 4096,
    qc_maxReps = 1000000
};

typedef enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_method = 256,
    key_device,
    key_out,
    key_picture,
    key_views,
    key_resolution,
    key_iterations,
    key_noSelf,
    key_touching,
    key_neighbours,
    key_margin,
    key_proximities,
    key_f64,
    key_backToFront,
    key_secondPassFromBack,
    key_reliable,
    key_threads,
    key_reps,
    key_json
} OptionKey;

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

static void CheckTogether(const struct argp_state* state, const qcPairsOptions* options)
{
    // "--out a.ply b.ply" forgot the output's name; it would replace the mesh.
    if (options->out != NULL && (HasEnding(options->out, ".ply") || HasEnding(options->out, ".obj")))
        argp_error(state, "--out: '%s' is named as a mesh; it would be overwritten with pairs", options->out);
    if (options->picture != NULL && !HasEnding(options->picture, ".png"))
        argp_error(state, "--picture: '%s' does not end in .png", options->picture);
    if (options->out != NULL && options->picture != NULL && strcmp(options->out, options->picture) == 0)
        argp_error(state, "--out and --picture name the same file");
    if (options->detect.proximities && options->out == NULL)
        argp_error(state, "--proximities: they are written with the pairs; name a file with --out");
    bool samples = options->detect.method == qc_methodQuick || options->detect.method == qc_methodCullide;
    if (samples && options->detect.margin > 0.0 && !options->detect.reliable)
        argp_error(state, "--margin: %s needs --reliable for it", qcMethod_Name(options->detect.method));
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    qcPairsOptions* options = state->input;
    switch (key)
    {
        case key_method:
            options->detect.method = (qcMethod)qcOption_ReadWord(state, "--method", text, s_methods);
            return 0;
        case key_device:
            options->device = (qcDeviceKind)qcOption_ReadWord(state, "--device", text, qcDeviceWords);
            options->deviceNamed = true;
            return 0;
        case key_views: qcOption_ReadViews(state, "--views", text, options->detect.views); return 0;
        case key_resolution:
            options->detect.resolution = qcOption_ReadNumber(state, "--resolution", text, 1, qc_maxResolution);
            return 0;
        case key_iterations:
            options->detect.iterations = qcOption_ReadNumber(state, "--iterations", text, 0, UINT32_MAX);
            return 0;
        case key_noSelf: options->selfCollision = false; return 0;
        case key_touching: options->detect.touching = true; return 0;
        case key_neighbours: options->detect.neighbours = true; return 0;
        case key_margin: options->detect.margin = qcOption_ReadLength(state, "--margin", text); return 0;
        case key_proximities: options->detect.proximities = true; return 0;
        case key_f64: options->f64 = true; return 0;
        case key_backToFront: options->detect.backToFront = true; return 0;
        case key_secondPassFromBack: options->detect.secondPassFromBack = true; return 0;
        case key_reliable: options->detect.reliable = true; return 0;
        case key_threads: options->detect.threads = qcOption_ReadNumber(state, "--threads", text, 0, 1024); return 0;
        case key_reps: options->reps = qcOption_ReadNumber(state, "--reps", text, 1, qc_maxReps); return 0;
        case key_json: options->json = true; return 0;
        case key_out: options->out = text; return 0;
        case key_picture: options->picture = text; return 0;
        case ARGP_KEY_ARGS:
            options->paths = state->argv + state->next;
            options->pathCount = (uint32_t)(state->argc - state->next);
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "no MESH is named"); return 0;
        case ARGP_KEY_END: CheckTogether(state, options); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option s_options[] = {
    {"method", key_method, "METHOD", 0,
     "brute, sweep, layers, quick (Quick-CULLIDE), cullide (CULLIDE) or auto (the default: picks one that never "
     "misses)",
     1},
    {"no-self", key_noSelf, NULL, 0, "Leave out triangles of one mesh that meet each other", 1},
    {"touching", key_touching, NULL, 0, "Report pairs that only touch too", 1},
    {"neighbours", key_neighbours, NULL, 0, "Test triangles of one mesh that share a vertex too", 1},
    {"margin", key_margin, "D", 0,
     "Report all pairs no further apart than D, touching ones too, decided exactly; D is in the units of the meshes. "
     "0, the default: pairs that meet",
     1},
    {"f64", key_f64, NULL, 0,
     "Keep every digit of the positions, for meshes far from the origin. By default OBJ is read as float, PLY as what "
     "it "
     "declares",
     1},
    {"threads", key_threads, "N", 0, "Threads; 0, the default: one per core", 1},
    {"device", key_device, "DEVICE", 0,
     "What layers, quick and cullide draw with: auto (the default), egl (a GPU), osmesa or surfaceless (software), or "
     "none (sweep then answers for them)",
     1},
    {NULL, 0, NULL, 0, "For quick and cullide:", 2},
    {"views", key_views, "LETTERS", 0, "Axes to look along, in this order; xyz by default", 2},
    {"resolution", key_resolution, "N", 0, "Pixels on a side, 1..4096; 4096 by default", 2},
    {"iterations", key_iterations, "N", 0, "Rounds over the views; 0, the default: until nothing changes", 2},
    {"back-to-front", key_backToFront, NULL, 0, "Draw back to front along the view, and not in the order of the file",
     2},
    {"second-pass-from-back", key_secondPassFromBack, NULL, 0,
     "Look from the other side in the second pass: what is fully behind is culled too", 2},
    {"reliable", key_reliable, NULL, 0,
     "Grow triangles by half a pixel and the margin before they are tested, so that nothing is missed. Self-collision "
     "is "
     "left to the sweep",
     2},
    {NULL, 0, NULL, 0, "Output:", 3},
    {"out", key_out, "FILE", 0,
     "Write the pairs, a line each, sorted: bodyA triangleA bodyB triangleB penetrating|touching|near. A body is the "
     "number of its MESH, a triangle its number in the file, both from 0; a polygon counts as the triangles of its "
     "fan, "
     "a strip (PLY's tristrips) as its triangles without those that name a vertex twice",
     3},
    {"proximities", key_proximities, NULL, 0,
     "Write behind each pair: distance depth pointA pointB normal, three numbers a point. The points are the closest "
     "of "
     "A and B; depth is how far A has to move along the normal, which points from B to A, until they only touch",
     3},
    {"picture", key_picture, "FILE.png", 0, "Draw the meshes, the potentially colliding set in red", 3},
    {"json", key_json, NULL, 0, "Report as one JSON object", 3},
    {"reps", key_reps, "N", 0, "Detect N times, and report the least and the median time of each stage", 3},
    {0}};

static const char s_help[] =
    "Finds the triangles of some meshes (PLY or OBJ) that intersect, within each mesh and among them.\v"
    "Exit status: 0 done; 1 output could not be written, or out of memory; 2 a mistake on the command line; 3 a mesh "
    "can't be read: file, line or element are named; 4 the device does not work here, or none can draw the picture.";

void qcPairs_ReadOptions(int argumentCount, char** arguments, qcPairsOptions* options)
{
    static const struct argp parser = {s_options, ReadOption, "MESH...", s_help, NULL, NULL, NULL};
    *options = (qcPairsOptions){.detect = qcDefaultDetectDef(), .selfCollision = true, .reps = 1};
    argp_err_exit_status = qc_exitUsage;
    argp_parse(&parser, argumentCount, arguments, 0, NULL, options);
}
