// A cloth that is thrown at one of Bullet's own shapes.
#ifndef QC_TESTS_BULLET_SOFT_BODY_SHAPE_SCENE_H
#define QC_TESTS_BULLET_SOFT_BODY_SHAPE_SCENE_H

#include "bullet/soft_body/shape_models.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"
#include "bullet/soft_body/soft_models.h"

/// A square of 2 by 2 metres over a shape at the origin. Its mass is 1 kg.
struct qcShapeScene : qcSoftWorld
{
    qcShapeModel model;
    btRigidBody* body = nullptr;
    btSoftBody* cloth = nullptr;

    explicit qcShapeScene(qcShapeKind kind, int side = 32, btScalar size = 2, btScalar mass = 0, bool isPlain = false)
        : qcSoftWorld(nullptr, isPlain), model(qcMakeShape(kind))
    {
        // For Bullet's own contacts of nodes.
        world.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(btScalar(0.03));
        world.getWorldInfo().m_sparsesdf.Reset();
        body = AddBody(model.shape.get(), mass, btVector3(0, 0, 0));
        const btScalar h = size / 2, y = model.top + btScalar(0.1) * size;
        cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-h, y, -h),
                                               btVector3(h * btScalar(1.03), y, -h),
                                               btVector3(-h, y + btScalar(0.05) * size, h),
                                               btVector3(h, y + btScalar(0.02) * size, h), side + 1, side + 1, 0, true);
        cloth->setTotalMass(1);
        cloth->m_cfg.piterations = 8;
        cloth->m_cfg.kKHR = 1;
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
    }

    ~qcShapeScene()
    {
        RemoveAll();
    }

    void UseBulletsContacts()
    {
        qcSoftBodySettings settings = softSolver.getSettings(cloth);
        settings.bulletNodeContacts = true;
        softSolver.setSettings(cloth, settings);
    }

    void Step(btScalar timeStep = btScalar(1.0 / 60))
    {
        world.stepSimulation(timeStep, 0);
        ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
    }

    btScalar KineticEnergy() const
    {
        btScalar sum = 0;
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            sum += cloth->m_nodes[i].m_v.length2() / cloth->m_nodes[i].m_im / 2;
        return sum;
    }

    btVector3 Center() const
    {
        btVector3 sum(0, 0, 0);
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            sum += cloth->m_nodes[i].m_x / cloth->m_nodes[i].m_im;
        return sum;
    }

    /// Kinetic and potential energy of the cloth, without that of its links.
    btScalar Energy() const
    {
        return KineticEnergy() - world.getGravity().dot(Center());
    }

    /// Watches the cloth and the triangles of the shape.
    void Watch(qcMotionOracle& oracle) const
    {
        oracle.Add([this] { return qcWorldMeshOf(cloth); });
        oracle.Add(model.model, body);
    }
};

#endif
