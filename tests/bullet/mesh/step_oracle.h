// An independent check that meshes don't meet within steps: exact tests at moments of the linear motion of vertices.
#ifndef QC_TESTS_BULLET_MESH_STEP_ORACLE_H
#define QC_TESTS_BULLET_MESH_STEP_ORACLE_H

#include "bullet/mesh/mesh_world.h"

/// Remembers where bodies were, and counts pairs of triangles of different bodies that penetrate on the way to where
/// they are.
class qcStepOracle
{
  public:
    static constexpr int s_moments = 16;

    void Add(const qcModel& model, const btRigidBody* body)
    {
        m_bodies.push_back({&model, body, body->getWorldTransform()});
    }

    /// The largest count at any moment since the last call, and a new start.
    size_t Count()
    {
        size_t count = 0;
        for (int k = 1; k <= s_moments; k++)
            count = std::max(count, CountAt(double(k) / s_moments));
        for (Body& body : m_bodies)
            body.start = body.body->getWorldTransform();
        return count;
    }

  private:
    struct Body
    {
        const qcModel* model;
        const btRigidBody* body;
        btTransform start;
    };

    static void AddAt(qcScene* scene, const Body& body, double time)
    {
        std::vector<double> positions;
        const std::vector<btScalar>& local = body.model->positions;
        for (size_t i = 0; i < local.size(); i += 3)
        {
            btVector3 p(local[i], local[i + 1], local[i + 2]);
            btVector3 from = body.start * p, to = body.body->getWorldTransform() * p;
            for (int axis = 0; axis < 3; axis++)
                positions.push_back((1 - time) * double(from[axis]) + time * double(to[axis]));
        }
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = positions.data();
        def.positionType = qc_positionF64;
        def.vertexCount = uint32_t(positions.size() / 3);
        def.indices = body.model->indices.data();
        def.triangleCount = body.model->TriangleCount();
        def.selfCollision = false;
        qcBodyId id;
        ck_assert_int_eq(qcScene_AddBody(scene, &def, &id), qc_statusOk);
    }

    size_t CountAt(double time) const
    {
        qcSceneDef sceneDef = qcDefaultSceneDef();
        qcScene* scene = nullptr;
        ck_assert_int_eq(qcScene_Create(&sceneDef, &scene), qc_statusOk);
        for (const Body& body : m_bodies)
            AddAt(scene, body, time);
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.threads = 1;
        const qcResult* result = nullptr;
        ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusOk);
        size_t pairs = result->pairCount;
        qcScene_Destroy(scene);
        return pairs;
    }

    std::vector<Body> m_bodies;
};

#endif
