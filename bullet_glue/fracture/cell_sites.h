// Sites of a fracture in the units of its mesh, and the bisectors between them.
#ifndef QC_GLUE_FRACTURE_CELL_SITES_H
#define QC_GLUE_FRACTURE_CELL_SITES_H

#include "fracture/plane_clip.h"
#include "fracture/unit_scale.h"

#include <optional>
#include <utility>

/// The sites whose cells may overlap the mesh.
struct qcFractureSites
{
    std::vector<uint32_t> numbers;   ///< index in the definition
    std::vector<qcClipPoint> scaled; ///< exact
    std::vector<qcClipPoint> local;  ///< rounded
    qcClipPoint origin = {0, 0, 0};  ///< of the local positions
};

/// Finds the sites for a mesh in local positions. Returns the reason why the mesh can't be divided, or an empty text.
std::string qcFractureSites_Find(const qcFractureDef& def, const qcFractureUnits& units, const qcFacetedMesh& mesh,
                                 qcFractureSites* sites);

/// The indices of two equal points, the lower one first; none: all are different. O(points * log(points)).
std::optional<std::pair<size_t, size_t>> qcFindEqual(const std::vector<qcClipPoint>& points);

/// The bisector of two sites in local positions; the second site is outside. Exchanging the sites exactly negates the
/// numbers. Its numbers are off by a few units in the last place, however far away the sites are.
qcClipPlane qcFractureSites_Bisect(const qcFractureSites& sites, uint32_t site, uint32_t other, uint32_t face);

/// Clips a solid to the cell of a site without a list of its neighbours: by the nearest sites, until the next one is
/// too far away to matter. Cut faces have the numbers `firstFace` + other site. About O(sites + neighbours * edges).
void qcFractureSites_ClipCell(const qcFractureSites& sites, uint32_t site, uint32_t firstFace,
                              const qcRoundedFaces* rounded, qcClipSolid* solid, qcClipScratch* scratch);

#endif
