// Sweep and prune (Cohen, Lin, Manocha, Ponamgi: I-COLLIDE, 1995) along one axis, in strips along another: boxes far
// apart in either axis are hardly ever compared. A sample chooses axes and strips. Proof that rounding loses no pair:
// plugin/docs/proofs/sweep_and_prune.md.
#include "sweep/sweep_and_prune.h"

#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

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

void qcSweepFrame_SetOrigin(qcSweepFrame* frame, double (*corners)[3], uint32_t count)
{
    for (int axis = 0; axis < 3 && count != 0; axis++)
    {
        for (uint32_t i = 1; i < count; i++)
        {
            double corner = corners[i][axis];
            uint32_t at = i;
            for (; at > 0 && corners[at - 1][axis] > corner; at--)
                corners[at][axis] = corners[at - 1][axis];
            corners[at][axis] = corner;
        }
        frame->origin[axis] = corners[count / 2][axis];
    }
}

enum
{
    // Comparing 256 boxes with each other takes as long as sweeping some 500 (10 000 boxes in a plane).
    qc_maxSample = 256,
    // The highest number of a strip, and below zero the lowest.
    qc_maxStrip = 1 << 30
};

/// Strips repeat: strip `stripCount` shares the entries of strip 0, so that boxes far away need no strips of their own.
typedef struct Layout
{
    int sweepAxis, stripAxis, otherAxis;
    uint32_t stripCount; ///< a power of two
    float stripsPerUnit;
} Layout;

/// The number of the strip of a coordinate: monotone, for any coordinate.
static int32_t StripOf(const Layout* layout, float x)
{
    float strip = x * layout->stripsPerUnit;
    if (!(strip > -(float)qc_maxStrip))
        return -qc_maxStrip;
    return strip < (float)qc_maxStrip ? (int32_t)strip : qc_maxStrip;
}

/// The strips of a box: `count` from `first`, modulo the number of strips.
typedef struct Strips
{
    uint32_t first, count;
} Strips;

static Strips StripsOf(const Layout* layout, const qcSweepBox* box)
{
    uint32_t first = (uint32_t)StripOf(layout, box->lower[layout->stripAxis]);
    uint32_t more = (uint32_t)StripOf(layout, box->upper[layout->stripAxis]) - first;
    return (Strips){first, more < layout->stripCount ? more + 1 : layout->stripCount};
}

/// Some of the boxes: a few far away or very large among all are few in it too.
typedef struct Sample
{
    uint32_t count;
    float lower[3][qc_maxSample], upper[3][qc_maxSample];
} Sample;

static void TakeSample(const qcSweepBox* boxes, uint32_t count, Sample* sample)
{
    // An eighth, and at least 16.
    uint32_t some = count / 8 > 16 ? count / 8 : 16, max = count < qc_maxSample ? count : qc_maxSample;
    sample->count = some < max ? some : max;
    for (uint32_t k = 0; k < sample->count; k++)
    {
        // Scattered: at equal distances all of them could be of one row of a grid.
        uint32_t first = (uint32_t)((uint64_t)k * count / sample->count);
        uint32_t room = (uint32_t)((uint64_t)(k + 1) * count / sample->count) - first;
        const qcSweepBox* box = &boxes[first + (uint32_t)((uint64_t)(k * 0x9e3779b9u) * room >> 32)];
        for (int axis = 0; axis < 3; axis++)
        {
            sample->lower[axis][k] = box->lower[axis];
            sample->upper[axis][k] = box->upper[axis];
        }
    }
}

/// The number of pairs that overlap along an axis: the fewer, the better the axis separates.
static uint32_t CountOverlaps(const Sample* sample, int axis)
{
    const float *lower = sample->lower[axis], *upper = sample->upper[axis];
    uint32_t overlaps = 0;
    for (uint32_t i = 1; i < sample->count; i++)
    {
        float low = lower[i], high = upper[i];
        for (uint32_t j = 0; j < i; j++)
            overlaps += (lower[j] <= high) & (low <= upper[j]);
    }
    return overlaps;
}

