// Copies of a model, piled up so that each overlaps its neighbours.
#ifndef QC_DEMOS_BENCH_SCENES_PILES_H
#define QC_DEMOS_BENCH_SCENES_PILES_H

#include "common/mesh_io/mesh_file.h"

#include <quickcullide/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A copy of floats. False: out of memory; then it is empty.
bool qcBenchPile_Copy(const qcMesh* model, qcMesh* copy);

/// The model as floats, its middle at the origin and 1 in extent. False: out of memory, or all its vertices are one
/// point.
bool qcBenchPile_Normalize(const qcMesh* model, qcMesh* body, qcMessage* message);

/// Transforms of `count` bodies of extent 1: on a lattice 0.8 apart, each turned in its own way. Deterministic to the
/// bit.
void qcBenchPile_Place(uint32_t count, qcTransform* places);

/// The positions of a body at its place, as floats.
void qcBenchPile_Put(const qcMesh* body, const qcTransform* place, float* positions);

#ifdef __cplusplus
}
#endif

#endif
