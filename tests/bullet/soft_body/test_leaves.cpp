// The tree of the leaves demo, its leaves before anything moves, and their fall.
#include "leaves/growth.h"
#include "leaves/world.h"

#include "support/check_ok.h"
#include "support/long_form.h"
#include "support/suite.h"

#include <cmath>
#include <map>
#include <utility>

namespace
{
/// A scene of the present positions, without the state of any solver.
class Soup
{
  public:
    Soup()
    {
        qcSceneDef def = qcDefaultSceneDef();
        CHECK_OK(qcScene_Create(&def, &m_scene));
    }
    ~Soup()
    {
        qcScene_Destroy(m_scene);
    }
    void Add(const void* positions, qcPositionType type, size_t stride, size_t vertexCount,
             const std::vector<uint32_t>& indices)
    {
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = positions;
        def.positionType = type;
        def.positionStride = stride;
        def.vertexCount = uint32_t(vertexCount);
        def.indices = indices.data();
        def.triangleCount = uint32_t(indices.size() / 3);
        def.selfCollision = false;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(m_scene, &def, &id));
    }
    void Add(const qcTree& tree)
    {
        Add(tree.vertices.data(), qcBulletPositions, sizeof(btVector3), tree.vertices.size(), tree.indices);
    }
    size_t CountWithin(double margin)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.margin = margin;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(m_scene, &def, &result));
        return result->pairCount;
    }

  private:
    qcScene* m_scene;
};

size_t CountPenetratingLeaves(const qcLeavesWorld& world)
{
    Soup soup;
    soup.Add(world.Tree());
    for (size_t i = 0; i < world.LeafCount(); i++)
    {
        std::vector<float> positions;
        world.AppendPositions(i, 0, &positions);
        soup.Add(positions.data(), qc_positionF32, 0, positions.size() / 3, world.LeafIndices());
    }
    return soup.CountWithin(0);
}

std::vector<float> PositionsAfter(uint32_t seed, uint32_t threads, int steps)
{
    qcLeavesRequest request;
    request.leaves = 40;
    request.seed = seed;
    request.threads = threads;
    qcLeavesWorld world(request, nullptr);
    for (int step = 0; step < steps; step++)
        world.Step();
    std::vector<float> positions;
    for (size_t i = 0; i < world.LeafCount(); i++)
        world.AppendPositions(i, 0, &positions);
    return positions;
}
} // namespace

START_TEST(a_tree_is_made_of_closed_tubes_that_face_outwards)
{
    for (uint32_t randomSeed = 1; randomSeed <= 3; randomSeed++)
    {
        qcTree tree = qcGrowTree(randomSeed);
        std::map<std::pair<uint32_t, uint32_t>, int> uses;
        double volume = 0;
        for (size_t i = 0; i < tree.indices.size(); i += 3)
        {
            const uint32_t* corner = &tree.indices[i];
            for (int k = 0; k < 3; k++)
                uses[{corner[k], corner[(k + 1) % 3]}]++;
            volume += double(tree.vertices[corner[0]].triple(tree.vertices[corner[1]], tree.vertices[corner[2]])) / 6;
        }
        for (const auto& edge : uses)
            ck_assert_msg(edge.second == 1 && uses.count({edge.first.second, edge.first.first}) == 1,
                          "seed %u: edge %u, %u", randomSeed, edge.first.first, edge.first.second);
        // A trunk of 2 m with a mean radius of 6 cm, and its branches.
        ck_assert_double_gt(volume, 0.02);
        ck_assert_double_lt(volume, 0.08);
    }
}
END_TEST

START_TEST(leaves_grow_further_than_the_gap_from_the_tree_and_each_other)
{
    const btScalar gap = btScalar(0.01);
    qcTree tree = qcGrowTree(1);
    std::vector<qcLeafMesh> leaves = qcGrowLeaves(tree, 384, gap, 1);
    ck_assert_uint_eq(leaves.size(), 384);
    ck_assert_uint_ge(leaves.size() * leaves[0].indices.size() / 3, 40000);
    Soup soup;
    soup.Add(tree);
    for (const qcLeafMesh& leaf : leaves)
    {
        ck_assert(leaf.indices == leaves[0].indices);
        soup.Add(leaf.vertices.data(), qcBulletPositions, sizeof(btVector3), leaf.vertices.size(),
                 std::vector<uint32_t>(leaf.indices.begin(), leaf.indices.end()));
    }
    ck_assert_uint_eq(soup.CountWithin(double(gap)), 0);
    // The oracle sees something: the stalks begin near a twig.
    ck_assert_uint_gt(soup.CountWithin(4 * double(gap)), 384);
}
END_TEST

START_TEST(leaves_fall_to_the_ground_without_a_penetrating_pair)
{
    qcLeavesRequest request;
    request.leaves = qcIsLongForm() ? 150 : 50;
    qcLeavesWorld world(request, nullptr);
    const size_t count = world.LeafCount();
    ck_assert_uint_eq(count, request.leaves);
    // Fewer leaves lie still after seven seconds.
    const double stepsToRest = (qcIsLongForm() ? 9 : 7.5) / qcLeavesWorld::stepSeconds;
    int contacts = 0;
    double energy = 0;
    for (int step = 1; step <= stepsToRest; step++)
    {
        world.Step();
        const qcSoftBodyStatistics& statistics = world.Statistics();
        ck_assert_msg(statistics.status == qc_statusOk && statistics.remaining == 0, "step %d: %d pairs penetrate",
                      step, statistics.remaining);
        // All ten rounds: planes don't hold leaves apart by themselves. No step takes more than four.
        ck_assert_int_lt(statistics.rounds, 7);
        if (step % 20 == 0)
            ck_assert_uint_eq(CountPenetratingLeaves(world), 0);
        ck_assert_msg(world.Lowest() > 0, "step %d: a leaf is in the ground by %g m", step, -world.Lowest());
        contacts = std::max(contacts, statistics.contacts);
        energy = std::max(energy, world.KineticEnergy());
        // 3 grams a leaf at 5 m/s: faster than air lets leaves fall.
        ck_assert_double_lt(world.KineticEnergy(), double(count) * 0.5 * 0.003 * 25);
    }
    ck_assert_uint_gt(world.HangingCount(), 0);
    ck_assert_uint_lt(world.HangingCount(), count / 5);
    ck_assert_int_gt(contacts, 1000);
    ck_assert_double_lt(world.KineticEnergy(), 0.02 * energy);
}
END_TEST

START_TEST(the_fall_depends_on_the_seed_and_not_on_threads)
{
    std::vector<float> first = PositionsAfter(5, 1, 200);
    ck_assert(first == PositionsAfter(5, 2, 200));
    ck_assert(first != PositionsAfter(6, 1, 200));
}
END_TEST

QC_RUN_TESTS("leaves", a_tree_is_made_of_closed_tubes_that_face_outwards,
             leaves_grow_further_than_the_gap_from_the_tree_and_each_other,
             leaves_fall_to_the_ground_without_a_penetrating_pair, the_fall_depends_on_the_seed_and_not_on_threads)
