// Which boxes are near which: a graph whose edges hang in a list at each of their two boxes, as contacts do in Box2D
// (Catto). Adding or removing an edge is O(1), leaving all neighbours O(neighbours).
#ifndef QC_BROADPHASE_OVERLAP_GRAPH_H
#define QC_BROADPHASE_OVERLAP_GRAPH_H

#include "base/memory.h"

#define QC_NO_EDGE UINT32_MAX

/// A bit of qcEdge.box[0] that the graph keeps for others.
#define QC_EDGE_MARK 0x80000000u

typedef struct qcEdge
{
    uint32_t box[2]; ///< a free edge: box[1] is QC_NO_EDGE. Numbers of boxes are below QC_EDGE_MARK.
} qcEdge;

/// End 2 i + j is where edge i hangs at its box j.
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

/// Makes room for boxes with ids below `boxCount`; new ones have no neighbours.
qcStatus qcOverlapGraph_Reserve(qcOverlapGraph* graph, size_t boxCount);
/// No boxes.
void qcOverlapGraph_Clear(qcOverlapGraph* graph);
/// No edges.
void qcOverlapGraph_PartAll(qcOverlapGraph* graph);
void qcOverlapGraph_Free(qcOverlapGraph* graph);

/// Adds an edge between two boxes that have none, with or without a mark. qc_statusOutOfMemory leaves the graph as it
/// was.
qcStatus qcOverlapGraph_Join(qcOverlapGraph* graph, uint32_t a, uint32_t b, bool mark);
/// Removes one edge.
void qcOverlapGraph_Cut(qcOverlapGraph* graph, uint32_t edge);
/// Removes all edges of a box.
void qcOverlapGraph_Part(qcOverlapGraph* graph, uint32_t box);

static inline qcEdge* qcOverlapGraph_Edge(const qcOverlapGraph* graph, uint32_t edge)
{
    return &QC_AT(qcEdge, graph->edges, edge);
}

/// The box at the other end.
static inline uint32_t qcOverlapGraph_Other(const qcOverlapGraph* graph, uint32_t end)
{
    return qcOverlapGraph_Edge(graph, end / 2)->box[1 - end % 2] & ~QC_EDGE_MARK;
}

/// The first end at a box, then the next one after an end; QC_NO_EDGE: there is none.
static inline uint32_t qcOverlapGraph_First(const qcOverlapGraph* graph, uint32_t box)
{
    return QC_AT(uint32_t, graph->first, box);
}

static inline uint32_t qcOverlapGraph_Next(const qcOverlapGraph* graph, uint32_t end)
{
    return QC_AT(qcEdgeEnd, graph->ends, end).next;
}

#endif
