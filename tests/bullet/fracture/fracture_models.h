// Closed meshes to break, and checks of single pieces.
#ifndef QC_TESTS_BULLET_FRACTURE_FRACTURE_MODELS_H
#define QC_TESTS_BULLET_FRACTURE_FRACTURE_MODELS_H

#include "quickcullide/bullet_fracture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

inline void qcAddQuad(qcFractureDef* def, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    for (uint32_t index : {a, b, c, a, c, d})
        def->indices.push_back(index);
}

inline qcFractureDef qcBoxToBreak(double x, double y, double z, bool insideOut = false)
{
    qcFractureDef def;
    for (int i = 0; i < 8; i++)
        def.vertices.push_back(btVector3(btScalar(i & 1 ? x : -x), btScalar(i & 2 ? y : -y), btScalar(i & 4 ? z : -z)));
    qcAddQuad(&def, 0, 2, 3, 1);
    qcAddQuad(&def, 4, 5, 7, 6);
    qcAddQuad(&def, 0, 1, 5, 4);
    qcAddQuad(&def, 2, 6, 7, 3);
    qcAddQuad(&def, 0, 4, 6, 2);
    qcAddQuad(&def, 1, 3, 7, 5);
    for (size_t i = 0; insideOut && i < def.indices.size(); i += 3)
        std::swap(def.indices[i], def.indices[i + 1]);
    return def;
}

inline qcFractureDef qcTorusToBreak(int around, int across, double radius, double tube)
{
    const double pi = 3.14159265358979323846;
    qcFractureDef def;
    for (int i = 0; i < around; i++)
        for (int k = 0; k < across; k++)
        {
            double u = 2 * pi * i / around, v = 2 * pi * k / across, r = radius + tube * std::cos(v);
            def.vertices.push_back(
                btVector3(btScalar(r * std::cos(u)), btScalar(r * std::sin(u)), btScalar(tube * std::sin(v))));
        }
    auto at = [&](int i, int k) { return uint32_t((i % around) * across + k % across); };
    for (int i = 0; i < around; i++)
        for (int k = 0; k < across; k++)
            qcAddQuad(&def, at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
    return def;
}

/// Adds the mesh of another definition, moved.
inline void qcAddToBreak(qcFractureDef* def, const qcFractureDef& other, const btVector3& by)
{
    const uint32_t offset = uint32_t(def->vertices.size());
    for (const btVector3& vertex : other.vertices)
        def->vertices.push_back(vertex + by);
    for (uint32_t index : other.indices)
        def->indices.push_back(index + offset);
}

/// A box with a hollow.
inline qcFractureDef qcHollowToBreak()
{
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    qcAddToBreak(&def, qcBoxToBreak(0.2, 0.2, 0.2, true), btVector3(0, 0, 0));
    return def;
}

/// A bar of 2 `teeth` - 1 by 1 by 2, along x, y and z, with teeth of 1 by 2 by 2 on it, apart by as much as they are
/// wide.
inline qcFractureDef qcCombToBreak(int teeth)
{
    qcFractureDef def;
    const int columns = 2 * teeth;
    for (int z = -1; z <= 1; z += 2)
        for (int y : {0, 1, 3})
            for (int x = 0; x < columns; x++)
                def.vertices.push_back(btVector3(btScalar(x), btScalar(y), btScalar(z)));
    auto at = [&](int x, int row, int side) { return uint32_t((side * 3 + row) * columns + x); };
    auto addAround = [&](int fromX, int fromRow, int toX, int toRow)
    { qcAddQuad(&def, at(fromX, fromRow, 0), at(toX, toRow, 0), at(toX, toRow, 1), at(fromX, fromRow, 1)); };
    auto addEnds = [&](int x, int row)
    {
        qcAddQuad(&def, at(x, row, 0), at(x, row + 1, 0), at(x + 1, row + 1, 0), at(x + 1, row, 0));
        qcAddQuad(&def, at(x, row, 1), at(x + 1, row, 1), at(x + 1, row + 1, 1), at(x, row + 1, 1));
    };
    for (int x = 0; x + 1 < columns; x++)
    {
        addAround(x, 0, x + 1, 0);
        addEnds(x, 0);
        if (x % 2 != 0)
        {
            addAround(x + 1, 1, x, 1);
            continue;
        }
        addEnds(x, 1);
        addAround(x + 1, 1, x + 1, 2);
        addAround(x + 1, 2, x, 2);
        addAround(x, 2, x, 1);
    }
    addAround(0, 1, 0, 0);
    addAround(columns - 1, 0, columns - 1, 1);
    return def;
}

inline double qcCutAreaOf(const qcPiece& piece)
{
    double area = 0;
    for (size_t i = 3 * size_t(piece.firstCutTriangle); i < piece.indices.size(); i += 3)
    {
        const btVector3 &a = piece.vertices[piece.indices[i]], &b = piece.vertices[piece.indices[i + 1]],
                        &c = piece.vertices[piece.indices[i + 2]];
        area += double((b - a).cross(c - a).length()) / 2;
    }
    return area;
}

inline void qcScatterInside(qcFractureDef* def, uint32_t count, uint64_t seed)
{
    btVector3 lower = def->vertices[0], upper = lower;
    for (const btVector3& vertex : def->vertices)
    {
        lower.setMin(vertex);
        upper.setMax(vertex);
    }
    def->sites = qcScatterSites(lower, upper, count, seed);
}

/// The volume inside triangles that face outwards. Computed in double from a vertex, wherever the mesh is.
inline double qcVolumeOf(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices)
{
    double volume = 0;
    for (size_t i = 0; i < indices.size(); i += 3)
    {
        double e[3][3];
        for (size_t c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
                e[c][axis] = double(vertices[indices[i + c]][axis]) - double(vertices[indices[0]][axis]);
        volume +=
            (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
            6;
    }
    return volume;
}

inline bool qcIsClosed(const qcPiece& piece)
{
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (size_t i = 0; i < piece.indices.size(); i++)
    {
        uint32_t a = piece.indices[i], b = piece.indices[i - i % 3 + (i + 1) % 3];
        edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
    return std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 0; });
}

#endif
