// Each tested triangle is compared with the triangles rendered before it: one that covers a sample of it, nearer, hides
// it; one that shares no sample with it, or lies behind it all over, does not. What remains is left to the rasteriser.
#include "gl/visibility/sure_results.h"

#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    qc_maxCellsPerSide = 1024
};

// Pixels by which a rasteriser may move a corner, in x and y each: GL demands 4 bits of subpixel.
static const float s_snap = 0.0625f;

/// A triangle in pixels; depths grow away from the eye.
typedef struct Triangle
{
    float x[3], y[3], z[3];
    float lower[2], upper[2];    ///< its box, larger by the snap
    float nearest, farthest;     ///< bounds of its depths, error included
    float slopeX, slopeY, slack; ///< of its plane through corner 0, and the error of a drawn depth; no plane: infinite
    float turn;                  ///< 1: counter-clockwise; -1: clockwise; 0: rounding may decide
    uint32_t step;
} Triangle;

/// A render in a cell, with what most comparisons need.
typedef struct Entry
{
    float lower[2], upper[2], nearest; ///< of the triangle
    uint32_t triangle;
} Entry;

typedef struct Finder
{
    const qcSureView* view;
    const qcVisibilityStep* steps;
    uint32_t stepCount;
    uint32_t cellsPerSide;
    float cellsPerPixel;
    qcSureResults* results;
} Finder;

//  ---- triangles -----------------------------------------------------------------------------------

/// Twice the signed area of (from, to, point), and the error of that by snapping and rounding.
static float Cross(float ex, float ey, float wx, float wy, float* error)
{
    *error = 2.0f * s_snap * (fabsf(ex) + fabsf(ey) + fabsf(wx) + fabsf(wy)) + 8.0f * s_snap * s_snap;
    return ex * wy - ey * wx;
}

/// The plane of a triangle whose orientation is sure.
static void FindPlane(Triangle* t, float area, uint32_t resolution)
{
    float ux = t->x[1] - t->x[0], uy = t->y[1] - t->y[0], uz = t->z[1] - t->z[0];
    float vx = t->x[2] - t->x[0], vy = t->y[2] - t->y[0], vz = t->z[2] - t->z[0];
    t->slopeX = (uz * vy - vz * uy) / area;
    t->slopeY = (vz * ux - uz * vx) / area;
    float slope = fabsf(t->slopeX) + fabsf(t->slopeY), extent = (float)resolution;
    float terms = (fabsf(uz * vy) + fabsf(vz * uy) + fabsf(vz * ux) + fabsf(uz * vx)) / fabsf(area);
    float areaError = 0x1p-20f * (fabsf(ux * vy) + fabsf(uy * vx)) / fabsf(area);
    t->slack = 2.0f * s_snap * slope + 0x1p-19f * (1.0f + 2.0f * extent * terms) + areaError * extent * slope;
}

static Triangle MakeTriangle(const qcSureView* view, uint32_t triangle, uint32_t step)
{
    const float* corner = view->corners + (size_t)9 * triangle;
    int x = (view->axis + 1) % 3, y = (view->axis + 2) % 3;
    float half = 0.5f * (float)view->resolution;
    Triangle t = {.slack = INFINITY, .step = step};
    for (int i = 0; i < 3; ++i)
    {
        t.x[i] = (corner[3 * i + x] + 1.0f) * half;
        t.y[i] = (corner[3 * i + y] + 1.0f) * half;
        t.z[i] = view->fromBack ? -corner[3 * i + view->axis] : corner[3 * i + view->axis];
    }
    t.lower[0] = fminf(t.x[0], fminf(t.x[1], t.x[2])) - s_snap;
    t.lower[1] = fminf(t.y[0], fminf(t.y[1], t.y[2])) - s_snap;
    t.upper[0] = fmaxf(t.x[0], fmaxf(t.x[1], t.x[2])) + s_snap;
    t.upper[1] = fmaxf(t.y[0], fmaxf(t.y[1], t.y[2])) + s_snap;
    float error, area = Cross(t.x[1] - t.x[0], t.y[1] - t.y[0], t.x[2] - t.x[0], t.y[2] - t.y[0], &error);
    t.turn = area > error ? 1.0f : area < -error ? -1.0f : 0.0f;
    if (t.turn != 0.0f)
        FindPlane(&t, area, view->resolution);
    t.nearest = fminf(t.z[0], fminf(t.z[1], t.z[2])) - t.slack;
    t.farthest = fmaxf(t.z[0], fmaxf(t.z[1], t.z[2])) + t.slack;
    return t;
}

