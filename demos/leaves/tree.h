// A tree that grows from a seed: a trunk, branches and twigs as closed triangle tubes.
#ifndef QC_DEMOS_LEAVES_TREE_H
#define QC_DEMOS_LEAVES_TREE_H

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <vector>

/// A place on a twig where a leaf may grow.
struct qcLeafSite
{
    btVector3 place; ///< on the twig's axis
    btVector3 along; ///< direction of the twig
    btScalar radius; ///< of the twig
};

/// Stands on the ground y = 0, about 3 m high. Metres.
struct qcTree
{
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices; ///< three for each triangle, counterclockwise from outside
    std::vector<qcLeafSite> sites; ///< from the trunk outwards
};

/// Each tube is a closed mesh and begins inside of the tube that it grows from.
qcTree qcGrowTree(uint32_t seed);

#endif
