// A soft body of the scene: what it collides with, and its motion.
#include "soft_body/scene/soft_scene.h"

#include <algorithm>

bool qcCollidesWithSurfaces(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    using Collision = btSoftBody::fCollision;
    // Bullet places the nodes of a reduced model itself.
    const int flags = body->m_cfg.collisions;
    return (flags & Collision::RVSmask) != 0 && (flags & Collision::CL_RS) == 0 && !settings.bulletNodeContacts &&
           !body->m_reducedModel;
}

btVector3 qcSceneSoftBody::VelocityMotionOf(size_t node, const btVector3& from) const
{
    const btVector3 motion = MotionOf(node, from);
    const btScalar length2 = applied.empty() ? btScalar(0) : applied[node].length2();
    if (!(length2 > 0))
        return motion;
    const btScalar taken = -applied[node].dot(MotionOf(node, solved[node])) / length2;
    return motion + applied[node] * std::min(std::max(taken, btScalar(0)), btScalar(1));
}

bool qcSceneSoftBody::FindMotionBox(btScalar reach, btVector3 box[2]) const
{
    if (!IsSolved())
        return qcFindMotionBox(start, positions, reach, box);
    box[0] = solvedBox[0];
    box[1] = solvedBox[1];
    qcEnlarge(reach, box);
    return hasSolvedBox;
}
