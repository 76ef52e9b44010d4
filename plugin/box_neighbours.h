// Which boxes are near which: a graph whose edges hang in a list at each of their two boxes, as contacts do in Box2D
// (Catto). Adding or removing an edge is O(1), leaving all neighbours O(neighbours).
#ifndef QC_PLUGIN_BOX_NEIGHBOURS_H
#define QC_PLUGIN_BOX_NEIGHBOURS_H

#include "memory.h"

#define QC_NO_EDGE UINT32_MAX

/// One end of an edge. Ends come in twins, 2 i and 2 i + 1.
typedef struct qcEdgeEnd
{
    uint32_t other;          ///< the box at the twin's end; a free edge: QC_NO_EDGE in the even end
    uint32_t next, previous; ///< ends in the list of the same box, or QC_NO_EDGE; a free edge: the next free one
} qcEdgeEnd;

/// All zero is not an empty graph: call qcNeighbours_Clear first.
typedef struct qcNeighbours
{
    qcArray ends;  ///< qcEdgeEnd
    qcArray first; ///< uint32_t, an end or QC_NO_EDGE, by box
    uint32_t firstFree;
} qcNeighbours;

/// Makes room for boxes with ids below `boxCount`; new ones have no neighbours.
qcStatus qcNeighbours_Reserve(qcNeighbours* graph, size_t boxCount);
void qcNeighbours_Clear(qcNeighbours* graph);
void qcNeighbours_Free(qcNeighbours* graph);

/// Adds an edge between two boxes that have none. qc_statusOutOfMemory leaves the graph as it was.
qcStatus qcNeighbours_Join(qcNeighbours* graph, uint32_t a, uint32_t b);
/// Removes all edges of a box.
void qcNeighbours_Part(qcNeighbours* graph, uint32_t box);

#endif
