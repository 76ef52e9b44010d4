// The mesh of the scenes: a decimated bunny.
#ifndef QC_DEMOS_BENCH_SOFT_MODEL_H
#define QC_DEMOS_BENCH_SOFT_MODEL_H

#include <LinearMath/btScalar.h>

#include <cstdint>
#include <vector>

/// Three numbers a point, three indices a triangle.
struct qcSoftModel
{
    std::vector<btScalar> positions;
    std::vector<uint32_t> indices;
};

/// About 900 triangles, `size` times as large as in its file, where it is about two units high; a torus where the model
/// is missing.
qcSoftModel qcMakeSoftModel(btScalar size);

#endif
