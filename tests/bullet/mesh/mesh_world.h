// A Bullet world with contact of meshes, for tests.
#ifndef QC_TESTS_BULLET_MESH_MESH_WORLD_H
#define QC_TESTS_BULLET_MESH_MESH_WORLD_H

#include "quickcullide/bullet.h"

#include "bullet/mesh/mesh_models.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

constexpr btScalar qcStep = btScalar(1.0 / 60);

/// Owns its bodies, shapes and models.
struct qcMeshWorld
{
    qcMeshContact contact;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<qcModel>> models;
    std::vector<std::unique_ptr<btStridingMeshInterface>> interfaces;
    double stepMs = 0; ///< mean time of a step in the last Step

    /// `adds`: otherwise the test calls contact.addTo, after actions of its own.
    explicit qcMeshWorld(bool adds = true)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
        if (adds)
            contact.addTo(&world);
        contact.setThreadCount(1);
    }

    ~qcMeshWorld()
    {
        for (auto& body : bodies)
            world.removeRigidBody(body.get());
    }

    btCollisionShape* Keep(std::unique_ptr<btCollisionShape> shape)
    {
        shapes.push_back(std::move(shape));
        return shapes.back().get();
    }

    btStridingMeshInterface* Interface(const qcModel& model)
    {
        models.emplace_back(new qcModel(model));
        interfaces.push_back(models.back()->MakeInterface());
        return interfaces.back().get();
    }

    btCollisionShape* StaticMesh(const qcModel& model)
    {
        return Keep(std::unique_ptr<btCollisionShape>(new btBvhTriangleMeshShape(Interface(model), true)));
    }

    btCollisionShape* GImpact(const qcModel& model, btScalar margin)
    {
        auto* shape = new btGImpactMeshShape(Interface(model));
        shape->setMargin(margin);
        shape->updateBound();
        return Keep(std::unique_ptr<btCollisionShape>(shape));
    }

    btRigidBody* Add(btCollisionShape* shape, btScalar mass, const btTransform& transform)
    {
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shape->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
        info.m_startWorldTransform = transform;
        bodies.emplace_back(new btRigidBody(info));
        world.addRigidBody(bodies.back().get());
        return bodies.back().get();
    }

    btRigidBody* Add(btCollisionShape* shape, btScalar mass, const btVector3& origin)
    {
        return Add(shape, mass, btTransform(btQuaternion::getIdentity(), origin));
    }

    void Step(int count = 1)
    {
        using namespace std::chrono;
        auto start = steady_clock::now();
        for (int i = 0; i < count; i++)
            world.stepSimulation(qcStep, 0);
        stepMs = duration<double, std::milli>(steady_clock::now() - start).count() / count;
        ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
    }

    /// Kinetic, and of gravity.
    double Energy() const
    {
        double energy = KineticEnergy();
        for (const auto& body : bodies)
            if (!body->isStaticObject())
                energy -= double(body->getGravity().dot(body->getWorldTransform().getOrigin()) / body->getInvMass());
        return energy;
    }

    double KineticEnergy() const
    {
        double energy = 0;
        for (const auto& body : bodies)
        {
            if (body->isStaticObject())
                continue;
            btVector3 spin = body->getInvInertiaTensorWorld().inverse() * body->getAngularVelocity();
            energy += double(body->getLinearVelocity().length2() / body->getInvMass() +
                             body->getAngularVelocity().dot(spin)) /
                      2;
        }
        return energy;
    }
};

/// All contact points of a dispatcher.
struct qcWorldContacts
{
    int points = 0;
    double deepest = 1e9;
};

inline qcWorldContacts qcContactsOf(btDispatcher& dispatcher)
{
    qcWorldContacts contacts;
    for (int m = 0; m < dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold->getNumContacts(); i++, contacts.points++)
            contacts.deepest = std::min(contacts.deepest, double(manifold->getContactPoint(i).getDistance()));
    }
    return contacts;
}

