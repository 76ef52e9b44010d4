// The order of few triangles for x86-64 with AVX2.
#include "mesh/sixteen_shorts.h"

#include "mesh/item_moves.inl.h"
#include "mesh/small_order.inl.h"

const qcOrderKernels qcOrderKernels_avx2 = {MakeSmallOrder};
