// Memory that cuts keep from one to the next: each takes some dozen small arrays.
#ifndef QC_GLUE_FRACTURE_SCRATCH_H
#define QC_GLUE_FRACTURE_SCRATCH_H

#include "common/union_find.h"
#include "fracture/open_edges.h"
#include "fracture/clip_mesh.h"

/// Where a face leaves the inside of a plane, and where it comes back: the first such points.
struct qcClipSeam
{
    uint32_t face, leave, enter;
};

/// A further such point.
struct qcClipEnd
{
    uint32_t face, point;
    bool leaves;
};

/// Edges of a face, up to an end.
struct qcClipFaceEdges
{
    uint32_t face;
    size_t end;
};

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
    qcHashTable<qcClipPoint, uint32_t> positions; ///< points by position
    std::vector<uint32_t> places;                 ///< of points
    //  Cuts.
    std::vector<double> sides;
    std::vector<qcClipPoint> points;
    std::vector<qcClipSeam> seams;
    std::vector<uint32_t> seamOf; ///< faces
    std::vector<qcClipEnd> ends;
    //  Faces.
    std::vector<qcClipFaceEdges> faces;
    std::vector<qcClipArrow> arrows;
    std::vector<uint32_t> arrowOf; ///< points
    std::vector<uint32_t> edgesOf; ///< points: how many there are
    qcClipEdges edges;
    qcClipLoops loops, openLoops;
    std::vector<qcClipCorner> corners, inward;
    std::vector<uint32_t> left;
    //  Parts.
    qcUnionFind islands;         ///< of points
    std::vector<uint32_t> parts; ///< of points
};

#endif
