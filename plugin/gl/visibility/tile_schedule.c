// Bins the triangles of a pass into tiles, then gives each step of a tile the earliest level that keeps its result. A
// level is a batch: all its tests, then all its renders, counted tests among them. Pixel boxes stand for triangles,
// which is conservative.
#include "gl/visibility/tile_schedule.h"

#include "base/status.h"

#include <string.h>

enum
{
    // Pixels on a side of the smallest cells by which overlaps of steps are found: about the size of a triangle when
    // 20 000 of them fill an image of 1024 pixels.
    qc_minCellSize = 8,
    // Cells on a side of a tile at most, so that a step as large as the image stays cheap.
    qc_maxCells = 256
};

/// Pixels that fragments of a triangle may cover, both ends included.
typedef struct PixelBox
{
    uint16_t x0, y0, x1, y1;
} PixelBox;

/// A triangle in a tile.
typedef struct Entry
{
    uint32_t step, triangle;
    PixelBox box;
} Entry;

/// A step in a tile.
typedef struct Run
{
    uint32_t step, triangleCount, level;
    size_t firstEntry;
} Run;

typedef struct CellBox
{
    uint32_t x0, y0, x1, y1;
} CellBox;

/// What a run does in its level, in this order. Within a level renders are drawn in step order.
typedef enum Part
{
    qc_partTest,
    qc_partTestThenRender,
    qc_partRender ///< counted or not
} Part;

/// The pass that is scheduled.
typedef struct Pass
{
    const qcScheduleView* view;
    const qcVisibilityStep* steps;
    uint32_t stepCount;
    uint32_t tilesPerSide;
    bool hasLevels; ///< some tests are not counted
} Pass;

/// Whether a step is tested by counting the fragments that pass as it is rendered.
static bool IsCounted(const qcScheduleView* view, const qcVisibilityStep* step)
{
    return view->counts && step->test && step->render && step->triangleCount == 1;
}

/// The pixel that contains a coordinate in pixels, clamped to the image; NaN gives 0.
static uint16_t ClampPixel(float pixel, uint32_t resolution)
{
    if (!(pixel > 0.0f))
        return 0;
    return (uint16_t)(pixel < (float)resolution ? (uint32_t)pixel : resolution - 1);
}

static PixelBox FindBox(const qcScheduleView* view, uint32_t triangle)
{
    const float* corner = view->corners + (size_t)9 * triangle;
    int x = (view->axis + 1) % 3, y = (view->axis + 2) % 3;
    float lower[2] = {corner[x], corner[y]}, upper[2] = {corner[x], corner[y]};
    for (int i = 1; i < 3; ++i)
    {
        const float point[2] = {corner[3 * i + x], corner[3 * i + y]};
        for (int k = 0; k < 2; ++k)
        {
            lower[k] = point[k] < lower[k] ? point[k] : lower[k];
            upper[k] = point[k] > upper[k] ? point[k] : upper[k];
        }
    }
    // One pixel wider: rasterisers round corners to a grid of about 1/256 pixel.
    float half = 0.5f * (float)view->resolution, dilationX = view->dilation[0] + 1.0f,
          dilationY = view->dilation[1] + 1.0f;
    return (PixelBox){ClampPixel((lower[0] + 1.0f) * half - dilationX, view->resolution),
                      ClampPixel((lower[1] + 1.0f) * half - dilationY, view->resolution),
                      ClampPixel((upper[0] + 1.0f) * half + dilationX, view->resolution),
                      ClampPixel((upper[1] + 1.0f) * half + dilationY, view->resolution)};
}

/// Counts a triangle in each tile that its box touches or, if `entries` isn't null, adds it to each of these tiles.
/// Counts are written at tileFirst[tile + 2]; their sums become the begins at tileFirst[tile + 1], and adding the
/// entries turns these into ends, in place.
static void BinTriangle(const Pass* pass, size_t* tileFirst, Entry* entries, uint32_t step, uint32_t triangle)
{
    uint32_t tileSize = pass->view->tileSize;
    PixelBox box = FindBox(pass->view, triangle);
    for (uint32_t ty = box.y0 / tileSize; ty <= box.y1 / tileSize; ++ty)
    {
        for (uint32_t tx = box.x0 / tileSize; tx <= box.x1 / tileSize; ++tx)
        {
            size_t tile = (size_t)ty * pass->tilesPerSide + tx;
            if (entries == NULL)
                ++tileFirst[tile + 2];
            else
                entries[tileFirst[tile + 1]++] = (Entry){step, triangle, box};
        }
    }
}

static void BinSteps(const Pass* pass, size_t* tileFirst, Entry* entries)
{
    for (uint32_t i = 0; i < pass->stepCount; ++i)
    {
        const qcVisibilityStep* step = &pass->steps[i];
        for (uint32_t k = 0; (step->test || step->render) && k < step->triangleCount; ++k)
            BinTriangle(pass, tileFirst, entries, i, step->firstTriangle + k);
    }
}

