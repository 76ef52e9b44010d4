// More leaves than needed are tried at all sites; one query finds which of them are too near to each other.
#include "leaves/growth.h"

#include "leaves/random.h"

#include "quickcullide/bullet_positions.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr int s_tries = 3; // leaves tried at a site

/// A leaf that leaves the twig sideways, its upper side up.
btTransform Sideways(const qcLeafSite& site, btScalar turn, btScalar gap, qcRandom* random)
{
    btVector3 u, v;
    btPlaneSpace1(site.along, u, v);
    btVector3 out = u * std::cos(turn) + v * std::sin(turn);
    btVector3 x = (out + site.along * (*random)(btScalar(0.3), btScalar(0.9)) -
                   btVector3(0, (*random)(btScalar(0.0), btScalar(0.6)), 0))
                      .normalized();
    btVector3 up(random->operator()(btScalar(-0.5), btScalar(0.5)), 1,
                 random->operator()(btScalar(-0.5), btScalar(0.5)));
    btVector3 z = x.cross(up).normalized(), y = z.cross(x);
    btMatrix3x3 axes(x.x(), y.x(), z.x(), x.y(), y.y(), z.y(), x.z(), y.z(), z.z());
    return btTransform(axes, site.place + out * (site.radius + 2 * gap));
}

std::vector<qcLeafMesh> MakeCandidates(const qcTree& tree, btScalar gap, uint32_t seed)
{
    qcRandom random(seed);
    std::vector<qcLeafMesh> leaves;
    btScalar turn = 0;
    for (int attempt = 0; attempt < s_tries; attempt++)
        for (const qcLeafSite& site : tree.sites)
        {
            turn += btScalar(2.4) + random(btScalar(-0.4), btScalar(0.4));
            btScalar size = random(btScalar(0.8), btScalar(1.15));
            qcLeafForm form;
            form.stalk *= size;
            form.length *= size;
            form.halfWidth *= size * random(btScalar(0.85), btScalar(1.15));
            form.fold = random(btScalar(0.12), btScalar(0.40));
            form.droop = random(btScalar(0.05), btScalar(0.40));
            form.wave = random(btScalar(0.0), btScalar(0.008));
            leaves.push_back(qcMakeLeaf(form, Sideways(site, turn, gap, &random)));
        }
    // A random order, so that the leaves which have room are spread over the tree.
    for (size_t i = leaves.size(); i > 1; i--)
        std::swap(leaves[i - 1], leaves[size_t(random(0, btScalar(i) - btScalar(0.5)))]);
    return leaves;
}

bool Add(qcScene* scene, const std::vector<btVector3>& vertices, const uint32_t* indices, size_t indexCount)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = vertices.data();
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btVector3);
    def.vertexCount = uint32_t(vertices.size());
    def.indices = indices;
    def.triangleCount = uint32_t(indexCount / 3);
    def.selfCollision = false;
    qcBodyId id;
    return qcScene_AddBody(scene, &def, &id) == qc_statusOk;
}

/// The tree is body 0, and the leaves follow.
const qcResult* FindNear(qcScene* scene, const qcTree& tree, const std::vector<qcLeafMesh>& leaves, btScalar gap)
{
    if (!Add(scene, tree.vertices, tree.indices.data(), tree.indices.size()))
        return nullptr;
    for (const qcLeafMesh& leaf : leaves)
    {
        std::vector<uint32_t> indices(leaf.indices.begin(), leaf.indices.end());
        if (!Add(scene, leaf.vertices, indices.data(), indices.size()))
            return nullptr;
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.margin = double(gap);
    const qcResult* result = nullptr;
    return qcScene_Detect(scene, &def, &result) == qc_statusOk ? result : nullptr;
}

/// Takes each leaf that is not near one taken earlier.
std::vector<qcLeafMesh> TakeApart(const std::vector<qcLeafMesh>& candidates, const qcResult& near, uint32_t count)
{
    std::vector<std::vector<uint32_t>> earlier(candidates.size());
    for (size_t i = 0; i < near.pairCount; i++)
        earlier[near.pairs[i].bodyB - 1].push_back(near.pairs[i].bodyA);
    std::vector<bool> taken(candidates.size() + 1);
    taken[0] = true; // the tree
    std::vector<qcLeafMesh> leaves;
    for (size_t i = 0; i < candidates.size() && leaves.size() < count; i++)
    {
        const std::vector<uint32_t>& others = earlier[i];
        taken[i + 1] = std::none_of(others.begin(), others.end(), [&taken](uint32_t body) { return taken[body]; });
        if (taken[i + 1])
            leaves.push_back(candidates[i]);
    }
    return leaves;
}
} // namespace

std::vector<qcLeafMesh> qcGrowLeaves(const qcTree& tree, uint32_t count, btScalar gap, uint32_t seed)
{
    std::vector<qcLeafMesh> candidates = MakeCandidates(tree, gap, seed), leaves;
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    if (qcScene_Create(&def, &scene) != qc_statusOk)
        return leaves;
    const qcResult* near = FindNear(scene, tree, candidates, gap);
    if (near != nullptr)
        leaves = TakeApart(candidates, *near, count);
    qcScene_Destroy(scene);
    return leaves;
}
