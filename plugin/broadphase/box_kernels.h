// Eight boxes side by side, and the loops over them, compiled once for each instruction set and chosen at run time.
// Results do not depend on the instruction set: there are comparisons, and for casts the same IEEE operations.
#ifndef QC_BROADPHASE_BOX_KERNELS_H
#define QC_BROADPHASE_BOX_KERNELS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum
{
    qc_lanes = 8,
    qc_treeLevels = 11 ///< for 2^31 boxes, eight times fewer in each level
};

/// Eight boxes, one a lane. An empty lane is NaN in all six values: it overlaps nothing.
typedef struct qcOctet
{
    float lower[3][qc_lanes], upper[3][qc_lanes];
} qcOctet;

/// A box for comparison with others. lower > upper is allowed, NaN not.
typedef struct qcFloatBox
{
    float lower[3], upper[3];
} qcFloatBox;

/// The smallest box around the boxes of an octet. An empty octet gives a box that overlaps nothing.
static inline qcFloatBox qcOctet_Around(const qcOctet* octet)
{
    qcFloatBox around;
    for (int k = 0; k < 3; k++)
    {
        around.lower[k] = INFINITY;
        around.upper[k] = -INFINITY;
        for (int lane = 0; lane < qc_lanes; lane++)
        {
            float lower = octet->lower[k][lane], upper = octet->upper[k][lane];
            around.lower[k] = lower < around.lower[k] ? lower : around.lower[k];
            around.upper[k] = upper > around.upper[k] ? upper : around.upper[k];
        }
    }
    return around;
}

/// The path of a moving box, in floats that are rounded outwards: no box that it hits is missed.
typedef struct qcFloatCast
{
    qcFloatBox path;      ///< contains the whole path
    float lowerOffset[3]; ///< at least the start plus the moving box's upper extent
    float upperOffset[3]; ///< at most the start plus the moving box's lower extent
    float inverse[3];     ///< of the direction; 0: no slab in this axis
} qcFloatCast;

/// 16 u, u = 2^-24: see plugin/docs/proofs/box_casts.md.
#define QC_FLOAT_CAST_TOLERANCE 0x1p-20f

static inline bool qcFloatBox_Overlap(const qcFloatBox* a, const qcFloatBox* b)
{
    return (a->lower[0] <= b->upper[0]) & (a->upper[0] >= b->lower[0]) & (a->lower[1] <= b->upper[1]) &
           (a->upper[1] >= b->lower[1]) & (a->lower[2] <= b->upper[2]) & (a->upper[2] >= b->lower[2]);
}

/// A complete 8-ary BVH: octet i of level l bounds the octets 8 i .. 8 i + 7 of level l - 1, one a lane.
typedef struct qcOctetTree
{
    const qcOctet* octets;
    uint32_t first[qc_treeLevels]; ///< first octet of each level; level 0 holds the boxes
    uint32_t levelCount;
} qcOctetTree;

/// Overlaps of a query octet with one octet of a tree. Bit lane + 8 row: the tree's box in this lane overlaps the
/// query's box in lane `row`.
typedef struct qcOctetHit
{
    uint64_t lanes;
    uint32_t octet; ///< of level 0 of the tree
} qcOctetHit;

typedef struct qcBoxKernels
{
    /// A bit for each lane that overlaps the box.
    uint32_t (*overlap)(const qcOctet* octet, const qcFloatBox* box);
    /// A bit for each lane that a cast may hit up to a fraction of its path, and lower bounds of the fractions at which
    /// it hits these lanes.
    uint32_t (*cast)(const qcOctet* octet, const qcFloatCast* cast, float fraction, float entries[qc_lanes]);
    /// Finds the octets of level 0, from `first` on, with a box that overlaps a box of the query octet. Returns the
    /// number of hits. `hits` has room for one per octet of level 0.
    size_t (*findOverlaps)(const qcOctet* octet, const qcOctetTree* tree, uint32_t first, qcOctetHit* hits);
} qcBoxKernels;

extern const qcBoxKernels qcBoxKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcBoxKernels qcBoxKernels_avx2;
#endif

/// The fastest kernels that this machine runs. The environment variable QC_KERNELS (plain, avx2) selects others.
const qcBoxKernels* qcBoxKernels_Get(void);

/// The i-th of the kernels that this machine runs, or null. For tests.
const qcBoxKernels* qcBoxKernels_Nth(size_t i);

#endif