/// Sorts entries by tile, in step order within a tile. Entries of tile i are tileFirst[i] .. tileFirst[i + 1].
static qcStatus BinTriangles(qcTileSchedule* s, const Pass* pass)
{
    size_t tileCount = (size_t)pass->tilesPerSide * pass->tilesPerSide;
    QC_TRY(qcArray_Resize(&s->tileFirst, tileCount + 2, sizeof(size_t), "tiles"));
    size_t* tileFirst = s->tileFirst.data;
    memset(tileFirst, 0, (tileCount + 2) * sizeof(size_t));
    BinSteps(pass, tileFirst, NULL);
    for (size_t tile = 1; tile < tileCount + 2; ++tile)
        tileFirst[tile] += tileFirst[tile - 1];
    QC_TRY(qcArray_Resize(&s->entries, tileFirst[tileCount + 1], sizeof(Entry), "triangles in tiles"));
    if (s->entries.count != 0)
        BinSteps(pass, tileFirst, s->entries.data);
    return qc_statusOk;
}

/// The cells of a tile that a box touches.
static CellBox FindCells(PixelBox box, const qcScheduleTile* tile, uint32_t tileSize, uint32_t cellSize)
{
    uint32_t x1 = box.x1 - tile->x, y1 = box.y1 - tile->y;
    return (CellBox){(box.x0 > tile->x ? box.x0 - tile->x : 0) / cellSize,
                     (box.y0 > tile->y ? box.y0 - tile->y : 0) / cellSize,
                     (x1 < tileSize ? x1 : tileSize - 1) / cellSize, (y1 < tileSize ? y1 : tileSize - 1) / cellSize};
}

static PixelBox JoinBoxes(PixelBox a, PixelBox b)
{
    return (PixelBox){a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0, a.x1 > b.x1 ? a.x1 : b.x1,
                      a.y1 > b.y1 ? a.y1 : b.y1};
}

/// The cells of a tile, and the levels of the steps that touched each so far.
typedef struct Cells
{
    uint32_t size, perSide; ///< pixels on a side of a cell; cells on a side of the tile
    uint32_t* afterRenders; ///< first level whose tests see every render so far
    uint32_t* lastTest;     ///< last level that tests
} Cells;

static uint32_t FindMaxLevel(const Cells* cells, const uint32_t* levels, CellBox box)
{
    uint32_t max = 0;
    for (uint32_t y = box.y0; y <= box.y1; ++y)
    {
        const uint32_t* row = levels + (size_t)y * cells->perSide;
        for (uint32_t x = box.x0; x <= box.x1; ++x)
            max = row[x] > max ? row[x] : max;
    }
    return max;
}

static void RaiseLevels(const Cells* cells, uint32_t* levels, CellBox box, uint32_t level)
{
    for (uint32_t y = box.y0; y <= box.y1; ++y)
    {
        uint32_t* row = levels + (size_t)y * cells->perSide;
        for (uint32_t x = box.x0; x <= box.x1; ++x)
            row[x] = row[x] > level ? row[x] : level;
    }
}

/// Returns the first level of a step at which its tests see all earlier renders, and no earlier test sees its renders.
/// Updates the cells.
static uint32_t TakeLevel(const Cells* cells, CellBox box, const qcVisibilityStep* step, bool isCounted)
{
    uint32_t level = 0;
    // A counted test sees the renders before it in its own level, too.
    if (step->test)
        level = FindMaxLevel(cells, cells->afterRenders, box);
    if (isCounted && level > 0)
        --level;
    // Within a level renders come after tests, and after the counted tests before them.
    if (step->render)
    {
        uint32_t lastTest = FindMaxLevel(cells, cells->lastTest, box);
        level = lastTest > level ? lastTest : level;
        RaiseLevels(cells, cells->afterRenders, box, level + 1);
    }
    if (step->test)
        RaiseLevels(cells, cells->lastTest, box, level);
    return level;
}

/// Half the mean side of the boxes of entries, within the tile: larger cells are quicker, smaller ones find fewer
/// overlaps.
static uint32_t ChooseCellSize(const Entry* entries, size_t count, uint32_t tileSize)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < count; ++i)
    {
        uint32_t width = (uint32_t)(entries[i].box.x1 - entries[i].box.x0) + 1u,
                 height = (uint32_t)(entries[i].box.y1 - entries[i].box.y0) + 1u;
        sum += (width < tileSize ? width : tileSize) + (height < tileSize ? height : tileSize);
    }
    uint32_t size = (uint32_t)(sum / (4 * count)), min = (tileSize + qc_maxCells - 1) / qc_maxCells;
    size = size > min ? size : min;
    return size > qc_minCellSize ? size : qc_minCellSize;
}

