// Voronoi cells of a cube as closed soups that lie side by side: the bisectors with the other sites cut each from the
// cube. Convex polyhedra cut by planes: Sutherland, Hodgman: Reentrant polygon clipping, 1974, face by
// face.
#ifndef QC_TESTS_MANIFOLD_SOLID_CELLS_H
#define QC_TESTS_MANIFOLD_SOLID_CELLS_H

#include "manifold/manifold_scenes.h"

enum
{
    qc_maxCells = 24,
    qc_maxFaces = 40, ///< of a cell
    qc_maxFaceCorners = 40
};

typedef struct qcCellFace
{
    double corner[qc_maxFaceCorners][3];
    int count;
    int neighbour; ///< the cell beyond it, or -1 - number of the cube's face
} qcCellFace;

typedef struct qcCell
{
    qcCellFace face[qc_maxFaces];
    int count;
} qcCell;

typedef struct qcCells
{
    double site[qc_maxCells][3];
    qcCell* cell; ///< `count`
    int count;
} qcCells;

/// The unit cube.
static inline void qcCell_MakeCube(qcCell* cell)
{
    // Around each face: the other two axes, there and back.
    static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    cell->count = 6;
    for (int f = 0; f < 6; f++)
    {
        qcCellFace* face = &cell->face[f];
        face->count = 4;
        face->neighbour = -1 - f;
        for (int c = 0; c < 4; c++)
        {
            face->corner[c][f / 2] = f % 2;
            face->corner[c][(f / 2 + 1) % 3] = square[f % 2 ? c : 3 - c][0];
            face->corner[c][(f / 2 + 2) % 3] = square[f % 2 ? c : 3 - c][1];
        }
    }
}

/// Corners beyond the plane by less lie in it.
#define QC_CELL_ROUNDING 1e-12

static inline void qcCellFace_Add(qcCellFace* face, const double corner[3])
{
    for (int i = 0; i < face->count; i++)
        if (qcDistance3(face->corner[i], corner) < 1e3 * QC_CELL_ROUNDING)
            return;
    ck_assert_int_lt(face->count, qc_maxFaceCorners);
    memcpy(face->corner[face->count++], corner, 3 * sizeof(double));
}

/// Keeps the part below the plane.
static inline void qcCellFace_Clip(qcCellFace* face, const double normal[3], double offset)
{
    qcCellFace old = *face;
    face->count = 0;
    for (int c = 0; c < old.count; c++)
    {
        const double *p = old.corner[c], *q = old.corner[(c + 1) % old.count];
        double x = qcDot3(normal, p) - offset, y = qcDot3(normal, q) - offset, between[3];
        if (x <= QC_CELL_ROUNDING)
            qcCellFace_Add(face, p);
        if (fabs(x) <= QC_CELL_ROUNDING || fabs(y) <= QC_CELL_ROUNDING || (x < 0) == (y < 0))
            continue;
        for (int axis = 0; axis < 3; axis++)
            between[axis] = p[axis] + x / (x - y) * (q[axis] - p[axis]);
        qcCellFace_Add(face, between);
    }
}

/// Puts the corners of a convex face in order around their mean, counter-clockwise as seen from the tip of the normal.
static inline void qcCellFace_Order(qcCellFace* face, const double normal[3])
{
    double mean[3] = {0, 0, 0}, angle[qc_maxFaceCorners], u[3] = {0, 0, 0}, v[3];
    for (int c = 0; c < face->count; c++)
        for (int axis = 0; axis < 3; axis++)
            mean[axis] += face->corner[c][axis] / face->count;
    for (int axis = 0; axis < 3; axis++)
        u[axis] = face->corner[0][axis] - mean[axis];
    for (int axis = 0; axis < 3; axis++)
        v[axis] = normal[(axis + 1) % 3] * u[(axis + 2) % 3] - normal[(axis + 2) % 3] * u[(axis + 1) % 3];
    for (int c = 0; c < face->count; c++)
    {
        double d[3], p[3], a;
        memcpy(p, face->corner[c], sizeof p);
        for (int axis = 0; axis < 3; axis++)
            d[axis] = p[axis] - mean[axis];
        a = atan2(qcDot3(d, v), qcDot3(d, u));
        int at = c;
        for (; at > 0 && angle[at - 1] > a; at--)
        {
            angle[at] = angle[at - 1];
            memcpy(face->corner[at], face->corner[at - 1], sizeof p);
        }
        angle[at] = a;
        memcpy(face->corner[at], p, sizeof p);
    }
}

