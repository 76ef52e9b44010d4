// Keys that are in order already, and their merging with others.
#ifndef QC_BASE_ORDERED_KEYS_H
#define QC_BASE_ORDERED_KEYS_H

#include <stddef.h>
#include <stdint.h>

/// Where the keys begin that are in ascending order up to the last one. O(their number).
size_t qcOrderedKeys_FindBegin(const uint64_t* keys, size_t count);

/// Merges two ordered lists into `keys`, which has room for both and begins with the first. Made for a first list that
/// is much shorter: O(count log orderedCount), and a copy of the second.
void qcOrderedKeys_Merge(uint64_t* keys, size_t count, const uint64_t* ordered, size_t orderedCount);

#endif
