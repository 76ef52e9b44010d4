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

/// All zero is not an empty graph: call qcNeighbours_Clear first.
typedef struct qcNeighbours
{
    qcArray edges; ///< qcEdge
    qcArray ends;  ///< qcEdgeEnd
    qcArray first; ///< uint32_t, an end or QC_NO_EDGE, by box
    uint32_t firstFree;
} qcNeighbours;

/// Makes room for boxes with ids below `boxCount`; new ones have no neighbours.
qcStatus qcNeighbours_Reserve(qcNeighbours* graph, size_t boxCount);
/// No boxes.
void qcNeighbours_Clear(qcNeighbours* graph);
/// No edges.
void qcNeighbours_PartAll(qcNeighbours* graph);
void qcNeighbours_Free(qcNeighbours* graph);

/// Adds an edge between two boxes that have none, with or without a mark. qc_statusOutOfMemory leaves the graph as it
/// was.
qcStatus qcNeighbours_Join(qcNeighbours* graph, uint32_t a, uint32_t b, bool mark);
/// Removes one edge.
void qcNeighbours_Cut(qcNeighbours* graph, uint32_t edge);
/// Removes all edges of a box.
void qcNeighbours_Part(qcNeighbours* graph, uint32_t box);

static inline qcEdge* qcNeighbours_Edge(const qcNeighbours* graph, uint32_t edge)
{
    return &QC_AT(qcEdge, graph->edges, edge);
}

/// The box at the other end.
static inline uint32_t qcNeighbours_Other(const qcNeighbours* graph, uint32_t end)
{
    return qcNeighbours_Edge(graph, end / 2)->box[1 - end % 2] & ~QC_EDGE_MARK;
}

/// The first end at a box, then the next one after an end; QC_NO_EDGE: there is none.
static inline uint32_t qcNeighbours_First(const qcNeighbours* graph, uint32_t box)
{
    return QC_AT(uint32_t, graph->first, box);
}

static inline uint32_t qcNeighbours_Next(const qcNeighbours* graph, uint32_t end)
{
    return QC_AT(qcEdgeEnd, graph->ends, end).next;
}

#endif
