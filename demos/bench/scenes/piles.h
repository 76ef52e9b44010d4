// Copies of a model, piled up so that each overlaps its neighbours.
#ifndef QC_DEMOS_BENCH_SCENES_PILES_H
#define QC_DEMOS_BENCH_SCENES_PILES_H

#include "common/mesh_io/mesh_file.h"

#include <quickcullide/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Copies a model with positions as floats. False: out of memory; the copy is then empty.
bool qcBenchPile_Copy(const qcMesh* model, qcMesh* copy);

/// Copies the model as floats, with its centre at the origin and an extent of 1. False: out of memory, or all its
/// vertices are one point.
bool qcBenchPile_Normalize(const qcMesh* model, qcMesh* body, qcMessage* message);

/// Transforms of `count` bodies of extent 1: on a lattice 0.8 apart, each turned in its own way. Deterministic to the
/// bit.
void qcBenchPile_Place(uint32_t count, qcTransform* places);

/// Transforms the positions of a body by `place`, to floats.
void qcBenchPile_Put(const qcMesh* body, const qcTransform* place, float* positions);

#ifdef __cplusplus
}
#endif

#endif
