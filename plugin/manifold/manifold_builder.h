// The manifolds of two bodies, or of one with itself: the stages in their order, each a struct of its own.
#ifndef QC_MANIFOLD_MANIFOLD_BUILDER_H
#define QC_MANIFOLD_MANIFOLD_BUILDER_H

#include "manifold/points.h"
#include "manifold/sparse_pairs.h"

/// The stages and results of one worker. Memory is retained between builds.
typedef struct qcManifoldBuilder
{
    qcWorkerResult result;
    qcSparsePairs sparse;
    qcContactTopology topology;
    qcContactRegions regions;
    qcContactProximity proximity;
    qcPairAdjacency adjacency;
    qcPairOverlaps overlaps;
    qcContactNormals normals;
    qcContactPoints points;
    const qcOverlapKernels* kernels;
    //  results of all builds of this step, one after the other; in each build first points count from 0
    qcArray manifolds;      ///< of qcManifold
    qcArray manifoldPoints; ///< of qcManifoldPoint
} qcManifoldBuilder;

/// Adds the manifolds of two bodies to the results. `threads` includes the calling one.
qcStatus qcManifoldBuilder_Build(qcManifoldBuilder* builder, const qcStepTriangles* triangles,
                                 const qcBodyPairInput* input, uint32_t threads);
void qcManifoldBuilder_Free(qcManifoldBuilder* builder);

#endif
