// Random starts of a Bullet world.
#include "bench/stability/jitter.h"

#include "bench/stability/world_support.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include <random>

namespace
{
class Draws
{
  public:
    explicit Draws(uint32_t start) : m_random(start)
    {
    }
    btScalar Within(double half)
    {
        return btScalar(half * m_part(m_random));
    }
    btVector3 Vector(double x, double y, double z)
    {
        btScalar first = Within(x), second = Within(y);
        return btVector3(first, second, Within(z));
    }

  private:
    std::mt19937 m_random;
    std::uniform_real_distribution<double> m_part{-1, 1};
};

/// A turn around `center`, and a shift.
btTransform Around(const btVector3& center, const btMatrix3x3& turn, const btVector3& shift)
{
    return btTransform(turn, center - turn * center + shift);
}

void JitterRigid(btRigidBody* body, double shift, double turn, Draws* draws)
{
    btVector3 axis = draws->Vector(1, 1, 1) + btVector3(0, btScalar(1e-3), 0);
    btMatrix3x3 rotation(btQuaternion(axis.normalized(), draws->Within(turn)));
    btTransform place = body->getWorldTransform();
    place = Around(place.getOrigin(), rotation, draws->Vector(shift, 0, shift)) * place;
    body->setWorldTransform(place);
    body->setInterpolationWorldTransform(place);
}

void JitterSoft(btSoftBody* body, double shift, double turn, Draws* draws)
{
    if (qcIsHeld(*body) || body->m_nodes.size() == 0)
        return;
    btVector3 center(0, 0, 0);
    for (int i = 0; i < body->m_nodes.size(); i++)
        center += body->m_nodes[i].m_x / btScalar(body->m_nodes.size());
    btMatrix3x3 rotation(btQuaternion(btVector3(0, 1, 0), draws->Within(turn)));
    body->transform(Around(center, rotation, draws->Vector(shift, 0, shift)));
    for (int i = 0; i < body->m_nodes.size(); i++)
    {
        btSoftBody::Node& node = body->m_nodes[i];
        node.m_x += draws->Vector(shift / 100, shift / 100, shift / 100);
        node.m_q = node.m_x;
    }
}
} // namespace

void qcJitterStart(btDiscreteDynamicsWorld* world, double shift, double turn, uint32_t start)
{
    Draws draws(start);
    btCollisionObjectArray& objects = world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        if (!qcMoves(*objects[i]))
            continue;
        if (btSoftBody* soft = btSoftBody::upcast(objects[i]))
            JitterSoft(soft, shift, turn, &draws);
        else if (btRigidBody* rigid = btRigidBody::upcast(objects[i]))
            JitterRigid(rigid, shift, turn, &draws);
    }
}
