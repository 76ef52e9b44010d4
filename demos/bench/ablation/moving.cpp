// Simulations in Bullet: final penetration and final speeds of the bodies.
#include "bench/ablation/ablation.h"
#include "bench/ablation/shapes.h"

#include "quickcullide/bullet.h"
#include "quickcullide/bullet_mesh.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <memory>
#include <random>

namespace
{
constexpr btScalar s_step = btScalar(1.0 / 60);
constexpr unsigned s_lastSteps = 60; // in which speeds are measured

class World
{
  public:
    World()
    {
        m_contact.addTo(&m_world);
        m_contact.setThreadCount(1);
    }

    ~World()
    {
        for (const Body& body : m_bodies)
            m_world.removeRigidBody(body.rigid.get());
    }
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    /// Adds a body; mass 0: static.
    void Add(const qcAblationMesh& mesh, btScalar mass, const btTransform& place)
    {
        Body body;
        body.mesh = mesh;
        body.shape = std::make_unique<qcMeshShape>(
            mesh.vertices.data(), sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32,
            sizeof(btVector3), uint32_t(mesh.vertices.size()), mesh.indices.data(), uint32_t(mesh.indices.size() / 3));
        body.shape->setMargin(btScalar(0.001));
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            body.shape->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, body.shape.get(), inertia);
        info.m_startWorldTransform = place;
        info.m_friction = btScalar(0.6);
        body.rigid = std::make_unique<btRigidBody>(info);
        // A body that sleeps would hide that its contacts tremble.
        body.rigid->setActivationState(DISABLE_DEACTIVATION);
        m_world.addRigidBody(body.rigid.get());
        m_bodies.push_back(std::move(body));
    }

    qcAblationResult Run(const char* stage, unsigned steps)
    {
        qcAblationResult result;
        std::vector<double> speeds;
        qcSwitchOff(stage);
        for (unsigned step = 0; step < steps; step++)
        {
            m_world.stepSimulation(s_step, 0);
            qcExpectOk(m_contact.getStatistics().status);
            result.ms += m_contact.getStatistics().manifoldMs / steps;
            result.points += double(CountPoints()) / steps;
            if (step + s_lastSteps >= steps)
                AddSpeeds(&speeds);
        }
        qcSwitchOff("");
        std::nth_element(speeds.begin(), speeds.begin() + speeds.size() / 2, speeds.end());
        result.speed = 1e3 * speeds[speeds.size() / 2];
        result.penetration = 1e3 * FindPenetration();
        return result;
    }

  private:
    struct Body
    {
        qcAblationMesh mesh;
        std::unique_ptr<qcMeshShape> shape;
        std::unique_ptr<btRigidBody> rigid;
    };

    int CountPoints()
    {
        int points = 0;
        for (int m = 0; m < m_dispatcher.getNumManifolds(); m++)
            points += m_dispatcher.getManifoldByIndexInternal(m)->getNumContacts();
        return points;
    }

    void AddSpeeds(std::vector<double>* speeds) const
    {
        for (const Body& body : m_bodies)
            if (!body.rigid->isStaticObject())
                speeds->push_back(double(body.rigid->getLinearVelocity().length()));
    }

    /// The deepest overlap of the bodies, by a new detection with all stages.
    double FindPenetration() const
    {
        qcSceneDef sceneDef = qcDefaultSceneDef();
        qcScene* scene = nullptr;
        qcExpectOk(qcScene_Create(&sceneDef, &scene));
        for (const Body& body : m_bodies)
        {
            qcAblationMesh placed = body.mesh;
            for (btVector3& v : placed.vertices)
                v = body.rigid->getWorldTransform() * v;
            qcAddRigid(scene, placed);
        }
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.margin = 0.005;
        def.manifolds = true;
        const qcResult* result = nullptr;
        qcExpectOk(qcScene_Detect(scene, &def, &result));
        double deepest = 0;
        for (size_t i = 0; i < result->manifoldPointCount; i++)
            deepest = std::max(deepest, -result->manifoldPoints[i].distance);
        qcScene_Destroy(scene);
        return deepest;
    }

    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    qcMeshContact m_contact;
    btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
    std::vector<Body> m_bodies;
};

void AddFloor(World* world)
{
    qcAblationMesh floor;
    qcAddTiles(&floor, btVector3(-4, 0, -4), btVector3(0, 0, 8), btVector3(8, 0, 0), 16);
    world->Add(floor, 0, btTransform::getIdentity());
}

/// Columns of bodies, each turned in its own way, above a bin.
qcAblationResult RunPile(const qcAblationMesh& mesh, btScalar spacing, unsigned seed, const char* stage, unsigned steps)
{
    World world;
    world.Add(qcBinOf(3 * spacing, 3), 0, btTransform::getIdentity());
    std::mt19937 random(seed);
    auto uniform = [&random] { return btScalar(random()) / btScalar(std::mt19937::max()) * 2 - 1; };
    for (int i = 0; i < 24; i++)
    {
        btQuaternion turn(btVector3(uniform(), uniform(), uniform() + 2).normalized(), 3 * uniform());
        btVector3 at(btScalar(i % 2) - btScalar(0.5), btScalar(i / 4) + btScalar(0.7),
                     btScalar(i / 2 % 2) - btScalar(0.5));
        world.Add(mesh, 1, btTransform(turn, at * spacing));
    }
    return world.Run(stage, steps);
}

} // namespace

qcAblationResult qcRunBoxPile(unsigned randomSeed, const char* stage, unsigned steps)
{
    return RunPile(qcBoxOf(btScalar(0.3), 3), btScalar(0.55), randomSeed, stage, steps);
}

qcAblationResult qcRunTorusPile(unsigned randomSeed, const char* stage, unsigned steps)
{
    return RunPile(qcTorusOf(btScalar(0.2), btScalar(0.35)), btScalar(0.6), randomSeed, stage, steps);
}

// The pieces of a cube that falls on its edge; they touch all along their cuts from the start.
qcAblationResult qcRunFracture(unsigned randomSeed, const char* stage, unsigned steps)
{
    World world;
    AddFloor(&world);
    btTransform place(btQuaternion(btVector3(0, 0, 1), btScalar(0.6)), btVector3(0, btScalar(1.2), 0));
    for (const qcPiece& piece : qcBreakCube(1, 40, randomSeed))
        world.Add({piece.vertices, piece.indices}, btScalar(piece.volume * 1000), place * piece.frame);
    return world.Run(stage, steps);
}
