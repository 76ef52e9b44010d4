// One leaf as a triangle mesh: a stalk and a pointed blade, folded along its midrib.
#ifndef QC_DEMOS_LEAVES_LEAF_H
#define QC_DEMOS_LEAVES_LEAF_H

#include <LinearMath/btTransform.h>

#include <vector>

/// Lengths in metres.
struct qcLeafForm
{
    btScalar stalk = btScalar(0.045);     ///< length of the stalk
    btScalar length = btScalar(0.20);     ///< of the blade
    btScalar halfWidth = btScalar(0.062); ///< of the blade where it is widest
    btScalar fold = btScalar(0.25);       ///< slope of both halves of the blade away from the midrib
    btScalar droop = btScalar(0.25);      ///< the tip lies lower than the stalk by this share of the blade's length
    btScalar wave = btScalar(0.004);      ///< height of the waves at the edge
};

struct qcLeafMesh
{
    std::vector<btVector3> vertices;
    std::vector<int> indices; ///< three for each triangle; the upper side is the front
};

/// Vertices of the stalk, which come first.
constexpr int qcLeafStalkVertices = 6;

/// `place`: the origin is the beginning of the stalk, x the direction of the leaf, y that of its upper side. All leaves
/// have the same indices.
qcLeafMesh qcMakeLeaf(const qcLeafForm& form, const btTransform& place);

#endif
