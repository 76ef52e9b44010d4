// A rope that falls over a horizontal cylinder, by this library or by Bullet alone, and measures of the rope.
#ifndef QC_DEMOS_BENCH_SOFT_ROPE_SCENE_H
#define QC_DEMOS_BENCH_SOFT_ROPE_SCENE_H

#include "bench/soft/soft_scene.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <cmath>
#include <memory>
#include <vector>

/// The contact model of rope and cylinder.
enum class qcRopeContact
{
    ours,          ///< qcSoftBodySolver, a qcMeshShape
    bulletsMesh,   ///< btDefaultSoftBodySolver, a btBvhTriangleMeshShape of the same triangles
    bulletsConvex, ///< btDefaultSoftBodySolver, a btCylinderShape
};

struct qcRopeSceneDef
{
    qcRopeContact contact = qcRopeContact::ours;
    /// Radius of the cylinder, metres. Its axis is z, and its centre the origin.
    btScalar radius = btScalar(0.25);
    btScalar length = 2;
    int sides = 32;
    int rings = 8; ///< of triangles along the axis
    /// Initial height of the rope, two metres long, above the cylinder, metres.
    btScalar height = btScalar(0.05);
    int nodes = 41;
    int iterations = 4; ///< of the rope's links in each step
    /// Coefficient of Coulomb friction between rope and cylinder. Bullet's own contact instead slows sliding by this
    /// share in each iteration.
    btScalar friction = btScalar(0.5);
    btVector3 velocity{0, -2, 0};
};

struct qcRopeMeasure
{
    btScalar highest = 0;               ///< height of the highest node, metres
    btScalar leftEnd = 0, rightEnd = 0; ///< heights of the rope's ends, metres
    btScalar speed = 0;                 ///< mean of the nodes, m/s
    btScalar depth = 0;                 ///< of the rope in the exact cylinder, links included, metres
    btScalar stretch = 0;               ///< length of the rope relative to its initial length

    /// True if the rope hangs over the cylinder: both ends are below its axis, and the highest node is above it.
    bool IsDraped(btScalar radius) const
    {
        return leftEnd < 0 && rightEnd < 0 && highest > radius * btScalar(0.8);
    }
};

/// A world with a rope and a cylinder.
class qcRopeScene : public qcSoftScene
{
  public:
    explicit qcRopeScene(const qcRopeSceneDef& sceneDef)
        : qcSoftScene(sceneDef.contact == qcRopeContact::ours), def(sceneDef)
    {
        MakeCylinder();
        cylinder.reset(new btRigidBody(0, nullptr, shape.get()));
        cylinder->setFriction(def.friction);
        world->addRigidBody(cylinder.get());
        btVector3 half(1, 0, 0), middle(0, def.radius + def.height, 0);
        rope = btSoftBodyHelpers::CreateRope(world->getWorldInfo(), middle - half, middle + half, def.nodes - 2, 0);
        rope->m_cfg.piterations = def.iterations;
        rope->m_cfg.kDF = 1;
        rope->setTotalMass(1);
        rope->setVelocity(def.velocity);
        qcSoftBodySettings settings;
        settings.friction = def.friction;
        quick.setSettings(rope, settings);
        world->addSoftBody(rope);
        m_length = Length();
    }

    ~qcRopeScene()
    {
        world->removeSoftBody(rope);
        delete rope;
        world->removeRigidBody(cylinder.get());
    }

    btScalar Length() const
    {
        btScalar sum = 0;
        for (int i = 0; i + 1 < rope->m_nodes.size(); i++)
            sum += rope->m_nodes[i].m_x.distance(rope->m_nodes[i + 1].m_x);
        return sum;
    }

    qcRopeMeasure Measure() const
    {
        qcRopeMeasure measure;
        const auto& nodes = rope->m_nodes;
        measure.highest = nodes[0].m_x.y();
        for (int i = 0; i < nodes.size(); i++)
        {
            measure.highest = btMax(measure.highest, nodes[i].m_x.y());
            measure.speed += nodes[i].m_v.length() / btScalar(nodes.size());
        }
        for (int i = 0; i + 1 < nodes.size(); i++)
            for (int part = 0; part <= 4; part++)
            {
                btVector3 x = nodes[i].m_x.lerp(nodes[i + 1].m_x, btScalar(part) / 4);
                if (btFabs(x.z()) < def.length / 2)
                    measure.depth = btMax(measure.depth, def.radius - btSqrt(x.x() * x.x() + x.y() * x.y()));
            }
        measure.leftEnd = nodes[0].m_x.y();
        measure.rightEnd = nodes[nodes.size() - 1].m_x.y();
        measure.stretch = Length() / m_length;
        return measure;
    }

    const qcRopeSceneDef def;
    std::unique_ptr<btTriangleMesh> triangles;
    std::unique_ptr<btCollisionShape> shape;
    std::unique_ptr<btRigidBody> cylinder;
    btSoftBody* rope = nullptr;

  private:
    void MakeCylinder()
    {
        if (def.contact == qcRopeContact::bulletsConvex)
        {
            shape.reset(new btCylinderShapeZ(btVector3(def.radius, def.radius, def.length / 2)));
            return;
        }
        triangles.reset(new btTriangleMesh);
        for (int ring = 0; ring < def.rings; ring++)
            for (int side = 0; side < def.sides; side++)
            {
                btVector3 a = Corner(side, ring), b = Corner(side + 1, ring), c = Corner(side, ring + 1),
                          d = Corner(side + 1, ring + 1);
                triangles->addTriangle(a, b, d);
                triangles->addTriangle(a, d, c);
            }
        for (int side = 1; side + 1 < def.sides; side++)
        {
            triangles->addTriangle(Corner(0, 0), Corner(side + 1, 0), Corner(side, 0));
            triangles->addTriangle(Corner(0, def.rings), Corner(side, def.rings), Corner(side + 1, def.rings));
        }
        if (def.contact == qcRopeContact::ours)
            shape.reset(new qcMeshShape(triangles.get()));
        else
            shape.reset(new btBvhTriangleMeshShape(triangles.get(), true));
    }

    btVector3 Corner(int side, int ring) const
    {
        btScalar angle = SIMD_2_PI * btScalar(side % def.sides) / btScalar(def.sides);
        return btVector3(def.radius * btCos(angle), def.radius * btSin(angle),
                         def.length * (btScalar(ring) / btScalar(def.rings) - btScalar(0.5)));
    }

    btScalar m_length = 0;
};

#endif
