// The overlap graph of a set of boxes, kept up to date outside of a search, and the overlaps of the last search.
#include "broadphase/box_set.h"

#include "base/status.h"
#include "broadphase/box_query.h"

#include <string.h>

/// The box at the last search, or null if it was added since.
static const qcBox* GetPrevious(const qcBoxes* set, uint32_t id, const qcBounds** bounds)
{
    uint32_t index = qcBoxes_Box(set, id)->movedIndex;
    const qcMovedBox* moved = index != QC_NOT_MOVED ? &QC_AT(qcMovedBox, set->movedBoxes, index) : NULL;
    *bounds = moved != NULL ? &moved->bounds : &QC_AT(qcBounds, set->bounds, id);
    if (moved == NULL)
        return qcBoxes_Box(set, id);
    return moved->added ? NULL : &moved->box;
}

bool qcBoxes_OverlappedBefore(const qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBounds *boundsA, *boundsB;
    const qcBox *x = GetPrevious(set, a, &boundsA), *y = GetPrevious(set, b, &boundsB);
    return !set->historyLost && x != NULL && y != NULL && qcBox_Overlap(x, boundsA, y, boundsB);
}

uint32_t qcBoxes_MarkNeighbours(qcBoxes* set, uint32_t id)
{
    uint32_t* marks = set->visitMarks.data;
    if (++set->lastMark == 0)
    {
        memset(marks, 0, set->visitMarks.count * sizeof *marks);
        set->lastMark = 1;
    }
    uint32_t end = qcOverlapGraph_FirstEnd(&set->overlaps, id);
    for (; end != QC_NO_EDGE; end = qcOverlapGraph_NextEnd(&set->overlaps, end))
        marks[qcOverlapGraph_Other(&set->overlaps, end)] = set->lastMark;
    return set->lastMark;
}

/// The box whose overlaps are added to the graph.
typedef struct Commit
{
    qcBoxes* set;
    uint32_t id, mark; ///< neighbours with this visit mark have an edge already
    bool failed;
} Commit;

static bool AddEdge(uint32_t id, void* userData, void* context)
{
    (void)userData;
    Commit* commit = context;
    if (id == commit->id || QC_AT(uint32_t, commit->set->visitMarks, id) == commit->mark)
        return true;
    commit->failed = qcOverlapGraph_AddEdge(&commit->set->overlaps, commit->id, id, false) != qc_statusOk;
    return !commit->failed;
}

void qcBoxes_CommitPairs(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    if (box->state != qc_boxPairsStale || box->stationary || set->historyLost)
        return;
    Commit commit = {.set = set, .id = id, .mark = qcBoxes_MarkNeighbours(set, id)};
    qcBoxQuery query = qcBoxQuery_MakeFor(set, id, AddEdge, &commit);
    query.box = QC_AT(qcFloatBox, set->forest.boxes, id);
    query.fat = true;
    qcBoxQuery_Run(&query, qc_dynamicBoxes | qc_staticBoxes);
    if (commit.failed)
        return;
    box->state = qc_boxPairsKnown;
    set->staleCount--;
}

/// Adds a marked edge if the box found is stationary, and was there at the last search.
static bool AddStationaryEdge(uint32_t id, void* userData, void* context)
{
    (void)userData;
    const Commit* commit = context;
    qcBoxes* set = commit->set;
    const qcBox* box = qcBoxes_Box(set, id);
    if (id == commit->id || !box->stationary || box->movedIndex != QC_NOT_MOVED)
        return true;
    // If memory runs out, the next search starts from scratch.
    set->historyLost = qcOverlapGraph_AddEdge(&set->overlaps, commit->id, id, true) != qc_statusOk;
    return !set->historyLost;
}

void qcBoxes_CommitStationaryPairs(qcBoxes* set, uint32_t id)
{
    Commit commit = {.set = set, .id = id};
    qcBoxQuery query = qcBoxQuery_MakeFor(set, id, AddStationaryEdge, &commit);
    if (!set->historyLost)
        qcBoxQuery_Run(&query, set->originMoved ? qc_dynamicBoxes | qc_staticBoxes : qc_staticBoxes);
}
