// Restitution of contact points that bodies reach within a step. Bullet's solver stops bodies at such a point, and
// would take the speed that closes its distance from that of the bounce: hardly anything bounced. So it solves them
// without restitution, and the bounce is added once the transforms are integrated.
#ifndef QC_GLUE_MESH_CONTACT_BOUNCES_H
#define QC_GLUE_MESH_CONTACT_BOUNCES_H

class btDynamicsWorld;
class btPersistentManifold;

/// Before the solver: points at a distance get the speed of their bounce, negative, in place of their restitution. The
/// solver takes what is negative for 0.
void qcMarkBounces(btPersistentManifold* manifold);

/// After the solver: bodies that it has stopped at marked points get these speeds. Points have their restitution again.
void qcApplyBounces(btDynamicsWorld* world);

#endif
