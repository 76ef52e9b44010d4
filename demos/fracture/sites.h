// Voronoi sites for a body that breaks.
#ifndef QC_DEMOS_FRACTURE_SITES_H
#define QC_DEMOS_FRACTURE_SITES_H

#include "quickcullide/bullet_mesh.h"

#include <vector>

/// Sites inside a closed mesh, so that each site has at least one piece; a third of them near the impact. They depend
/// on the seed alone.
std::vector<btVector3> qcScatterSitesInside(const qcMeshShape& shape, uint32_t count, uint64_t seed,
                                            const btVector3& impact);

#endif