/// Whether a triangle surely covers a point.
static bool Covers(const Triangle* t, float px, float py)
{
    for (int i = 0; i < 3; ++i)
    {
        int k = i < 2 ? i + 1 : 0;
        float error, side = Cross(t->x[k] - t->x[i], t->y[k] - t->y[i], px - t->x[i], py - t->y[i], &error) * t->turn;
        if (!(side > error))
            return false;
    }
    return true;
}

static float DepthAt(const Triangle* t, float px, float py)
{
    return t->z[0] + t->slopeX * (px - t->x[0]) + t->slopeY * (py - t->y[0]);
}

static bool IsCorner(const Triangle* t, float px, float py)
{
    return (t->x[0] == px && t->y[0] == py) || (t->x[1] == px && t->y[1] == py) || (t->x[2] == px && t->y[2] == py);
}

/// Whether an edge of `a` has `b` beyond it: corners that both have stay on the edge however they are rounded.
static bool SeparatesByEdge(const Triangle* a, const Triangle* b)
{
    for (int i = 0; a->turn != 0.0f && i < 3; ++i)
    {
        int k = i < 2 ? i + 1 : 0;
        float ex = a->x[k] - a->x[i], ey = a->y[k] - a->y[i];
        int beyond = 0;
        for (; beyond < 3; ++beyond)
        {
            float px = b->x[beyond], py = b->y[beyond];
            if ((px == a->x[i] && py == a->y[i]) || (px == a->x[k] && py == a->y[k]))
                continue;
            float error, side = Cross(ex, ey, px - a->x[i], py - a->y[i], &error) * a->turn;
            if (!(side < -error))
                break;
        }
        if (beyond == 3)
            return true;
    }
    return false;
}

/// Whether a line through a corner that both have separates the rest of them.
static bool SeparatesByCorner(const Triangle* a, const Triangle* b)
{
    int i = 0;
    while (i < 3 && !IsCorner(b, a->x[i], a->y[i]))
        ++i;
    if (i == 3)
        return false;
    float cx = a->x[i], cy = a->y[i];
    float nx = a->x[0] + a->x[1] + a->x[2] - b->x[0] - b->x[1] - b->x[2],
          ny = a->y[0] + a->y[1] + a->y[2] - b->y[0] - b->y[1] - b->y[2];
    float margin = 3.0f * s_snap * (fabsf(nx) + fabsf(ny));
    for (int k = 0; k < 3; ++k)
    {
        if ((a->x[k] != cx || a->y[k] != cy) && !((a->x[k] - cx) * nx + (a->y[k] - cy) * ny > margin))
            return false;
        if ((b->x[k] != cx || b->y[k] != cy) && !((b->x[k] - cx) * nx + (b->y[k] - cy) * ny < -margin))
            return false;
    }
    return true;
}

/// Whether the corners of `corners` are all farther (sign 1) or nearer (-1) than the plane of `plane`, by their errors.
static bool IsBeyondPlane(const Triangle* corners, const Triangle* plane, float sign)
{
    float slack = corners->slack + plane->slack;
    for (int i = 0; i < 3; ++i)
        if (!((corners->z[i] - DepthAt(plane, corners->x[i], corners->y[i])) * sign > slack))
            return false;
    return true;
}

/// Whether a render may hide a test in some sample.
static bool MayHide(const Triangle* render, const Triangle* test)
{
    if (render->turn != 0.0f && test->turn != 0.0f &&
        (IsBeyondPlane(render, test, 1.0f) || IsBeyondPlane(test, render, -1.0f)))
        return false;
    return !SeparatesByEdge(test, render) && !SeparatesByEdge(render, test) && !SeparatesByCorner(test, render);
}

//  ---- cells ---------------------------------------------------------------------------------------

typedef struct CellBox
{
    uint32_t x0, y0, x1, y1;
} CellBox;

static uint32_t FindCell(const Finder* f, float pixel)
{
    float cell = pixel * f->cellsPerPixel;
    if (!(cell > 0.0f))
        return 0;
    return cell < (float)f->cellsPerSide ? (uint32_t)cell : f->cellsPerSide - 1;
}

