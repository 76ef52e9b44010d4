// Sweep and prune (Cohen, Lin, Manocha, Ponamgi: I-COLLIDE, 1995) along one axis, in strips along another: boxes far
// apart in either axis are never compared. Proof that rounding loses no pair: plugin/docs/proofs/sweep_and_prune.md.
#include "sweep/sweep_and_prune.h"

#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <math.h>

qcSweepBox qcSweepFrame_Map(const qcSweepFrame* frame, const double lower[3], const double upper[3], uint32_t body,
                            uint32_t item)
{
    qcSweepBox box;
    for (int axis = 0; axis < 3; axis++)
    {
        box.lower[axis] = (float)(lower[axis] - frame->origin[axis]);
        box.upper[axis] = (float)(upper[axis] + frame->margin - frame->origin[axis]);
    }
    box.body = body;
    box.item = item;
    return box;
}

typedef struct Layout
{
    int sweepAxis, stripAxis, otherAxis;
    uint32_t stripCount;
    float stripOrigin, stripsPerUnit;
} Layout;

/// The strip of a coordinate: monotone, and in range for any coordinate.
static uint32_t StripOf(const Layout* layout, float x)
{
    float strip = (x - layout->stripOrigin) * layout->stripsPerUnit;
    // NaN (infinity times zero) goes to strip 0, for lower and upper ends alike.
    if (!(strip >= 1.0f))
        return 0;
    return strip < (float)layout->stripCount ? (uint32_t)strip : layout->stripCount - 1;
}

/// The boxes along one axis.
typedef struct Extent
{
    double low, range; ///< of all boxes
    double size;       ///< of a box, mean
    double room;       ///< boxes that fit side by side where most of them are: the more, the better the axis separates
} Extent;

static Extent FindExtent(const qcSweepBox* boxes, uint32_t count, int axis)
{
    float low = boxes[0].lower[axis], high = boxes[0].upper[axis];
    double size = 0.0, sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < count; i++)
    {
        low = fminf(low, boxes[i].lower[axis]);
        high = fmaxf(high, boxes[i].upper[axis]);
        size += (double)boxes[i].upper[axis] - (double)boxes[i].lower[axis];
        double offset = (double)boxes[i].lower[axis] - (double)boxes[0].lower[axis];
        sum += offset;
        squares += offset * offset;
    }
    Extent e = {.low = low, .range = (double)high - (double)low, .size = size / count};
    // The width of a uniform distribution: sqrt(12) standard deviations. The range would overrate an axis along which a
    // few outliers lie far from all other boxes. Infinite boxes make it NaN.
    double mean = sum / count, spread = sqrt(12.0 * fmax(squares / count - mean * mean, 0.0)) + e.size;
    e.room = e.size > 0.0 && isfinite(spread) ? spread / e.size : e.range > 0.0 ? count : 1.0;
    return e;
}

static Layout Plan(const qcSweepBox* boxes, uint32_t count)
{
    Extent extent[3];
    for (int axis = 0; axis < 3; axis++)
        extent[axis] = FindExtent(boxes, count, axis);
    Layout layout = {.sweepAxis = 0};
    for (int axis = 1; axis < 3; axis++)
        if (extent[axis].room > extent[layout.sweepAxis].room)
            layout.sweepAxis = axis;
    int u = (layout.sweepAxis + 1) % 3, v = (layout.sweepAxis + 2) % 3;
    layout.stripAxis = extent[u].room >= extent[v].room ? u : v;
    layout.otherAxis = extent[u].room >= extent[v].room ? v : u;
    const Extent* across = &extent[layout.stripAxis];
    // Strips as wide as two boxes: n boxes of any sizes have at most n + n / 2 entries.
    double strips = fmin(across->range / across->size / 2.0, (double)count);
    layout.stripCount = strips >= 1.0 ? (uint32_t)strips : 1;
    layout.stripOrigin = (float)across->low;
    double perUnit = layout.stripCount / across->range;
    layout.stripsPerUnit = isfinite(perUnit) && perUnit <= 3e38 ? (float)perUnit : 0.0f;
    return layout;
}

