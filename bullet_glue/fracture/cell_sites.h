// Sites of a fracture in the units of its mesh, and the planes between them.
#ifndef QC_GLUE_FRACTURE_CELL_SITES_H
#define QC_GLUE_FRACTURE_CELL_SITES_H

#include "fracture/plane_clip.h"
#include "fracture/unit_scale.h"

/// The sites whose cells may overlap the mesh.
struct qcFractureSites
{
    std::vector<uint32_t> numbers;   ///< in the definition
    std::vector<qcClipPoint> scaled; ///< exact
    std::vector<qcClipPoint> local;  ///< rounded
    qcClipPoint origin = {0, 0, 0};  ///< of the local positions
};

/// Finds them; the mesh is in local positions. Returns why the mesh can't be divided among them, or an empty text.
std::string qcFractureSites_Find(const qcFractureDef& def, const qcFractureUnits& units, const qcClipMesh& mesh,
                                 qcFractureSites* sites);

/// The plane between the cells of two sites, in local positions; the second cell is outside. With the sites exchanged
/// it has the same numbers with other signs. Rounded as if computed exactly, however far away the sites are.
qcClipPlane qcFractureSites_Bisect(const qcFractureSites& sites, uint32_t site, uint32_t other, uint32_t face);

/// Cuts a solid down to the cell of a site, without a list of its neighbours: by the nearest sites until the others are
/// too far away to matter. Their faces are numbered from `firstFace` on. About O(sites + neighbours * edges).
void qcFractureSites_CutCell(const qcFractureSites& sites, uint32_t site, uint32_t firstFace, qcClipSolid* solid,
                             qcClipScratch* scratch);

#endif