static CellBox FindCells(const Finder* f, const Triangle* t)
{
    return (CellBox){FindCell(f, t->lower[0]), FindCell(f, t->lower[1]), FindCell(f, t->upper[0]),
                     FindCell(f, t->upper[1])};
}

/// Whether a box contains the centre of a pixel. Without one, a triangle has no fragment.
static bool HasSample(const Triangle* t)
{
    return floorf(t->upper[0] - 0.5f) >= ceilf(t->lower[0] - 0.5f) &&
           floorf(t->upper[1] - 0.5f) >= ceilf(t->lower[1] - 0.5f);
}

static qcStatus MakeTriangles(const Finder* f)
{
    qcSureResults* r = f->results;
    size_t count = 0;
    for (uint32_t s = 0; s < f->stepCount; ++s)
        count += qcSureResults_CountParts(&f->steps[s]);
    QC_TRY(qcArray_Reserve(&r->triangles, count, sizeof(Triangle), "triangles of visibility tests"));
    r->triangles.count = 0;
    for (uint32_t s = 0; s < f->stepCount; ++s)
    {
        const qcVisibilityStep* step = &f->steps[s];
        for (uint32_t k = 0; k < qcSureResults_CountParts(step); ++k)
            QC_AT(Triangle, r->triangles, r->triangles.count++) = MakeTriangle(f->view, step->firstTriangle + k, s);
    }
    return qc_statusOk;
}

/// Cells about as large as the mean box, at most four a triangle.
static void ChooseCells(Finder* f)
{
    const qcSureResults* r = f->results;
    double sum = 0.0;
    for (size_t i = 0; i < r->triangles.count; ++i)
    {
        const Triangle* t = &QC_AT(Triangle, r->triangles, i);
        sum += 0.5 * ((t->upper[0] - t->lower[0]) + (t->upper[1] - t->lower[1]));
    }
    double count = (double)r->triangles.count;
    double cells = fmin((double)f->view->resolution * count / fmax(sum, 1.0), 2.0 * sqrt(count));
    f->cellsPerSide = cells < 1.0 ? 1 : cells < qc_maxCellsPerSide ? (uint32_t)cells : qc_maxCellsPerSide;
    f->cellsPerPixel = (float)f->cellsPerSide / (float)f->view->resolution;
}

/// Counts the renders of each cell at cellFirst[cell + 2] or, with `add`, writes them in step order.
static void BinRenders(const Finder* f, bool add)
{
    size_t* first = f->results->cellFirst.data;
    Entry* entries = f->results->entries.data;
    for (size_t i = 0; i < f->results->triangles.count; ++i)
    {
        const Triangle* t = &QC_AT(Triangle, f->results->triangles, i);
        if (!f->steps[t->step].render || !HasSample(t))
            continue;
        const Entry entry = {{t->lower[0], t->lower[1]}, {t->upper[0], t->upper[1]}, t->nearest, (uint32_t)i};
        CellBox box = FindCells(f, t);
        for (uint32_t y = box.y0; y <= box.y1; ++y)
        {
            for (uint32_t x = box.x0; x <= box.x1; ++x)
            {
                size_t cell = (size_t)y * f->cellsPerSide + x;
                if (add)
                    entries[first[cell + 1]++] = entry;
                else
                    ++first[cell + 2];
            }
        }
    }
}

static qcStatus MakeCells(Finder* f)
{
    qcSureResults* r = f->results;
    ChooseCells(f);
    size_t count = (size_t)f->cellsPerSide * f->cellsPerSide;
    QC_TRY(qcArray_Resize(&r->cellFirst, count + 2, sizeof(size_t), "cells of visibility tests"));
    size_t* first = r->cellFirst.data;
    memset(first, 0, (count + 2) * sizeof(size_t));
    BinRenders(f, false);
    for (size_t cell = 1; cell < count + 2; ++cell)
        first[cell] += first[cell - 1];
    QC_TRY(qcArray_Resize(&r->entries, first[count + 1], sizeof(Entry), "cells of visibility tests"));
    BinRenders(f, true);
    return qc_statusOk;
}

//  ---- results -------------------------------------------------------------------------------------

