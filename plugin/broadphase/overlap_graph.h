// The overlap graph: an edge for each pair of boxes whose enlarged AABBs overlap. An edge is in the list of each of its
// two boxes, like a contact in Box2D (Catto). Adding or removing an edge is O(1), removing all of a box O(its edges).
#ifndef QC_BROADPHASE_OVERLAP_GRAPH_H
#define QC_BROADPHASE_OVERLAP_GRAPH_H

#include "base/memory.h"

#define QC_NO_EDGE UINT32_MAX

/// A bit of qcEdge.box[0] for the caller's use; the graph preserves it.
#define QC_EDGE_MARK 0x80000000u

typedef struct qcEdge
{
    uint32_t box[2]; ///< a free edge: box[1] is QC_NO_EDGE. Numbers of boxes are below QC_EDGE_MARK.
} qcEdge;

/// End 2 i + j links edge i into the list of its box j.
typedef struct qcEdgeEnd
{
    uint32_t next, previous; ///< ends in the list of the same box, or QC_NO_EDGE; a free edge: the next free one
} qcEdgeEnd;

/// All zero is not an empty graph: call qcOverlapGraph_Clear first.
typedef struct qcOverlapGraph
{
    qcArray edges; ///< qcEdge
    qcArray ends;  ///< qcEdgeEnd
    qcArray first; ///< uint32_t, an end or QC_NO_EDGE, by box
    uint32_t firstFree;
} qcOverlapGraph;

/// Makes room for boxes with ids below `boxCount`; new boxes have no edges.
qcStatus qcOverlapGraph_Reserve(qcOverlapGraph* graph, size_t boxCount);
/// Removes all boxes and edges.
void qcOverlapGraph_Clear(qcOverlapGraph* graph);
/// Removes all edges.
void qcOverlapGraph_RemoveAllEdges(qcOverlapGraph* graph);
void qcOverlapGraph_Free(qcOverlapGraph* graph);

/// Adds an edge between two boxes without one, with or without QC_EDGE_MARK. qc_statusOutOfMemory leaves the graph
/// unchanged.
qcStatus qcOverlapGraph_AddEdge(qcOverlapGraph* graph, uint32_t a, uint32_t b, bool mark);
/// Removes one edge.
void qcOverlapGraph_RemoveEdge(qcOverlapGraph* graph, uint32_t edge);
/// Removes all edges of a box.
void qcOverlapGraph_RemoveEdgesOf(qcOverlapGraph* graph, uint32_t box);

static inline qcEdge* qcOverlapGraph_Edge(const qcOverlapGraph* graph, uint32_t edge)
{
    return &QC_AT(qcEdge, graph->edges, edge);
}

/// The box at the other end.
static inline uint32_t qcOverlapGraph_Other(const qcOverlapGraph* graph, uint32_t end)
{
    return qcOverlapGraph_Edge(graph, end / 2)->box[1 - end % 2] & ~QC_EDGE_MARK;
}

/// The first end of a box's list, and the end after a given one. QC_NO_EDGE: there is none.
static inline uint32_t qcOverlapGraph_FirstEnd(const qcOverlapGraph* graph, uint32_t box)
{
    return QC_AT(uint32_t, graph->first, box);
}

static inline uint32_t qcOverlapGraph_NextEnd(const qcOverlapGraph* graph, uint32_t end)
{
    return QC_AT(qcEdgeEnd, graph->ends, end).next;
}

#endif
