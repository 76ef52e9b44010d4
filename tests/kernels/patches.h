// Patches of triangles with one boundary loop: strips that bend, fold and cross themselves, and patches that grow
// triangle by triangle, with notches, slivers and fans.
#ifndef QC_TESTS_KERNELS_PATCHES_H
#define QC_TESTS_KERNELS_PATCHES_H

#include "kernels/kernel_pairs.h"

enum
{
    qc_patchColumns = 24, ///< max squares along a strip
    qc_patchRows = 2,
    qc_patchVertices = (qc_patchColumns + 1) * (qc_patchRows + 1),
    qc_patchTriangles = 2 * qc_patchColumns * qc_patchRows
};

/// Exact corners, and as floats, wrong by at most the error.
typedef struct qcPatch
{
    double positions[qc_patchVertices][3];
    qcPoint points[qc_patchVertices];
    qcCorners corners[qc_patchTriangles];
    uint32_t vertexCount, triangleCount, loopCount;
    uint32_t slots[qc_patchTriangles], loop[qc_patchVertices];
    float pointError;
} qcPatch;

static inline uint32_t qcPatch_Vertex(uint32_t column, uint32_t row)
{
    return column * (qc_patchRows + 1) + row;
}

static inline void qcPatch_AddTriangle(qcPatch* patch, uint32_t a, uint32_t b, uint32_t c)
{
    patch->corners[patch->triangleCount] = (qcCorners){{a, b, c}};
    patch->slots[patch->triangleCount] = patch->triangleCount;
    patch->triangleCount++;
}

/// Squares in a row, each cut in two.
static inline void qcPatch_MakeStrip(qcPatch* patch, uint32_t columns)
{
    *patch = (qcPatch){.vertexCount = (columns + 1) * (qc_patchRows + 1), .pointError = 0x1p-24f};
    for (uint32_t c = 0; c < columns; c++)
        for (uint32_t r = 0; r < qc_patchRows; r++)
        {
            uint32_t corner[4] = {qcPatch_Vertex(c, r), qcPatch_Vertex(c + 1, r), qcPatch_Vertex(c + 1, r + 1),
                                  qcPatch_Vertex(c, r + 1)};
            qcPatch_AddTriangle(patch, corner[0], corner[1], corner[2]);
            qcPatch_AddTriangle(patch, corner[0], corner[2], corner[3]);
        }
    uint32_t at = 0;
    for (uint32_t c = 0; c < columns; c++)
        patch->loop[at++] = qcPatch_Vertex(c, 0);
    for (uint32_t r = 0; r < qc_patchRows; r++)
        patch->loop[at++] = qcPatch_Vertex(columns, r);
    for (uint32_t c = columns; c > 0; c--)
        patch->loop[at++] = qcPatch_Vertex(c, qc_patchRows);
    for (uint32_t r = qc_patchRows; r > 0; r--)
        patch->loop[at++] = qcPatch_Vertex(0, r);
    patch->loopCount = at;
}

/// Three perpendicular directions: any, or those of the axes.
static inline void qcMakeDirections(qcRandom* random, bool ofAxes, double direction[3][3])
{
    memset(direction, 0, 9 * sizeof(double));
    direction[0][0] = direction[1][1] = direction[2][2] = 1.0;
    while (!ofAxes)
    {
        for (int i = 0; i < 3; i++)
        {
            direction[0][i] = qcRandom_Uniform(random, -1, 1);
            direction[1][i] = qcRandom_Uniform(random, -1, 1);
        }
        qcCross(direction[0], direction[1], direction[2]);
        ofAxes = qcDot(direction[2], direction[2]) >= 0.1;
        qcCross(direction[2], direction[0], direction[1]);
        for (int k = 0; k < 3; k++)
        {
            double length = sqrt(qcDot(direction[k], direction[k]));
            for (int i = 0; i < 3; i++)
                direction[k][i] /= length;
        }
    }
}