/// Clears the cells of a tile.
static qcStatus MakeCells(qcTileSchedule* s, uint32_t tileSize, uint32_t cellSize, Cells* cells)
{
    cells->size = cellSize;
    cells->perSide = (tileSize + cellSize - 1) / cellSize;
    size_t count = (size_t)cells->perSide * cells->perSide;
    QC_TRY(qcArray_Resize(&s->cells, 2 * count, sizeof(uint32_t), "cells of a tile"));
    memset(s->cells.data, 0, 2 * count * sizeof(uint32_t));
    cells->afterRenders = s->cells.data;
    cells->lastTest = cells->afterRenders + count;
    return qc_statusOk;
}

/// Finds the runs of a tile, each with its level, from the tile's entries.
static qcStatus FindRuns(qcTileSchedule* s, const Pass* pass, const qcScheduleTile* tile, const size_t entryRange[2],
                         uint32_t* levelCount)
{
    const Entry* entries = s->entries.data;
    size_t entryCount = entryRange[1] - entryRange[0];
    uint32_t tileSize = pass->view->tileSize;
    Cells cells = {0};
    if (pass->hasLevels)
        QC_TRY(MakeCells(s, tileSize, ChooseCellSize(entries + entryRange[0], entryCount, tileSize), &cells));
    QC_TRY(qcArray_Reserve(&s->runs, entryCount, sizeof(Run), "runs of a tile"));
    s->runs.count = 0;
    *levelCount = 0;
    for (size_t i = entryRange[0], end; i < entryRange[1]; i = end)
    {
        PixelBox box = entries[i].box;
        for (end = i + 1; end < entryRange[1] && entries[end].step == entries[i].step; ++end)
            box = JoinBoxes(box, entries[end].box);
        const qcVisibilityStep* step = &pass->steps[entries[i].step];
        uint32_t level = 0;
        if (pass->hasLevels)
            level = TakeLevel(&cells, FindCells(box, tile, tileSize, cells.size), step, IsCounted(pass->view, step));
        if (level + 1 > *levelCount)
            *levelCount = level + 1;
        QC_AT(Run, s->runs, s->runs.count++) = (Run){entries[i].step, (uint32_t)(end - i), level, i};
    }
    return qc_statusOk;
}

static size_t SortKey(const Pass* pass, const Run* run)
{
    const qcVisibilityStep* step = &pass->steps[run->step];
    bool tests = step->test && !IsCounted(pass->view, step);
    return (size_t)3 * run->level + (step->render ? (tests ? qc_partTestThenRender : qc_partRender) : qc_partTest);
}

/// Counting sort of the runs by level.
static qcStatus SortRuns(qcTileSchedule* s, const Pass* pass, uint32_t levelCount)
{
    size_t keyCount = (size_t)3 * levelCount + 1;
    QC_TRY(qcArray_Resize(&s->keys, keyCount, sizeof(size_t), "levels of a tile"));
    QC_TRY(qcArray_Resize(&s->order, s->runs.count, sizeof(Run), "runs of a tile"));
    size_t* keys = s->keys.data;
    memset(keys, 0, keyCount * sizeof(size_t));
    const Run* runs = s->runs.data;
    for (size_t i = 0; i < s->runs.count; ++i)
        ++keys[SortKey(pass, &runs[i]) + 1];
    for (size_t i = 1; i < keyCount; ++i)
        keys[i] += keys[i - 1];
    for (size_t i = 0; i < s->runs.count; ++i)
        QC_AT(Run, s->order, keys[SortKey(pass, &runs[i])]++) = runs[i];
    return qc_statusOk;
}

/// Writes the fan of a triangle's polygon. Returns the end of the indices.
static uint32_t* WriteFan(uint32_t* indices, uint32_t triangle, uint32_t polygonCorners)
{
    uint32_t first = triangle * polygonCorners;
    for (uint32_t c = 2; c < polygonCorners; ++c)
    {
        *indices++ = first;
        *indices++ = first + c - 1;
        *indices++ = first + c;
    }
    return indices;
}

/// Adds a run to its batch; its polygons begin here.
static void AddRun(qcTileSchedule* s, const Pass* pass, const Run* run, size_t polygon, qcScheduleBatch* batch)
{
    const qcVisibilityStep* step = &pass->steps[run->step];
    if (step->test && !IsCounted(pass->view, step))
    {
        QC_AT(qcScheduleTest, s->tests, s->tests.count++) = (qcScheduleTest){run->step, run->triangleCount, polygon};
        ++batch->testCount;
        batch->testedCount += run->triangleCount;
    }
    if (step->render)
    {
        if (batch->polygonCount == 0)
            batch->firstPolygon = polygon;
        batch->polygonCount += run->triangleCount;
    }
}

