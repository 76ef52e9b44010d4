// What two triangles have in common, seen along a direction. (Where its corners are: manifold/overlap_kernels.inl.h.)
#include "manifold/overlap_kernels.h"

#include <math.h>

bool qcManifoldPair_CoversArea(const qcManifoldPair* pair, const qcRawPoint* corners, int count)
{
    qcVector longest = {0.0, 0.0, 0.0};
    for (int i = 1; i < count; i++)
    {
        qcVector d = qcMinus(corners[i].end[0], corners[0].end[0]);
        longest = qcDot(d, d) > qcDot(longest, longest) ? d : longest;
    }
    double width = QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair), length2 = qcDot(longest, longest);
    for (int i = 1; i < count; i++)
    {
        qcVector across = qcCross(longest, qcMinus(corners[i].end[0], corners[0].end[0]));
        if (qcDot(across, across) > width * width * length2)
            return true;
    }
    return false;
}

int qcManifoldBuilder_FindCommonPart(const qcManifoldBuilder* m, const qcManifoldPair* pair, qcVector normal,
                                     qcRawPoint corners[qc_maxCommonCorners])
{
    qcTriangleView views[2];
    for (int side = 0; side < 2; side++)
        qcTriangleView_Begin(&views[side], pair->side[side]);
    return m->sight->findCommonPart(pair, normal, (qcTriangleView* [2]){&views[0], &views[1]}, corners);
}
