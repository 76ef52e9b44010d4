// The order in which the primitives of a level are drawn and tested.
#ifndef QC_CULL_VISIBILITY_DRAW_ORDER_H
#define QC_CULL_VISIBILITY_DRAW_ORDER_H

#include "base/memory.h"

/// A run of triangles that is tested and drawn as one.
typedef struct qcCullPrimitive
{
    uint32_t firstTriangle, triangleCount; ///< nine floats a triangle
    /// Primitives of one group don't hide each other: triangles of one body, culled against other bodies. Groups are
    /// numbered from 0 and contiguous.
    uint32_t group;
} qcCullPrimitive;

/// The order, and memory retained between steps.
typedef struct qcCullOrder
{
    qcArray primitives; ///< uint32_t: the order, the primitives of a group together
    qcArray groups, scratch;
} qcCullOrder;

/// Fills the order by index.
qcStatus qcCullOrder_ByNumber(qcCullOrder* order, uint32_t primitiveCount);

/// Fills the order farthest first along an axis (0, 1, 2); a group's depth is the mean depth of its corners.
/// O(triangles).
qcStatus qcCullOrder_BackToFront(qcCullOrder* order, const qcCullPrimitive* primitives, uint32_t primitiveCount,
                                 const float* corners, int axis);
void qcCullOrder_Free(qcCullOrder* order);

#endif
