// Colours of debug drawing, and candidates.
#ifndef QC_GLUE_COMMON_DEBUG_DRAW_H
#define QC_GLUE_COMMON_DEBUG_DRAW_H

#include <LinearMath/btIDebugDraw.h>

inline btVector3 qcCandidateColor()
{
    return btVector3(1, 0, 0);
}

inline btVector3 qcCandidatePairColor()
{
    return btVector3(1, btScalar(0.55), 0);
}

inline btVector3 qcManifoldColor()
{
    return btVector3(0, btScalar(0.8), 1);
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

/// Draws a line between the centroids of two triangles.
inline void qcDrawCandidatePair(btIDebugDraw* drawer, const btVector3 a[3], const btVector3 b[3])
{
    drawer->drawLine((a[0] + a[1] + a[2]) / 3, (b[0] + b[1] + b[2]) / 3, qcCandidatePairColor());
}

#endif
