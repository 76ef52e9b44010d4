// A cloth that is thrown at one of Bullet's own shapes, and what exact tests find within each step.
#ifndef QC_TESTS_BULLET_SOFT_BODY_SHAPE_SCENE_H
#define QC_TESTS_BULLET_SOFT_BODY_SHAPE_SCENE_H

#include "bullet/soft_body/shape_models.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

/// Pairs of triangles of a soft body and a rigid one that penetrate within steps, by exact tests of the linear motion.
class qcPassOracle
{
  public:
    static constexpr int s_moments = 16;

    qcPassOracle(const btSoftBody* soft, const btCollisionObject* rigid, const qcModel& model)
        : m_soft(soft), m_rigid(rigid), m_model(model), m_softStart(qcSoupOf(soft)), m_rigidStart(RigidSoup())
    {
    }

    /// The largest count at any moment since the last call; the last moment is the present.
    size_t Count()
    {
        const qcSoup softEnd = qcSoupOf(m_soft), rigidEnd = RigidSoup();
        size_t max = 0;
        for (int k = 1; k <= s_moments; k++)
            max = std::max(max, qcCountPenetrating({Between(m_softStart, softEnd, double(k) / s_moments),
                                                    Between(m_rigidStart, rigidEnd, double(k) / s_moments)},
                                                   true));
        m_softStart = softEnd;
        m_rigidStart = rigidEnd;
        return max;
    }

  private:
    qcSoup RigidSoup() const
    {
        qcSoup soup;
        for (size_t i = 0; i < m_model.positions.size(); i += 3)
            soup.Add(m_rigid->getWorldTransform() *
                     btVector3(m_model.positions[i], m_model.positions[i + 1], m_model.positions[i + 2]));
        soup.indices = m_model.indices;
        return soup;
    }

    static qcSoup Between(const qcSoup& start, const qcSoup& end, double time)
    {
        qcSoup soup = end;
        for (size_t i = 0; i < soup.positions.size(); i++)
            soup.positions[i] = (1 - time) * start.positions[i] + time * end.positions[i];
        return soup;
    }

    const btSoftBody* m_soft;
    const btCollisionObject* m_rigid;
    const qcModel& m_model;
    qcSoup m_softStart, m_rigidStart;
};

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
        while (!cloths.empty())
            RemoveCloth();
        for (const auto& rigid : bodies)
            world.removeRigidBody(rigid.get());
        bodies.clear();
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

    size_t CountPenetratingNow() const
    {
        qcSoup rigid;
        for (size_t i = 0; i < model.model.positions.size(); i += 3)
            rigid.Add(body->getWorldTransform() *
                      btVector3(model.model.positions[i], model.model.positions[i + 1], model.model.positions[i + 2]));
        rigid.indices = model.model.indices;
        return qcCountPenetrating({qcSoupOf(cloth), rigid}, true);
    }
};

#endif
