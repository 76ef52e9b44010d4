// Rigid Bullet worlds for bullet_hashes.cpp: shapes, bodies, and hashes of their motion and contacts.
#ifndef QC_GOLDEN_BULLET_WORLDS_H
#define QC_GOLDEN_BULLET_WORLDS_H

#include "quickcullide/bullet.h"

#include "house/golden/meshes.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletSoftBody/btSoftBody.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

constexpr qcPositionType qc_scalarType = sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32;

inline void Print(const char* name, const qcHash& hash)
{
    std::printf(" %s=%llu:%016llx", name, (unsigned long long)hash.count, (unsigned long long)hash.value);
}

inline void CheckOk(qcStatus status, const char* what)
{
    if (status == qc_statusOk)
        return;
    std::fprintf(stderr, "%s: %s\n", what, qcStatus_Name(status));
    std::exit(2);
}

/// Three numbers; the fourth is padding.
inline void AddHash(qcHash& hash, const btVector3& v)
{
    qcHash_AddArray(&hash, &v, 1, 3 * sizeof(btScalar));
}

inline void AddHash(qcHash& hash, const btTransform& transform)
{
    for (int row = 0; row < 3; row++)
        AddHash(hash, transform.getBasis()[row]);
    AddHash(hash, transform.getOrigin());
}

inline void AddHash(qcHash& hash, const btSoftBody& body)
{
    for (int i = 0; i < body.m_nodes.size(); i++)
    {
        AddHash(hash, body.m_nodes[i].m_x);
        AddHash(hash, body.m_nodes[i].m_v);
    }
}

/// The points of all manifolds, in the dispatcher's order.
inline void AddContacts(qcHash& hash, btDispatcher& dispatcher)
{
    for (int m = 0; m < dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold->getNumContacts(); i++)
        {
            const btManifoldPoint& point = manifold->getContactPoint(i);
            AddHash(hash, point.m_positionWorldOnA);
            AddHash(hash, point.m_positionWorldOnB);
            AddHash(hash, point.m_normalWorldOnB);
            qcHash_AddArray(&hash, &point.m_distance1, 1, sizeof point.m_distance1);
        }
    }
}

//  ---- shapes ------------------------------------------------------------------------------------------------------

/// In Bullet's precision.
struct Model
{
    std::vector<btScalar> positions;
    std::vector<uint32_t> indices;

    explicit Model(qcMesh mesh)
        : positions(mesh.positions, mesh.positions + 3 * size_t(mesh.vertexCount)),
          indices(mesh.indices, mesh.indices + 3 * size_t(mesh.triangleCount))
    {
        qcMesh_Free(&mesh);
    }
};

inline std::unique_ptr<qcMeshShape> MakeShape(const Model& model)
{
    return std::make_unique<qcMeshShape>(model.positions.data(), qc_scalarType, 0, uint32_t(model.positions.size() / 3),
                                         model.indices.data(), uint32_t(model.indices.size() / 3));
}

inline qcMesh MakeFloor(uint32_t side, double half)
{
    qcMesh mesh = qcMesh_MakeGrid(side, side, false, false);
    for (uint32_t v = 0; v < mesh.vertexCount; v++)
    {
        double* x = mesh.positions + 3 * v;
        x[0] = half * (2.0 * (v / (side + 1)) / side - 1.0);
        x[1] = 0.05 * ((v * 7) % 5);
        x[2] = half * (2.0 * (v % (side + 1)) / side - 1.0);
    }
    return mesh;
}

/// Tori, balls, boxes.
inline qcMesh MakeMesh(uint32_t kind)
{
    return kind % 3 == 0 ? qcMesh_MakeTorus(0.4, 0.15, 16, 8)
                         : qcMesh_MakeBox(0.3, kind % 3 == 1 ? 3 : 2, kind % 3 == 1);
}

/// Rigid bodies and what they need; the world is the caller's.
struct Bodies
{
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;

    btCollisionShape* Keep(std::unique_ptr<btCollisionShape> shape)
    {
        shapes.push_back(std::move(shape));
        return shapes.back().get();
    }

    btRigidBody* Add(btDiscreteDynamicsWorld& world, btCollisionShape* shape, btScalar mass, const btVector3& origin,
                     const btQuaternion& turn = btQuaternion::getIdentity())
    {
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shape->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
        info.m_startWorldTransform = btTransform(turn, origin);
        bodies.push_back(std::make_unique<btRigidBody>(info));
        world.addRigidBody(bodies.back().get());
        return bodies.back().get();
    }

    void AddTo(qcHash& hash) const
    {
        for (const auto& body : bodies)
        {
            AddHash(hash, body->getWorldTransform());
            AddHash(hash, body->getLinearVelocity());
            AddHash(hash, body->getAngularVelocity());
        }
    }

    void RemoveFrom(btDiscreteDynamicsWorld& world)
    {
        for (auto& body : bodies)
            world.removeRigidBody(body.get());
        bodies.clear();
    }
};

inline btScalar Uniform(qcRandom& random, double lower, double upper)
{
    return btScalar(qcRandom_Uniform(&random, lower, upper));
}

inline btVector3 Point(qcRandom& random, double lower, double upper)
{
    btScalar x = Uniform(random, lower, upper), y = Uniform(random, lower, upper);
    return btVector3(x, y, Uniform(random, lower, upper));
}

inline btQuaternion Turn(qcRandom& random)
{
    btVector3 v = Point(random, -1.0, 1.0);
    return btQuaternion(v.x(), v.y(), v.z(), btScalar(1.25)).normalized();
}

//  ---- rigid worlds ------------------------------------------------------------------------------------------------

struct RigidWorld
{
    qcMeshContact contact;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    Bodies bodies;
    qcHash motion = qcHash_Start(), contacts = qcHash_Start();

    explicit RigidWorld(unsigned threads)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
        contact.addTo(&world);
        contact.setThreadCount(threads);
    }

    ~RigidWorld()
    {
        bodies.RemoveFrom(world);
    }

    void Step()
    {
        world.stepSimulation(btScalar(1.0 / 60), 0);
        CheckOk(contact.getStatistics().status, "qcMeshContact");
        bodies.AddTo(motion);
        AddContacts(contacts, dispatcher);
    }

    void PrintAs(const char* name) const
    {
        std::printf("%s", name);
        Print("motion", motion);
        Print("contacts", contacts);
        std::putchar('\n');
    }
};

#endif
