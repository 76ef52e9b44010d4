// Packed pair masks.
#include "mesh/pair_mask.h"

#include <stdbool.h>

size_t qcPairMask_Pack(const uint64_t words[qc_pairMaskWords], uint64_t packed[qc_maxPairMaskSize])
{
    uint64_t some = 0, none = 0;
    size_t size = 2;
    for (uint32_t word = 0; word < qc_pairMaskWords; word++)
    {
        bool isNone = words[word] == 0, isSome = !isNone && words[word] != UINT64_MAX;
        none |= (uint64_t)isNone << word;
        some |= (uint64_t)isSome << word;
        if (isSome)
            packed[size++] = words[word];
    }
    packed[0] = some;
    packed[1] = none;
    return size;
}

const uint64_t* qcPairMask_OfOneNode(void)
{
    static const uint64_t diagonal = UINT64_C(0x8040201008040201), b = QC_PAIRS_IN_ORDER;
    // Words i + 8 j with i > j have no bits. The last word is the one more that qcPairMask_Word reads.
    static const uint64_t mask[] = {diagonal, UINT64_C(0x0080c0e0f0f8fcfe), b, b, b, b, b, b, b, b, 0};
    return mask;
}
