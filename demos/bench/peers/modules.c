// Finds the modules of peer libraries: files beside the program. The build makes those whose library it found.
#define _POSIX_C_SOURCE 200809L
#include "bench/peers/modules.h"

#include "common/files.h"

#include <dlfcn.h>
#include <limits.h>
#include <string.h>
#include <unistd.h>

typedef struct Module
{
    const char* name;
    const char* packages; ///< of Debian and Ubuntu
} Module;

static const Module s_modules[qc_peerLibraryCount] = {[qc_peerEmbree] = {"embree", "libembree-dev"},
                                                      [qc_peerBullet] = {"bullet", "libbullet-dev"},
                                                      [qc_peerCgal] = {"cgal", "libcgal-dev libtbb-dev"}};

const char* qcPeerModule_Name(int library)
{
    return s_modules[library].name;
}

const char* qcPeerModule_Packages(int library)
{
    return s_modules[library].packages;
}

static bool FindPath(int library, char* path, size_t size, qcMessage* message)
{
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length < 0)
        return qcMessage_Fail(message, "/proc/self/exe does not say where the program lies");
    program[length] = 0;
    *strrchr(program, '/') = 0;
    int written = snprintf(path, size, "%s/qc-bench-peer-%s.so", program, s_modules[library].name);
    return (size_t)written < size || qcMessage_Fail(message, "the path of the program is too long");
}

bool qcPeerModule_Load(int library, const qcPeerLibrary** loaded, qcMessage* message)
{
    char path[PATH_MAX];
    *loaded = NULL;
    if (!FindPath(library, path, sizeof path, message))
        return false;
    if (!qcFiles_IsThere(path))
        return true;
    void* module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    void* symbol = module != NULL ? dlsym(module, "qcPeer_GetLibrary") : NULL;
    if (symbol == NULL)
        return qcMessage_Fail(message, "%s", dlerror());
    // ISO C has no cast from an object's address to a function's.
    qcPeerGetLibraryFunction* get;
    memcpy(&get, &symbol, sizeof get);
    *loaded = get();
    return true;
}
