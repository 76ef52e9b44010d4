// The order of few triangles on any processor.
#include "base/eight_shorts.h"

enum
{
    qc_shorts = 8
};

typedef qcEightShorts Shorts;

static inline Shorts LoadShorts(const void* from)
{
    return qcEightShorts_Load(from);
}

static inline Shorts MinShorts(Shorts a, Shorts b)
{
    return qcEightShorts_Min(a, b);
}

static inline Shorts MaxShorts(Shorts a, Shorts b)
{
    return qcEightShorts_Max(a, b);
}

#include "mesh/item_moves.inl.h"
#include "mesh/small_order.inl.h"

const qcOrderKernels qcOrderKernels_scalar = {MakeSmallOrder};
