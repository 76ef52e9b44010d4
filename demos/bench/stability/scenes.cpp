// The scenes of `qc-bench stability`: those of the demos and of `qc-bench soft`, and piles of rigid bodies.
#include "bench/stability/scenes.h"

#include "bench/soft/pile_scene.h"
#include "bench/soft/rope_scene.h"
#include "bench/soft/tangle_scene.h"
#include "bench/through/shapes.h"
#include "cloth/world.h"
#include "common/files.h"
#include "common/mesh_io/bunny_path.h"
#ifdef QC_HAS_FRACTURE
#include "breaking/world.h"
#include "fracture/world.h"
#endif
#include "leaves/world.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <cstring>
#include <random>
#include <utility>

namespace
{
/// A demo's world of soft bodies.
template <class DemoWorld> class SoftDemo : public qcStabilityScene
{
  public:
    template <class... Arguments>
    explicit SoftDemo(Arguments&&... arguments) : m_world(std::forward<Arguments>(arguments)...)
    {
    }
    bool Step(std::string*) override
    {
        m_world.Step();
        return true;
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world.Bullet();
    }
    const qcSoftBodyStatistics* SoftStatistics() const override
    {
        return &m_world.Statistics();
    }

  private:
    DemoWorld m_world;
};

/// A cloth falls over a round table.
class Cloth : public SoftDemo<qcClothWorld>
{
  public:
    explicit Cloth(bool full) : SoftDemo(full ? 20000 : 2000, true, nullptr, qc_methodAuto, 0)
    {
    }
};

/// Leaves fall from a tree and lie on the ground; a few stay on the tree, in the wind.
class Leaves : public SoftDemo<qcLeavesWorld>
{
  public:
    explicit Leaves(bool full) : SoftDemo(Request(full), nullptr)
    {
    }

  private:
    static qcLeavesRequest Request(bool full)
    {
        qcLeavesRequest request;
        request.leaves = full ? 384 : 32;
        return request;
    }
};

#ifdef QC_HAS_FRACTURE
/// A body falls, breaks, and its pieces come to rest in a heap.
class Fracture : public qcStabilityScene
{
  public:
    explicit Fracture(bool full)
    {
        qcFractureRequest request;
        request.pieces = full ? 200 : 40;
        // Four metres, like the demo's.
        if (!qcFiles_IsThere(QC_BUNNY_PATH) ||
            !qcReadFractureModel(QC_BUNNY_PATH, full ? 5000 : 1000, 4, &m_model, &m_failure))
            MakeTorus();
        m_world.reset(new qcFractureWorld(m_model, request, nullptr));
    }
    bool Step(std::string* message) override
    {
        qcFractureStep step;
        return m_world->Step(&step, message);
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world->Bullet();
    }

  private:
    /// In place of a bunny that can't be read.
    void MakeTorus()
    {
        qcTorus torus(btScalar(1.4), btScalar(0.6), 32, 16);
        m_model = qcFractureModel();
        for (size_t i = 0; i < torus.points.size(); i += 3)
            m_model.vertices.push_back(btVector3(torus.points[i], torus.points[i + 1], torus.points[i + 2]));
        m_model.indices.assign(torus.indices.begin(), torus.indices.end());
        m_model.volume = btScalar(2 * 9.8696 * 1.4 * 0.36);
    }

    qcFractureModel m_model;
    std::string m_failure;
    std::unique_ptr<qcFractureWorld> m_world;
};

/// A bunny falls on a dragon again and again, which breaks into pieces. Both are shapes of the demo's own.
class Breaking : public qcStabilityScene
{
  public:
    explicit Breaking(bool full)
    {
        qcBreakingModelDef def;
        if (!full)
        {
            def.dragonTriangles = 2000;
            def.bunnyTriangles = 300;
            def.cells = 30;
        }
        if (qcMakeBreakingModel(def, &m_model, &m_failure))
            m_world.reset(new qcBreakingWorld(m_model, qc_methodAuto, 0, nullptr));
    }
    bool Step(std::string* message) override
    {
        qcBreakingStep step;
        *message = m_failure;
        return m_world != nullptr && m_world->Step(&step, message);
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world->Bullet();
    }

