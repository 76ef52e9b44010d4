// Which contact points of a pair of bodies are worth a place in Bullet's manifolds.
#ifndef QC_BULLET_GLUE_MESH_POINTS_H
#define QC_BULLET_GLUE_MESH_POINTS_H

#include "mesh_batch.h"

/// A few points with similar normals, the deepest first, then by distance.
struct qcPointGroup
{
    int count = 0;
    const qcMeshPoint* points[4];
};

/// Fills at most `most` groups and returns how many. Rigid bodies feel no difference between points with the same
/// normal and the corners of their hull, so each group has up to four that span it. `points` are reordered. Distances
/// count from the shells; the nearer a point's to `reach`, the less it counts. None of a group is nearer to another
/// one, at either end, than `apart` or than one of the two is wide.
int qcGroupPoints(std::vector<qcMeshPoint>* points, btScalar reach, btScalar apart, int most, qcPointGroup* groups);

#endif
