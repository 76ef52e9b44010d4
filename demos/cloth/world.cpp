// The cloth, the table and the floor. All but the two lines with qcBroadphase and qcSoftBodySolver is plain Bullet.
#include "cloth/world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <cmath>

namespace
{
constexpr btScalar s_margin = btScalar(0.01);

btRigidBody::btRigidBodyConstructionInfo Fixed(btCollisionShape* shape, const btVector3& place)
{
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape);
    info.m_startWorldTransform.setOrigin(place);
    info.m_friction = btScalar(0.6);
    return info;
}
} // namespace

qcClothWorld::qcClothWorld(unsigned triangleCount, bool selfCollision, qcDevice* device, qcMethod method,
                           unsigned threads)
    : m_dispatcher(&m_configuration), m_softSolver(device),
      m_world(&m_dispatcher, &m_broadphase, &m_solver, &m_configuration, &m_softSolver),
      m_tableShape(btVector3(qcClothTable::radius, qcClothTable::thickness / 2, qcClothTable::radius)),
      m_floorShape(btVector3(0, 1, 0), 0),
      m_table(Fixed(&m_tableShape, btVector3(0, qcClothTable::height - qcClothTable::thickness / 2, 0))),
      m_floor(Fixed(&m_floorShape, btVector3(0, 0, 0))), m_gripShape(btVector3(gripHalf, gripHalf, gripHalfLength)),
      m_grip(0, &m_gripMotion, &m_gripShape), m_gripStart(0, 0, 0)
{
    m_tableShape.setMargin(s_margin);
    m_world.addRigidBody(&m_table);
    m_world.addRigidBody(&m_floor);
    btSoftBodyWorldInfo& info = m_world.getWorldInfo();
    info.m_gravity = m_world.getGravity();
    // Bullet samples shapes on a grid for soft bodies; the default of 0.25 m makes a round table square. Only Reset
    // takes the new size over.
    info.m_sparsesdf.setDefaultVoxelsz(btScalar(0.03));
    info.m_sparsesdf.Reset();
    m_softSolver.setMethod(method);
    m_softSolver.setThreadCount(threads);
    AddCloth(triangleCount, selfCollision);
}

qcClothWorld::~qcClothWorld()
{
    m_world.removeSoftBody(m_cloth);
    if (m_pulled >= 0)
        m_world.removeRigidBody(&m_grip);
    delete m_cloth;
    m_world.removeRigidBody(&m_floor);
    m_world.removeRigidBody(&m_table);
}

void qcClothWorld::AddCloth(unsigned triangleCount, bool selfCollision)
{
    int side = m_side = int(std::ceil(std::sqrt(triangleCount / 2.0)));
    // A little off the centre, so that the folds are not symmetric.
    btScalar x = btScalar(0.06), z = btScalar(-0.04), y = qcClothTable::height + btScalar(0.05);
    m_cloth = btSoftBodyHelpers::CreatePatch(m_world.getWorldInfo(), btVector3(x - 1, y, z - 1),
                                             btVector3(x + 1, y, z - 1), btVector3(x - 1, y, z + 1),
                                             btVector3(x + 1, y, z + 1), side + 1, side + 1, 0, true);
    m_cloth->getCollisionShape()->setMargin(s_margin);
    btSoftBody::Material* bending = m_cloth->appendMaterial();
    bending->m_kLST = btScalar(0.5);
    m_cloth->generateBendingConstraints(2, bending);
    m_cloth->m_cfg.piterations = 8;
    m_cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    // Bullet's default for contact with fixed bodies, 0.1, lets cloth sink through a table.
    m_cloth->m_cfg.kKHR = 1;
    m_cloth->m_cfg.kDP = btScalar(0.005);
    m_cloth->setTotalMass(1);
    m_world.addSoftBody(m_cloth);

    qcSoftBodySettings settings;
    settings.selfCollision = selfCollision;
    settings.thickness = btScalar(0.4) * 2 / btScalar(side); // of an edge
    settings.friction = btScalar(0.3);
    m_softSolver.setSettings(m_cloth, settings);

    for (int i = 0; i < m_cloth->m_faces.size(); i++)
        for (const btSoftBody::Node* node : m_cloth->m_faces[i].m_n)
            m_indices.push_back(uint32_t(node - &m_cloth->m_nodes[0]));
}

void qcClothWorld::PullAway()
{
    // Nodes of the middle fifth of the edge x = 1, which hangs between two corners.
    std::vector<int> held;
    for (int i = 2 * m_side / 5; i <= 3 * m_side / 5; i++)
        held.push_back(i * (m_side + 1) + m_side);
    m_gripStart.setZero();
    for (int node : held)
        m_gripStart += m_cloth->m_nodes[node].m_x / btScalar(held.size());
    btTransform place(btQuaternion::getIdentity(), m_gripStart);
    m_gripMotion.setWorldTransform(place);
    m_grip.setWorldTransform(place);
    m_grip.setCollisionFlags(m_grip.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    m_grip.setActivationState(DISABLE_DEACTIVATION);
    // It holds the cloth and collides with nothing.
    m_world.addRigidBody(&m_grip, btBroadphaseProxy::KinematicFilter, 0);
    for (int node : held)
        m_cloth->appendAnchor(node, &m_grip, true);
    // Over a table as rough as in the first act, the cloth stretches rather than slips.
    m_table.setFriction(btScalar(0.1));
    // The pull has to reach the other side, a hundred edges away: with 8 rounds in a step the cloth is rubber.
    m_cloth->m_cfg.piterations = 20;
    m_pulled = 0;
}

/// Speeds up, pulls up to the height of the table and away, and lets go.
void qcClothWorld::MoveGrip()
{
    constexpr btScalar speed = btScalar(1.4), rampSeconds = btScalar(0.5), riseMetres = btScalar(0.8);
    m_pulled += stepSeconds;
    if (m_pulled > pullSeconds)
    {
        m_cloth->m_anchors.clear();
        return;
    }
    auto t = btScalar(m_pulled);
    btScalar away = t < rampSeconds ? speed * t * t / (2 * rampSeconds) : speed * (t - rampSeconds / 2);
    btScalar height = qcClothTable::height - btScalar(0.1) - m_gripStart.y();
    btVector3 offset(away, height * btMin(away / riseMetres, btScalar(1)), 0);
    m_gripMotion.setWorldTransform(btTransform(btQuaternion::getIdentity(), m_gripStart + offset));
}

qcStepCosts qcClothWorld::Step()
{
    if (m_pulled >= 0)
        MoveGrip();
    qcStepCosts costs = qcTimeStep(&m_world, stepSeconds);
    costs.MoveSoft(m_softSolver.getStatistics());
    return costs;
}

const std::vector<float>& qcClothWorld::Positions()
{
    m_positions.resize(3 * size_t(m_cloth->m_nodes.size()));
    for (int i = 0; i < m_cloth->m_nodes.size(); i++)
        for (int axis = 0; axis < 3; axis++)
            m_positions[3 * size_t(i) + size_t(axis)] = float(m_cloth->m_nodes[i].m_x[axis]);
    return m_positions;
}
