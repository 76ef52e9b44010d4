// Sites inside a mesh: a ray upwards crosses its surface an odd number of times.
#include "fracture/sites.h"

#include "quickcullide/bullet_fracture.h"

namespace
{
/// Counts the triangles above a point.
struct CountAbove : btTriangleCallback
{
    explicit CountAbove(const btVector3& point) : point(point)
    {
    }

    /// Twice the signed area of an edge and the point, as seen from above.
    btScalar Side(const btVector3& a, const btVector3& b) const
    {
        return (b.x() - a.x()) * (point.z() - a.z()) - (b.z() - a.z()) * (point.x() - a.x());
    }

    void processTriangle(btVector3* triangle, int, int) override
    {
        btScalar u = Side(triangle[1], triangle[2]), v = Side(triangle[2], triangle[0]),
                 w = Side(triangle[0], triangle[1]), area = u + v + w;
        if ((u < 0) != (v < 0) || (v < 0) != (w < 0) || area == 0)
            return;
        count += (u * triangle[0].y() + v * triangle[1].y() + w * triangle[2].y()) / area > point.y();
    }

    btVector3 point;
    int count = 0;
};

bool IsInside(const qcMeshShape& shape, const btVector3& point, btScalar top)
{
    CountAbove above(point);
    shape.processAllTriangles(&above, point, btVector3(point.x(), top, point.z()));
    return above.count % 2 == 1;
}

/// Adds those of the candidates that are inside until there are `count`.
void TakeInside(const qcMeshShape& shape, const std::vector<btVector3>& candidates, btScalar top, size_t count,
                std::vector<btVector3>* sites)
{
    for (const btVector3& candidate : candidates)
        if (sites->size() < count && IsInside(shape, candidate, top))
            sites->push_back(candidate);
}
} // namespace

std::vector<btVector3> qcScatterSitesInside(const qcMeshShape& shape, uint32_t count, uint64_t seed,
                                            const btVector3& impact)
{
    btVector3 lower, upper;
    shape.getAabb(btTransform::getIdentity(), lower, upper);
    std::vector<btVector3> sites;
    // Most bodies fill at least a sixteenth of their box; others get fewer sites.
    uint32_t candidates = 16 * count;
    TakeInside(shape, qcScatterSites(lower, upper, candidates, seed, &impact), upper.y(), count / 3, &sites);
    TakeInside(shape, qcScatterSites(lower, upper, candidates, ~seed), upper.y(), count, &sites);
    return sites;
}
