// A world of Bullet with this library's contact for the scenes of `qc-bench through`.
#include "bench/through/world.h"

#include <algorithm>

namespace
{
// Stiffness of a spring of the deformable world, relative to a node's mass over the square of the step: Bullet's
// explicit integration is stable below 0.25 with eight springs a node. Damping, relative to mass over step.
constexpr btScalar s_stiffness = btScalar(0.1), s_damping = btScalar(0.02);
// N/m: a cloth of 1 kg that hangs is stretched by a tenth.
constexpr btScalar s_implicitStiffness = 40;
constexpr btScalar s_margin = btScalar(0.01);
// Relative to an edge.
constexpr btScalar s_thickness = btScalar(0.4), s_jitter = btScalar(1e-4);
constexpr btScalar s_maxThickness = btScalar(0.03); ///< metres

//  Version 0.2.0, which is measured with these sources too, has no such setting.

template <class Settings>
auto SetContinuous(Settings* settings, bool continuous, int) -> decltype(settings->continuous = continuous)
{
    return settings->continuous = continuous;
}

template <class Settings> void SetContinuous(Settings*, bool, long)
{
}

btSoftBodyWorldInfo& InfoOf(btSoftRigidDynamicsWorld* classic, qcDeformableWorld* deformable)
{
    return classic != nullptr ? classic->getWorldInfo() : deformable->getWorldInfo();
}
} // namespace

btScalar qcJitter::Number()
{
    return 2 * btScalar(m_random() - m_random.min()) / btScalar(m_random.max() - m_random.min()) - 1;
}

btVector3 qcJitter::Vector()
{
    btScalar x = Number(), y = Number(), z = Number();
    return btVector3(x, y, z);
}

btTransform qcJitter::Rotation(const btVector3& center, btScalar angle)
{
    btVector3 axis = Vector() + btVector3(0, btScalar(1e-3), 0);
    btQuaternion turn(axis.normalized(), angle * Number());
    return btTransform(turn, center - quatRotate(turn, center));
}

qcThroughWorld::qcThroughWorld(const qcThroughWorldDef& worldDef) : m_def(worldDef)
{
    btVector3 gravity(0, -m_def.gravity, 0);
    if (m_def.kind == qc_throughDeformable || m_def.kind == qc_throughImplicit)
    {
        m_deformableConstraints.setDeformableSolver(&m_deformableSolver);
        m_deformable.reset(new qcDeformableWorld(&m_dispatcher, &m_broadphase, &m_deformableConstraints,
                                                 &m_configuration, &m_deformableSolver));
        m_deformable->setThreadCount(m_def.threads);
        m_deformable->setImplicit(m_def.kind == qc_throughImplicit);
        m_deformable->setUseProjection(m_def.kind == qc_throughImplicit);
        m_gravityForce.reset(new btDeformableGravityForce(gravity));
        m_world = m_deformable.get();
    }
    else
    {
        m_classic.reset(
            new btSoftRigidDynamicsWorld(&m_dispatcher, &m_broadphase, &m_solver, &m_configuration, &m_softSolver));
        m_world = m_classic.get();
    }
    m_contact.addTo(m_world);
    m_contact.setThreadCount(m_def.threads);
    m_softSolver.setThreadCount(m_def.threads);
    m_world->setGravity(gravity);
    InfoOf(m_classic.get(), m_deformable.get()).m_gravity = m_world->getGravity();
}

qcThroughWorld::~qcThroughWorld()
{
    for (const qcThroughBody& body : m_bodies)
    {
        if (body.soft != nullptr && m_deformable)
        {
            for (const auto& springs : m_springs)
                m_deformable->removeForce(body.soft, springs.get());
            m_deformable->removeForce(body.soft, m_gravityForce.get());
            m_deformable->removeSoftBody(body.soft);
        }
        else if (body.soft != nullptr)
            m_classic->removeSoftBody(body.soft);
        else
            m_world->removeRigidBody(body.rigid);
        delete body.soft;
        delete body.rigid;
    }
}