/// Whether the sample nearest to a point of a triangle is surely hidden by renders of triangles before `end`.
static bool IsSampleHidden(const Finder* f, const Triangle* t, size_t end, float x, float y)
{
    float px = floorf(x) + 0.5f, py = floorf(y) + 0.5f;
    if (!Covers(t, px, py))
        return false;
    float depth = DepthAt(t, px, py) - t->slack;
    const size_t* first = f->results->cellFirst.data;
    size_t cell = (size_t)FindCell(f, py) * f->cellsPerSide + FindCell(f, px);
    const Entry* entries = f->results->entries.data;
    for (size_t i = first[cell]; i < first[cell + 1] && entries[i].triangle < end; ++i)
    {
        const Entry* entry = &entries[i];
        if (entry->nearest > depth || entry->lower[0] > px || entry->upper[0] < px || entry->lower[1] > py ||
            entry->upper[1] < py)
            continue;
        const Triangle* render = &QC_AT(Triangle, f->results->triangles, entry->triangle);
        if (render->turn != 0.0f && DepthAt(render, px, py) + render->slack < depth && Covers(render, px, py))
            return true;
    }
    return false;
}

/// Whether some sample of a triangle is surely hidden: near the centre, then near the corners.
static bool IsHidden(const Finder* f, const Triangle* t, size_t end)
{
    if (t->turn == 0.0f)
        return false;
    float x = (t->x[0] + t->x[1] + t->x[2]) / 3.0f, y = (t->y[0] + t->y[1] + t->y[2]) / 3.0f;
    if (IsSampleHidden(f, t, end, x, y))
        return true;
    for (int i = 0; i < 3; ++i)
        if (IsSampleHidden(f, t, end, 0.25f * x + 0.75f * t->x[i], 0.25f * y + 0.75f * t->y[i]))
            return true;
    return false;
}

/// Whether a cell is the first one that a render and a triangle are both in.
static bool IsFirstCell(const Finder* f, const Entry* entry, const Triangle* t, uint32_t cellX, uint32_t cellY)
{
    return FindCell(f, fmaxf(entry->lower[0], t->lower[0])) == cellX &&
           FindCell(f, fmaxf(entry->lower[1], t->lower[1])) == cellY;
}

/// Marks the renders in a cell that may hide a triangle, among triangles before `end`. `any`: whether there are any.
static void MarkCell(const Finder* f, const Triangle* t, size_t end, uint32_t cellX, uint32_t cellY, bool* any)
{
    const size_t* first = f->results->cellFirst.data;
    size_t cell = (size_t)cellY * f->cellsPerSide + cellX;
    const Entry* entries = f->results->entries.data;
    uint32_t* found = f->results->found.data;
    for (size_t i = first[cell]; i < first[cell + 1] && entries[i].triangle < end; ++i)
    {
        const Entry* entry = &entries[i];
        if (entry->nearest > t->farthest || entry->lower[0] > t->upper[0] || entry->upper[0] < t->lower[0] ||
            entry->lower[1] > t->upper[1] || entry->upper[1] < t->lower[1])
            continue;
        // Where the triangle is tested in any case, a render that is drawn in any case makes no difference.
        bool isMarked = *any && (found[entry->triangle] & qc_sureRender) != 0;
        if (isMarked || !IsFirstCell(f, entry, t, cellX, cellY) ||
            !MayHide(&QC_AT(Triangle, f->results->triangles, entry->triangle), t))
            continue;
        found[entry->triangle] |= qc_sureRender;
        *any = true;
    }
}

static bool MarkHiders(const Finder* f, const Triangle* t, size_t end)
{
    if (!HasSample(t))
        return false;
    bool any = false;
    CellBox box = FindCells(f, t);
    for (uint32_t y = box.y0; y <= box.y1; ++y)
        for (uint32_t x = box.x0; x <= box.x1; ++x)
            MarkCell(f, t, end, x, y, &any);
    return any;
}

/// Decides the test of a step, whose triangles begin here, or leaves those triangles of it that something may hide.
static void DecideStep(const Finder* f, uint32_t step, size_t firstTriangle)
{
    size_t end = firstTriangle + f->steps[step].triangleCount;
    for (size_t i = firstTriangle; i < end; ++i)
    {
        if (!IsHidden(f, &QC_AT(Triangle, f->results->triangles, i), firstTriangle))
            continue;
        QC_AT(uint32_t, f->results->found, i) |= qc_sureHidden;
        return;
    }
    for (size_t i = firstTriangle; i < end; ++i)
        if (MarkHiders(f, &QC_AT(Triangle, f->results->triangles, i), firstTriangle))
            QC_AT(uint32_t, f->results->found, i) |= qc_sureTest;
}

