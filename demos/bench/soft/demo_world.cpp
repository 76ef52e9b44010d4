// The worlds of the demo scenes: classic or deformable, with this library's contact or Bullet's.
#include "bench/soft/demo_scenes.h"
#include "bench/soft/soft_scene.h"
#include "bench/soft/tangle_scene.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

/// Members are in the order in which Bullet requires them to be made.
struct qcDemoScene::World
{
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> rigid;
    std::vector<std::unique_ptr<btSoftBody>> soft;
    std::vector<std::unique_ptr<btDeformableLagrangianForce>> forces;
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btDeformableBodySolver deformableSolver;
    btSequentialImpulseConstraintSolver classicSolver;
    btDeformableMultiBodyConstraintSolver solver; ///< of the deformable world
    qcSoftBodySolver quick;
    btDefaultSoftBodySolver bullets;
    std::unique_ptr<btSoftRigidDynamicsWorld> classic;              ///< or null
    std::unique_ptr<btDeformableMultiBodyDynamicsWorld> deformable; ///< or null
    std::unique_ptr<btMultiBody> chain;                             ///< or null
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> links;    ///< of the chain
    qcSoftBodyContact* contact = nullptr;                           ///< null: Bullet's

    btDiscreteDynamicsWorld& Dynamics()
    {
        return classic ? static_cast<btDiscreteDynamicsWorld&>(*classic) : *deformable;
    }
    void MakeClassic(bool ours)
    {
        btSoftBodySolver* softSolver = ours ? static_cast<btSoftBodySolver*>(&quick) : &bullets;
        classic.reset(
            new btSoftRigidDynamicsWorld(&dispatcher, &broadphase, &classicSolver, &configuration, softSolver));
        contact = ours ? &quick : nullptr;
    }
    void MakeDeformable(bool ours)
    {
        solver.setDeformableSolver(&deformableSolver);
        if (!ours)
        {
            deformable.reset(new btDeformableMultiBodyDynamicsWorld(&dispatcher, &broadphase, &solver, &configuration,
                                                                    &deformableSolver));
            return;
        }
        auto* world = new qcDeformableWorld(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver);
        deformable.reset(world);
        contact = world;
    }
};

qcDemoScene::qcDemoScene(qcDemoContact contact, bool isDeformable, void (*make)(qcDemoScene&))
    : m_contact(contact), m_world(new World)
{
    bool ours = contact != qcDemoContact::bullets;
    if (isDeformable)
        m_world->MakeDeformable(ours);
    else
        m_world->MakeClassic(ours);
    Info().m_gravity = btVector3(0, -10, 0);
    Info().m_sparsesdf.setDefaultVoxelsz(btScalar(0.25));
    m_world->Dynamics().setGravity(Info().m_gravity);
    make(*this);
}

qcDemoScene::~qcDemoScene()
{
    for (const auto& body : m_world->soft)
        if (m_world->classic)
            m_world->classic->removeSoftBody(body.get());
        else
            m_world->deformable->removeSoftBody(body.get());
    for (const auto& body : m_world->rigid)
        m_world->Dynamics().removeRigidBody(body.get());
    for (const auto& link : m_world->links)
        m_world->Dynamics().removeCollisionObject(link.get());
    if (m_world->chain)
        m_world->deformable->removeMultiBody(m_world->chain.get());
}

void qcDemoScene::Step()
{
    m_world->Dynamics().stepSimulation(m_world->classic ? btScalar(1.0 / 60) : btScalar(1.0 / 240), 0);
}

size_t qcDemoScene::NodeCount() const
{
    size_t count = 0;
    for (const auto& body : m_world->soft)
        count += size_t(body->m_nodes.size());
    return count;
}

size_t qcDemoScene::CountTangled() const
{
    std::vector<const btSoftBody*> bodies;
    for (const auto& body : m_world->soft)
        bodies.push_back(body.get());
    return qcCountTangled(bodies);
}

btSoftBodyWorldInfo& qcDemoScene::Info()
{
    return m_world->classic ? m_world->classic->getWorldInfo() : m_world->deformable->getWorldInfo();
}

void qcDemoScene::Add(btSoftBody* body, std::vector<btDeformableLagrangianForce*> forces)
{
    m_world->soft.emplace_back(body);
    if (m_contact == qcDemoContact::oursLikeBullets)
    {
        qcSoftBodySettings settings;
        settings.selfCollision = false;
        settings.bulletNodeContacts = true;
        m_world->contact->setSettings(body, settings);
    }
    if (m_world->classic)
        m_world->classic->addSoftBody(body);
    else
        m_world->deformable->addSoftBody(body);
    for (btDeformableLagrangianForce* force : forces)
    {
        m_world->forces.emplace_back(force);
        m_world->deformable->addForce(body, force);
    }
}

btRigidBody* qcDemoScene::AddRigid(btScalar mass, const btVector3& place, btCollisionShape* shape)
{
    btVector3 inertia(0, 0, 0);
    m_world->shapes.emplace_back(shape);
    if (mass > 0)
        shape->calculateLocalInertia(mass, inertia);
    m_world->rigid.emplace_back(new btRigidBody(mass, nullptr, shape, inertia));
    btRigidBody* body = m_world->rigid.back().get();
    body->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
    m_world->Dynamics().addRigidBody(body);
    return body;
}

void qcDemoScene::AddChain(int boxes, const btVector3& place, const btVector3& half)
{
    const btScalar mass = btScalar(0.1);
    const btVector3 down(0, -half.y(), 0);
    btVector3 inertia;
    m_world->shapes.emplace_back(new btBoxShape(half));
    btCollisionShape* shape = m_world->shapes.back().get();
    shape->calculateLocalInertia(mass, inertia);
    m_world->chain.reset(new btMultiBody(boxes - 1, mass, inertia, false, false));
    btMultiBody& chain = *m_world->chain;
    chain.setBasePos(place);
    for (int i = 0; i + 1 < boxes; i++)
        chain.setupRevolute(i, mass, inertia, i - 1, btQuaternion::getIdentity(), btVector3(1, 0, 0), down, down, true);
    chain.finalizeMultiDof();
    m_world->deformable->addMultiBody(&chain);
    for (int i = -1; i + 1 < boxes; i++)
    {
        m_world->links.emplace_back(new btMultiBodyLinkCollider(&chain, i));
        btMultiBodyLinkCollider* link = m_world->links.back().get();
        link->setCollisionShape(shape);
        m_world->Dynamics().addCollisionObject(link, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
        if (i < 0)
            chain.setBaseCollider(link);
        else
            chain.getLink(i).m_collider = link;
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    chain.forwardKinematics(rotations, origins);
    chain.updateCollisionObjectWorldTransforms(rotations, origins);
}
