// Both maps, from doubles here and from floats in the cluster order, are monotone up to rounding.
#include "mesh/region_cells.h"

#include <math.h>

// Products and quotients of numbers between these stay far from the limits of single precision.
static const double s_maxCoordinate = 0x1p100, s_minExtent = 0x1p-100;

// Cells: far more than a coordinate's error in single precision, which is below 2^-18.
static const double s_error = 0x1p-10;

bool qcRegionCells_Begin(qcRegionCells* cells, const double lower[3], const double upper[3])
{
    double extent = 0.0;
    *cells = (qcRegionCells){.scale = 0.0};
    for (int axis = 0; axis < 3; axis++)
    {
        if (!(fabs(lower[axis]) < s_maxCoordinate && fabs(upper[axis]) < s_maxCoordinate))
            return false;
        cells->lower[axis] = lower[axis];
        extent = fmax(extent, upper[axis] - lower[axis]);
    }
    cells->scale = (double)qc_cellsAlong / extent;
    return extent > s_minExtent;
}

double qcRegionCells_Size(const qcRegionCells* cells)
{
    return 1.0 / cells->scale;
}

/// Cells first[k] .. last[k] along each axis.
typedef struct CellRange
{
    uint32_t first[3], last[3];
} CellRange;

static uint32_t CellAt(double at)
{
    return at > 0.0 ? (uint32_t)fmin(at, qc_cellsAlong - 1) : 0;
}

static CellRange RangeOf(const qcRegionCells* cells, const double lower[3], const double upper[3], double reach)
{
    CellRange range;
    for (int axis = 0; axis < 3; axis++)
    {
        range.first[axis] = CellAt((lower[axis] - reach - cells->lower[axis]) * cells->scale - s_error);
        range.last[axis] = CellAt((upper[axis] + reach - cells->lower[axis]) * cells->scale + s_error);
    }
    return range;
}

static uint32_t RowOf(const CellRange* range)
{
    return (2u << range->last[0]) - (1u << range->first[0]);
}

void qcRegionCells_Mark(qcRegionCells* cells, const double lower[3], const double upper[3], double reach)
{
    const CellRange range = RangeOf(cells, lower, upper, reach);
    for (uint32_t z = range.first[2]; z <= range.last[2]; z++)
        for (uint32_t y = range.first[1]; y <= range.last[1]; y++)
            cells->rows[z][y] = (uint16_t)(cells->rows[z][y] | RowOf(&range));
}

bool qcRegionCells_AreMarked(const qcRegionCells* cells, const double lower[3], const double upper[3], double reach)
{
    const CellRange range = RangeOf(cells, lower, upper, reach);
    uint32_t missing = 0;
    for (uint32_t z = range.first[2]; z <= range.last[2]; z++)
        for (uint32_t y = range.first[1]; y <= range.last[1]; y++)
            missing |= RowOf(&range) & ~(uint32_t)cells->rows[z][y];
    return missing == 0;
}
