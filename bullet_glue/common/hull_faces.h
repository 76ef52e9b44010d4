// Convex hulls of points on a shape's surface, as faces and triangles.
#ifndef QC_GLUE_COMMON_HULL_FACES_H
#define QC_GLUE_COMMON_HULL_FACES_H

#include <LinearMath/btConvexHullComputer.h>

#include <cstdint>
#include <vector>

/// The outermost points of a convex shape, support(direction), along the axes and all diagonals of a cube.
template <typename Support> std::vector<btVector3> qcOutermostPoints(const Support& support)
{
    std::vector<btVector3> points;
    for (int i = 0; i < 27; i++)
        if (i != 13)
            points.push_back(
                support(btVector3(btScalar(i % 3 - 1), btScalar(i / 3 % 3 - 1), btScalar(i / 9 - 1)).normalized()));
    return points;
}

/// The corners of a hull's face, counter-clockwise as seen from outside: indices into its `vertices`.
inline std::vector<uint32_t> qcCornersOfFace(const btConvexHullComputer& hull, int face)
{
    std::vector<uint32_t> corners;
    const btConvexHullComputer::Edge *first = &hull.edges[hull.faces[face]], *edge = first;
    do
    {
        corners.push_back(uint32_t(edge->getSourceVertex()));
        edge = edge->getNextEdgeOfFace();
    } while (edge != first);
    return corners;
}

/// Appends the triangles of a face, three indices each.
inline void qcAddTriangles(const std::vector<uint32_t>& corners, std::vector<uint32_t>* indices)
{
    for (size_t i = 1; i + 1 < corners.size(); i++)
        indices->insert(indices->end(), {corners[0], corners[i], corners[i + 1]});
}

#endif