/// The mean of all values but those more than four times as large as the mean.
static double TypicalValue(const double* values, uint32_t count)
{
    double mean = INFINITY;
    for (uint32_t kept = count, previous = 0; kept != previous;)
    {
        double sum = 0.0, limit = 4.0 * mean;
        previous = kept;
        kept = 0;
        for (uint32_t i = 0; i < count; i++)
        {
            sum += values[i] <= limit ? values[i] : 0.0;
            kept += values[i] <= limit;
        }
        mean = sum / kept;
    }
    return mean;
}

/// Strips as wide as two boxes: n boxes of one size have n + n / 2 entries.
static float StripsPerUnit(const Sample* sample, const Layout* layout)
{
    const float *lower = sample->lower[layout->stripAxis], *upper = sample->upper[layout->stripAxis];
    double sizes[qc_maxSample], distances[qc_maxSample];
    for (uint32_t i = 0; i < sample->count; i++)
    {
        sizes[i] = fmin((double)upper[i] - (double)lower[i], FLT_MAX);
        distances[i] = fmin(fabs((double)lower[i]), FLT_MAX);
    }
    double width = 2.0 * TypicalValue(sizes, sample->count);
    if (width == 0.0)
        width = TypicalValue(distances, sample->count) / layout->stripCount;
    // No zero, even halved 32 times: times infinity it is not a number.
    return (float)fmax(fmin(1.0 / width, FLT_MAX), 0x1p-90);
}

static Layout Plan(const qcSweepBox* boxes, uint32_t count)
{
    Sample sample;
    TakeSample(boxes, count, &sample);
    uint32_t overlaps[3];
    for (int axis = 0; axis < 3; axis++)
        overlaps[axis] = CountOverlaps(&sample, axis);
    Layout layout = {.sweepAxis = 0, .stripCount = 1};
    for (int axis = 1; axis < 3; axis++)
        if (overlaps[axis] < overlaps[layout.sweepAxis])
            layout.sweepAxis = axis;
    int u = (layout.sweepAxis + 1) % 3, v = (layout.sweepAxis + 2) % 3;
    layout.stripAxis = overlaps[u] <= overlaps[v] ? u : v;
    layout.otherAxis = overlaps[u] <= overlaps[v] ? v : u;
    // Where boxes are spread evenly over m strips, one in m pairs overlaps along the axis.
    uint32_t pairs = sample.count * (sample.count - 1) / 2, strips = count;
    if (overlaps[layout.stripAxis] != 0)
        strips = pairs / overlaps[layout.stripAxis];
    while (layout.stripCount < strips && layout.stripCount <= count / 2)
        layout.stripCount *= 2;
    layout.stripsPerUnit = StripsPerUnit(&sample, &layout);
    return layout;
}

typedef struct Job
{
    Layout layout;
    const qcSweepBox* entries;
    const size_t* stripFirst;
    qcSweepFunction* function;
    void* context;
    atomic_uint_least64_t comparisons;
} Job;

static void SweepStrip(void* context, size_t strip, uint32_t worker)
{
    Job* job = context;
    const Layout* layout = &job->layout;
    const int s = layout->sweepAxis, t = layout->stripAxis, o = layout->otherAxis;
    const qcSweepBox* end = job->entries + job->stripFirst[strip + 1];
    const uint32_t mask = layout->stripCount - 1;
    uint64_t comparisons = 0;
    for (const qcSweepBox* a = job->entries + job->stripFirst[strip]; a < end; a++)
    {
        float upper = a->upper[s];
        const qcSweepBox* b = a + 1;
        for (; b < end && b->lower[s] <= upper; b++)
        {
            bool overlap = (a->lower[t] <= b->upper[t]) & (b->lower[t] <= a->upper[t]) & (a->lower[o] <= b->upper[o]) &
                           (b->lower[o] <= a->upper[o]);
            if (overlap && ((uint32_t)StripOf(layout, fmaxf(a->lower[t], b->lower[t])) & mask) == strip)
                job->function(job->context, a, b, worker);
        }
        comparisons += (uint64_t)(b - a - 1);
    }
    atomic_fetch_add_explicit(&job->comparisons, comparisons, memory_order_relaxed);
}

