// The candidate triangles of a step's first query, its separating planes and the nodes of its zones, as lines.
#include "soft_body/draw_contacts.h"

#include "common/debug_draw.h"
#include "common/shape_triangles.h"
#include "common/weld_vertices.h"
#include "quickcullide/bullet_debug_draw.h"
#include "soft_body/contact_step.h"

#include <algorithm>

namespace
{
void DrawNode(const btVector3& node, btScalar size, const btVector3& color, btIDebugDraw* drawer)
{
    for (int axis = 0; axis < 3; axis++)
    {
        btVector3 arm(0, 0, 0);
        arm[axis] = size;
        drawer->drawLine(node - arm, node + arm, color);
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
        DrawNode(corners[0], soft.thickness / 2, qcCandidateColor(), drawer);
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
/// Fills `corners` with the present corners of a plane's triangle. False: its body has left or has changed.
bool FindCorners(const qcRigidMeshes& meshes, const qcPlaneSide& side, qcLiveObjects& liveObjects, double corners[9])
{
    btTransform transform;
    if (side.soft != nullptr ? !liveObjects.Contains(side.soft->body, side.soft->uniqueId)
                             : !liveObjects.Contains(side.rigid->object, side.rigid->uniqueId) ||
                                   !meshes.FindTransform(*side.rigid, *side.mesh, &transform))
        return false;
    for (int c = 0; c < 3; c++)
    {
        uint32_t vertex = side.vertices[std::min(c, side.count - 1)];
        if (side.soft != nullptr && int(vertex) >= side.soft->NodeCount())
            return false;
        btVector3 corner = side.soft != nullptr ? side.soft->body->m_nodes[int(vertex)].m_x
                                                : transform * side.mesh->shape->getVertices()[vertex];
        for (int axis = 0; axis < 3; axis++)
            corners[3 * c + axis] = double(corner[axis]);
    }
    return true;
}

/// Draws a square between the closest points of both triangles, and the normal.
void DrawPlane(const qcRigidMeshes& meshes, const qcSeparatingPlane& plane, qcLiveObjects& liveObjects,
               btIDebugDraw* drawer)
{
    double above[9], below[9];
    if (!FindCorners(meshes, plane.above, liveObjects, above) || !FindCorners(meshes, plane.below, liveObjects, below))
        return;
    qcProximity proximity;
    if (!qcTrianglesWithin(above, below, double(BT_LARGE_FLOAT), &proximity))
        return;
    btVector3 center = (qcVectorOf(proximity.pointA) + qcVectorOf(proximity.pointB)) / 2, u, v;
    btPlaneSpace1(plane.normal, u, v);
    const qcSceneSoftBody& soft = plane.above.soft != nullptr ? *plane.above.soft : *plane.below.soft;
    const btVector3 corners[4] = {u + v, u - v, -u - v, v - u};
    for (int c = 0; c < 4; c++)
        drawer->drawLine(center + corners[c] * (soft.thickness / 2),
                         center + corners[(c + 1) % 4] * (soft.thickness / 2), qcPlaneColor());
    drawer->drawLine(center, center + plane.normal * soft.thickness, qcPlaneColor());
}
} // namespace

void qcSoftCandidates::Clear()
{
    m_pcs.clear();
    m_features.clear();
    m_pairs.clear();
}

void qcSoftCandidates::Record(const qcResult& result)
{
    m_pcs.assign(result.pcs, result.pcs + result.pcsCount);
    m_pairs.assign(result.candidates, result.candidates + result.candidateCount);
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

void qcSoftBodyContact::Implementation::DrawPcs(qcLiveObjects& liveObjects, btIDebugDraw* drawer)
{
    if (m_candidates.AreEmpty())
        return;
    m_candidates.Sort();
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
}

/// Fills the present corners of a triangle of the scene. False: its body has left or has changed.
bool qcSoftBodyContact::Implementation::FindTriangle(uint32_t slot, uint32_t triangle, qcLiveObjects& liveObjects,
                                                     btVector3 corners[3])
{
    if (const qcSceneSoftBody* soft = scene.Find(slot))
    {
        if (!liveObjects.Contains(soft->body, soft->uniqueId))
            return false;
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t node = soft->topology.indices[3 * size_t(triangle) + c];
            if (int(node) >= soft->NodeCount())
                return false;
            corners[c] = soft->body->m_nodes[int(node)].m_x;
        }
        return true;
    }
    qcSceneRigid* rigid;
    btTransform transform;
    const qcSceneMesh* mesh = scene.meshes.Find(slot, &rigid);
    if (mesh == nullptr || !liveObjects.Contains(rigid->object, rigid->uniqueId) ||
        !scene.meshes.FindTransform(*rigid, *mesh, &transform))
        return false;
    for (size_t c = 0; c < 3; c++)
        corners[c] = transform * mesh->shape->getVertices()[mesh->shape->getIndices()[3 * size_t(triangle) + c]];
    return true;
}

void qcSoftBodyContact::Implementation::DrawCandidatePairs(qcLiveObjects& liveObjects, btIDebugDraw* drawer)
{
    btVector3 a[3], b[3];
    for (const qcCandidate& pair : m_candidates.Pairs())
        if (FindTriangle(pair.bodyA, pair.triangleA, liveObjects, a) &&
            FindTriangle(pair.bodyB, pair.triangleB, liveObjects, b))
            qcDrawCandidatePair(drawer, a, b);
}

void qcSoftBodyContact::Implementation::DrawPlanes(qcLiveObjects& liveObjects, btIDebugDraw* drawer)
{
    for (const qcSeparatingPlane& plane : m_planes.Planes())
        DrawPlane(scene.meshes, plane, liveObjects, drawer);
    m_zones.ForEachNode(
        [&](const qcSceneSoftBody& soft, uint32_t node)
        {
            if (liveObjects.Contains(soft.body, soft.uniqueId) && int(node) < soft.NodeCount())
                DrawNode(soft.body->m_nodes[int(node)].m_x, soft.thickness, qcZoneColor(), drawer);
        });
}

void qcSoftBodyContact::Implementation::Draw(int modes, btIDebugDraw* drawer)
{
    if ((m_candidates.AreEmpty() && m_planes.Count() == 0) || manifolds.GetBroadphase() == nullptr)
        return;
    qcLiveObjects liveObjects(manifolds.GetBroadphase());
    if ((modes & qc_drawPcs) != 0)
        DrawPcs(liveObjects, drawer);
    if ((modes & qc_drawCandidates) != 0)
        DrawCandidatePairs(liveObjects, drawer);
    if ((modes & qc_drawPlanes) != 0)
        DrawPlanes(liveObjects, drawer);
    drawer->flushLines();
}
