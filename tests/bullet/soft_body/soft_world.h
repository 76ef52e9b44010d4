// Bullet's worlds of soft bodies with this library's broadphase and contact.
#ifndef QC_TESTS_BULLET_SOFT_BODY_SOFT_WORLD_H
#define QC_TESTS_BULLET_SOFT_BODY_SOFT_WORLD_H

#include "quickcullide/bullet.h"

#include "bullet/mesh/mesh_models.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <memory>
#include <vector>

/// A soft-rigid world. It removes and deletes the soft bodies, rigid bodies and shapes in its lists.
struct qcSoftWorld
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    btDefaultSoftBodySolver bulletsSolver;
    qcMeshContact meshContact;
    btSoftRigidDynamicsWorld world;
    std::vector<btSoftBody*> cloths;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;

    /// `isPlain`: with Bullet's own soft-body solver.
    explicit qcSoftWorld(qcDevice* device = nullptr, bool isPlain = false)
        : softSolver(device), world(&dispatcher, &broadphase, &solver, &configuration,
                                    isPlain ? &bulletsSolver : static_cast<btSoftBodySolver*>(&softSolver))
    {
        world.getWorldInfo().m_gravity = world.getGravity();
        softSolver.setThreadCount(1);
    }

    ~qcSoftWorld()
    {
        RemoveAll();
    }
    qcSoftWorld(const qcSoftWorld&) = delete;
    qcSoftWorld& operator=(const qcSoftWorld&) = delete;

    /// Also for the destructors of scenes that own what bodies use.
    void RemoveAll()
    {
        while (!cloths.empty())
            RemoveCloth();
        for (const auto& body : bodies)
            world.removeRigidBody(body.get());
        bodies.clear();
    }

    void SetGravity(const btVector3& gravity)
    {
        world.setGravity(gravity);
        world.getWorldInfo().m_gravity = gravity;
    }

    qcMeshShape* KeepMesh(const qcModel& model)
    {
        std::unique_ptr<qcMeshShape> shape = model.MakeShape();
        qcMeshShape* mesh = shape.get();
        shapes.push_back(std::move(shape));
        return mesh;
    }

    btRigidBody* AddBody(btCollisionShape* shape, btScalar mass, const btVector3& at)
    {
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shape->calculateLocalInertia(mass, inertia);
        bodies.emplace_back(new btRigidBody(mass, nullptr, shape, inertia));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        bodies.back()->setInterpolationWorldTransform(bodies.back()->getWorldTransform());
        world.addRigidBody(bodies.back().get());
        return bodies.back().get();
    }

    btRigidBody* AddMesh(const qcModel& model, btScalar mass, const btVector3& at)
    {
        return AddBody(KeepMesh(model), mass, at);
    }

    /// Adds a soft body, 1 cm thick, with four iterations of its links.
    btSoftBody* AddThin(btSoftBody* soft)
    {
        soft->m_cfg.piterations = 4;
        soft->getCollisionShape()->setMargin(btScalar(0.01));
        world.addSoftBody(soft);
        cloths.push_back(soft);
        return soft;
    }

    /// A quadrilateral of cloth between corners as btSoftBodyHelpers::CreatePatch has them: 0.3 kg, 1 cm thick.
    btSoftBody* AddPatch(const btVector3& corner00, const btVector3& corner10, const btVector3& corner01,
                         const btVector3& corner11, int nodesAlong, int nodesAcross, double friction)
    {
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), corner00, corner10, corner01, corner11,
                                                           nodesAlong, nodesAcross, 0, true);
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        cloth->setTotalMass(btScalar(0.3));
        cloth->m_cfg.kDF = btScalar(friction);
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
        return cloth;
    }

    /// Removes the last soft body of the list.
    void RemoveCloth()
    {
        world.removeSoftBody(cloths.back());
        delete cloths.back();
        cloths.pop_back();
    }
};

#endif