inline qcModel qcCubeModel(int n = 2)
{
    return qcBoxModel(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)), n);
}

/// A floor and four walls, open at the top, 2 * `half` wide inside.
inline qcModel qcBinModel(btScalar half, btScalar height)
{
    qcModel model;
    btVector3 x(2 * half, 0, 0), y(0, height, 0), z(0, 0, 2 * half), corner(-half, 0, -half);
    qcAddGrid(&model, corner, z, x, 4, 4);
    qcAddGrid(&model, corner, x, y, 4, 4);
    qcAddGrid(&model, corner, y, z, 4, 4);
    qcAddGrid(&model, corner + x, z, y, 4, 4);
    qcAddGrid(&model, corner + z, y, x, 4, 4);
    return model;
}

/// A rigid body as triangles in world space, for the exact test.
struct qcPlacedModel
{
    const qcModel* model;
    const btRigidBody* body;
};

/// Calls use(result) with the pairs of triangles of different bodies, where these are.
template <typename Use>
void qcDetectPlaced(const std::vector<qcPlacedModel>& all, const qcDetectDef& detect, const Use& use)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    ck_assert_int_eq(qcScene_Create(&sceneDef, &scene), qc_statusOk);
    for (const qcPlacedModel& placed : all)
    {
        qcModel moved = *placed.model;
        moved.Move(placed.body->getWorldTransform());
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = moved.positions.data();
        def.positionType = qcBulletPositions;
        def.vertexCount = uint32_t(moved.positions.size() / 3);
        def.indices = moved.indices.data();
        def.triangleCount = moved.TriangleCount();
        def.selfCollision = false;
        qcBodyId id;
        ck_assert_int_eq(qcScene_AddBody(scene, &def, &id), qc_statusOk);
    }
    const qcResult* result = nullptr;
    ck_assert_int_eq(qcScene_Detect(scene, &detect, &result), qc_statusOk);
    use(*result);
    qcScene_Destroy(scene);
}

/// Pairs of triangles of different bodies that penetrate, by the exact test.
inline size_t qcCountPenetrating(const std::vector<qcPlacedModel>& all)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodBrute;
    size_t pairs = 0;
    qcDetectPlaced(all, def, [&](const qcResult& result) { pairs = result.pairCount; });
    return pairs;
}

/// The floor of a world: its top is at height 0.
enum qcFloor
{
    qc_floorStatic,
    qc_floorOurs,
    qc_floorGImpact,
    qc_floorTerrain,
    qc_floorScaled,
    qc_floorPlane,
    qc_floorCount
};

/// Adds a floor of this kind. Returns its margin.
inline btScalar qcAddFloor(qcMeshWorld& world, qcFloor floor)
{
    static const float heights[81] = {};
    qcModel model = qcFloorModel(4, 8);
    btCollisionShape* shape = nullptr;
    switch (floor)
    {
        case qc_floorStatic: shape = world.StaticMesh(model); break;
        case qc_floorOurs: shape = world.Keep(model.MakeShape()); break;
        case qc_floorGImpact: shape = world.GImpact(model, 0); break;
        case qc_floorTerrain:
            shape = world.Keep(std::unique_ptr<btCollisionShape>(
                new btHeightfieldTerrainShape(9, 9, heights, btScalar(-1), btScalar(1), 1, false)));
            break;
        case qc_floorScaled:
            shape = world.Keep(std::unique_ptr<btCollisionShape>(new btScaledBvhTriangleMeshShape(
                static_cast<btBvhTriangleMeshShape*>(world.StaticMesh(qcFloorModel(1, 8))), btVector3(4, 1, 4))));
            break;
        default: shape = world.Keep(std::unique_ptr<btCollisionShape>(new btStaticPlaneShape(btVector3(0, 1, 0), 0)));
    }
    world.Add(shape, 0, btVector3(0, 0, 0));
    return floor == qc_floorPlane ? btScalar(0) : shape->getMargin();
}

#endif
