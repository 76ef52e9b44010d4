// The bodies of a recording as plain triangles in world space: for methods and measurements that know no bodies.
#ifndef QC_DEMOS_BENCH_PAPER_SOUP_H
#define QC_DEMOS_BENCH_PAPER_SOUP_H

#include <quickcullide/quickcullide.h>

typedef struct qcPaperSoupBody
{
    bool isThere, deforming, selfCollision;
    double* positions; ///< in local space, of a deforming body in world space
    uint32_t* indices;
    uint32_t vertexCount, triangleCount;
    qcTransform transform;
    uint32_t group, mask, owner;
} qcPaperSoupBody;

typedef struct qcPaperSoup
{
    qcPaperSoupBody* bodies; ///< by slot
    uint32_t bodyCount;
    uint32_t changes; ///< bodies added and removed so far
    //  All of them: filled by qcPaperSoup_Collect and qcPaperSoup_Place.
    double* positions;
    uint32_t* indices;
    uint32_t* firstTriangles; ///< of each slot
    uint32_t vertexCount, triangleCount;
} qcPaperSoup;

/// Follows an operation. False: out of memory.
bool qcPaperSoup_Apply(qcPaperSoup* soup, const qcOperation* operation);
/// Lists the triangles of all bodies, in the order of their slots. Call it when `changes` has grown. False: out of
/// memory.
bool qcPaperSoup_Collect(qcPaperSoup* soup);
/// Computes the present positions as the library does, to the last bit.
void qcPaperSoup_Place(qcPaperSoup* soup);
void qcPaperSoup_Free(qcPaperSoup* soup);

#endif
