// The scenes of `qc-bench piles`.
#include "bench/piles/scenes.h"

#include "quickcullide/bullet_fracture.h"

#include <cstring>
#include <random>

namespace
{
/// 576 triangles, 0.8 wide.
qcTriangles Torus()
{
    return qcMakeTorus(btScalar(0.3), btScalar(0.1), 24, 12);
}

/// 902 triangles, about 1 high.
qcTriangles Bunny()
{
    return qcMakeBunny(1000);
}

/// 69 666 triangles, about 1 high.
qcTriangles FineBunny()
{
    return qcMakeBunny(UINT32_MAX);
}

using Random = std::minstd_rand;

btScalar Draw(Random* random, double lower, double upper)
{
    return btScalar(std::uniform_real_distribution<double>(lower, upper)(*random));
}

btQuaternion DrawRotation(Random* random)
{
    btScalar q[4];
    for (btScalar& value : q)
        value = Draw(random, -1, 1);
    return btQuaternion(q[0], q[1], q[2], q[3]).normalized();
}

/// `Count` copies of a model, turned at random, in layers of four; each falls on those below. `Spacing` and half the
/// width of the bin, `Bin`, in cm; no bin: 0.
template <qcTriangles (*Model)(), int Count, int Spacing, int Bin> void MakeHeap(uint32_t seed, qcPilesSetup* setup)
{
    setup->models = {Model()};
    setup->binHalf = btScalar(Bin) / 100;
    Random random(seed);
    for (int i = 0; i < Count; i++)
    {
        btVector3 place(btScalar(i % 2) - btScalar(0.5), btScalar(0.6) + btScalar(i / 4),
                        btScalar(i / 2 % 2) - btScalar(0.5));
        setup->bodies.push_back({0, btTransform(DrawRotation(&random), place * (btScalar(Spacing) / 100))});
    }
}

/// Rings that lie on each other, a little apart at the start, each turned about the vertical axis at random.
template <int Count> void MakeStack(uint32_t seed, qcPilesSetup* setup)
{
    setup->models = {Torus()};
    Random random(seed);
    btQuaternion flat(btVector3(1, 0, 0), SIMD_HALF_PI);
    for (int i = 0; i < Count; i++)
    {
        btQuaternion turn(btVector3(0, 1, 0), Draw(&random, 0, 3));
        btVector3 place(Draw(&random, -0.02, 0.02), btScalar(0.12) + btScalar(0.23) * btScalar(i),
                        Draw(&random, -0.02, 0.02));
        setup->bodies.push_back({0, btTransform(turn * flat, place)});
    }
}

/// Rings, each of which passes through the one before: a chain that falls on the ground.
template <int Count> void MakeChain(uint32_t seed, qcPilesSetup* setup)
{
    setup->models = {qcMakeTorus(btScalar(0.3), btScalar(0.06), 24, 12)};
    Random random(seed);
    for (int i = 0; i < Count; i++)
    {
        btScalar angle = (i % 2 == 0 ? 1 : -1) * SIMD_PI / 4 + Draw(&random, -0.1, 0.1);
        btScalar middle = btScalar(Count - 1) / 2;
        setup->bodies.push_back({0, btTransform(btQuaternion(btVector3(1, 0, 0), angle),
                                                btVector3(btScalar(0.42) * (btScalar(i) - middle), 1, 0))});
    }
}
/// Pieces of a fine bunny, each where it was in the whole.
template <int Sites> void MakePieces(uint32_t seed, qcPilesSetup* setup)
{
    const qcTriangles& bunny = qcMakeBunny(UINT32_MAX);
    qcFractureDef def;
    for (size_t i = 0; i < bunny.positions.size(); i += 3)
        def.vertices.emplace_back(bunny.positions[i], bunny.positions[i + 1], bunny.positions[i + 2]);
    def.indices = bunny.indices;
    def.sites = qcScatterSites(btVector3(-0.5, -0.5, -0.5), btVector3(0.5, 0.5, 0.5), Sites, seed, nullptr);
    btTransform place(btQuaternion(btVector3(0, 0, 1), btScalar(0.3)), btVector3(0, btScalar(0.75), 0));
    for (const qcPiece& piece : qcFracture_Split(def).pieces)
    {
        qcTriangles model;
        for (const btVector3& vertex : piece.vertices)
            model.Add(vertex);
        model.indices = piece.indices;
        setup->bodies.push_back({setup->models.size(), place * piece.frame});
        setup->models.push_back(model);
    }
}
} // namespace

const std::vector<qcPilesSceneDef>& qcPilesScenes()
{
    static const std::vector<qcPilesSceneDef> scenes = {
        {"tori-6", "6 tori of 576 triangles on the ground", 900, MakeHeap<Torus, 6, 90, 0>},
        {"tori-12", "12 tori in a bin", 900, MakeHeap<Torus, 12, 90, 95>},
        {"bunnies-6", "6 bunnies of 902 triangles on the ground", 900, MakeHeap<Bunny, 6, 125, 0>},
        {"bunnies-12", "12 bunnies in a bin", 900, MakeHeap<Bunny, 12, 125, 135>},
        {"stack-6", "6 tori that lie on each other", 900, MakeStack<6>},
        {"chain-6", "6 rings, each through the next, on the ground", 900, MakeChain<6>, false},
        {"bunnies-20", "20 bunnies of 69 666 triangles in a bin", 180, MakeHeap<FineBunny, 20, 144, 150>, false, false},
        {"pieces-31", "pieces of such a bunny that falls apart", 60, MakePieces<31>, false, false},
    };
    return scenes;
}

const qcPilesSceneDef* qcFindPilesScene(const char* name)
{
    for (const qcPilesSceneDef& scene : qcPilesScenes())
        if (std::strcmp(scene.name, name) == 0)
            return &scene;
    return nullptr;
}