  private:
    qcBreakingModel m_model;
    std::string m_failure;
    std::unique_ptr<qcBreakingWorld> m_world;
};
#endif

/// A world of rigid bodies, and what each scene adds to it.
class Rigid : public qcStabilityScene
{
  public:
    static constexpr btScalar stepSeconds = btScalar(1.0 / 120);

    Rigid()
    {
        m_contact.addTo(&m_world);
        m_world.addRigidBody(&m_ground);
        m_ground.setFriction(btScalar(0.8));
    }
    ~Rigid() override
    {
        for (const auto& body : m_bodies)
            m_world.removeRigidBody(body.get());
        m_world.removeRigidBody(&m_ground);
    }
    bool Step(std::string* message) override
    {
        m_world.stepSimulation(stepSeconds, 0);
        *message = qcStatus_Name(m_contact.getStatistics().status);
        return m_contact.getStatistics().status == qc_statusOk;
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world;
    }

  protected:
    void Add(btCollisionShape* shape, btScalar mass, const btTransform& place)
    {
        btVector3 inertia;
        shape->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
        info.m_startWorldTransform = place;
        info.m_friction = btScalar(0.6);
        info.m_rollingFriction = btScalar(0.01);
        m_bodies.emplace_back(new btRigidBody(info));
        m_world.addRigidBody(m_bodies.back().get());
    }

    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;

  private:
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    qcMeshContact m_contact;
    btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
    btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
    btRigidBody m_ground{0, nullptr, &m_plane};
    std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

/// Small meshes fall into a heap: tori, which catch each other, balls and boxes of triangles.
class Meshes : public Rigid
{
  public:
    explicit Meshes(bool full)
    {
        m_shapes.push_back(qcMakeTorus(btScalar(0.3), btScalar(0.1), 16, 8).MakeShape());
        m_shapes.push_back(qcMakeSphere(btScalar(0.25), 12, 8).MakeShape());
        m_shapes.push_back(qcMakeBox(btVector3(btScalar(0.3), btScalar(0.15), btScalar(0.2))).MakeShape());
        std::minstd_rand random(7);
        std::uniform_real_distribution<double> part(-1, 1);
        int count = full ? 200 : 40;
        for (int i = 0; i < count; i++)
        {
            btScalar q[4];
            for (btScalar& value : q)
                value = btScalar(part(random));
            btVector3 place(btScalar(0.9) * btScalar(i % 3 - 1), btScalar(0.6) + btScalar(0.9) * btScalar(i / 9),
                            btScalar(0.9) * btScalar(i / 3 % 3 - 1));
            Add(m_shapes[size_t(i) % m_shapes.size()].get(), 10,
                btTransform(btQuaternion(q[0], q[1], q[2], q[3]).normalized(), place));
        }
    }
};

/// A wall and a tower of Bullet's own boxes: the broadphase of this library, and nothing else of it.
class Boxes : public Rigid
{
  public:
    explicit Boxes(bool full)
    {
        btScalar half = btScalar(0.25);
        m_shapes.emplace_back(new btBoxShape(btVector3(half, half, half)));
        int rows = full ? 20 : 10;
        for (int row = 0; row < rows; row++)
            for (int i = 0; i < rows - row; i++)
                AddBox(2 * half * (btScalar(1.02) * btScalar(i) + btScalar(0.51) * btScalar(row)), row, 0);
        // Ten would fall after 20 seconds, with btDbvtBroadphase too: Bullet's boxes creep where none may sleep.
        for (int row = 0; row < 5; row++)
            AddBox(0, row, 2);
    }

