// BVH build order by median splits: boxes that follow each other are near each other.
#ifndef QC_BROADPHASE_BVH_BUILD_ORDER_H
#define QC_BROADPHASE_BVH_BUILD_ORDER_H

#include "broadphase/box_kernels.h"

/// A box's centre and id.
typedef struct qcBoxItem
{
    int32_t center[3]; ///< floats as integers of the same order
    uint32_t id;
} qcBoxItem;

qcBoxItem qcBoxItem_Make(const qcFloatBox* box, uint32_t id);

/// Orders items for a complete 8-ary tree over them. `boxes` are by id. O(count log count) expected.
void qcBuildOrder_Arrange(qcBoxItem* items, size_t count, const qcFloatBox* boxes);

#endif