typedef struct Job
{
    Layout layout;
    const qcSweepBox* entries;
    const size_t* stripFirst;
    qcSweepFunction* function;
    void* context;
} Job;

static void SweepStrip(void* context, size_t strip, uint32_t worker)
{
    const Job* job = context;
    const Layout* layout = &job->layout;
    const int s = layout->sweepAxis, t = layout->stripAxis, o = layout->otherAxis;
    const qcSweepBox* end = job->entries + job->stripFirst[strip + 1];
    for (const qcSweepBox* a = job->entries + job->stripFirst[strip]; a < end; a++)
    {
        float upper = a->upper[s];
        for (const qcSweepBox* b = a + 1; b < end && b->lower[s] <= upper; b++)
        {
            bool overlap = (a->lower[t] <= b->upper[t]) & (b->lower[t] <= a->upper[t]) & (a->lower[o] <= b->upper[o]) &
                           (b->lower[o] <= a->upper[o]);
            if (overlap && StripOf(layout, fmaxf(a->lower[t], b->lower[t])) == strip)
                job->function(job->context, a, b, worker);
        }
    }
}

/// Copies each box into all strips that it overlaps, sorted by lower ends along the sweep axis.
static qcStatus FillStrips(qcSweep* sweep, const qcSweepBox* boxes, uint32_t count, const Layout* layout)
{
    QC_TRY(qcArray_Resize(&sweep->order, count, sizeof(qcSortItem), "sweep order"));
    QC_TRY(qcArray_Resize(&sweep->stripFirst, layout->stripCount + 2, sizeof(size_t), "sweep strips"));
    qcSortItem* order = sweep->order.data;
    size_t* first = sweep->stripFirst.data;
    for (size_t s = 0; s < sweep->stripFirst.count; s++)
        first[s] = 0;
    for (uint32_t i = 0; i < count; i++)
    {
        order[i] = (qcSortItem){qcSort_FloatKey(boxes[i].lower[layout->sweepAxis]), i};
        uint32_t last = StripOf(layout, boxes[i].upper[layout->stripAxis]);
        for (uint32_t s = StripOf(layout, boxes[i].lower[layout->stripAxis]); s <= last; s++)
            first[s + 2]++;
    }
    QC_TRY(qcSort_Items(order, count, &sweep->scratch));
    for (size_t s = 2; s < sweep->stripFirst.count; s++)
        first[s] += first[s - 1];
    QC_TRY(qcArray_Resize(&sweep->entries, first[layout->stripCount + 1], sizeof(qcSweepBox), "sweep entries"));
    qcSweepBox* entries = sweep->entries.data;
    // first[s + 1] is the end of strip s while it is filled, and then the begin of strip s + 1.
    for (uint32_t k = 0; k < count; k++)
    {
        const qcSweepBox* box = &boxes[order[k].value];
        uint32_t last = StripOf(layout, box->upper[layout->stripAxis]);
        for (uint32_t s = StripOf(layout, box->lower[layout->stripAxis]); s <= last; s++)
            entries[first[s + 1]++] = *box;
    }
    return qc_statusOk;
}

qcStatus qcSweep_FindPairs(qcSweep* sweep, const qcSweepBox* boxes, uint32_t count, uint32_t threads,
                           qcSweepFunction* function, void* context)
{
    if (count < 2)
        return qc_statusOk;
    Layout layout = Plan(boxes, count);
    QC_TRY(FillStrips(sweep, boxes, count, &layout));
    Job job = {layout, sweep->entries.data, sweep->stripFirst.data, function, context};
    // Below 4096 boxes all strips together take less than 0.5 ms.
    qcParallel_For(count < 4096 ? 1 : threads, layout.stripCount, 2, SweepStrip, &job);
    return qc_statusOk;
}

void qcSweep_Free(qcSweep* sweep)
{
    qcArray_Free(&sweep->order);
    qcArray_Free(&sweep->scratch);
    qcArray_Free(&sweep->stripFirst);
    qcArray_Free(&sweep->entries);
}
