// Voronoi cells of sites, and the distribution of a solid to them.
#ifndef QC_GLUE_FRACTURE_VORONOI_CELLS_H
#define QC_GLUE_FRACTURE_VORONOI_CELLS_H

#include "fracture/plane_clip.h"
#include "fracture/scratch.h"

#include <functional>

struct qcFractureCell
{
    std::vector<uint32_t> neighbours; ///< sites of the adjacent cells, nearest first
    qcClipPoint lower, upper;         ///< AABB of the cell within an enlarged AABB of mesh and sites, itself enlarged
};

/// The cells of sites around the vertices of a mesh that is 1 to 2 long. Empty if the sites are too close to each other
/// or too far from the mesh for voro++.
std::vector<qcFractureCell> qcFindFractureCells(const std::vector<qcClipPoint>& mesh,
                                                const std::vector<qcClipPoint>& sites);

/// Calls the function with each cell and a part of the solid that contains what is in the cell's box, in parallel. Most
/// of the rest of the solid is clipped off; cut faces outside the cell have numbers from `firstFace` on.
void qcDistributeSolid(qcClipSolid solid, const std::vector<qcFractureCell>& cells, uint32_t firstFace,
                       const std::function<void(size_t cell, const qcClipSolid& solid, qcClipScratch* scratch)>& take);

#endif
