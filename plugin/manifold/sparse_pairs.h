// Before the first stage: of the near pairs of two fine meshes only those are kept that no other one covers. Rules,
// what is promised and why: plugin/docs/proofs/sparse_contact.md.
#ifndef QC_MANIFOLD_SPARSE_PAIRS_H
#define QC_MANIFOLD_SPARSE_PAIRS_H

#include "manifold/overlap_kernels.h"

/// The pairs of two bodies that are kept, and scratch; memory is retained.
typedef struct qcSparsePairs
{
    qcArray pairs; ///< of qcPair, in the order of the reported ones
    qcArray runs;  ///< of qcSortItem: see qcAllManifolds
    //  scratch
    qcArray numbers;    ///< of each triangle of both bodies: its number here plus 1; all 0 between builds
    qcArray triangles;  ///< of those of the pairs
    qcArray candidates; ///< pairs whose smaller triangle is no longer than the spacing, by that triangle
    qcArray ends;       ///< of uint32_t, by pair: the numbers of both triangles
    qcArray isKept;     ///< bool, by pair
    qcArray cells;      ///< hash table of the nearest candidate of each cell and direction
} qcSparsePairs;

/// Chooses pairs with the input's spacing, and makes `sparse` the input of these. `sparse` is the given input if all
/// pairs are kept: without a spacing, for a body with itself, for few pairs, and where two triangles touch. O(pairs).
qcStatus qcSparsePairs_Choose(const qcStepTriangles* triangles, const qcBodyPairInput* input,
                              const qcOverlapKernels* kernels, qcSparsePairs* pairs, qcManifoldInput* reported,
                              qcBodyPairInput* sparse);
void qcSparsePairs_Free(qcSparsePairs* pairs);

#endif
