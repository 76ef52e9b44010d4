// Memory that cuts keep from one to the next: each takes some dozen small arrays.
#ifndef QC_BULLET_GLUE_FRACTURE_SCRATCH_H
#define QC_BULLET_GLUE_FRACTURE_SCRATCH_H

#include "fracture_clip.h"
#include "fracture_edges.h"

/// A corner of an outline, as seen along an axis.
struct qcClipCorner
{
    double u, v;
    uint32_t point, place; ///< which of the mesh, and which of the outline
    uint32_t obstacle;     ///< the place of a corner that, while it is left, keeps this one from being an ear
    bool isLeft;
};

/// For one thread at a time; what is in it between two calls does not matter.
struct qcClipScratch
{
    qcClipEdges edges;
    qcClipLoops loops;
    qcClipTable<uint64_t, uint32_t> crossings;    ///< points by edge
    qcClipTable<qcClipPoint, uint32_t> positions; ///< points by position
    std::vector<double> sides;
    std::vector<uint8_t> marks;                 ///< of points
    std::vector<std::array<uint32_t, 2>> faces; ///< of points
    std::vector<uint32_t> places;               ///< of points
    std::vector<qcClipPoint> points;
    std::vector<qcClipTriangle> triangles;
    qcClipMesh made;
    std::vector<qcClipCorner> corners, inward;
    std::vector<uint32_t> left;
};

#endif
