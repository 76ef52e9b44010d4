// Bullet's two worlds of soft bodies and multibodies, with this library's contact.
#ifndef QC_TESTS_BULLET_SOFT_BODY_MULTIBODY_WORLD_H
#define QC_TESTS_BULLET_SOFT_BODY_MULTIBODY_WORLD_H

#include "bullet/moving_links.h"
#include "bullet/soft_body/deformable_test_world.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

/// A world with cloths, which it removes and deletes.
class qcMultiBodyWorld
{
  public:
    virtual ~qcMultiBodyWorld() = default;
    virtual btMultiBodyDynamicsWorld& World() = 0;
    virtual qcSoftBodyContact& Contact() = 0;
    virtual btScalar TimeStep() const = 0;
    /// A square of 2 m, at a height, of 1 kg. `pinned`: at its four corners.
    virtual btSoftBody* AddCloth(btScalar height, bool pinned, int side = 16) = 0;

    void Step()
    {
        World().stepSimulation(TimeStep(), 0);
        ck_assert_int_eq(Contact().getStatistics().status, qc_statusOk);
    }
    /// A step in which nothing passes anything.
    void StepApart(qcMotionOracle& oracle)
    {
        Step();
        ck_assert_uint_eq(oracle.Count(), 0);
        ck_assert_int_eq(Contact().getStatistics().unproven, 0);
    }

  protected:
    static btSoftBody* MakeCloth(btSoftBodyWorldInfo& info, btScalar height, bool pinned, int side)
    {
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(info, btVector3(-1, height, -1), btVector3(1, height, -1),
                                                           btVector3(-1, height, 1), btVector3(1, height, 1), side + 1,
                                                           side + 1, pinned ? 15 : 0, true);
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        cloth->setTotalMass(1);
        return cloth;
    }
};

class qcClassicMultiBodyWorld : public qcMultiBodyWorld
{
  public:
    explicit qcClassicMultiBodyWorld(const btVector3& gravity)
    {
        m_world.setGravity(gravity);
        m_world.getWorldInfo().m_gravity = gravity;
        m_contact.setThreadCount(1);
    }
    ~qcClassicMultiBodyWorld() override
    {
        for (btSoftBody* cloth : m_cloths)
        {
            m_world.removeSoftBody(cloth);
            delete cloth;
        }
    }
    btMultiBodyDynamicsWorld& World() override
    {
        return m_world;
    }
    qcSoftBodyContact& Contact() override
    {
        return m_contact;
    }
    btScalar TimeStep() const override
    {
        return btScalar(1.0 / 60);
    }
    btSoftBody* AddCloth(btScalar height, bool pinned, int side) override
    {
        btSoftBody* cloth = MakeCloth(m_world.getWorldInfo(), height, pinned, side);
        cloth->m_cfg.piterations = 8;
        m_world.addSoftBody(cloth);
        m_cloths.push_back(cloth);
        return cloth;
    }

  private:
    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btMultiBodyConstraintSolver m_solver;
    qcSoftBodySolver m_contact;
    btSoftMultiBodyDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration, &m_contact};
    std::vector<btSoftBody*> m_cloths;
};

class qcDeformableMultiBodyWorld : public qcMultiBodyWorld
{
  public:
    explicit qcDeformableMultiBodyWorld(const btVector3& g) : m_gravity(g)
    {
        m_test.world->setGravity(g);
        m_test.world->getWorldInfo().m_gravity = g;
        m_test.world->setThreadCount(1);
    }
    btMultiBodyDynamicsWorld& World() override
    {
        return *m_test.world;
    }
    qcSoftBodyContact& Contact() override
    {
        return *m_test.world;
    }
    btScalar TimeStep() const override
    {
        return btScalar(1.0 / 120);
    }
    btSoftBody* AddCloth(btScalar height, bool pinned, int side) override
    {
        btSoftBody* cloth = MakeCloth(m_test.world->getWorldInfo(), height, pinned, side);
        cloth->m_cfg.collisions =
            btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::VF_DD;
        m_test.world->addSoftBody(cloth);
        m_test.world->addForce(cloth, &m_springs);
        m_test.world->addForce(cloth, &m_gravity);
        m_test.cloths.push_back(cloth);
        return cloth;
    }

  private:
    btDeformableMassSpringForce m_springs{30, btScalar(0.2), true};
    btDeformableGravityForce m_gravity;
    qcDeformableTestWorld<qcDeformableWorld> m_test;
};

