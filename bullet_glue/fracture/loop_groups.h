// Groups of loops that are apart from each other.
#ifndef QC_GLUE_FRACTURE_LOOP_GROUPS_H
#define QC_GLUE_FRACTURE_LOOP_GROUPS_H

#include "fracture/faceted_mesh.h"
#include "fracture/open_edges.h"

/// Groups of loops whose boxes don't meet, in the order of their first loops. A tesselator's time may be quadratic in
/// the number of edges that a line crosses, which is less in each group. O(loops * log(loops)) where few boxes overlap
/// along the longest axis.
std::vector<qcClipLoops> qcGroupLoops(const std::vector<qcClipPoint>& points, const qcClipLoops& loops);

#endif