static qcStatus DecideSteps(const Finder* f)
{
    qcSureResults* r = f->results;
    size_t triangleCount = r->triangles.count, triangle = 0;
    QC_TRY(qcArray_Resize(&r->found, triangleCount, sizeof(uint32_t), "triangles of visibility tests"));
    memset(r->found.data, 0, triangleCount * sizeof(uint32_t));
    for (uint32_t s = 0; s < f->stepCount; triangle += qcSureResults_CountParts(&f->steps[s++]))
        if (f->steps[s].test)
            DecideStep(f, s, triangle);
    return qc_statusOk;
}

qcStatus qcSureResults_Find(qcSureResults* r, const qcSureView* view, const qcVisibilityStep* steps, uint32_t stepCount,
                            uint8_t* visible)
{
    Finder f = {.view = view, .steps = steps, .stepCount = stepCount, .results = r};
    r->steps.count = r->stepOf.count = 0;
    QC_TRY(MakeTriangles(&f));
    if (r->triangles.count == 0)
        return qc_statusOk;
    QC_TRY(MakeCells(&f));
    QC_TRY(DecideSteps(&f));
    return qcSureResults_Take(r, steps, stepCount, r->found.data, visible);
}

//  ---- what is left --------------------------------------------------------------------------------

/// Adds a triangle of a step; there is room.
static void AddStep(qcSureResults* r, const qcVisibilityStep* step, uint32_t number, uint32_t k, bool test, bool render)
{
    QC_AT(uint32_t, r->stepOf, r->stepOf.count++) = number;
    QC_AT(qcVisibilityStep, r->steps, r->steps.count++) = (qcVisibilityStep){step->firstTriangle + k, 1, test, render};
}

/// Adds the triangles of a step that are drawn in this way.
static void AddSteps(qcSureResults* r, const qcVisibilityStep* step, uint32_t number, const uint32_t* found,
                     qcSureFound draw)
{
    for (uint32_t k = 0; k < step->triangleCount; ++k)
        if ((found[k] & draw) != 0)
            AddStep(r, step, number, k, draw == qc_sureTest, draw == qc_sureRender);
}

/// Adds what is drawn of a step. Returns whether it is hidden.
static bool TakeStep(qcSureResults* r, const qcVisibilityStep* step, uint32_t number, const uint32_t* found)
{
    uint32_t any = 0;
    for (uint32_t k = 0; k < step->triangleCount; ++k)
        any |= found[k];
    bool isHidden = (any & qc_sureHidden) != 0;
    // A step that is hidden needs no test. One that is rendered in any case may be so where no test needs it.
    if (r->counts && (any & qc_sureTest) != 0 && !isHidden && step->render && step->triangleCount == 1)
    {
        AddStep(r, step, number, 0, true, true);
        return false;
    }
    if ((any & qc_sureTest) != 0 && !isHidden)
        AddSteps(r, step, number, found, qc_sureTest);
    if ((any & qc_sureRender) != 0)
        AddSteps(r, step, number, found, qc_sureRender);
    return isHidden;
}

qcStatus qcSureResults_Take(qcSureResults* r, const qcVisibilityStep* steps, uint32_t stepCount, const uint32_t* found,
                            uint8_t* visible)
{
    size_t room = 2 * qcSureResults_CountTriangles(steps, stepCount);
    QC_TRY(qcArray_Reserve(&r->steps, room, sizeof(qcVisibilityStep), "visibility steps"));
    QC_TRY(qcArray_Reserve(&r->stepOf, room, sizeof(uint32_t), "visibility steps"));
    r->steps.count = r->stepOf.count = 0;
    for (uint32_t s = 0; s < stepCount; ++s)
    {
        const qcVisibilityStep* step = &steps[s];
        if (!step->test && !step->render)
            continue;
        // Nothing is left of most steps.
        bool isLeft = step->triangleCount != 1 || *found != 0;
        bool isHidden = isLeft && TakeStep(r, step, s, found);
        if (step->test)
            visible[s] = !isHidden;
        found += step->triangleCount;
    }
    return qc_statusOk;
}

void qcSureResults_Free(qcSureResults* r)
{
    qcArray* arrays[] = {&r->steps, &r->stepOf, &r->triangles, &r->cellFirst, &r->entries, &r->found};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i)
        qcArray_Free(arrays[i]);
}
