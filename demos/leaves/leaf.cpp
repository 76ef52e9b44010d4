// A leaf is made of rows across the midrib, which bend towards the tip as veins do.
#include "leaves/leaf.h"

#include <array>
#include <cmath>

namespace
{
struct Row
{
    btScalar along; ///< place on the midrib; 0: the blade's base, 1: its tip; the stalk is below 0, its beginning at -1
    btScalar width; ///< share of the largest half width
    int half;       ///< vertices on each side of the midrib
};

constexpr btScalar s_stalkWidth = btScalar(0.065); // share of the blade's

const std::array<Row, 13> s_rows = {{{-1, s_stalkWidth, 1},
                                     {btScalar(-0.05), s_stalkWidth, 1},
                                     {btScalar(0.04), btScalar(0.50), 2},
                                     {btScalar(0.13), btScalar(0.82), 3},
                                     {btScalar(0.23), btScalar(0.97), 3},
                                     {btScalar(0.33), 1, 3},
                                     {btScalar(0.43), btScalar(0.95), 3},
                                     {btScalar(0.53), btScalar(0.84), 3},
                                     {btScalar(0.63), btScalar(0.69), 3},
                                     {btScalar(0.72), btScalar(0.52), 3},
                                     {btScalar(0.81), btScalar(0.34), 2},
                                     {btScalar(0.90), btScalar(0.17), 1},
                                     {1, 0, 0}}};

/// `side`: -1..1 from edge to edge.
btVector3 Place(const qcLeafForm& form, const Row& row, btScalar side)
{
    btScalar across = side * row.width * form.halfWidth;
    if (row.along < 0)
        return {form.stalk * (1 + row.along), btFabs(across) * form.fold, across};
    btScalar x = row.along * form.length + btFabs(across) * btScalar(0.35);
    btScalar u = btMin(row.along, btScalar(1));
    btScalar wave = form.wave * side * side * std::sin(btScalar(14) * row.along + btScalar(1.5) * side);
    return {form.stalk + x, btFabs(across) * form.fold - form.droop * form.length * u * u + wave, across};
}

/// Triangles between one half of two rows: the midrib's vertices and `a` and `b` further ones with indices `step`
/// apart.
void Join(int midA, int a, int midB, int b, int step, std::vector<int>* indices)
{
    for (int i = 0, j = 0; i < a || j < b;)
    {
        // The shorter diagonal: vertices of a row are spread evenly.
        bool advancesA = j == b || (i < a && (i + 1) * b <= (j + 1) * a);
        int next = advancesA ? midA + step * (i + 1) : midB + step * (j + 1);
        int p = midA + step * i, q = midB + step * j;
        if (step > 0)
            indices->insert(indices->end(), {p, next, q});
        else
            indices->insert(indices->end(), {p, q, next});
        (advancesA ? i : j)++;
    }
}
} // namespace

qcLeafMesh qcMakeLeaf(const qcLeafForm& form, const btTransform& place)
{
    qcLeafMesh leaf;
    int below = 0, belowHalf = 0;
    for (const Row& row : s_rows)
    {
        int middle = int(leaf.vertices.size()) + row.half;
        for (int i = -row.half; i <= row.half; i++)
            leaf.vertices.push_back(place * Place(form, row, btScalar(i) / btScalar(btMax(row.half, 1))));
        if (row.along > -1)
            for (int step : {1, -1})
                Join(below, belowHalf, middle, row.half, step, &leaf.indices);
        below = middle;
        belowHalf = row.half;
    }
    return leaf;
}