/// The classic world, or the deformable one.
inline std::unique_ptr<qcMultiBodyWorld> qcMakeMultiBodyWorld(bool isDeformable, const btVector3& gravity)
{
    if (isDeformable)
        return std::unique_ptr<qcMultiBodyWorld>(new qcDeformableMultiBodyWorld(gravity));
    return std::unique_ptr<qcMultiBodyWorld>(new qcClassicMultiBodyWorld(gravity));
}

/// A static box. It is in its world while it lives.
class qcFixedBox
{
  public:
    qcFixedBox(qcMultiBodyWorld& world, const btVector3& half, const btVector3& place)
        : m_world(world.World()), m_shape(half), m_body(0, nullptr, &m_shape)
    {
        m_body.setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
        m_world.addRigidBody(&m_body);
    }
    ~qcFixedBox()
    {
        m_world.removeRigidBody(&m_body);
    }
    qcFixedBox(const qcFixedBox&) = delete;
    qcFixedBox& operator=(const qcFixedBox&) = delete;

    const btRigidBody* Body() const
    {
        return &m_body;
    }

  private:
    btMultiBodyDynamicsWorld& m_world;
    btBoxShape m_shape;
    btRigidBody m_body;
};

/// A multibody whose links are boxes. It is in its world while it lives.
class qcRobot
{
  public:
    qcRobot(qcMultiBodyWorld& world, int links, btScalar baseMass, const btVector3& baseHalf, bool hasFixedBase)
        : qcRobot(world.World(), links, baseMass, baseHalf, hasFixedBase)
    {
    }
    qcRobot(btMultiBodyDynamicsWorld& world, int links, btScalar baseMass, const btVector3& baseHalf, bool hasFixedBase)
        : m_world(world), m_body(links, baseMass, InertiaOf(baseMass, baseHalf), hasFixedBase, true)
    {
        m_body.setLinearDamping(0);
        m_body.setAngularDamping(0);
    }
    ~qcRobot()
    {
        for (const std::unique_ptr<Part>& part : m_parts)
            m_world.removeCollisionObject(&part->collider);
        m_world.removeMultiBody(&m_body);
    }
    qcRobot(const qcRobot&) = delete;
    qcRobot& operator=(const qcRobot&) = delete;

    btMultiBody& Body()
    {
        return m_body;
    }
    static btVector3 InertiaOf(btScalar mass, const btVector3& half)
    {
        btVector3 inertia;
        btBoxShape(half).calculateLocalInertia(mass, inertia);
        return inertia;
    }
    /// Ends the set-up of joints. `isStepped`: the world moves it.
    void Finish(bool isStepped = true)
    {
        m_body.finalizeMultiDof();
        if (isStepped)
            m_world.addMultiBody(&m_body);
    }
    /// Makes a link (-1: the base) a box. Call Finish before.
    btMultiBodyLinkCollider* AddBox(int link, const btVector3& half)
    {
        m_parts.emplace_back(new Part(&m_body, link, half));
        btMultiBodyLinkCollider* collider = &m_parts.back()->collider;
        if (link < 0)
            m_body.setBaseCollider(collider);
        else
            m_body.getLink(link).m_collider = collider;
        m_world.addCollisionObject(collider, 1, -1);
        Place();
        return collider;
    }
    /// Moves the colliders to where the joints are.
    void Place()
    {
        qcPlaceColliders(m_body);
    }
    /// Watches the boxes, each less `inside` on all sides; they don't count against each other.
    void Watch(qcMotionOracle& oracle, btScalar inside = 0) const
    {
        for (const std::unique_ptr<Part>& part : m_parts)
        {
            const qcModel model = qcBoxModel(part->half - btVector3(inside, inside, inside), 1);
            const btCollisionObject* collider = &part->collider;
            oracle.Add([model, collider] { return qcWorldMeshOf(model, collider->getWorldTransform()); }, 1);
        }
    }
    btVector3 Momentum() const
    {
        btVector3 sum(0, 0, 0);
        qcForEachLink(m_body,
                      [&sum](const qcMovingLink& link) { sum += link.place.getBasis() * link.velocity * link.mass; });
        return sum;
    }
    btScalar Energy(const btVector3& gravity) const
    {
        return qcEnergyOf(m_body, gravity);
    }

  private:
    struct Part
    {
        btVector3 half;
        btBoxShape shape;
        btMultiBodyLinkCollider collider;

        Part(btMultiBody* body, int link, const btVector3& size) : half(size), shape(size), collider(body, link)
        {
            shape.setMargin(btScalar(0.005));
            collider.setCollisionShape(&shape);
        }
    };

    btMultiBodyDynamicsWorld& m_world;
    btMultiBody m_body;
    std::vector<std::unique_ptr<Part>> m_parts;
};

#endif
