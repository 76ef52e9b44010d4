// The pairs of objects whose motions in a step may meet.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_PAIRS_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_PAIRS_H

#include "mesh_contact/limits/swept_object.h"

/// Finds the pairs whose boxes overlap and that collide; at least one of the two moves, and one is not isUnmoved. Marks
/// their objects as paired. The order of pairs is not determined. O(n log n) and what qcSweepBoxes visits.
void qcFindSweptPairs(btCollisionWorld* world, const std::vector<qcSweptObject*>& objects,
                      std::vector<qcSweptPair>* pairs);

#endif
