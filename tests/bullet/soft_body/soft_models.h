// The triangles of soft bodies and of meshes as they lie in a Bullet world, and the count of penetrating pairs.
#ifndef QC_TESTS_BULLET_SOFT_BODY_SOFT_MODELS_H
#define QC_TESTS_BULLET_SOFT_BODY_SOFT_MODELS_H

#include "quickcullide/bullet.h"

#include "bullet/mesh/motion_oracle.h"
#include "support/oracle.h"

#include <algorithm>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

inline qcWorldMesh qcWorldMeshOf(const btSoftBody* body)
{
    qcWorldMesh soup;
    for (int i = 0; i < body->m_nodes.size(); i++)
        soup.Add(body->m_nodes[i].m_x);
    for (int i = 0; i < body->m_faces.size(); i++)
        for (const btSoftBody::Node* node : body->m_faces[i].m_n)
            soup.indices.push_back(uint32_t(node - &body->m_nodes[0]));
    return soup;
}

/// Momentum of the nodes that can move.
inline btVector3 qcMomentumOf(const btSoftBody* body)
{
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < body->m_nodes.size(); i++)
        if (body->m_nodes[i].m_im > 0)
            sum += body->m_nodes[i].m_v / body->m_nodes[i].m_im;
    return sum;
}

/// Mean speed of the nodes.
inline btScalar qcSpeedOf(const btSoftBody* body)
{
    btScalar sum = 0;
    for (int i = 0; i < body->m_nodes.size(); i++)
        sum += body->m_nodes[i].m_v.length();
    return sum / btScalar(body->m_nodes.size());
}

inline btScalar qcLowestNode(const btSoftBody* body)
{
    btScalar lowest = BT_LARGE_FLOAT;
    for (int i = 0; i < body->m_nodes.size(); i++)
        lowest = btMin(lowest, body->m_nodes[i].m_x.y());
    return lowest;
}

inline qcWorldMesh qcWorldMeshOf(const qcMeshShape& mesh, const btTransform& transform)
{
    qcWorldMesh soup;
    for (uint32_t i = 0; i < mesh.getVertexCount(); i++)
        soup.Add(transform * mesh.getVertices()[i]);
    soup.indices.assign(mesh.getIndices(), mesh.getIndices() + 3 * size_t(mesh.getTriangleCount()));
    return soup;
}

/// Penetrating pairs, counted without the glue; `between`: only pairs of different soups.
inline size_t qcCountPenetrating(const std::vector<qcWorldMesh>& soups, bool between = false)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    ck_assert_int_eq(qcScene_Create(&sceneDef, &scene), qc_statusOk);
    for (const qcWorldMesh& soup : soups)
    {
        qcBodyDef def = qcBodyOf(soup);
        def.selfCollision = !between;
        qcBodyId id;
        ck_assert_int_eq(qcScene_AddBody(scene, &def, &id), qc_statusOk);
    }
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result = nullptr;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusOk);
    size_t pairs = result->pairCount;
    qcScene_Destroy(scene);
    return pairs;
}

inline void qcCorners(const qcWorldMesh& soup, size_t triangle, double corners[3][3])
{
    for (size_t c = 0; c < 3; c++)
        std::copy_n(&soup.positions[3 * size_t(soup.indices[3 * triangle + c])], 3, corners[c]);
}

inline bool qcBoxesMeet(const double a[3][3], const double b[3][3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        auto mineA = {a[0][axis], a[1][axis], a[2][axis]}, mineB = {b[0][axis], b[1][axis], b[2][axis]};
        if (std::max(mineA) < std::min(mineB) || std::max(mineB) < std::min(mineA))
            return false;
    }
    return true;
}

inline bool qcShareIndex(const qcWorldMesh& soup, size_t a, size_t b)
{
    for (size_t i = 0; i < 9; i++)
        if (soup.indices[3 * a + i / 3] == soup.indices[3 * b + i % 3])
            return true;
    return false;
}

/// Penetrating pairs within the first soup, and between it and the others, in rational arithmetic, without
/// the library.
inline size_t qcCountPenetratingExactly(const std::vector<qcWorldMesh>& soups)
{
    size_t count = 0;
    const qcWorldMesh& first = soups[0];
    for (size_t a = 0; a < first.indices.size() / 3; a++)
    {
        double cornersA[3][3], cornersB[3][3];
        qcCorners(first, a, cornersA);
        for (const qcWorldMesh& other : soups)
            for (size_t b = &other == &first ? a + 1 : 0; b < other.indices.size() / 3; b++)
            {
                qcCorners(other, b, cornersB);
                if (!qcBoxesMeet(cornersA, cornersB) || (&other == &first && qcShareIndex(first, a, b)))
                    continue;
                count += qcOracle_Relate(cornersA, cornersB) == qc_relationPenetrating;
            }
    }
    return count;
}

#endif
