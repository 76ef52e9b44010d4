// A cloth in the plane of a floor is on neither side of it, and exact tests find that all its triangles penetrate. Such
// a cloth would be tangled with the floor, and fall through it.
#include "soft_body/response/lying_starts.h"

#include "soft_body/response/position_constraints.h"

#include <algorithm>

namespace
{
// Rounding of a transformed point, relative to its coordinates.
constexpr btScalar s_rounding = 4 * SIMD_EPSILON;
// The height at which a lying body starts, as a share of the contact distance.
constexpr btScalar s_height = btScalar(1e-3);

/// The plane of a rigid triangle at the start of the step.
struct Plane
{
    btVector3 point, normal;

    Plane(const qcSceneRigid& rigid, const qcSceneMesh& mesh, uint32_t triangle)
    {
        btVector3 corners[3];
        for (size_t c = 0; c < 3; c++)
            corners[c] = rigid.StartOf(mesh, mesh.shape->getIndices()[3 * triangle + c]);
        point = corners[0];
        normal = (corners[1] - point).cross(corners[2] - point);
        const btScalar length = normal.length();
        normal = length > 0 ? normal / length : btVector3(0, 0, 0);
    }

    btScalar HeightOf(const btVector3& position) const
    {
        return normal.dot(position - point);
    }

    btScalar RoundingOf(const btVector3& position) const
    {
        return s_rounding * normal.absolute().dot(position.absolute() + point.absolute());
    }
};

/// Lifts the corners of a soft triangle that are in the plane and can move, if none is below it.
bool Lift(const Plane& plane, btScalar distance, uint32_t triangle, qcSceneSoftBody* soft)
{
    const uint32_t* corners = &soft->topology.indices[3 * size_t(triangle)];
    auto isBelow = [&](uint32_t corner)
    { return plane.HeightOf(soft->start[corner]) < -plane.RoundingOf(soft->start[corner]); };
    if (std::any_of(corners, corners + 3, isBelow))
        return false;
    bool any = false;
    for (int c = 0; c < 3; c++)
    {
        btVector3& position = soft->start[corners[c]];
        const btScalar rounding = plane.RoundingOf(position), height = plane.HeightOf(position);
        if (height > rounding || soft->InverseMass(corners[c]) <= 0)
            continue;
        position += plane.normal * (std::max(2 * rounding, s_height * distance) - height);
        any = true;
    }
    return any;
}
} // namespace

btScalar qcLyingDistance(qcSoftBodyScene& scene)
{
    btScalar largest = 0;
    for (const qcSceneSoftBody& soft : scene.Bodies())
        if (soft.startsElsewhere)
            for (const btVector3& position : soft.start)
                largest = std::max(largest, position.absolute()[position.absolute().maxAxis()]);
    return 8 * s_rounding * largest;
}

bool qcLiftStarts(qcSoftBodyScene& scene, const qcResult& result)
{
    bool any = false;
    for (size_t i = 0; i < result.pairCount; i++)
    {
        const qcPair& pair = result.pairs[i];
        qcSceneSoftBody *a = scene.Find(pair.bodyA), *b = scene.Find(pair.bodyB);
        qcSceneSoftBody* soft = a != nullptr ? a : b;
        if ((a != nullptr && b != nullptr) || !soft->startsElsewhere || !qcHasResponse(scene, pair))
            continue;
        qcSceneRigid* rigid = nullptr;
        const qcSceneMesh& mesh = *scene.meshes.Find(a != nullptr ? pair.bodyB : pair.bodyA, &rigid);
        const Plane plane(*rigid, mesh, a != nullptr ? pair.triangleB : pair.triangleA);
        const uint32_t triangle = a != nullptr ? pair.triangleA : pair.triangleB;
        any = Lift(plane, mesh.ContactDistance(soft->thickness), triangle, soft) || any;
    }
    return any;
}