/// Part of a ring, or more than one turn of it. `rise`: its height per turn; `noise`: max displacement of a vertex.
/// With one turn and no rise the ends coincide. It faces any direction.
static inline void qcPatch_MakeRing(qcRandom* random, uint32_t columns, double rounds, double rise, double noise,
                                    qcPatch* patch)
{
    double direction[3][3];
    qcMakeDirections(random, false, direction);
    qcPatch_MakeStrip(patch, columns);
    for (uint32_t c = 0; c <= columns; c++)
        for (uint32_t r = 0; r <= qc_patchRows; r++)
        {
            double turn = rounds * c / columns, angle = 6.283185307179586 * (turn == 1.0 ? 0.0 : turn);
            double radius = 0.3 + 0.1 * r / qc_patchRows, height = rise * turn;
            uint32_t v = qcPatch_Vertex(c, r);
            for (int i = 0; i < 3; i++)
            {
                patch->positions[v][i] = 0.5 + radius * (cos(angle) * direction[0][i] + sin(angle) * direction[1][i]) +
                                         height * direction[2][i] + qcRandom_Uniform(random, -noise, noise);
                patch->points[v].x[i] = (float)patch->positions[v][i];
            }
        }
}

/// From coordinates in a plane and above it to a random position in the unit box, scaled to `size`. Points are wrong by
/// up to `error`; large errors are rarer.
static inline void qcPatch_Place(qcPatch* patch, qcRandom* random, bool ofAxes, double size, double error)
{
    double direction[3][3], low[3] = {INFINITY, INFINITY, INFINITY}, widest = 0.0, turned[qc_patchVertices][3];
    qcMakeDirections(random, ofAxes, direction);
    for (uint32_t v = 0; v < patch->vertexCount; v++)
        for (int i = 0; i < 3; i++)
        {
            const double* x = patch->positions[v];
            turned[v][i] = x[0] * direction[0][i] + x[1] * direction[1][i] + x[2] * direction[2][i];
            low[i] = fmin(low[i], turned[v][i]);
        }
    for (uint32_t v = 0; v < patch->vertexCount; v++)
        for (int i = 0; i < 3; i++)
            widest = fmax(widest, turned[v][i] - low[i]);
    patch->pointError = error > 0.0 ? (float)error : 0x1p-24f;
    for (int i = 0; i < 3; i++)
    {
        double at = qcRandom_Uniform(random, 0.0, 1.0 - size);
        for (uint32_t v = 0; v < patch->vertexCount; v++)
        {
            double off =
                qcRandom_Below(random, 2) == 0 ? qcRandom_Uniform(random, -1.0, 1.0) : qcRandom_Integer(random, -1, 1);
            patch->points[v].x[i] = (float)(at + (turned[v][i] - low[i]) * size / widest);
            patch->positions[v][i] = (double)patch->points[v].x[i] + off * error * (1.0 - 0x1p-20);
        }
    }
}

/// The course of a strip in its plane.
typedef enum qcStripKind
{
    qc_stripStraight,
    qc_stripU, ///< there and back: the arms are near each other
    qc_stripZigzag,
    qc_stripMeander, ///< in any direction
    qc_stripKindCount
} qcStripKind;

