// Contact points of turning bodies. Bullet's solver takes a point along the straight line of its velocity; a vertex of
// a body that turns leaves that line for an arc. On a ball that rolls the vertices ahead of the lowest one seem to get
// into the ground, and brake it. Reasons and numbers: plugin/docs/mesh_contact.md, "Turning bodies".
#ifndef QC_GLUE_MESH_CONTACT_POINTS_TURNED_POINTS_H
#define QC_GLUE_MESH_CONTACT_POINTS_TURNED_POINTS_H

#include "mesh_contact/points/contact_reduction.h"

struct btCollisionObjectWrapper;

/// Moves points that a body approaches by turning to where its vertex is when it gets nearest to the other body's face
/// within the step, or touches it, with the distance for which the solver's straight line ends at the same height.
/// Points keep their normals. Unchanged are points where the body that turns less has an edge or a vertex, and those
/// whose arcs hardly differ from lines. Ends are on the margins, distances beyond them. O(points), and for shapes other
/// than qcMeshShape and planes a query of their tree for each turned point.
void qcTurnPoints(const btCollisionObjectWrapper& body0, btScalar margin0, const btCollisionObjectWrapper& body1,
                  btScalar margin1, btScalar timeStep, std::vector<qcMeshPoint>* points);

#endif
