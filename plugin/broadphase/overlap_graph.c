// The overlap graph: edges in one list per box, doubly linked, and a free list. After the contact graph of Box2D
// (Catto).
#include "broadphase/overlap_graph.h"

#include "base/status.h"

static qcEdgeEnd* End(qcOverlapGraph* graph, uint32_t end)
{
    return &QC_AT(qcEdgeEnd, graph->ends, end);
}

static void Link(qcOverlapGraph* graph, uint32_t end, uint32_t box)
{
    uint32_t* first = &QC_AT(uint32_t, graph->first, box);
    *End(graph, end) = (qcEdgeEnd){*first, QC_NO_EDGE};
    if (*first != QC_NO_EDGE)
        End(graph, *first)->previous = end;
    *first = end;
}

static void Unlink(qcOverlapGraph* graph, uint32_t end, uint32_t box)
{
    qcEdgeEnd e = *End(graph, end);
    if (e.previous == QC_NO_EDGE)
        QC_AT(uint32_t, graph->first, box) = e.next;
    else
        End(graph, e.previous)->next = e.next;
    if (e.next != QC_NO_EDGE)
        End(graph, e.next)->previous = e.previous;
}

qcStatus qcOverlapGraph_Reserve(qcOverlapGraph* graph, size_t boxCount)
{
    size_t previous = graph->first.count;
    if (boxCount <= previous)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&graph->first, boxCount, sizeof(uint32_t), "edge lists of boxes"));
    for (size_t box = previous; box < boxCount; box++)
        QC_AT(uint32_t, graph->first, box) = QC_NO_EDGE;
    return qc_statusOk;
}

void qcOverlapGraph_Clear(qcOverlapGraph* graph)
{
    graph->edges.count = 0;
    graph->ends.count = 0;
    graph->first.count = 0;
    graph->firstFree = QC_NO_EDGE;
}

void qcOverlapGraph_RemoveAllEdges(qcOverlapGraph* graph)
{
    graph->edges.count = 0;
    graph->ends.count = 0;
    graph->firstFree = QC_NO_EDGE;
    for (size_t box = 0; box < graph->first.count; box++)
        QC_AT(uint32_t, graph->first, box) = QC_NO_EDGE;
}

void qcOverlapGraph_Free(qcOverlapGraph* graph)
{
    qcArray_Free(&graph->edges);
    qcArray_Free(&graph->ends);
    qcArray_Free(&graph->first);
    qcOverlapGraph_Clear(graph);
}

qcStatus qcOverlapGraph_AddEdge(qcOverlapGraph* graph, uint32_t a, uint32_t b, bool mark)
{
    uint32_t edge = graph->firstFree;
    if (edge != QC_NO_EDGE)
        graph->firstFree = End(graph, 2 * edge)->next;
    else
    {
        size_t count = graph->edges.count;
        if (count >= QC_NO_EDGE / 2)
            return qcFailMemory(SIZE_MAX, "more than 2^31 edges of an overlap graph");
        QC_TRY(qcArray_Reserve(&graph->edges, count + 1, sizeof(qcEdge), "edges of an overlap graph"));
        QC_TRY(qcArray_Reserve(&graph->ends, 2 * count + 2, sizeof(qcEdgeEnd), "edge lists of an overlap graph"));
        edge = (uint32_t)graph->edges.count++;
        graph->ends.count += 2;
    }
    *qcOverlapGraph_Edge(graph, edge) = (qcEdge){{mark ? a | QC_EDGE_MARK : a, b}};
    Link(graph, 2 * edge, a);
    Link(graph, 2 * edge + 1, b);
    return qc_statusOk;
}

void qcOverlapGraph_RemoveEdge(qcOverlapGraph* graph, uint32_t edge)
{
    qcEdge* e = qcOverlapGraph_Edge(graph, edge);
    Unlink(graph, 2 * edge, e->box[0] & ~QC_EDGE_MARK);
    Unlink(graph, 2 * edge + 1, e->box[1]);
    e->box[1] = QC_NO_EDGE;
    End(graph, 2 * edge)->next = graph->firstFree;
    graph->firstFree = edge;
}

void qcOverlapGraph_RemoveEdgesOf(qcOverlapGraph* graph, uint32_t box)
{
    for (uint32_t end; (end = qcOverlapGraph_FirstEnd(graph, box)) != QC_NO_EDGE;)
        qcOverlapGraph_RemoveEdge(graph, end / 2);
}
