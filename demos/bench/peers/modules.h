// The modules of peer libraries: files beside the program, where the build found their library.
#ifndef QC_DEMOS_BENCH_PEERS_MODULES_H
#define QC_DEMOS_BENCH_PEERS_MODULES_H

#include "bench/peers/library.h"
#include "common/message.h"

enum
{
    qc_peerEmbree, ///< number of a library
    qc_peerBullet,
    qc_peerCgal,
    qc_peerLibraryCount
};

/// "embree"; `library` below qc_peerLibraryCount.
const char* qcPeerModule_Name(int library);
/// The packages to install before the library's module can be built.
const char* qcPeerModule_Packages(int library);
/// Loads a library's module from beside the program; null where there is none. It stays loaded until the program ends.
/// False with a message: the module exists and does not load.
bool qcPeerModule_Load(int library, const qcPeerLibrary** loaded, qcMessage* message);

#endif
