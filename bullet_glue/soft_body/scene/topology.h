// The colliding parts of a soft body as triangles of a qcScene: faces, rope links, single nodes.
#ifndef QC_GLUE_SOFT_BODY_SCENE_TOPOLOGY_H
#define QC_GLUE_SOFT_BODY_SCENE_TOPOLOGY_H

#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <utility>
#include <vector>

struct qcSoftTopology
{
    /// Node indices, three a triangle: first the faces; then (a, b, b) for each rope link; then (a, a, a) for each node
    /// that belongs to no face and no rope link.
    std::vector<uint32_t> indices;
    size_t faceCount = 0, ropeCount = 0; ///< triangles
    /// The nodes of these triangles, ascending. All others are inside a skin of faces, and collide with nothing.
    std::vector<uint32_t> nodes;
    /// The links with an end that belongs to no face: index and nodes of each. Rope links are chosen from these. Empty
    /// in a body of tetrahedra.
    std::vector<std::pair<int, std::pair<uint32_t, uint32_t>>> looseLinks;
    /// All links of the body. -1: links don't matter, since each node belongs to a face or the body is of tetrahedra.
    int linkCount = -1;
    /// The thickness where the settings give 0: half the mean edge of the faces; in a body without faces an eighth of
    /// the mean length of its rope links; 0 without either.
    btScalar defaultThickness = 0;
    /// Rest lengths of the first link, the one in the middle and the last, for qcIsScaled. 0 without links.
    btScalar restLengths[3] = {0, 0, 0};
    /// Each node but the last has a rope link to the next one, and nothing else collides.
    bool isChain = false;
};

/// O(faces + links * links at a node).
qcSoftTopology qcTopologyOf(const btSoftBody* body);
/// Nine tenths of the height that all faces but a hundredth exceed, each at rest over its longest edge. A thicker face
/// pushes the corners of its neighbours across their edges, and so stiffens a mesh of uneven triangles at rest. O(faces
/// + links).
btScalar qcClearHeightOf(const btSoftBody* body, const qcSoftTopology& topology);
/// True if a body with the same number of nodes still has this topology. O(faces + looseLinks).
bool qcIsTopologyOf(const qcSoftTopology& topology, const btSoftBody* body);
/// True if links have been given other rest lengths, by a tenth at least, as btSoftBody::scale does: the default
/// thickness is that of another body. O(1).
bool qcIsScaled(const qcSoftTopology& topology, const btSoftBody* body);

#endif
