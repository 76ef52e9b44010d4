// Triangle soups made by rule for the benchmark: the same arguments give the same bits on every machine with the same C
// library.
#ifndef QC_DEMOS_BENCH_SCENES_SHAPES_H
#define QC_DEMOS_BENCH_SCENES_SHAPES_H

#include "common/mesh_io/mesh_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A random number in lower .. upper; the state is the seed.
double qcBenchShapes_Random(uint64_t* state, double lower, double upper);

/// A cloth of 2 * side * side triangles, folded into four panels and these into three, 12 layers with wrinkles.
/// `wrinkles`: their depth; at 1 some layers cross, at 2.5 (a tangle) most do. False: out of memory.
bool qcBenchShapes_MakeCloth(uint32_t side, double wrinkles, qcMesh* mesh);

/// A square cloth of 2 * side * side triangles over a ball that spins: it hangs down in pleats that wind around the
/// axis and cross each other, in about 0.63 pairs of triangles for each of its triangles. False: out of memory.
bool qcBenchShapes_MakeSpunCloth(uint32_t side, qcMesh* mesh);

/// An open tube of 8 * side * side triangles, with deep flutes, wrung by 17 turns: its triangles are long and lie close
/// together: the boxes of 15 times as many pairs overlap (neighbours not counted), but only few intersect. False: out
/// of memory.
bool qcBenchShapes_MakeWrungTube(uint32_t side, qcMesh* mesh);

/// Two wavy sheets over the unit square, `gap` apart; in some places the upper one dips through the lower one, by up
/// to the gap.
bool qcBenchShapes_MakeSheets(double gap, qcMesh sheets[2]);

/// Needles of a tenth of the unit cube: the tip of each second one pokes through the one before, by a tenth to a ten
/// thousandth of its length.
bool qcBenchShapes_MakeSlivers(uint32_t count, qcMesh* mesh);

/// Triangles with corners of their own at the same three points: each intersects each.
bool qcBenchShapes_MakeCoincident(uint32_t count, qcMesh* mesh);

#ifdef __cplusplus
}
#endif

#endif
