// Which contact points of a pair of bodies are worth a place in Bullet's manifolds.
#ifndef QC_GLUE_MESH_CONTACT_CONTACT_REDUCTION_H
#define QC_GLUE_MESH_CONTACT_CONTACT_REDUCTION_H

#include "common/shape_triangles.h"

/// Where two triangles come near each other, or cross.
struct qcMeshPoint
{
    btVector3 onA, onB; ///< in world space
    btVector3 normal;   ///< from B towards A
    btScalar distance;  ///< between the triangles; the margins of the shapes are not part of it
    qcTriangleSource sourceA, sourceB;
    int region = 0;                  ///< of contact, that it is of
    bool kept = false;               ///< a point of the step before is near
    btScalar ahead = BT_LARGE_FLOAT; ///< the distance at the end of the step, as the bodies move now
};

/// The points of two bodies, seen from the first.
void qcAppendPoints(const qcResult& result, qcBodyId a, const std::vector<qcTriangleSource>& sourcesA, qcBodyId b,
                    const std::vector<qcTriangleSource>& sourcesB, std::vector<qcMeshPoint>* points);

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
