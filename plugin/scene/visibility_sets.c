// Set transitions of section 4.1, and CULLIDE's in the same terms.
#include "scene/visibility_sets.h"

bool qcVisibilitySet_IsTested(qcVisibilitySet set, int pass, bool quick)
{
    if (set == qc_setBfv)
        return false;
    if (!quick)
        return true;
    return set == qc_setNfv || set == (pass == 1 ? qc_setSfv : qc_setFfv);
}

bool qcVisibilitySet_IsRendered(qcVisibilitySet set, int pass, bool quick)
{
    if (set == qc_setBfv)
        return false;
    if (!quick)
        return true;
    return set == qc_setNfv || set == (pass == 1 ? qc_setFfv : qc_setSfv);
}

qcVisibilitySet qcVisibilitySet_After(qcVisibilitySet set, int pass, bool fullyVisible)
{
    if (!fullyVisible)
        return set;
    qcVisibilitySet other = pass == 1 ? qc_setSfv : qc_setFfv; // fully visible in the other pass
    if (set == other)
        return qc_setBfv;
    return pass == 1 ? qc_setFfv : qc_setSfv;
}

qcVisibilitySet qcVisibilitySet_NextView(qcVisibilitySet set, bool quick)
{
    return quick || set == qc_setBfv ? set : qc_setNfv;
}
