// The four visibility sets, and lemmas 2 to 5. Govindaraju, Lin, Manocha: Quick-CULLIDE, VR 2005, section 4.1.
#ifndef QC_SCENE_VISIBILITY_SETS_H
#define QC_SCENE_VISIBILITY_SETS_H

#include "quickcullide/scene.h"

/// Whether a primitive of this set is tested in this pass (1 or 2). Quick: lemma 3 spares FFV the first pass, lemma 4
/// SFV the second. CULLIDE: all but BFV.
bool qcVisibilitySet_IsTested(qcVisibilitySet set, int pass, bool quick);

/// Whether a primitive of this set is rendered in this pass. Quick: lemma 5 spares SFV the first pass and FFV the
/// second. CULLIDE: all but BFV.
bool qcVisibilitySet_IsRendered(qcVisibilitySet set, int pass, bool quick);

/// The set of a primitive after a test in this pass.
qcVisibilitySet qcVisibilitySet_After(qcVisibilitySet set, int pass, bool fullyVisible);

/// The set of a primitive at the beginning of the next view. CULLIDE resets FFV and SFV.
qcVisibilitySet qcVisibilitySet_NextView(qcVisibilitySet set, bool quick);

/// Whether two primitives of these sets may collide: neither is pruned, and they aren't in one collision-free set.
static inline bool qcVisibilitySet_MayCollide(unsigned a, unsigned b)
{
    return a != qc_setBfv && b != qc_setBfv && (a != b || a == qc_setNfv);
}

#endif
