// Colours of debug drawing, and candidate triangles.
#ifndef QC_GLUE_COMMON_DEBUG_DRAW_H
#define QC_GLUE_COMMON_DEBUG_DRAW_H

#include <LinearMath/btIDebugDraw.h>

inline btVector3 qcCandidateColor()
{
    return btVector3(1, 0, 0);
}

inline btVector3 qcPlaneColor()
{
    return btVector3(1, 1, 0);
}

inline btVector3 qcZoneColor()
{
    return btVector3(1, 0, 1);
}

inline void qcDrawCandidate(btIDebugDraw* drawer, const btVector3& a, const btVector3& b, const btVector3& c)
{
    drawer->drawTriangle(a, b, c, qcCandidateColor(), 1);
}

#endif