void qcThroughWorld::AddSoft(btSoftBody* soft, const btVector3& velocity, btScalar thickness)
{
    soft->getCollisionShape()->setMargin(s_margin);
    soft->m_cfg.piterations = 4;
    soft->m_cfg.kKHR = 1;
    soft->m_cfg.kCHR = 1;
    soft->m_sleepingThreshold = 0;
    soft->setActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < soft->m_nodes.size(); i++)
        if (soft->m_nodes[i].m_im > 0)
            soft->m_nodes[i].m_v = soft->m_nodes[i].m_vn = velocity;
    btScalar mass = soft->getTotalMass() / btScalar(soft->m_nodes.size());
    btScalar stiffness =
        m_def.kind == qc_throughImplicit ? s_implicitStiffness : s_stiffness * mass * btScalar(m_def.hz * m_def.hz);
    btScalar damping = s_damping * mass * btScalar(m_def.hz);
    qcSoftBodySettings settings;
    settings.thickness = thickness;
    settings.friction = btScalar(0.3);
    SetContinuous(&settings, m_def.continuous, 0);
    if (m_deformable)
    {
        soft->m_cfg.collisions = btSoftBody::fCollision::SDF_RD;
        m_deformable->setSettings(soft, settings);
        m_deformable->addSoftBody(soft);
        m_springs.emplace_back(new btDeformableMassSpringForce(stiffness, damping, true));
        m_deformable->addForce(soft, m_springs.back().get());
        m_deformable->addForce(soft, m_gravityForce.get());
    }
    else
    {
        m_softSolver.setSettings(soft, settings);
        m_classic->addSoftBody(soft);
    }
    m_bodies.emplace_back();
    m_bodies.back().soft = soft;
    m_bodies.back().stiffness = stiffness;
    qcTriangles& triangles = m_bodies.back().triangles;
    auto indexOf = [soft](const btSoftBody::Node* node) { return uint32_t(node - &soft->m_nodes[0]); };
    for (int i = 0; i < soft->m_faces.size(); i++)
        triangles.Add(indexOf(soft->m_faces[i].m_n[0]), indexOf(soft->m_faces[i].m_n[1]),
                      indexOf(soft->m_faces[i].m_n[2]));
    for (int i = 0; i < soft->m_links.size() && soft->m_faces.size() == 0; i++)
        triangles.Add(indexOf(soft->m_links[i].m_n[0]), indexOf(soft->m_links[i].m_n[1]),
                      indexOf(soft->m_links[i].m_n[1]));
}

btSoftBody* qcThroughWorld::AddCloth(const qcClothDef& def, qcJitter* jitter, btScalar turn)
{
    const btVector3& c = def.center;
    btVector3 x(def.halfX, 0, 0), z(0, 0, def.halfZ);
    btSoftBody* cloth =
        btSoftBodyHelpers::CreatePatch(InfoOf(m_classic.get(), m_deformable.get()), c - x - z, c + x - z, c - x + z,
                                       c + x + z + btVector3(0, def.tilt, 0), def.nodesX, def.nodesZ, 0, true);
    btScalar edge = std::min(2 * def.halfX / btScalar(def.nodesX - 1), 2 * def.halfZ / btScalar(def.nodesZ - 1));
    cloth->transform(jitter->Rotation(c, turn));
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        cloth->m_nodes[i].m_x += s_jitter * edge * jitter->Vector();
        cloth->m_nodes[i].m_q = cloth->m_nodes[i].m_x;
    }
    cloth->setTotalMass(def.mass);
    AddSoft(cloth, def.velocity, std::min(s_thickness * edge, s_maxThickness));
    return cloth;
}

btSoftBody* qcThroughWorld::AddRope(const btVector3& from, const btVector3& to, int nodes, qcJitter* jitter)
{
    btSoftBody* rope =
        btSoftBodyHelpers::CreateRope(InfoOf(m_classic.get(), m_deformable.get()), from, to, nodes - 2, 1 | 2);
    btScalar edge = (to - from).length() / btScalar(nodes - 1);
    for (int i = 0; i < nodes; i++)
    {
        rope->m_nodes[i].m_x += s_jitter * edge * jitter->Vector();
        rope->m_nodes[i].m_q = rope->m_nodes[i].m_x;
    }
    rope->setTotalMass(1);
    AddSoft(rope, btVector3(0, 0, 0), 0);
    return rope;
}

