// A cloth that falls over a pile of meshes: dynamic qcMeshShapes with qcMeshContact and qcSoftBodySolver, or Bullet
// alone, whose moving meshes are btGImpactMeshShapes.
#ifndef QC_DEMOS_BENCH_SOFT_PILE_SCENE_H
#define QC_DEMOS_BENCH_SOFT_PILE_SCENE_H

#include "bench/soft/soft_scene.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

struct qcPileSceneDef
{
    bool ours = true;
    int bodies = 20;
    int nodes = 30; ///< along an edge of the cloth, which is 6 m long
    btScalar height = btScalar(3.5);
    /// A mesh of about one metre, its centre of mass at the origin.
    std::vector<btScalar> positions;
    std::vector<uint32_t> indices;
};

struct qcPileMeasure
{
    btScalar height = 0; ///< mean of the cloth's nodes, metres
    btScalar speed = 0;  ///< mean of the nodes, m/s
    int still = 0;       ///< nodes that did not move at all in the last step
    size_t below = 0;    ///< nodes under the ground
};

class qcPileScene : public qcSoftScene
{
  public:
    explicit qcPileScene(const qcPileSceneDef& sceneDef) : qcSoftScene(sceneDef.ours), def(sceneDef)
    {
        if (def.ours)
            contact.addTo(world.get());
        else
            btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
        world->addRigidBody(&ground);
        MakeShape();
        AddBodies();
        const btScalar h = 3, y = def.height;
        cloth = btSoftBodyHelpers::CreatePatch(world->getWorldInfo(), btVector3(-h, y, -h), btVector3(h, y, -h),
                                               btVector3(-h, y, h), btVector3(h, y, h), def.nodes, def.nodes, 0, true);
        cloth->setTotalMass(2);
        world->addSoftBody(cloth);
    }

    ~qcPileScene()
    {
        world->removeSoftBody(cloth);
        delete cloth;
        for (const auto& body : bodies)
            world->removeRigidBody(body.get());
        world->removeRigidBody(&ground);
    }

    void Step()
    {
        m_before.clear();
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            m_before.push_back(cloth->m_nodes[i].m_x);
        qcSoftScene::Step();
    }

    /// The state after the last step.
    qcPileMeasure Measure() const
    {
        qcPileMeasure measure;
        const btScalar count = btScalar(cloth->m_nodes.size());
        for (int i = 0; i < cloth->m_nodes.size(); i++)
        {
            const btSoftBody::Node& node = cloth->m_nodes[i];
            measure.height += node.m_x.y() / count;
            measure.speed += node.m_v.length() / count;
            measure.still += !m_before.empty() && node.m_x == m_before[size_t(i)];
            measure.below += node.m_x.y() < 0;
        }
        return measure;
    }

    const qcPileSceneDef def;
    btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
    btRigidBody ground{0, nullptr, &plane};
    std::unique_ptr<btTriangleIndexVertexArray> triangles;
    std::unique_ptr<btCollisionShape> shape;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    btSoftBody* cloth = nullptr;

  private:
    void MakeShape()
    {
        std::unique_ptr<qcMeshShape> mesh(new qcMeshShape(def.positions.data(), qcBulletPositions, 0,
                                                          uint32_t(def.positions.size() / 3), def.indices.data(),
                                                          uint32_t(def.indices.size() / 3)));
        mesh->calculateLocalInertia(s_mass, m_inertia);
        if (def.ours)
        {
            shape = std::move(mesh);
            return;
        }
        triangles.reset(new btTriangleIndexVertexArray);
        btIndexedMesh part;
        part.m_numTriangles = int(def.indices.size() / 3);
        part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(def.indices.data());
        part.m_triangleIndexStride = 3 * int(sizeof(uint32_t));
        part.m_numVertices = int(def.positions.size() / 3);
        part.m_vertexBase = reinterpret_cast<const unsigned char*>(def.positions.data());
        part.m_vertexStride = 3 * int(sizeof(btScalar));
        part.m_vertexType = sizeof(btScalar) == sizeof(double) ? PHY_DOUBLE : PHY_FLOAT;
        triangles->addIndexedMesh(part, PHY_INTEGER);
        std::unique_ptr<btGImpactMeshShape> gimpact(new btGImpactMeshShape(triangles.get()));
        gimpact->updateBound();
        shape = std::move(gimpact);
    }

    /// In layers of twelve, turned at random.
    void AddBodies()
    {
        std::minstd_rand random(7);
        std::uniform_real_distribution<double> part(-1, 1);
        for (int i = 0; i < def.bodies; i++)
        {
            btScalar q[4];
            for (btScalar& value : q)
                value = btScalar(part(random));
            btVector3 place(btScalar(1.1) * btScalar(i % 4) - btScalar(1.65),
                            btScalar(0.8) + btScalar(1.1) * btScalar(i / 12),
                            btScalar(1.1) * btScalar(i / 4 % 3) - btScalar(1.1));
            bodies.emplace_back(new btRigidBody(s_mass, nullptr, shape.get(), m_inertia));
            bodies.back()->setWorldTransform(btTransform(btQuaternion(q[0], q[1], q[2], q[3]).normalized(), place));
            world->addRigidBody(bodies.back().get());
        }
    }

    static constexpr btScalar s_mass = 10;

    btVector3 m_inertia{0, 0, 0};
    std::vector<btVector3> m_before; ///< nodes before the last step
};

#endif
