// Leaves on a tree before anything moves: as many as have room.
#ifndef QC_DEMOS_LEAVES_GROWTH_H
#define QC_DEMOS_LEAVES_GROWTH_H

#include "leaves/leaf.h"
#include "leaves/tree.h"

#include "quickcullide/quickcullide.h"

#include <string>

/// At most `count` leaves, each further than `gap` from the tree and from all others. Empty, with qcLastMessage, if a
/// query failed.
std::vector<qcLeafMesh> qcGrowLeaves(const qcTree& tree, uint32_t count, btScalar gap, uint32_t seed);

#endif
