// What of a soft body collides: faces, links that are ropes, and single nodes, as triangles of a qcScene.
#ifndef QC_GLUE_SOFT_BODY_SCENE_TOPOLOGY_H
#define QC_GLUE_SOFT_BODY_SCENE_TOPOLOGY_H

#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <utility>
#include <vector>

struct qcSoftTopology
{
    /// Three a triangle: first the faces; then (a, b, b) for each rope link; then (a, a, a) for each node that neither
    /// a face nor a rope link has.
    std::vector<uint32_t> indices;
    size_t faceCount = 0, ropeCount = 0; ///< triangles
    /// What ropes are chosen from: number and nodes of each link with an end that no face has. Empty in a body of
    /// tetrahedra.
    std::vector<std::pair<int, std::pair<uint32_t, uint32_t>>> looseLinks;
    int linkCount = -1; ///< all links; -1: each node is a face's, or the body is of tetrahedra, and links don't matter
    /// What stands for a thickness of 0: half the mean edge of the faces; in a body without faces an eighth of the mean
    /// length of its rope links; else 0.
    btScalar defaultThickness = 0;
};

/// O(faces + links * links at a node).
qcSoftTopology qcTopologyOf(const btSoftBody* body);
/// Is this the topology of a body that has as many nodes as it had then? O(faces + looseLinks).
bool qcIsTopologyOf(const qcSoftTopology& topology, const btSoftBody* body);

#endif
