// Contact points of a pair of bodies, and their reduction to what Bullet's manifolds hold.
#ifndef QC_GLUE_MESH_CONTACT_POINTS_CONTACT_REDUCTION_H
#define QC_GLUE_MESH_CONTACT_POINTS_CONTACT_REDUCTION_H

#include "common/shape_triangles.h"

#include <utility>

/// A contact point of two triangles.
struct qcMeshPoint
{
    btVector3 onA, onB; ///< in world space
    btVector3 normal;   ///< from B towards A
    btScalar distance;  ///< between the triangles, without the margins of the shapes
    qcTriangleSource sourceA, sourceB;
    int region = 0;                        ///< number of its region of contact
    bool isKnown = false;                  ///< near a point of the previous step
    btScalar endDistance = BT_LARGE_FLOAT; ///< at the end of the step, for the velocities at its beginning
    bool isFaceCorner = false;             ///< one of three common vertices of two faces that touch

    /// Exchanges A and B.
    void Swap()
    {
        std::swap(onA, onB);
        std::swap(sourceA, sourceB);
        normal = -normal;
    }
    /// Sets the distance of the ends along the normal. Bullet requires ends on a line along it: the one on A takes this
    /// part of the difference, the other one the rest.
    void AlignEnds(btScalar partOfA = btScalar(0.5))
    {
        distance = (onA - onB).dot(normal);
        const btVector3 aside = onA - onB - distance * normal;
        onA -= aside * partOfA;
        onB += aside * (1 - partOfA);
    }
};

/// Appends the contact points of bodies `a` and `b` in a result.
void qcAppendPoints(const qcResult& result, qcBodyId a, const std::vector<qcTriangleSource>& sourcesA, qcBodyId b,
                    const std::vector<qcTriangleSource>& sourcesB, std::vector<qcMeshPoint>* points);

/// Up to four points with similar normals, by distance.
struct qcPointGroup
{
    int count = 0;
    const qcMeshPoint* points[4];
};

struct qcReductionDef
{
    btScalar contactDistance; ///< points at distances closer to it have less weight
    btScalar minSpacing;      ///< the points of a group are further apart, at either end
    int maxGroups = 1;
    /// Points with one normal that bodies reach fast within the step fill further groups, since a body turns about
    /// those that stop it.
    bool keepsReached = false;
    bool turns = false; ///< the bodies turn against each other: where they touched counts less than where they will
};

/// Groups points by normal, and reduces each group to the deepest point and up to three that span the largest area with
/// it, or four that carry it: for rigid bodies only the hull of points with equal normals matters. Distances are beyond
/// the margins. The points of a group are also further apart than their distances. The groups refer to `points`.
/// Returns the number of groups. O(points * (log(points) + maxGroups)).
int qcGroupPoints(const std::vector<qcMeshPoint>& points, const qcReductionDef& def, qcPointGroup* groups);

#endif
