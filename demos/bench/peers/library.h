// The interface of `qc-bench peers` to a peer library. Each library is in a module of its own, which is loaded at run
// time: neither qc-bench nor anything else links a peer.
//
// Thread-safety: one thread calls; a method may use qcPeerTask::threads of its own.
#ifndef QC_DEMOS_BENCH_PEERS_LIBRARY_H
#define QC_DEMOS_BENCH_PEERS_LIBRARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qcPeerBody
{
    const uint32_t* indices; ///< three a triangle
    uint32_t vertexCount, triangleCount;
} qcPeerBody;

/// World positions of a body's vertices, three each: one of the two is null.
typedef struct qcPeerPose
{
    const float* floats;
    const double* doubles;
} qcPeerPose;

/// The task of each step: find the pairs of triangles that penetrate, without neighbours (by vertex index).
typedef struct qcPeerTask
{
    const qcPeerBody* bodies;
    uint32_t bodyCount;
    bool self; ///< true: pairs of triangles of one body; false: of two bodies
    uint32_t threads;
} qcPeerTask;

/// In any order, either triangle first.
typedef struct qcPeerPair
{
    uint32_t bodyA, triangleA, bodyB, triangleB;
} qcPeerPair;

/// Valid until the next step.
typedef struct qcPeerAnswer
{
    const qcPeerPair* pairs;
    size_t count;
} qcPeerAnswer;

/// A method of a library.
typedef struct qcPeerMethod
{
    const char* name; ///< "embree-refit"
    bool threaded;    ///< false: one thread at most
} qcPeerMethod;

typedef struct qcPeerLibrary
{
    const char* name; ///< "Embree 3.13.5"
    const qcPeerMethod* methods;
    uint32_t methodCount;
    /// Builds the structures that persist from step to step, for the current positions. Null: it failed. The task
    /// outlives the state.
    void* (*open)(const qcPeerTask* task, uint32_t method, const qcPeerPose* poses);
    /// Takes new positions (a pose a body, valid until the next step), gives pairs. False: it failed.
    bool (*step)(void* state, const qcPeerPose* poses, qcPeerAnswer* answer);
    void (*close)(void* state);
} qcPeerLibrary;

/// The one function of a module, under the name qcPeer_GetLibrary.
typedef const qcPeerLibrary* qcPeerGetLibraryFunction(void);

#ifdef __cplusplus
}
#endif

#endif