/// A strip with steps of about 1. `notch`: max inward displacement of contour vertices, relative to the width; `noise`:
/// max displacement of any vertex; `height`: that of waves across the plane.
static inline void qcPatch_MakePath(qcRandom* random, qcStripKind kind, uint32_t columns, double notch, double noise,
                                    double height, qcPatch* patch)
{
    double width = qcRandom_Uniform(random, 0.7, 3.0), gap = width * pow(2.0, qcRandom_Uniform(random, -6.0, 1.0));
    double radius = 0.5 * (width + gap), heading = 0.0, at[2] = {0.0, 0.0}, shear = qcRandom_Uniform(random, -0.5, 0.5);
    double sharp = qcRandom_Uniform(random, 0.0, 1.5);
    uint32_t bend = (uint32_t)(3.14159265 * radius) + 2, before = columns > bend ? (columns - bend) / 2 : 0;
    shear = kind == qc_stripStraight ? shear : 0.0;
    qcPatch_MakeStrip(patch, columns);
    for (uint32_t c = 0; c <= columns; c++)
    {
        double turn = kind == qc_stripU         ? (c > before && c <= before + bend ? 3.14159265 / bend : 0.0)
                      : kind == qc_stripZigzag  ? (c % 4 == 0   ? sharp
                                                   : c % 4 == 2 ? -sharp
                                                                : 0.0)
                      : kind == qc_stripMeander ? qcRandom_Uniform(random, -sharp, sharp)
                                                : 0.0;
        double step = kind == qc_stripU && turn != 0.0 ? 3.14159265 * radius / bend : 1.0;
        heading += 0.5 * turn;
        at[0] += step * cos(heading);
        at[1] += step * sin(heading);
        heading += 0.5 * turn;
        for (uint32_t r = 0; r <= qc_patchRows; r++)
        {
            double* x = patch->positions[qcPatch_Vertex(c, r)];
            double side = (double)r / qc_patchRows - 0.5;
            if (r == 0 || r == qc_patchRows)
                side *= 1.0 - notch * qcRandom_Uniform(random, 0.0, 1.0);
            // To the right of the course.
            x[0] = at[0] - side * width * (sin(heading) + shear) + qcRandom_Uniform(random, -noise, noise);
            x[1] = at[1] + side * width * cos(heading) + qcRandom_Uniform(random, -noise, noise);
            x[2] = height * sin(0.7 * at[0] + 0.3 * at[1]) + 0.3 * qcRandom_Uniform(random, -noise, noise);
        }
    }
}

/// Triangles almost all around a vertex: a sharp notch stays open. Any radii.
static inline void qcPatch_MakeFan(qcRandom* random, uint32_t triangles, double open, double height, qcPatch* patch)
{
    *patch = (qcPatch){.vertexCount = triangles + 2, .loopCount = triangles + 2};
    double rough = qcRandom_Uniform(random, 0.0, 1.0);
    for (uint32_t v = 1; v < patch->vertexCount; v++)
    {
        double angle = (6.283185307179586 - open) * (v - 1) / triangles;
        double radius = pow(2.0, rough * qcRandom_Uniform(random, -1.0, 1.0));
        patch->positions[v][0] = radius * cos(angle);
        patch->positions[v][1] = radius * sin(angle);
        patch->positions[v][2] = height * qcRandom_Uniform(random, -1.0, 1.0);
    }
    for (uint32_t i = 0; i < triangles; i++)
        qcPatch_AddTriangle(patch, 0, i + 1, i + 2);
    for (uint32_t i = 0; i < patch->loopCount; i++)
        patch->loop[i] = i;
}

/// A row of triangles with teeth, which lean to either side: their tips are near each other.
static inline void qcPatch_MakeTeeth(qcRandom* random, uint32_t teeth, double lean, double height, qcPatch* patch)
{
    *patch = (qcPatch){.vertexCount = 3 * teeth + 1};
    // In threes: the base of a tooth, its tip, and the point below; finally the end of the last one.
    for (uint32_t v = 0; v < patch->vertexCount; v++)
    {
        double* x = patch->positions[v];
        double to = v / 3 % 2 == 0 ? lean : -lean;
        x[0] = v / 3 + (v % 3 == 0 ? 0.0 : v % 3 == 1 ? 0.5 + to * qcRandom_Uniform(random, 0.8, 1.0) : 0.5);
        x[1] = v % 3 == 0 ? 0.0 : v % 3 == 1 ? qcRandom_Uniform(random, 0.7, 1.3) : -1.0;
        x[2] = height * qcRandom_Uniform(random, -1.0, 1.0);
    }
    for (uint32_t i = 0; i < teeth; i++)
    {
        uint32_t base = 3 * i, tip = base + 1, below = base + 2, next = base + 3;
        qcPatch_AddTriangle(patch, base, next, tip);
        qcPatch_AddTriangle(patch, below, next, base);
        if (i + 1 < teeth)
            qcPatch_AddTriangle(patch, below, below + 3, next);
        patch->loop[i] = below;
        patch->loop[3 * teeth - 1 - 2 * i] = tip;
        patch->loop[3 * teeth - 2 * i] = base;
    }
    patch->loop[teeth] = 3 * teeth;
    patch->loopCount = 3 * teeth + 1;
}

