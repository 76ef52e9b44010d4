// Triangle meshes in double precision with numbered faces: the input and the output of clipping.
#ifndef QC_GLUE_FRACTURE_FACETED_MESH_H
#define QC_GLUE_FRACTURE_FACETED_MESH_H

#include "common/double_vector.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

using qcClipPoint = qcDoubleVector;

struct qcClipTriangle
{
    std::array<uint32_t, 3> corner;
    uint32_t face; ///< triangles of one face lie in one plane
};

struct qcFacetedMesh
{
    std::vector<qcClipPoint> points;
    std::vector<qcClipTriangle> triangles;
};

/// The axis along which the items have the largest extent; `coordinate`: of an item along an axis.
template <typename Item, typename Coordinate>
size_t qcLongestAxis(const std::vector<Item>& items, const Coordinate& coordinate)
{
    size_t longest = 0;
    double maxLength = -1;
    for (size_t axis = 0; axis < 3; axis++)
    {
        auto isLower = [&](const Item& a, const Item& b) { return coordinate(a, axis) < coordinate(b, axis); };
        auto ends = std::minmax_element(items.begin(), items.end(), isLower);
        double length = coordinate(*ends.second, axis) - coordinate(*ends.first, axis);
        if (length > maxLength)
        {
            maxLength = length;
            longest = axis;
        }
    }
    return longest;
}

/// fracture/scratch.h
struct qcClipScratch;

/// Merges points at the same position. `newIndices` receives the index of each point among the remaining ones.
void qcWeldPoints(std::vector<qcClipPoint>* points, std::vector<uint32_t>* newIndices, qcClipScratch* scratch);

/// Merges vertices at the same position, and drops triangles that then have a vertex twice.
void qcFacetedMesh_Weld(qcFacetedMesh* mesh, qcClipScratch* scratch);

/// Returns the volume; `first` receives the integral of positions over it.
double qcFacetedMesh_Measure(const qcFacetedMesh& mesh, qcClipPoint* first);

/// The components of a closed mesh, each with its own vertices. Parts that touch in edges or vertices only are
/// components of their own if at least two of them hold more than `minVolume`. A hollow or a sheet stays with the part
/// that it touches if that is the only one. `mayTouchItself`: false if there are no such parts. In the order of their
/// first triangles (fracture/components.cpp).
std::vector<qcFacetedMesh> qcFacetedMesh_FindComponents(const qcFacetedMesh& mesh, bool mayTouchItself,
                                                        double minVolume, qcClipScratch* scratch);

/// True if more than two triangles share an edge of a closed mesh, or those at a vertex don't follow each other around
/// it in a single turn.
bool qcFacetedMesh_TouchesItself(const qcFacetedMesh& mesh);

#endif