/// Keeps the part below the plane, and closes the cut.
static inline void qcCell_Clip(qcCell* cell, const double normal[3], double offset, int neighbour)
{
    qcCellFace cap = {.neighbour = neighbour};
    int kept = 0;
    for (int f = 0; f < cell->count; f++)
    {
        qcCellFace* face = &cell->face[f];
        qcCellFace_Clip(face, normal, offset);
        int inside = 0;
        for (int c = 0; c < face->count; c++)
        {
            if (fabs(qcDot3(normal, face->corner[c]) - offset) <= 4.0 * QC_CELL_ROUNDING)
                qcCellFace_Add(&cap, face->corner[c]);
            else
                inside++;
        }
        if (inside > 0 && face->count >= 3)
            cell->face[kept++] = *face;
    }
    cell->count = kept;
    if (cap.count < 3)
        return;
    qcCellFace_Order(&cap, normal);
    ck_assert_int_lt(cell->count, qc_maxFaces);
    cell->face[cell->count++] = cap;
}

/// The bisector of two sites: its points have normal . x == offset; the normal points from site i to j.
static inline double qcCells_Bisector(const qcCells* cells, int i, int j, double normal[3])
{
    const double *a = cells->site[i], *b = cells->site[j];
    double length = qcDistance3(a, b), offset = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        normal[axis] = (b[axis] - a[axis]) / length;
        offset += normal[axis] * 0.5 * (a[axis] + b[axis]);
    }
    return offset;
}

/// Gives corners of several cells that differ by rounding one position.
static inline void qcCells_Weld(qcCells* cells)
{
    double(*known)[3] = malloc(sizeof(double[3]) * qc_maxCells * qc_maxFaces * qc_maxFaceCorners);
    size_t count = 0;
    for (int i = 0; i < cells->count; i++)
        for (int f = 0; f < cells->cell[i].count; f++)
            for (int c = 0; c < cells->cell[i].face[f].count; c++)
            {
                double* corner = cells->cell[i].face[f].corner[c];
                size_t k = 0;
                while (k < count && qcDistance3(known[k], corner) > 1e-8)
                    k++;
                if (k == count)
                    memcpy(known[count++], corner, sizeof known[0]);
                memcpy(corner, known[k], sizeof known[0]);
            }
    free(known);
}

static inline qcCells qcCells_Make(uint64_t seed, int count)
{
    qcRandom random = {seed};
    qcCells cells = {.cell = malloc(sizeof(qcCell) * (size_t)count), .count = count};
    ck_assert(cells.cell != NULL && count <= qc_maxCells);
    for (int i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            cells.site[i][axis] = qcRandom_Uniform(&random, 0.0, 1.0);
    for (int i = 0; i < count; i++)
    {
        qcCell_MakeCube(&cells.cell[i]);
        for (int j = 0; j < count; j++)
        {
            double normal[3];
            if (j == i)
                continue;
            double offset = qcCells_Bisector(&cells, i, j, normal);
            qcCell_Clip(&cells.cell[i], normal, offset, j);
        }
    }
    qcCells_Weld(&cells);
    return cells;
}

static inline void qcCells_Free(qcCells* cells)
{
    free(cells->cell);
}

/// Triangulates each face as a fan from a random corner: the two sides of a cut have different triangles.
static inline qcSoup qcCell_Soup(const qcCell* cell, qcRandom* random)
{
    uint32_t triangles = 0, at = 0;
    for (int f = 0; f < cell->count; f++)
        triangles += (uint32_t)cell->face[f].count - 2;
    qcSoup soup = qcMakeEmptySoup(3 * triangles, triangles);
    for (int f = 0; f < cell->count; f++)
    {
        const qcCellFace* face = &cell->face[f];
        int first = (int)qcRandom_Below(random, (uint32_t)face->count);
        for (int c = 1; c + 1 < face->count; c++)
            for (int k = 0; k < 3; k++)
            {
                int corner = k == 0 ? first : (first + c + k - 1) % face->count;
                memcpy(soup.positions + 3 * (size_t)at, face->corner[corner], sizeof face->corner[0]);
                soup.indices[at] = at;
                at++;
            }
    }
    return soup;
}

#endif
