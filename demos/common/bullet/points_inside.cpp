// A ray upwards from a point inside crosses the surface an odd number of times.
#include "common/bullet/points_inside.h"

namespace
{
/// Counts the triangles above a point.
struct CountAbove : btTriangleCallback
{
    explicit CountAbove(const btVector3& below) : point(below)
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
} // namespace

std::vector<btVector3> qcPointsInside(const qcMeshShape& shape, const std::vector<btVector3>& candidates,
                                      size_t maxCount)
{
    btVector3 lower, upper;
    shape.getAabb(btTransform::getIdentity(), lower, upper);
    std::vector<btVector3> inside;
    for (const btVector3& candidate : candidates)
        if (inside.size() < maxCount && IsInside(shape, candidate, upper.y()))
            inside.push_back(candidate);
    return inside;
}
