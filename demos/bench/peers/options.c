// The command line of `qc-bench peers`.
#include "bench/peers/peers.h"

#include "common/options.h"

static const char s_help[] =
    "Our sweep beside other libraries: Embree's rtcCollide, Bullet's btDbvt, CGAL's box_intersection_d, as far as they "
    "were installed when this was built. All get the same meshes in the same run, and a triangle test that is as exact "
    "as ours, so that all must find the same pairs. A step is new positions in (vertices move by 0.3 % of the "
    "scene's diagonal, rigid bodies by that of their own), pairs out.\v"
    "The environment variable QC_KERNELS (plain, avx2, avx512) chooses our instruction set; the peers are compiled for "
    "this machine.\n\n"
    "Exit status: as for qc-bench; 1 also where a method found other pairs than ours.";

void qcPeers_ReadOptions(int argumentCount, char** arguments, qcPeersOptions* options)
{
    *options = (qcPeersOptions){.threads = {1, 2},
                                .threadsCount = 2,
                                .frames = 8,
                                .rounds = 3,
                                .device = qc_deviceNone,
                                .models = {.bunny = QC_BUNNY_PATH},
                                .out = "out/bench"};
    qcWord scenes[qc_peerSceneCount + 2] = {{"all", -1}}, peers[qc_peerLibraryCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_peerSceneCount; ++i)
        scenes[i + 1] = (qcWord){qcPeerScene_Name(i), i};
    for (int i = 0; i < qc_peerLibraryCount; ++i)
        peers[i] = (qcWord){qcPeerModule_Name(i), i};
    const qcOption rows[] = {
        {.group = 1, .help = "What is tried; all of it by default:"},
        {1, "scenes", "LIST",
         "Of cloth-1k, cloth-20k, tangle-20k (crossing itself in thousands of places), tangle-92k (a cloth on a "
         "spinning ball), wrung-80k (a tube), cloth-250k, cloth-1m, bunny, dragon, coincident-2k (triangles at one "
         "place, all pairs of which intersect): each with itself; bunnies-27 (of 5000 triangles: the model's vertices "
         "in each cell of a grid become one) and bunnies-8 (as they are): with "
         "each other, all vertices new in each frame; rigid-27, rigid-8: the same bodies, transforms new in each frame",
         qcOption_Marks(options->scenes, qc_peerSceneCount, scenes)},
        {1, "peers", "LIST", "Of embree, bullet, cgal", qcOption_Marks(options->libraries, qc_peerLibraryCount, peers)},
        {.group = 2, .help = "How it is measured:"},
        {2, "threads", "LIST", "Numbers of threads; %s by default",
         qcOption_Numbers(options->threads, &options->threadsCount, qc_maxPeerThreads, 1, 1024, true)},
        // In a closed motion of two frames the second frame would be the way back.
        {2, "frames", "N", "Frames of the motion, 3 to 32; %s by default",
         qcOption_Number(&options->frames, 3, qc_maxPeerFrames)},
        {2, "rounds", "N", "Times that each method goes through the frames, in turn; %s by default",
         qcOption_Number(&options->rounds, 1, qc_maxPeerRounds)},
        {2, "device", "DEVICE",
         "auto, egl (a GPU), osmesa or surfaceless (software): layers is measured too; none by default",
         qcOption_Device(&options->device)},
        {.group = 3, .help = "Files:"},
        {3, "bunny", "FILE", "The model of the bunnies; that of the package glmark2-data by default",
         qcOption_Text(&options->models.bunny)},
        {3, "dragon", "FILE", "The model of dragon, which is skipped without it; tests/dragon.sh fetches it",
         qcOption_Text(&options->models.dragon)},
        {3, "out", "FOLDER", "Where peers.csv, peers.gp and the picture go; %s by default, made if it is missing",
         qcOption_Folder(&options->out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
