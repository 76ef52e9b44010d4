// The candidate triangles of a step's first query, as lines.
#include "soft_body/draw_contacts.h"

#include "common/debug_draw.h"
#include "common/weld_vertices.h"
#include "common/live_objects.h"
#include "soft_body/contact_step.h"

#include <algorithm>

namespace
{
void DrawNode(const btVector3& node, btScalar size, btIDebugDraw* drawer)
{
    for (int axis = 0; axis < 3; axis++)
    {
        btVector3 arm(0, 0, 0);
        arm[axis] = size;
        drawer->drawLine(node - arm, node + arm, qcCandidateColor());
    }
}

/// Draws a triangle of the scene: a face, a rope link or a single node. Nodes may have been removed since the step.
void DrawTriangle(const qcSceneSoftBody& soft, uint32_t triangle, btIDebugDraw* drawer)
{
    const uint32_t* nodes = &soft.topology.indices[3 * size_t(triangle)];
    btVector3 corners[3];
    for (int c = 0; c < 3; c++)
    {
        if (int(nodes[c]) >= soft.NodeCount())
            return;
        corners[c] = soft.body->m_nodes[int(nodes[c])].m_x;
    }
    if (triangle < soft.topology.faceCount)
        qcDrawCandidate(drawer, corners[0], corners[1], corners[2]);
    else if (triangle < soft.topology.faceCount + soft.topology.ropeCount)
        drawer->drawLine(corners[0], corners[1], qcCandidateColor());
    else
        DrawNode(corners[0], soft.thickness / 2, drawer);
}

void DrawSoft(const qcSoftCandidates& candidates, const qcSceneSoftBody& soft, btIDebugDraw* drawer)
{
    for (uint32_t t = 0; t < soft.topology.indices.size() / 3; t++)
        if (candidates.Contains(soft.id.slot, t, &soft.topology.indices[3 * size_t(t)]))
            DrawTriangle(soft, t, drawer);
}

void DrawMesh(const qcSoftCandidates& candidates, const qcSceneMesh& mesh, const btTransform& transform,
              btIDebugDraw* drawer)
{
    const qcMeshShape& shape = *mesh.shape;
    const btVector3* vertices = shape.getVertices();
    // Vertex indices as in the scene.
    std::vector<uint32_t> welded = qcFirstAtPosition(vertices, shape.getVertexCount());
    for (uint32_t t = 0; t < shape.getTriangleCount(); t++)
    {
        const uint32_t* index = shape.getIndices() + 3 * size_t(t);
        const uint32_t corners[3] = {welded[index[0]], welded[index[1]], welded[index[2]]};
        if (candidates.Contains(mesh.id.slot, t, corners))
            qcDrawCandidate(drawer, transform * vertices[index[0]], transform * vertices[index[1]],
                            transform * vertices[index[2]]);
    }
}
} // namespace

void qcSoftCandidates::Clear()
{
    m_pcs.clear();
    m_features.clear();
}

void qcSoftCandidates::Record(const qcResult& result)
{
    m_pcs.assign(result.pcs, result.pcs + result.pcsCount);
    m_features.clear();
    for (size_t i = 0; i < result.contactCount; i++)
    {
        const qcContact& contact = result.contacts[i];
        const uint32_t *a = contact.verticesA, *b = contact.verticesB;
        m_features.push_back({contact.bodyA, {a[0], a[1], a[2]}});
        m_features.push_back({contact.bodyB, {b[0], b[1], b[2]}});
    }
}

bool qcSoftCandidates::AreEmpty() const
{
    return m_pcs.empty() && m_features.empty();
}

void qcSoftCandidates::Sort()
{
    for (Feature& feature : m_features)
        feature = MakeFeature(feature.slot, feature.vertices[0], feature.vertices[1], feature.vertices[2]);
    std::sort(m_features.begin(), m_features.end());
}

qcSoftCandidates::Feature qcSoftCandidates::MakeFeature(uint32_t slot, uint32_t a, uint32_t b, uint32_t c)
{
    Feature feature{slot, {a, b, c}};
    std::sort(feature.vertices.begin(), feature.vertices.end());
    // An edge may have either end twice.
    if (feature.vertices[0] == feature.vertices[1])
        feature.vertices[1] = feature.vertices[2];
    return feature;
}

bool qcSoftCandidates::ContainsFeature(const Feature& feature) const
{
    return std::binary_search(m_features.begin(), m_features.end(), feature);
}

bool qcSoftCandidates::Contains(uint32_t slot, uint32_t triangle, const uint32_t corners[3]) const
{
    auto isLess = [](const qcTriangleRef& x, const qcTriangleRef& y)
    { return std::tie(x.body, x.triangle) < std::tie(y.body, y.triangle); };
    if (std::binary_search(m_pcs.begin(), m_pcs.end(), qcTriangleRef{slot, triangle}, isLess))
        return true;
    for (int c = 0; c < 3; c++)
    {
        uint32_t from = corners[c], to = corners[(c + 1) % 3];
        if (ContainsFeature(MakeFeature(slot, from, from, from)) || ContainsFeature(MakeFeature(slot, from, to, to)))
            return true;
    }
    return ContainsFeature(MakeFeature(slot, corners[0], corners[1], corners[2]));
}

void qcSoftBodyContact::Implementation::Draw(btIDebugDraw* drawer)
{
    if (m_candidates.AreEmpty() || manifolds.GetBroadphase() == nullptr)
        return;
    m_candidates.Sort();
    qcLiveObjects liveObjects(manifolds.GetBroadphase());
    for (const qcSceneSoftBody& soft : scene.Bodies())
        if (liveObjects.Contains(soft.body, soft.uniqueId))
            DrawSoft(m_candidates, soft, drawer);
    for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        for (const qcSceneMesh& mesh : rigid->meshes)
        {
            btTransform transform;
            if (liveObjects.Contains(rigid->object, rigid->uniqueId) &&
                scene.meshes.FindTransform(*rigid, mesh, &transform))
                DrawMesh(m_candidates, mesh, transform, drawer);
        }
    drawer->flushLines();
}
