// Types and functions of `qc-bench peers`: the options, the scenes, the methods, a row for each.
#ifndef QC_DEMOS_BENCH_PEERS_PEERS_H
#define QC_DEMOS_BENCH_PEERS_PEERS_H

#include "bench/scenes/animated_scene.h"
#include "bench/scenes/scenes.h"
#include "bench/bench.h"
#include "bench/peers/modules.h"

#include <quickcullide/quickcullide.h>

enum
{
    qc_peerSceneCount = 14,
    qc_peerSceneRecipes = qc_peerSceneCount + 1, // with cloth-20m, which only "qc-bench first" has
    qc_peerLibraryMethods = 4,                   // of one library, at most
    qc_maxPeerMethods = 2 + qc_peerLibraryCount * qc_peerLibraryMethods,
    qc_maxPeerFrames = 32,
    qc_maxPeerRounds = 16,
    qc_maxPeerThreads = 8 // different numbers of them
};

typedef struct qcPeersOptions
{
    bool scenes[qc_peerSceneCount];
    bool libraries[qc_peerLibraryCount];
    uint32_t threads[qc_maxPeerThreads];
    uint32_t threadsCount;
    uint32_t frames, rounds;
    qcDeviceKind device;
    qcBenchModels models;
    const char* out;
} qcPeersOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcPeers_ReadOptions(int argumentCount, char** arguments, qcPeersOptions* options);

//  ---- scenes ------------------------------------------------------------------------------------

/// "cloth-20k"; `index` below qc_peerSceneRecipes.
const char* qcPeerScene_Name(int index);
const char* qcPeerScene_Title(int index);

/// Makes the animation of a scene; empty unless it was made. Deterministic to the bit.
qcBenchMade qcPeerScene_Make(int index, const qcBenchModels* models, uint32_t frameCount, qcAnimation* animation,
                             qcMessage* message);
//  ---- methods -------------------------------------------------------------------------------------

/// A method of this library or of a peer.
typedef struct qcPeerEntrant
{
    const char* name;
    const qcPeerLibrary* library; ///< null: ours
    uint32_t method;              ///< of the library, or a qcMethod
    bool threaded;
} qcPeerEntrant;

//  ---- rows ----------------------------------------------------------------------------------------

/// The pairs that a method found in a frame.
typedef struct qcPeerSeen
{
    bool ran;
    uint64_t pairs;
    uint64_t sum; ///< of hashes of the pairs, independent of their order: unequal sums prove unequal pairs
} qcPeerSeen;

typedef struct qcPeerRow
{
    qcPeerEntrant entrant;
    uint32_t threads;
    char skipped[256]; ///< reason why it did not run; empty: it ran
    double openMs;     ///< structures for bodies at rest, and their copies
    double firstMs, secondMs;
    uint32_t steps;   ///< timed steps
    double ms, minMs; ///< positions in, pairs out: median and minimum
    qcPeerSeen seen[qc_maxPeerFrames];
    uint64_t pairs; ///< in the first frame
    bool agrees;    ///< with our sweep, in every frame that both saw
} qcPeerRow;

/// One scene and what was measured on it.
typedef struct qcPeersTable
{
    int scene;
    qcAnimationKind kind;
    uint32_t bodyCount, triangleCount;
    qcPeerRow rows[qc_maxPeerThreads * qc_maxPeerMethods]; ///< those of a number of threads together, our sweep first
    uint32_t rowCount;
} qcPeersTable;

/// Adds a row for each entrant with this number of threads. False with a message: out of memory, or our sweep failed.
bool qcPeers_Measure(const qcPeersOptions* options, const qcAnimation* animation, const qcPeerEntrant* entrants,
                     uint32_t entrantCount, qcDevice* device, uint32_t threads, qcPeersTable* table,
                     qcMessage* message);

/// The row of our sweep with this number of threads.
const qcPeerRow* qcPeersTable_FindOurs(const qcPeersTable* table, uint32_t threads);
/// The quickest row of Embree with this number of threads; null: none ran.
const qcPeerRow* qcPeersTable_FindEmbree(const qcPeersTable* table, uint32_t threads);
/// Preprocessing in seconds: the time by which this step of ours, which took `ms`, exceeds later ones. The BVH is built
/// in the first or the second step. For 100 K triangles, or for a million pairs where it grows with pairs.
double qcPeersTable_Preprocessing(const qcPeersTable* table, const qcPeerRow* ours, double ms);
/// Whether pairs outnumber triangles: then the memory of pairs takes most of a first step.
bool qcPeersTable_GrowsWithPairs(const qcPeersTable* table, const qcPeerRow* ours);

//  ---- reports -------------------------------------------------------------------------------------

/// Prints a readable summary of one scene on standard output.
void qcPeers_PrintTable(const qcPeersTable* table);
bool qcPeers_WriteCsv(const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount,
                      qcMessage* message);
/// Writes the gnuplot script beside the CSV and runs it.
bool qcPeers_Plot(const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount, qcMessage* message);

#endif
