// The limit of pairs.
#include "base/related_pair.h"

#include "base/status.h"

qcStatus qcRelatedPair_CheckCount(uint64_t count, uint64_t maxPairs)
{
    if (count <= maxPairs)
        return qc_statusOk;
    return qcFail(qc_statusTooManyPairs, "qcScene_Detect: more than %llu pairs of triangles (qcDetectDef::maxPairs)",
                  (unsigned long long)maxPairs);
}
