// Traversal of the BVH forest of a set of boxes, with a box.
#ifndef QC_BROADPHASE_BOX_QUERY_H
#define QC_BROADPHASE_BOX_QUERY_H

#include "base/float_mode.h"
#include "broadphase/box_set.h"

typedef struct qcBoxQuery
{
    const qcBoxes* set;
    qcBounds bounds;
    qcFloatBox box; ///< a box of floats that contains `bounds` minus the origin
    bool exact;     ///< the floats equal the bounds
    bool fat;       ///< find boxes whose AABB in the forest overlaps `box`; otherwise boxes that overlap `bounds`
    qcBoxFunction* function; ///< called for each box found; returns false to stop
    void* context;
} qcBoxQuery;

/// The boxes that a query visits: bits.
typedef enum qcForestPart
{
    qc_dynamicBoxes = 1, ///< inserted since the last search
    qc_staticBoxes = 2
} qcForestPart;

/// A query with a box given by its bounds. NaN means unbounded.
qcBoxQuery qcBoxQuery_Make(const qcBoxes* set, const double lower[3], const double upper[3], qcBoxFunction* function,
                           void* context);

/// A query with a box of the set.
qcBoxQuery qcBoxQuery_MakeFor(const qcBoxes* set, uint32_t id, qcBoxFunction* function, void* context);

/// Calls the function if the box overlaps. Returns false if the function stops the query.
bool qcBoxQuery_Test(const qcBoxQuery* query, uint32_t id);

/// Tests the boxes of some qcForestPart.
void qcBoxQuery_Run(const qcBoxQuery* query, unsigned parts);

/// A function of the host. It runs in the host's floating-point environment.
typedef struct qcHostFunction
{
    qcBoxFunction* function;
    void* context;
    qcFloatMode mode;
} qcHostFunction;

/// A qcBoxFunction whose context is a qcHostFunction.
bool qcHostFunction_Call(uint32_t id, void* userData, void* context);

#endif