btRigidBody* qcThroughWorld::AddRigid(const qcTriangles& triangles, btScalar mass, const btTransform& place)
{
    btCollisionShape* shape = m_shapes.back().get();
    btVector3 inertia(0, 0, 0);
    if (mass > 0)
        shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform = place;
    m_bodies.emplace_back();
    m_bodies.back().rigid = new btRigidBody(info);
    m_bodies.back().triangles = triangles;
    m_bodies.back().rigid->setActivationState(DISABLE_DEACTIVATION);
    m_world->addRigidBody(m_bodies.back().rigid);
    return m_bodies.back().rigid;
}

btRigidBody* qcThroughWorld::AddMesh(const qcTriangles& triangles, btScalar mass, const btTransform& place)
{
    m_shapes.push_back(triangles.MakeShape());
    return AddRigid(triangles, mass, place);
}

btRigidBody* qcThroughWorld::AddShape(std::unique_ptr<btCollisionShape> shape, const qcTriangles& core,
                                      const btTransform& place)
{
    m_shapes.push_back(std::move(shape));
    return AddRigid(core, 0, place);
}

void qcThroughWorld::Step()
{
    m_world->stepSimulation(btScalar(1) / btScalar(m_def.hz), 0);
}

double qcThroughWorld::KineticEnergy() const
{
    double sum = 0;
    for (const qcThroughBody& body : m_bodies)
    {
        for (int i = 0; body.soft != nullptr && i < body.soft->m_nodes.size(); i++)
        {
            const btSoftBody::Node& node = body.soft->m_nodes[i];
            sum += node.m_im > 0 ? double(node.m_v.length2()) / double(node.m_im) / 2 : 0;
        }
        if (body.rigid == nullptr || body.rigid->isStaticOrKinematicObject())
            continue;
        const btRigidBody& rigid = *body.rigid;
        btVector3 spin = rigid.getAngularVelocity() * rigid.getWorldTransform().getBasis();
        sum += double(rigid.getMass() * rigid.getLinearVelocity().length2()) / 2;
        for (int axis = 0; axis < 3; axis++)
            if (rigid.getInvInertiaDiagLocal()[axis] > 0)
                sum += double(spin[axis] * spin[axis] / rigid.getInvInertiaDiagLocal()[axis]) / 2;
    }
    return sum;
}

/// At the nodes' positions; btDeformableMassSpringForce has that at the predicted ones.
double qcThroughWorld::SpringEnergy() const
{
    double sum = 0;
    for (const qcThroughBody& body : m_bodies)
        for (int i = 0; body.soft != nullptr && i < body.soft->m_links.size(); i++)
        {
            const btSoftBody::Link& link = body.soft->m_links[i];
            double stretch = double((link.m_n[1]->m_x - link.m_n[0]->m_x).length() - link.m_rl);
            sum += double(body.stiffness) * stretch * stretch / 2;
        }
    return sum;
}

double qcThroughWorld::Energy() const
{
    double sum = KineticEnergy();
    for (const qcThroughBody& body : m_bodies)
    {
        for (int i = 0; body.soft != nullptr && i < body.soft->m_nodes.size(); i++)
        {
            const btSoftBody::Node& node = body.soft->m_nodes[i];
            sum += node.m_im > 0 ? double(m_def.gravity) * double(node.m_x.y()) / double(node.m_im) : 0;
        }
        if (body.rigid != nullptr && !body.rigid->isStaticOrKinematicObject())
            sum += double(body.rigid->getMass() * m_def.gravity * body.rigid->getWorldTransform().getOrigin().y());
    }
    return m_deformable ? sum + SpringEnergy() : sum;
}

btVector3 qcThroughWorld::Momentum() const
{
    btVector3 sum(0, 0, 0);
    for (const qcThroughBody& body : m_bodies)
    {
        for (int i = 0; body.soft != nullptr && i < body.soft->m_nodes.size(); i++)
            if (body.soft->m_nodes[i].m_im > 0)
                sum += body.soft->m_nodes[i].m_v / body.soft->m_nodes[i].m_im;
        if (body.rigid != nullptr && !body.rigid->isStaticOrKinematicObject())
            sum += body.rigid->getLinearVelocity() * body.rigid->getMass();
    }
    return sum;
}

const qcSoftBodyStatistics& qcThroughWorld::SoftStatistics() const
{
    return m_deformable ? m_deformable->getStatistics() : m_softSolver.getStatistics();
}
