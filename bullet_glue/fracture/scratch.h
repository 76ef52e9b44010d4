// Memory that clipping keeps from one cut to the next: each cut needs some dozen small arrays.
#ifndef QC_GLUE_FRACTURE_SCRATCH_H
#define QC_GLUE_FRACTURE_SCRATCH_H

#include "common/union_find.h"
#include "fracture/faceted_mesh.h"
#include "fracture/open_edges.h"

/// An edge that a plane crosses: its ends in the solid that is cut, and its index in the one that is made.
struct qcCrossedEdge
{
    uint32_t from, to;
    size_t kept;
};

/// The edge that closes a face cut by a plane: the points where the face first leaves and first enters the inside.
struct qcCutEdge
{
    uint32_t face, leave, enter;
};

/// A point where a face leaves or enters the inside.
struct qcCutPoint
{
    uint32_t face, point;
    bool leaves;
};

/// The half-edges of a face: up to `end`, from the end of the previous face.
struct qcFaceEdges
{
    uint32_t face;
    size_t end;
};

/// A corner of an outline, projected along an axis.
struct qcOutlineCorner
{
    double u, v;
    uint32_t point;    ///< index in the mesh
    uint32_t index;    ///< in the outline
    uint32_t obstacle; ///< index of a corner that, while it remains, keeps this one from being an ear
    bool remains;
};

/// For one thread at a time. Its contents between two calls don't matter.
struct qcClipScratch
{
    qcHashTable<qcClipPoint, uint32_t> positions; ///< points by position
    std::vector<uint32_t> newIndices;             ///< by point
    //  Cuts.
    std::vector<double> sides;
    std::vector<qcClipPoint> points;         ///< that the plane makes
    std::vector<qcCrossedEdge> crossedEdges; ///< the first crossedCount
    size_t crossedCount = 0;
    std::vector<qcCutEdge> cutEdges;
    std::vector<uint32_t> cutEdgeOf; ///< by face
    std::vector<qcCutPoint> extraPoints, cutsInPlane;
    //  Faces.
    std::vector<qcFaceEdges> faces;
    std::vector<uint32_t> faceIndex; ///< by face, in `faces`
    std::vector<qcHalfEdge> halfEdges;
    std::vector<uint32_t> halfEdgeFrom; ///< by point
    std::vector<uint32_t> edgeCount;    ///< by point
    qcEdgeCounts edges;
    qcClipLoops loops, openLoops;
    std::vector<qcOutlineCorner> corners, inward;
    std::vector<uint32_t> remaining;
    //  Components of a mesh.
    qcUnionFind components;          ///< of points, or of triangles
    std::vector<uint32_t> component; ///< by representative point or triangle
};

#endif