/// The loop without its i-th vertex, or with one more in front of it.
static inline void qcPatch_ChangeLoop(qcPatch* patch, uint32_t i, bool add, uint32_t vertex)
{
    uint32_t* from = patch->loop + i + !add;
    memmove(patch->loop + i + add, from, (patch->loopCount - i - !add) * sizeof patch->loop[0]);
    patch->loopCount = add ? patch->loopCount + 1 : patch->loopCount - 1;
    if (add)
        patch->loop[i] = vertex;
}

/// Grows triangle by triangle: from an edge of the loop to a new vertex, or into a notch. Some are slivers. `fan`: the
/// probability that a new triangle is next to the previous one. Most triangles that would overlap others are not added.
static inline void qcPatch_MakeGrown(qcRandom* random, uint32_t triangles, double fan, double height, qcPatch* patch)
{
    *patch = (qcPatch){.vertexCount = 3, .loopCount = 3, .loop = {0, 1, 2}};
    patch->positions[1][0] = 1.0;
    patch->positions[2][0] = qcRandom_Uniform(random, -0.5, 1.5);
    patch->positions[2][1] = qcRandom_Uniform(random, 0.2, 1.0);
    qcPatch_AddTriangle(patch, 0, 1, 2);
    for (uint32_t tries = 0, last = 0; patch->triangleCount < triangles && tries < 20 * triangles; tries++)
    {
        uint32_t n = patch->loopCount,
                 i = qcRandom_Uniform(random, 0.0, 1.0) < fan ? last % n : qcRandom_Below(random, n);
        uint32_t from = patch->loop[i], to = patch->loop[(i + 1) % n], after = patch->loop[(i + 2) % n];
        const double *p = patch->positions[from], *q = patch->positions[to], *r = patch->positions[after];
        double along[2] = {q[0] - p[0], q[1] - p[1]}, next[2] = {r[0] - q[0], r[1] - q[1]};
        if (n > 3 && along[0] * next[1] - along[1] * next[0] < 0.0 && qcRandom_Below(random, 3) == 0)
        {
            qcPatch_AddTriangle(patch, from, after, to);
            qcPatch_ChangeLoop(patch, (i + 1) % n, false, 0);
            last = 0;
            continue;
        }
        double high = pow(2.0, qcRandom_Uniform(random, -4.0, 0.7)), at = qcRandom_Uniform(random, -0.7, 1.7);
        double apex[2] = {p[0] + at * along[0] + high * along[1], p[1] + at * along[1] - high * along[0]};
        bool covered = false;
        for (uint32_t t = 0; t < patch->triangleCount; t++)
        {
            bool inside = true;
            for (int c = 0; c < 3; c++)
            {
                const double *a = patch->positions[patch->corners[t].vertex[c]],
                             *b = patch->positions[patch->corners[t].vertex[(c + 1) % 3]];
                inside = inside && (b[0] - a[0]) * (apex[1] - a[1]) - (b[1] - a[1]) * (apex[0] - a[0]) > 0.0;
            }
            covered = covered || inside;
        }
        if (covered)
            continue;
        uint32_t v = patch->vertexCount++;
        patch->positions[v][0] = apex[0];
        patch->positions[v][1] = apex[1];
        qcPatch_AddTriangle(patch, to, from, v);
        qcPatch_ChangeLoop(patch, i + 1, true, v);
        last = i + 1;
    }
    for (uint32_t v = 0; v < patch->vertexCount; v++)
        patch->positions[v][2] = qcRandom_Uniform(random, -height, height);
}

#endif
