// What kernels put in order: 16-bit coordinates of a centroid.
#ifndef QC_MESH_ORDER_ITEM_H
#define QC_MESH_ORDER_ITEM_H

#include "mesh/small_order.h"

enum
{
    qc_countedKeys = 32 ///< at a time; so many more can be read, and are above all others
};

typedef union Item
{
    int16_t at[4]; ///< 0 .. INT16_MAX; the last is the index of the centroid
    uint64_t all;
} Item;

#endif