  private:
    void AddBox(btScalar x, int row, btScalar z)
    {
        btTransform place = btTransform::getIdentity();
        place.setOrigin(btVector3(x, btScalar(0.25) + btScalar(0.502) * btScalar(row), z));
        Add(m_shapes[0].get(), 10, place);
    }
};

const qcSoftBodyStatistics& StatisticsOf(const qcSoftBodySolver& solver)
{
    return solver.getStatistics();
}

const qcSoftBodyStatistics& StatisticsOf(const qcDeformableWorld* world)
{
    return world->getStatistics();
}

/// A scene of `qc-bench soft`, with this library's contact.
template <class BenchScene> class SoftBench : public qcStabilityScene
{
  public:
    template <class... Arguments>
    explicit SoftBench(Arguments&&... arguments) : m_scene(std::forward<Arguments>(arguments)...)
    {
    }
    bool Step(std::string*) override
    {
        m_scene.Step();
        return true;
    }
    btDiscreteDynamicsWorld& World() override
    {
        return *m_scene.world;
    }
    const qcSoftBodyStatistics* SoftStatistics() const override
    {
        return &StatisticsOf(m_scene.quick);
    }

  private:
    BenchScene m_scene;
};

/// A cloth falls over a pile of meshes that move.
class ClothPile : public SoftBench<qcPileScene>
{
  public:
    explicit ClothPile(bool full) : SoftBench(Def(full))
    {
    }

  private:
    static qcPileSceneDef Def(bool full)
    {
        qcPileSceneDef def;
        def.bodies = full ? 20 : 8;
        def.nodes = full ? 50 : 24;
        qcTorus torus(btScalar(0.35), btScalar(0.15), full ? 24 : 16, full ? 12 : 8);
        def.positions = torus.points;
        def.indices.assign(torus.indices.begin(), torus.indices.end());
        return def;
    }
};

/// An elastic cube with scrambled nodes untangles, and keeps its shape.
class Tangle : public SoftBench<qcScrambledScene>
{
  public:
    explicit Tangle(bool full) : SoftBench(true, full ? 5 : 3)
    {
        // The cube has no weight: no force of gravity was added.
        World().setGravity(btVector3(0, 0, 0));
    }
};

/// A rope hangs over a cylinder.
class Rope : public SoftBench<qcRopeScene>
{
  public:
    explicit Rope(bool) : SoftBench(qcRopeSceneDef())
    {
    }
};

template <class Scene> std::unique_ptr<qcStabilityScene> Make(bool full)
{
    return std::make_unique<Scene>(full);
}
} // namespace

const std::vector<qcStabilitySceneDef>& qcStabilityScenes()
{
    static const std::vector<qcStabilitySceneDef> scenes = {
        {"cloth", "a cloth falls over a round table", "2 048 triangles", "20 000 triangles", qcClothWorld::stepSeconds,
         10, Make<Cloth>},
#ifdef QC_HAS_FRACTURE
        {"fracture", "a bunny breaks and its pieces come to rest", "1 000 triangles, 40 pieces",
         "5 000 triangles, 200 pieces", qcFractureWorld::stepSeconds, 5, Make<Fracture>},
        {"breaking", "a bunny falls on a dragon, again and again", "2 000 triangles, 30 cells",
         "250 000 triangles, 700 cells", qcBreakingWorld::stepSeconds, 2, Make<Breaking>, "a crane lifts the bunny"},
#endif
        {"leaves", "leaves fall from a tree", "32 leaves", "384 leaves", qcLeavesWorld::stepSeconds, 12, Make<Leaves>,
         nullptr, false},
        {"meshes", "tori, balls and boxes of triangles fall into a heap", "40 meshes", "200 meshes", Rigid::stepSeconds,
         10, Make<Meshes>},
        {"boxes", "a wall and a tower of convex boxes", "60 boxes", "215 boxes", Rigid::stepSeconds, 2, Make<Boxes>,
         nullptr, true, 0.0005, 0.0005},
        {"cloth-pile", "a cloth falls over a pile of moving tori", "24 x 24 nodes, 8 tori", "50 x 50 nodes, 20 tori",
         1.0 / 60, 20, Make<ClothPile>},
        // Tetrahedra that were turned inside out snap back one by one; what they store is no part of the energy.
        {"tangle", "an elastic cube with scrambled nodes", "3 x 3 x 3 cells", "5 x 5 x 5 cells", 1.0 / 60, 40,
         Make<Tangle>},
        {"rope", "a rope hangs over a cylinder", "41 nodes", "41 nodes", 1.0 / 60, 10, Make<Rope>},
    };
    return scenes;
}

const qcStabilitySceneDef* qcFindStabilityScene(const char* name)
{
    for (const qcStabilitySceneDef& scene : qcStabilityScenes())
        if (std::strcmp(scene.name, name) == 0)
            return &scene;
    return nullptr;
}
