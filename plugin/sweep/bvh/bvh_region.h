// The region that a limited BVH covers: that in which other bodies may come near. Triangles outside are left out until
// a body comes near them, or its own motion may bring them into the region. Proof that no pair is lost:
// plugin/docs/proofs/bvh_region.md.
#ifndef QC_SWEEP_BVH_BVH_REGION_H
#define QC_SWEEP_BVH_BVH_REGION_H

#include "mesh/region_cells.h"
#include "scene/bodies.h"

typedef struct qcBvhRegion
{
    qcRegionCells cells;
    qcArray reference;   ///< float, three a vertex: positions when the BVH was built
    double rounding;     ///< max error of a coordinate of the reference
    uint64_t revision;   ///< qcBody::moved of the positions that `displacement` belongs to
    double displacement; ///< max change of a coordinate since the BVH was built
} qcBvhRegion;

/// For a new BVH of a deforming body: no cell is marked. False: there is no region around the body.
bool qcBvhRegion_Begin(qcBvhRegion* region, const qcBody* body);
/// Another body may come near, in its present place or about a cell away: marks cells.
void qcBvhRegion_Include(qcBvhRegion* region, const qcBody* other, double queryDistance);
/// Stores the positions of the body, which are those of the BVH. O(vertices).
qcStatus qcBvhRegion_SetReference(qcBvhRegion* region, const qcBody* body);

/// Brings `displacement` up to date. O(vertices) if the body has moved.
void qcBvhRegion_Follow(qcBvhRegion* region, const qcBody* body);
/// True: at present no triangle that was left out is within the query distance of the other body. `Follow` comes first.
bool qcBvhRegion_Covers(const qcBvhRegion* region, const qcBody* other, double queryDistance);

/// Null is allowed.
void qcBvhRegion_Delete(qcBvhRegion* region);

#endif
