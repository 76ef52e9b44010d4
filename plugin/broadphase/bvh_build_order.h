// BVH build order by median splits: boxes that follow each other are near each other.
#ifndef QC_BROADPHASE_BVH_BUILD_ORDER_H
#define QC_BROADPHASE_BVH_BUILD_ORDER_H

#include "broadphase/box_kernels.h"

enum
{
    // Boxes by id lie anywhere in memory: those that a build reads are fetched so many ahead.
    qc_fetchAhead = 16
};

/// A box's centre and id.
typedef struct qcBoxItem
{
    int32_t center[3]; ///< floats as integers of the same order
    uint32_t id;
} qcBoxItem;

typedef union qcFloatOrder
{
    float f;
    int32_t i;
} qcFloatOrder;

/// An integer that compares like the float, and back.
static inline int32_t qcFloatOrder_Of(float x)
{
    qcFloatOrder bits = {.f = x + 0.0f};
    return bits.i ^ (bits.i >> 31 & INT32_MAX);
}

static inline float qcFloatOrder_Float(int32_t order)
{
    qcFloatOrder bits = {.i = order ^ (order >> 31 & INT32_MAX)};
    return bits.f;
}

static inline qcBoxItem qcBoxItem_Make(const qcFloatBox* box, uint32_t id)
{
    qcBoxItem item = {.id = id};
    for (int k = 0; k < 3; k++)
    {
        float center = 0.5f * box->lower[k] + 0.5f * box->upper[k];
        // False for NaN, too: the result of infinities that cancel.
        center = center > -1e30f ? center : -1e30f;
        item.center[k] = qcFloatOrder_Of(center < 1e30f ? center : 1e30f);
    }
    return item;
}

/// Orders items for a complete 8-ary tree over them. `boxes` are by id. O(count log count) expected.
void qcBuildOrder_Arrange(qcBoxItem* items, size_t count, const qcFloatBox* boxes);

#endif
