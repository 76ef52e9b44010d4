// The cluster order of any number of triangles, by their centroids: halved at the median until few are left.
#ifndef QC_MESH_MEDIAN_SPLIT_H
#define QC_MESH_MEDIAN_SPLIT_H

#include "mesh/small_order.h"

/// Lists the triangles of `count` centroids by nodes and clusters, in O(count log count). The centroids are permuted;
/// `scratch` has room for as many. The order does not depend on the number of threads.
void qcMedianSplit_Run(qcCentroid* centroids, qcCentroid* scratch, uint32_t count, uint32_t threads,
                       uint32_t* triangles);

#endif
