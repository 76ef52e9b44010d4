// Eight boxes side by side, and the loops over them, compiled once for each instruction set and chosen at run time.
// What is found does not depend on the instruction set: there are comparisons only.
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

/// A lane without a box is NaN in all six: it meets nothing.
typedef struct qcOctet
{
    float lower[3][qc_lanes], upper[3][qc_lanes];
} qcOctet;

/// A box for comparison with others. lower > upper is allowed, NaN not.
typedef struct qcFloatBox
{
    float lower[3], upper[3];
} qcFloatBox;

/// The smallest box around the boxes of an octet; of none, a box that meets nothing.
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

static inline bool qcFloatBox_Meet(const qcFloatBox* a, const qcFloatBox* b)
{
    return (a->lower[0] <= b->upper[0]) & (a->upper[0] >= b->lower[0]) & (a->lower[1] <= b->upper[1]) &
           (a->upper[1] >= b->lower[1]) & (a->lower[2] <= b->upper[2]) & (a->upper[2] >= b->lower[2]);
}

/// A complete tree of eight: octet i of level l is around the octets 8 i .. 8 i + 7 of level l - 1, one a lane.
typedef struct qcOctetTree
{
    const qcOctet* octets;
    uint32_t first[qc_treeLevels]; ///< octet of each level; level 0 holds the boxes
    uint32_t levelCount;
} qcOctetTree;

/// Bit lane + 8 row: the box in this lane of the octet meets the one in that row of the octet that was sought for.
typedef struct qcOctetHit
{
    uint64_t lanes;
    uint32_t octet; ///< of level 0
} qcOctetHit;

typedef struct qcBoxKernels
{
    /// A bit for each lane that meets the box.
    uint32_t (*meet)(const qcOctet* octet, const qcFloatBox* box);
    /// The octets of level 0 from `first` on that meet boxes of an octet: writes what meets, returns how many did.
    /// `hits` has room for one of each.
    size_t (*seek)(const qcOctet* octet, const qcOctetTree* tree, uint32_t first, qcOctetHit* hits);
} qcBoxKernels;

extern const qcBoxKernels qcBoxKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcBoxKernels qcBoxKernels_avx2;
#endif

/// The best that this machine runs. The environment's QC_KERNELS (plain, avx2) names another.
const qcBoxKernels* qcBoxKernels_Get(void);

/// All that this machine runs, for tests: the i-th, or null.
const qcBoxKernels* qcBoxKernels_Nth(size_t i);

#endif
