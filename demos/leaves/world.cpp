// The tree, its leaves, the ground and the wind. All but the lines with qcBroadphase, qcSoftBodySolver and qcMeshShape
// is plain Bullet.
#include "leaves/world.h"

#include "leaves/growth.h"
#include "leaves/random.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <algorithm>
#include <cmath>

namespace
{
constexpr btScalar s_thickness = btScalar(0.006);  // of a leaf, m
constexpr btScalar s_treeMargin = btScalar(0.004); // m
constexpr btScalar s_leafMass = btScalar(0.003);   // kg
constexpr btScalar s_springiness = btScalar(0.07);
constexpr btScalar s_air = btScalar(1.2); // kg/m3

// Gusts, in which most leaves let go.
struct Gust
{
    double seconds;
    btScalar speed; // m/s
};
constexpr Gust s_gusts[] = {{1.2, btScalar(1.6)}, {3.0, btScalar(2.2)}, {4.6, btScalar(1.4)}};
constexpr double s_gustSeconds = 0.35; // from its height to 37 %

btScalar GustSpeed(double seconds)
{
    btScalar speed = 0;
    for (const Gust& gust : s_gusts)
        speed += gust.speed * btScalar(std::exp(-std::pow((seconds - gust.seconds) / s_gustSeconds, 2)));
    return speed;
}

/// When a leaf lets go: some in still air, most in a gust, a few not at all.
double LetsGo(qcRandom* random)
{
    btScalar kind = (*random)(0, 1), spread = (*random)(-1, 1);
    if (kind < btScalar(0.06))
        return HUGE_VAL;
    if (kind < btScalar(0.30))
        return double((*random)(btScalar(0.2), 5));
    const Gust& gust = s_gusts[kind < btScalar(0.50) ? 0 : kind < btScalar(0.80) ? 1 : 2];
    return gust.seconds + s_gustSeconds * double(spread);
}

btRigidBody::btRigidBodyConstructionInfo Fixed(btCollisionShape* shape)
{
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape);
    info.m_friction = btScalar(0.6);
    return info;
}
} // namespace

qcLeavesWorld::qcLeavesWorld(const qcLeavesRequest& request, qcDevice* device)
    : m_request(request), m_dispatcher(&m_configuration), m_softSolver(device),
      m_world(&m_dispatcher, &m_broadphase, &m_solver, &m_configuration, &m_softSolver),
      m_tree(qcGrowTree(request.seed)), m_groundShape(btVector3(0, 1, 0), 0), m_ground(Fixed(&m_groundShape))
{
    m_softSolver.setMethod(request.method);
    m_softSolver.setThreadCount(request.threads);
    btSoftBodyWorldInfo& info = m_world.getWorldInfo();
    info.m_gravity = m_world.getGravity();
    info.air_density = s_air;
    m_world.addRigidBody(&m_ground);
    AddTree();
    qcRandom random(request.seed);
    for (const qcLeafMesh& leaf : qcGrowLeaves(m_tree, request.leaves, s_thickness + s_treeMargin, request.seed))
        AddLeaf(leaf, LetsGo(&random));
}

qcLeavesWorld::~qcLeavesWorld()
{
    for (const Leaf& leaf : m_leaves)
    {
        m_world.removeSoftBody(leaf.body);
        delete leaf.body;
    }
    m_world.removeRigidBody(m_treeBody.get());
    m_world.removeRigidBody(&m_ground);
}

void qcLeavesWorld::AddTree()
{
    m_treeShape = std::make_unique<qcMeshShape>(m_tree.vertices.data(), qcBulletPositions, sizeof(btVector3),
                                                uint32_t(m_tree.vertices.size()), m_tree.indices.data(),
                                                uint32_t(m_tree.indices.size() / 3));
    m_treeShape->setMargin(s_treeMargin);
    m_treeBody = std::make_unique<btRigidBody>(Fixed(m_treeShape.get()));
    m_world.addRigidBody(m_treeBody.get());
}

