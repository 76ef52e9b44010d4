// Sites inside a mesh.
#include "fracture/sites.h"

#include "common/bullet/points_inside.h"
#include "quickcullide/bullet_fracture.h"

std::vector<btVector3> qcScatterSitesInside(const qcMeshShape& shape, uint32_t count, uint64_t seed,
                                            const btVector3& impact)
{
    btVector3 lower, upper;
    shape.getAabb(btTransform::getIdentity(), lower, upper);
    // Most bodies fill at least a sixteenth of their box; others get fewer sites.
    uint32_t candidates = 16 * count;
    std::vector<btVector3> sites =
        qcPointsInside(shape, qcScatterSites(lower, upper, candidates, seed, &impact), count / 3);
    std::vector<btVector3> spread =
        qcPointsInside(shape, qcScatterSites(lower, upper, candidates, ~seed), count - sites.size());
    sites.insert(sites.end(), spread.begin(), spread.end());
    return sites;
}
