// Which boxes are near which: a graph whose edges hang in a list at each of their two boxes, as contacts do in Box2D
// (Catto).
#include "box_neighbours.h"

#include "status.h"

static qcEdgeEnd* End(qcNeighbours* graph, uint32_t end)
{
    return &QC_AT(qcEdgeEnd, graph->ends, end);
}

static void Link(qcNeighbours* graph, uint32_t end, uint32_t box, uint32_t other)
{
    uint32_t* first = &QC_AT(uint32_t, graph->first, box);
    *End(graph, end) = (qcEdgeEnd){other, *first, QC_NO_EDGE};
    if (*first != QC_NO_EDGE)
        End(graph, *first)->previous = end;
    *first = end;
}

static void Unlink(qcNeighbours* graph, uint32_t end, uint32_t box)
{
    qcEdgeEnd e = *End(graph, end);
    if (e.previous == QC_NO_EDGE)
        QC_AT(uint32_t, graph->first, box) = e.next;
    else
        End(graph, e.previous)->next = e.next;
    if (e.next != QC_NO_EDGE)
        End(graph, e.next)->previous = e.previous;
}

qcStatus qcNeighbours_Reserve(qcNeighbours* graph, size_t boxCount)
{
    size_t known = graph->first.count;
    if (boxCount <= known)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&graph->first, boxCount, sizeof(uint32_t), "neighbours of boxes"));
    for (size_t box = known; box < boxCount; box++)
        QC_AT(uint32_t, graph->first, box) = QC_NO_EDGE;
    return qc_statusOk;
}

void qcNeighbours_Clear(qcNeighbours* graph)
{
    graph->ends.count = 0;
    graph->first.count = 0;
    graph->firstFree = QC_NO_EDGE;
}

void qcNeighbours_Free(qcNeighbours* graph)
{
    qcArray_Free(&graph->ends);
    qcArray_Free(&graph->first);
    qcNeighbours_Clear(graph);
}

qcStatus qcNeighbours_Join(qcNeighbours* graph, uint32_t a, uint32_t b)
{
    uint32_t end = graph->firstFree;
    if (end != QC_NO_EDGE)
        graph->firstFree = End(graph, end)->next;
    else
    {
        if (graph->ends.count >= QC_NO_EDGE - 1)
            return qcFailMemory(SIZE_MAX, "more than 2^31 pairs of boxes near each other");
        end = (uint32_t)graph->ends.count;
        QC_TRY(
            qcArray_Resize(&graph->ends, graph->ends.count + 2, sizeof(qcEdgeEnd), "pairs of boxes near each other"));
    }
    Link(graph, end, a, b);
    Link(graph, end ^ 1u, b, a);
    return qc_statusOk;
}

void qcNeighbours_Part(qcNeighbours* graph, uint32_t box)
{
    uint32_t end = QC_AT(uint32_t, graph->first, box);
    while (end != QC_NO_EDGE)
    {
        qcEdgeEnd e = *End(graph, end);
        Unlink(graph, end ^ 1u, e.other);
        *End(graph, end & ~1u) = (qcEdgeEnd){QC_NO_EDGE, graph->firstFree, QC_NO_EDGE};
        graph->firstFree = end & ~1u;
        end = e.next;
    }
    QC_AT(uint32_t, graph->first, box) = QC_NO_EDGE;
}
