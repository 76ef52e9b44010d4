// A grid of cells around a mesh. Cells are marked where other bodies may come; triangles that meet no marked cell can
// be left out. Positions outside the grid belong to the cells at its border, so that overlap in space means a common
// cell.
#ifndef QC_MESH_REGION_CELLS_H
#define QC_MESH_REGION_CELLS_H

#include "base/four_floats.h"

#include <stdbool.h>
#include <stdint.h>

enum
{
    qc_cellsAlong = 16 ///< the longest axis
};

typedef struct qcRegionCells
{
    double lower[3], scale;                      ///< a position's cell: (x - lower) * scale, clamped
    uint16_t rows[qc_cellsAlong][qc_cellsAlong]; ///< by z and y: bit x is set where the cell is marked
} qcRegionCells;

/// A grid around a box without a marked cell. False: the box has no extent, or numbers too large or too small for
/// single precision.
bool qcRegionCells_Begin(qcRegionCells* cells, const double lower[3], const double upper[3]);
/// The length of a cell's edges.
double qcRegionCells_Size(const qcRegionCells* cells);
/// Marks the cells within `reach` of a box.
void qcRegionCells_Mark(qcRegionCells* cells, const double lower[3], const double upper[3], double reach);
/// Whether all cells within `reach` of a box are marked. Positions that were mapped in single precision count as well.
bool qcRegionCells_AreMarked(const qcRegionCells* cells, const double lower[3], const double upper[3], double reach);

/// Whether a box meets a marked cell. Its corners are given in cells; the fourth coordinates are not used.
static inline bool qcRegionCells_Meet(const qcRegionCells* cells, qcFourFloats lower, qcFourFloats upper)
{
    const qcFourFloats zero = {0.0f, 0.0f, 0.0f, 0.0f}, last = zero + (float)(qc_cellsAlong - 1);
    typedef int32_t FourInts __attribute__((vector_size(16)));
    // Without a sign, so that no index is extended: this test takes a tenth of a first step.
    const qcFourWords first = (qcFourWords) __builtin_convertvector(
                          qcFourFloats_Min(qcFourFloats_Max(lower, zero), last), FourInts),
                      end = (qcFourWords) __builtin_convertvector(qcFourFloats_Min(qcFourFloats_Max(upper, zero), last),
                                                                  FourInts);
    const uint16_t *near = cells->rows[first[2]], *far = cells->rows[end[2]];
    // Most triangles are shorter than a cell. For these no branch depends on where they lie.
    uint32_t met = near[first[1]] | near[end[1]] | far[first[1]] | far[end[1]];
    if (end[1] - first[1] > 1 || end[2] - first[2] > 1)
        for (uint32_t z = first[2]; z <= end[2]; z++)
            for (uint32_t y = first[1]; y <= end[1]; y++)
                met |= cells->rows[z][y];
    return (met & ((2u << end[0]) - (1u << first[0]))) != 0;
}

#endif