/// Counts the entries of each strip in first[strip + 2]. False: they are many more than boxes.
static bool CountEntries(const qcSweepBox* boxes, uint32_t count, const Layout* layout, size_t* first)
{
    const uint32_t mask = layout->stripCount - 1;
    size_t entries = 0;
    memset(first, 0, (layout->stripCount + 2) * sizeof *first);
    for (uint32_t i = 0; i < count && entries <= 3 * (size_t)count; i++)
    {
        Strips strips = StripsOf(layout, &boxes[i]);
        for (uint32_t k = 0; k < strips.count; k++)
            first[((strips.first + k) & mask) + 2]++;
        entries += strips.count;
    }
    return entries <= 3 * (size_t)count;
}

/// Copies each box into all strips that it overlaps, sorted by lower ends along the sweep axis. Where many boxes are
/// much wider than strips, strips become fewer and wider.
static qcStatus FillStrips(qcSweep* sweep, const qcSweepBox* boxes, uint32_t count, Layout* layout)
{
    QC_TRY(qcArray_Resize(&sweep->order, count, sizeof(qcSortItem), "sweep order"));
    QC_TRY(qcArray_Resize(&sweep->stripFirst, (size_t)layout->stripCount + 2, sizeof(size_t), "sweep strips"));
    qcSortItem* order = sweep->order.data;
    size_t* first = sweep->stripFirst.data;
    for (uint32_t i = 0; i < count; i++)
        order[i] = (qcSortItem){qcSort_FloatKey(boxes[i].lower[layout->sweepAxis]), i};
    QC_TRY(qcSort_Items(order, count, &sweep->scratch));
    while (!CountEntries(boxes, count, layout, first))
    {
        layout->stripCount /= 2;
        layout->stripsPerUnit /= 2.0f;
    }
    for (size_t s = 2; s < (size_t)layout->stripCount + 2; s++)
        first[s] += first[s - 1];
    QC_TRY(qcArray_Resize(&sweep->entries, first[layout->stripCount + 1], sizeof(qcSweepBox), "sweep entries"));
    qcSweepBox* entries = sweep->entries.data;
    const uint32_t mask = layout->stripCount - 1;
    // first[s + 1] is the end of strip s while it is filled, and then the begin of strip s + 1.
    for (uint32_t i = 0; i < count; i++)
    {
        const qcSweepBox* box = &boxes[order[i].value];
        Strips strips = StripsOf(layout, box);
        for (uint32_t k = 0; k < strips.count; k++)
            entries[first[((strips.first + k) & mask) + 1]++] = *box;
    }
    return qc_statusOk;
}

qcStatus qcSweep_FindPairs(qcSweep* sweep, const qcSweepBox* boxes, uint32_t count, uint32_t threads,
                           qcSweepFunction* function, void* context)
{
    sweep->comparisons = 0;
    if (count < 2)
        return qc_statusOk;
    Layout layout = Plan(boxes, count);
    QC_TRY(FillStrips(sweep, boxes, count, &layout));
    Job job = {layout, sweep->entries.data, sweep->stripFirst.data, function, context, 0};
    // Below 4096 boxes all strips together take less than 0.5 ms.
    qcParallel_For(count < 4096 ? 1 : threads, layout.stripCount, 2, SweepStrip, &job);
    sweep->comparisons = atomic_load(&job.comparisons);
    return qc_statusOk;
}

void qcSweep_Free(qcSweep* sweep)
{
    qcArray_Free(&sweep->order);
    qcArray_Free(&sweep->scratch);
    qcArray_Free(&sweep->stripFirst);
    qcArray_Free(&sweep->entries);
}
