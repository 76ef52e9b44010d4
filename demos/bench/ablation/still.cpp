// Scenes whose depth is known: bodies overlap by a displacement that would separate them again.
#include "bench/ablation/ablation.h"
#include "bench/ablation/shapes.h"

#include <algorithm>
#include <random>

namespace
{
constexpr unsigned s_repeats = 5; // the fastest is reported

/// Bodies, each displaced from a position in which it only touches the others.
struct Displaced
{
    qcScene* scene = nullptr;
    std::vector<qcBodyId> bodies;
    std::vector<btTransform> places;
    std::vector<btVector3> displacements;

    Displaced()
    {
        qcSceneDef def = qcDefaultSceneDef();
        qcExpectOk(qcScene_Create(&def, &scene));
    }
    ~Displaced()
    {
        qcScene_Destroy(scene);
    }
    Displaced(const Displaced&) = delete;
    Displaced& operator=(const Displaced&) = delete;

    void Add(const qcAblationMesh& mesh, const btTransform& place, const btVector3& displacement)
    {
        bodies.push_back(qcAddRigid(scene, mesh));
        places.push_back(place);
        displacements.push_back(displacement);
    }

    /// Moves all bodies by `offset`, since a detection of an unchanged scene would repeat its result.
    void Place(double offset)
    {
        for (size_t i = 0; i < bodies.size(); i++)
        {
            const btTransform& place = places[i];
            qcTransform transform = qcIdentityTransform();
            for (int row = 0; row < 3; row++)
            {
                for (int column = 0; column < 3; column++)
                    transform.linear[3 * row + column] = double(place.getBasis()[row][column]);
                transform.translation[row] = double(place.getOrigin()[row]) + double(displacements[i][row]) + offset;
            }
            qcExpectOk(qcScene_SetTransform(scene, bodies[i], &transform));
        }
    }

    qcAblationResult Measure(const char* stage, double margin)
    {
        qcSwitchOff(stage);
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.margin = margin;
        def.touching = def.manifolds = true;
        def.threads = 1;
        qcAblationResult measured;
        measured.ms = 1e9;
        measured.depth = 0;
        for (unsigned i = 0; i < s_repeats; i++)
        {
            Place(1e-9 * i);
            const qcResult* result = nullptr;
            qcExpectOk(qcScene_Detect(scene, &def, &result));
            measured.ms = std::min(measured.ms, result->profile.manifoldMs);
            measured.points = double(result->manifoldPointCount);
            for (size_t m = 0; m < result->manifoldCount; m++)
                measured.depth = std::max(measured.depth, RelativeDepth(*result, result->manifolds[m]));
        }
        return measured;
    }

    /// Depth of a manifold's deepest point relative to the displacement that would separate its bodies.
    double RelativeDepth(const qcResult& result, const qcManifold& manifold) const
    {
        if (manifold.pointCount == 0)
            return 0;
        double depth = -result.manifoldPoints[manifold.firstPoint].distance;
        double length = double((displacements[manifold.bodyA] - displacements[manifold.bodyB]).length());
        // Bodies without contact before their displacement overlap by less; they are included.
        return length > 0 ? depth / length : 0;
    }
};

} // namespace

// A box of tiles, turned, sunk into a floor of tiles by a hundredth of their size and more.
qcAblationResult qcRunSunkBox(unsigned seed, const char* stage)
{
    Displaced scene;
    qcAblationMesh floor;
    qcAddTiles(&floor, btVector3(-2, 0, -2), btVector3(0, 0, 4), btVector3(4, 0, 0), 24);
    btTransform turned(btQuaternion(btVector3(0, 1, 0), btScalar(0.3) * btScalar(seed)),
                       btVector3(0, btScalar(0.5), 0));
    scene.Add(qcBoxOf(1, 8), turned, btVector3(0, btScalar(-0.001) * btScalar(seed * seed), 0));
    scene.Add(floor, btTransform::getIdentity(), btVector3(0, 0, 0));
    return scene.Measure(stage, 0.02);
}

// Cells of a cube, each displaced in a direction of its own.
qcAblationResult qcRunDisplacedCells(unsigned seed, const char* stage)
{
    Displaced scene;
    std::mt19937 random(seed);
    auto uniform = [&random] { return btScalar(random()) / btScalar(std::mt19937::max()) * 2 - 1; };
    // From a thousandth of the cube to a fiftieth: less and more than the margin.
    btScalar most = btScalar(seed % 2 == 0 ? 0.001 : 0.0025) * btScalar(seed);
    for (const qcPiece& piece : qcBreakCube(1, 30, seed))
    {
        btVector3 displacement(uniform(), uniform(), uniform());
        scene.Add({piece.vertices, piece.indices}, piece.frame, displacement * most);
    }
    return scene.Measure(stage, 0.01);
}