void qcLeavesWorld::AddLeaf(const qcLeafMesh& mesh, double letsGo)
{
    std::vector<btScalar> positions;
    for (const btVector3& vertex : mesh.vertices)
        positions.insert(positions.end(), {vertex.x(), vertex.y(), vertex.z()});
    btSoftBody* body = btSoftBodyHelpers::CreateFromTriMesh(m_world.getWorldInfo(), positions.data(),
                                                            mesh.indices.data(), int(mesh.indices.size() / 3));
    btSoftBody::Material* bending = body->appendMaterial();
    bending->m_kLST = btScalar(0.6);
    body->generateBendingConstraints(2, bending);
    body->setTotalMass(s_leafMass);
    // The shape that a leaf goes back to when it was bent, at this share of the way in a step.
    body->setPose(false, true);
    body->m_cfg.kMT = s_springiness;
    body->m_cfg.piterations = 4;
    body->m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    body->m_cfg.kKHR = 1;
    body->m_cfg.kDP = btScalar(0.01);
    body->m_cfg.aeromodel = btSoftBody::eAeroModel::F_TwoSided;
    body->m_cfg.kDG = btScalar(0.06);
    body->m_cfg.kLF = btScalar(0.22);
    body->getCollisionShape()->setMargin(s_thickness);
    for (int i = 0; i < qcLeafStalkVertices; i++)
        body->setMass(i, 0);
    qcSoftBodySettings settings;
    settings.thickness = s_thickness;
    settings.friction = btScalar(0.3);
    // Stiff and folded along the midrib, a leaf doesn't reach itself; contact would cost a third of the step.
    settings.selfCollision = false;
    m_softSolver.setSettings(body, settings);
    m_world.addSoftBody(body);
    m_leaves.push_back({body, letsGo, true});
    if (m_leafIndices.empty())
        m_leafIndices.assign(mesh.indices.begin(), mesh.indices.end());
}

/// The stalk moves freely from now on.
void qcLeavesWorld::LetGo(Leaf* leaf)
{
    btSoftBody::tNodeArray& nodes = leaf->body->m_nodes;
    for (int i = 0; i < qcLeafStalkVertices; i++)
        nodes[i].m_im = nodes[nodes.size() - 1].m_im;
    // Not setMass, after which Bullet takes the present shape of the leaf for its shape at rest.
    leaf->body->updateLinkConstants();
    leaf->hangs = false;
}

/// A breeze along x, gusts, and turbulence that moves along with them.
btVector3 qcLeavesWorld::Wind(const btVector3& place) const
{
    btScalar t = btScalar(m_seconds), gust = GustSpeed(m_seconds - double(place.x()) * 0.15);
    btScalar x = place.x() - t * btScalar(0.8), y = place.y(), z = place.z();
    btVector3 turbulence(std::sin(btScalar(2.9) * z + btScalar(1.7) * y + btScalar(3.1) * t),
                         std::sin(btScalar(3.7) * x + btScalar(2.3) * z + btScalar(4.3) * t),
                         std::sin(btScalar(2.3) * x - btScalar(3.1) * y + btScalar(3.7) * t));
    // Calm near the ground.
    btScalar height = btMin(btScalar(1), btScalar(0.15) + y);
    return height * (btVector3(btScalar(0.25) + gust, 0, gust * btScalar(0.25)) +
                     turbulence * (btScalar(0.35) + btScalar(0.4) * gust));
}

qcStepCosts qcLeavesWorld::Step()
{
    for (Leaf& leaf : m_leaves)
    {
        if (leaf.hangs && m_seconds >= leaf.letsGo)
            LetGo(&leaf);
        leaf.body->setWindVelocity(Wind((leaf.body->m_bounds[0] + leaf.body->m_bounds[1]) / 2));
    }
    qcStepCosts costs = qcTimeStep(&m_world, stepSeconds);
    costs.MoveSoft(m_softSolver.getStatistics());
    m_seconds += stepSeconds;
    return costs;
}

void qcLeavesWorld::AppendPositions(size_t leaf, double seconds, std::vector<float>* positions) const
{
    const btSoftBody::tNodeArray& nodes = m_leaves[leaf].body->m_nodes;
    for (int i = 0; i < nodes.size(); i++)
    {
        btVector3 place = nodes[i].m_x + nodes[i].m_v * btScalar(seconds);
        positions->insert(positions->end(), {float(place.x()), float(place.y()), float(place.z())});
    }
}

size_t qcLeavesWorld::HangingCount() const
{
    return size_t(std::count_if(m_leaves.begin(), m_leaves.end(), [](const Leaf& leaf) { return leaf.hangs; }));
}

double qcLeavesWorld::KineticEnergy() const
{
    double energy = 0;
    for (const Leaf& leaf : m_leaves)
        for (int i = 0; i < leaf.body->m_nodes.size(); i++)
        {
            const btSoftBody::Node& node = leaf.body->m_nodes[i];
            if (node.m_im > 0)
                energy += 0.5 * double(node.m_v.length2() / node.m_im);
        }
    return energy;
}

double qcLeavesWorld::Lowest() const
{
    btScalar lowest = BT_LARGE_FLOAT;
    for (const Leaf& leaf : m_leaves)
        for (int i = 0; i < leaf.body->m_nodes.size(); i++)
            lowest = btMin(lowest, leaf.body->m_nodes[i].m_x.y());
    return double(lowest);
}
