// Works tangled surfaces apart.
//
// At each end of a pair's segment an edge of one triangle passes through the other triangle, the face. With e the edge,
// n the normal of the face, and r the direction of the segment from that end, a motion d of the edge moves the end by
// d - e (n.d) / (n.e), and so shortens the segment by d . (r - n (e.r) / (n.e)).
#include "soft_body/response/untangle.h"

#include "common/shape_triangles.h"

#include <algorithm>

namespace
{
// The largest motion of a node in a step, as a share of the thickness.
constexpr btScalar s_maxShift = btScalar(0.25);
// Edges with a smaller sine to the face give no reliable direction.
constexpr btScalar s_minEdgeSlope = btScalar(0.05);

/// Moves an edge one way and a face the other.
struct Push
{
    qcSceneSoftBody *edgeBody, *faceBody; ///< null: a mesh, which stays
    uint32_t nodes[5];                    ///< of the edge two, of the face three
    btScalar weights[5];
    btVector3 direction; ///< of the edge, no longer than 1
};

struct Triangle
{
    qcSceneSoftBody* soft;
    uint32_t nodes[3];
    btVector3 corners[3];

    Triangle(qcSoftBodyScene& scene, uint32_t slot, uint32_t triangle) : soft(scene.Find(slot))
    {
        qcSceneRigid* rigid = nullptr;
        const qcSceneMesh* mesh = soft == nullptr ? scene.meshes.Find(slot, &rigid) : nullptr;
        for (size_t c = 0; c < 3; c++)
        {
            nodes[c] = soft != nullptr ? soft->topology.indices[3 * size_t(triangle) + c]
                                       : mesh->shape->getIndices()[3 * size_t(triangle) + c];
            corners[c] = soft != nullptr ? soft->positions[nodes[c]]
                                         : mesh->sceneTransform * mesh->shape->getVertices()[nodes[c]];
        }
    }

    btVector3 Normal() const
    {
        btVector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        return normal.fuzzyZero() ? btVector3(0, 0, 0) : normal.normalized();
    }
};

/// The parameter of the point of an edge that is nearest to a point, and the squared distance.
btScalar NearestOnEdge(const Triangle& triangle, int edge, const btVector3& point, btScalar* distance2)
{
    btVector3 from = triangle.corners[edge], along = triangle.corners[(edge + 1) % 3] - from;
    btScalar length2 = along.length2();
    btScalar share = length2 > 0 ? btClamped(along.dot(point - from) / length2, btScalar(0), btScalar(1)) : btScalar(0);
    *distance2 = point.distance2(from + along * share);
    return share;
}

void Barycentric(const Triangle& face, const btVector3& normal, const btVector3& point, btScalar weights[3])
{
    btScalar sum = 0;
    for (int c = 0; c < 3; c++)
    {
        const btVector3 &next = face.corners[(c + 1) % 3], &last = face.corners[(c + 2) % 3];
        weights[c] = btMax(btScalar(0), normal.dot((next - point).cross(last - point)));
        sum += weights[c];
    }
    for (int c = 0; c < 3; c++)
        weights[c] = sum > 0 ? weights[c] / sum : btScalar(1) / 3;
}

/// False: the edge is too flat in the face to shorten the segment reliably.
bool MakePush(const Triangle& a, const Triangle& b, const btVector3& end, const btVector3& along, Push* push)
{
    const Triangle* best = nullptr;
    int bestEdge = 0;
    btScalar nearest = BT_LARGE_FLOAT, share = 0;
    for (const Triangle* triangle : {&a, &b})
        for (int edge = 0; edge < 3; edge++)
        {
            btScalar distance2, at = NearestOnEdge(*triangle, edge, end, &distance2);
            if (distance2 >= nearest)
                continue;
            nearest = distance2;
            best = triangle;
            bestEdge = edge;
            share = at;
        }
    const Triangle& face = best == &a ? b : a;
    btVector3 normal = face.Normal(), edge = best->corners[(bestEdge + 1) % 3] - best->corners[bestEdge];
    if (edge.fuzzyZero())
        return false;
    edge.normalize();
    btScalar slope = normal.dot(edge);
    if (btFabs(slope) < s_minEdgeSlope)
        return false;
    push->edgeBody = best->soft;
    push->faceBody = face.soft;
    push->nodes[0] = best->nodes[bestEdge];
    push->nodes[1] = best->nodes[(bestEdge + 1) % 3];
    push->weights[0] = 1 - share;
    push->weights[1] = share;
    std::copy_n(face.nodes, 3, &push->nodes[2]);
    Barycentric(face, normal, end, &push->weights[2]);
    push->direction = along - normal * (edge.dot(along) / slope);
    btScalar length = push->direction.length();
    if (length > 1)
        push->direction /= length;
    return true;
}

/// Calls function(body, node, share) for each node; share: the node's part of the push's relative motion, negative for
/// the nodes of the face.
template <typename Function> void ForEachNode(const Push& push, Function function)
{
    btScalar sum = 0, largest = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < 5; i++)
        {
            qcSceneSoftBody* body = i < 2 ? push.edgeBody : push.faceBody;
            if (body == nullptr)
                continue;
            btScalar share = push.weights[i] * body->InverseMass(push.nodes[i]);
            if (pass == 0)
            {
                sum += push.weights[i] * share;
                largest = std::max(largest, share);
            }
            else if (share > 0)
                function(body, push.nodes[i], (i < 2 ? share : -share) / std::max(sum, largest));
        }
}
} // namespace

void qcUntangle(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& pairs)
{
    std::vector<Push> pushes;
    for (size_t i : pairs)
    {
        const qcPair& pair = result.pairs[i];
        Triangle a(scene, pair.bodyA, pair.triangleA), b(scene, pair.bodyB, pair.triangleB);
        btVector3 p = qcVectorOf(result.segments[i].p), q = qcVectorOf(result.segments[i].q), along = q - p;
        if (along.fuzzyZero())
            continue;
        along.normalize();
        Push push;
        if (MakePush(a, b, p, along, &push))
            pushes.push_back(push);
        if (MakePush(a, b, q, -along, &push))
            pushes.push_back(push);
    }
    // One factor for all nodes, given by the one that would move furthest, keeps momentum.
    btScalar maxShare = 0;
    for (qcSceneSoftBody& soft : scene.Bodies())
        soft.shifts.assign(soft.positions.size(), btVector3(0, 0, 0));
    for (const Push& push : pushes)
        ForEachNode(push, [&](qcSceneSoftBody* body, uint32_t node, btScalar share)
                    { body->shifts[node] += push.direction * share; });
    for (const qcSceneSoftBody& soft : scene.Bodies())
        for (const btVector3& shift : soft.shifts)
            maxShare = std::max(maxShare, shift.length() / (s_maxShift * soft.thickness));
    for (qcSceneSoftBody& soft : scene.Bodies())
        for (size_t i = 0; i < soft.shifts.size() && maxShare > 0; i++)
        {
            soft.shifts[i] /= maxShare;
            soft.positions[i] += soft.shifts[i];
        }
}