/// Writes the sorted runs as indices, tests and batches. The arrays have room.
static void WriteBatches(qcTileSchedule* s, const Pass* pass, qcScheduleTile* tile)
{
    const Run* runs = s->order.data;
    const Entry* entries = s->entries.data;
    size_t polygon = s->polygons.count;
    uint32_t* index = &QC_AT(uint32_t, s->indices, s->indices.count);
    qcScheduleBatch* batch = NULL;
    for (size_t i = 0; i < s->order.count; ++i)
    {
        const Run* run = &runs[i];
        if (batch == NULL || run->level != runs[i - 1].level)
        {
            batch = &QC_AT(qcScheduleBatch, s->batches, s->batches.count++);
            *batch = (qcScheduleBatch){s->tests.count, 0, polygon, 0, polygon, 0};
        }
        AddRun(s, pass, run, polygon, batch);
        uint32_t isCounted = IsCounted(pass->view, &pass->steps[run->step]);
        tile->countedCount += isCounted != 0 ? run->triangleCount : 0;
        for (uint32_t k = 0; k < run->triangleCount; ++k)
        {
            uint32_t triangle = entries[run->firstEntry + k].triangle;
            index = WriteFan(index, triangle, pass->view->polygonCorners);
            QC_AT(qcSchedulePolygon, s->polygons, polygon++) = (qcSchedulePolygon){triangle, run->step, isCounted};
        }
    }
    tile->polygonCount = polygon - tile->firstPolygon;
    s->polygons.count = polygon;
    s->indices.count = (size_t)(index - (uint32_t*)s->indices.data);
    tile->batchCount = s->batches.count - tile->firstBatch;
    tile->testCount = s->tests.count - tile->firstTest;
}

static qcStatus AddTile(qcTileSchedule* s, const Pass* pass, uint32_t tx, uint32_t ty, const size_t entryRange[2])
{
    qcScheduleTile tile = {.x = tx * pass->view->tileSize,
                           .y = ty * pass->view->tileSize,
                           .firstBatch = s->batches.count,
                           .firstTest = s->tests.count,
                           .firstPolygon = s->polygons.count};
    uint32_t levelCount = 0;
    QC_TRY(FindRuns(s, pass, &tile, entryRange, &levelCount));
    QC_TRY(SortRuns(s, pass, levelCount));
    QC_TRY(qcArray_Reserve(&s->tests, s->tests.count + s->runs.count, sizeof(qcScheduleTest), "visibility tests"));
    QC_TRY(qcArray_Reserve(&s->batches, s->batches.count + levelCount, sizeof(qcScheduleBatch), "visibility batches"));
    QC_TRY(qcArray_Reserve(&s->tiles, s->tiles.count + 1, sizeof(qcScheduleTile), "visibility tiles"));
    WriteBatches(s, pass, &tile);
    QC_AT(qcScheduleTile, s->tiles, s->tiles.count++) = tile;
    return qc_statusOk;
}

qcStatus qcTileSchedule_Build(qcTileSchedule* s, const qcScheduleView* view, const qcVisibilityStep* steps,
                              uint32_t stepCount)
{
    Pass pass = {view, steps, stepCount, (view->resolution + view->tileSize - 1) / view->tileSize, false};
    for (uint32_t i = 0; i < stepCount && !pass.hasLevels; ++i)
        pass.hasLevels = steps[i].test && !IsCounted(view, &steps[i]);
    s->indices.count = s->polygons.count = s->tests.count = s->batches.count = s->tiles.count = 0;
    QC_TRY(BinTriangles(s, &pass));
    size_t indexCount = qcTileSchedule_GetIndexCount(view->polygonCorners);
    QC_TRY(qcArray_Reserve(&s->indices, indexCount * s->entries.count, sizeof(uint32_t), "visibility indices"));
    QC_TRY(qcArray_Reserve(&s->polygons, s->entries.count, sizeof(qcSchedulePolygon), "visibility polygons"));
    const size_t* tileFirst = s->tileFirst.data;
    for (uint32_t ty = 0; ty < pass.tilesPerSide; ++ty)
    {
        for (uint32_t tx = 0; tx < pass.tilesPerSide; ++tx)
        {
            const size_t* range = &tileFirst[(size_t)ty * pass.tilesPerSide + tx];
            if (range[0] < range[1])
                QC_TRY(AddTile(s, &pass, tx, ty, range));
        }
    }
    return qc_statusOk;
}

void qcTileSchedule_Free(qcTileSchedule* s)
{
    qcArray* arrays[] = {&s->indices, &s->polygons, &s->tests, &s->batches, &s->tiles, &s->tileFirst,
                         &s->entries, &s->runs,     &s->order, &s->keys,    &s->cells};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i)
        qcArray_Free(arrays[i]);
}
