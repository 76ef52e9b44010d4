// Voronoi cells of sites, and a mesh dealt out to them.
#ifndef QC_GLUE_FRACTURE_VORONOI_CELLS_H
#define QC_GLUE_FRACTURE_VORONOI_CELLS_H

#include "fracture/plane_clip.h"
#include "fracture/scratch.h"

#include <functional>

struct qcFractureCell
{
    std::vector<uint32_t> neighbours; ///< sites of the cells beside it, nearest first
    qcClipPoint lower, upper;         ///< the box of it within a box that holds the mesh, with room around it
};

/// The cells of sites in and around the vertices of a mesh that is 1 to 2 long. None if the sites are too close to each
/// other or too far from the mesh for voro++.
std::vector<qcFractureCell> qcFindFractureCells(const std::vector<qcClipPoint>& mesh,
                                                const std::vector<qcClipPoint>& sites);

/// Calls the function with each cell and what the solid is in its box, in parallel. The rest of the solid is mostly
/// cut off, by faces that are outside of the cell and have numbers from `firstFace` on.
void qcDealSolid(qcClipSolid solid, const std::vector<qcFractureCell>& cells, uint32_t firstFace,
                 const std::function<void(size_t cell, qcClipSolid solid, qcClipScratch* scratch)>& take);

#endif
