// Meshes for the tests of the Bullet glue: boxes, spheres, tori and floors of triangles, in Bullet's precision.
#ifndef QC_TESTS_BULLET_MESH_MESH_MODELS_H
#define QC_TESTS_BULLET_MESH_MESH_MODELS_H

#include "quickcullide/bullet_mesh.h"

#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

constexpr double qcPi = 3.14159265358979323846;

struct qcModel
{
    std::vector<btScalar> positions;
    std::vector<uint32_t> indices;

    uint32_t Add(double x, double y, double z)
    {
        positions.insert(positions.end(), {btScalar(x), btScalar(y), btScalar(z)});
        return uint32_t(positions.size() / 3 - 1);
    }

    void Add(uint32_t a, uint32_t b, uint32_t c)
    {
        indices.insert(indices.end(), {a, b, c});
    }

    void Append(const qcModel& other)
    {
        uint32_t first = uint32_t(positions.size() / 3);
        positions.insert(positions.end(), other.positions.begin(), other.positions.end());
        for (uint32_t index : other.indices)
            indices.push_back(first + index);
    }

    uint32_t TriangleCount() const
    {
        return uint32_t(indices.size() / 3);
    }

    btVector3 Corner(uint32_t triangle, uint32_t c) const
    {
        const btScalar* p = &positions[3 * size_t(indices[3 * size_t(triangle) + c])];
        return btVector3(p[0], p[1], p[2]);
    }

    void Move(const btTransform& transform)
    {
        for (size_t i = 0; i < positions.size(); i += 3)
        {
            btVector3 p = transform * btVector3(positions[i], positions[i + 1], positions[i + 2]);
            for (int axis = 0; axis < 3; axis++)
                positions[i + size_t(axis)] = p[axis];
        }
    }

    std::unique_ptr<qcMeshShape> MakeShape(btScalar margin = btScalar(0.01)) const
    {
        std::unique_ptr<qcMeshShape> shape(
            new qcMeshShape(positions.data(), sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32, 0,
                            uint32_t(positions.size() / 3), indices.data(), TriangleCount()));
        shape->setMargin(margin);
        return shape;
    }

    /// The interface refers to the model.
    std::unique_ptr<btTriangleIndexVertexArray> MakeInterface()
    {
        return std::unique_ptr<btTriangleIndexVertexArray>(new btTriangleIndexVertexArray(
            int(TriangleCount()), reinterpret_cast<int*>(indices.data()), 3 * int(sizeof(int)),
            int(positions.size() / 3), positions.data(), 3 * int(sizeof(btScalar))));
    }
};

/// A rectangle of `n` by `m` quads, from `corner` along two sides.
inline void qcAddGrid(qcModel* model, const btVector3& corner, const btVector3& side1, const btVector3& side2, int n,
                      int m)
{
    uint32_t first = uint32_t(model->positions.size() / 3);
    for (int j = 0; j <= m; j++)
        for (int i = 0; i <= n; i++)
        {
            btVector3 p = corner + side1 * (btScalar(i) / btScalar(n)) + side2 * (btScalar(j) / btScalar(m));
            model->Add(double(p.x()), double(p.y()), double(p.z()));
        }
    for (int j = 0; j < m; j++)
        for (int i = 0; i < n; i++)
        {
            uint32_t a = first + uint32_t(j * (n + 1) + i), b = a + 1, c = a + uint32_t(n) + 1, d = c + 1;
            // The diagonals alternate.
            if ((i + j) % 2 == 0)
            {
                model->Add(a, b, d);
                model->Add(a, d, c);
            }
            else
            {
                model->Add(a, b, c);
                model->Add(b, d, c);
            }
        }
}

/// A closed box, facing outwards. Each side is a grid of its own, so vertices at its edges coincide in position only.
inline qcModel qcBoxModel(const btVector3& half, int n)
{
    qcModel model;
    for (int axis = 0; axis < 3; axis++)
        for (int sign = -1; sign <= 1; sign += 2)
        {
            int u = (axis + 1) % 3, v = (axis + 2) % 3;
            btVector3 corner = -half, side1(0, 0, 0), side2(0, 0, 0);
            if (sign > 0)
                corner[axis] = half[axis];
            side1[u] = 2 * half[u];
            side2[v] = 2 * half[v];
            if (sign > 0)
                qcAddGrid(&model, corner, side1, side2, n, n);
            else
                qcAddGrid(&model, corner, side2, side1, n, n);
        }
    return model;
}

/// An icosahedron whose triangles are split in four `levels` times, facing outwards.
inline qcModel qcSphereModel(double radius, int levels)
{
    const double t = (1 + std::sqrt(5.0)) / 2;
    const double corners[12][3] = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
    const uint32_t faces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                   {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                   {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    qcModel model;
    auto add = [&](double x, double y, double z)
    {
        double scale = radius / std::sqrt(x * x + y * y + z * z);
        return model.Add(x * scale, y * scale, z * scale);
    };
    for (const double* corner : corners)
        add(corner[0], corner[1], corner[2]);
    for (const uint32_t* face : faces)
        model.Add(face[0], face[1], face[2]);
    for (int level = 0; level < levels; level++)
    {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        auto middle = [&](uint32_t a, uint32_t b)
        {
            auto key = std::make_pair(std::min(a, b), std::max(a, b));
            auto found = middles.find(key);
            if (found != middles.end())
                return found->second;
            const btScalar *p = &model.positions[3 * size_t(a)], *q = &model.positions[3 * size_t(b)];
            uint32_t m = add(double(p[0]) + double(q[0]), double(p[1]) + double(q[1]), double(p[2]) + double(q[2]));
            middles[key] = m;
            return m;
        };
        std::vector<uint32_t> old;
        old.swap(model.indices);
        for (size_t i = 0; i < old.size(); i += 3)
        {
            uint32_t ab = middle(old[i], old[i + 1]), bc = middle(old[i + 1], old[i + 2]),
                     ca = middle(old[i + 2], old[i]);
            model.Add(old[i], ab, ca);
            model.Add(old[i + 1], bc, ab);
            model.Add(old[i + 2], ca, bc);
            model.Add(ab, bc, ca);
        }
    }
    return model;
}

/// A surface of revolution about the z axis, from circles of these radii at these heights.
inline qcModel qcRevolvedModel(const std::vector<std::pair<double, double>>& circles, int segments)
{
    qcModel model;
    for (const auto& circle : circles)
        for (int i = 0; i < segments; i++)
            model.Add(circle.first * std::cos(2 * qcPi * i / segments),
                      circle.first * std::sin(2 * qcPi * i / segments), circle.second);
    for (uint32_t r = 0; r + 1 < circles.size(); r++)
        for (uint32_t i = 0; i < uint32_t(segments); i++)
        {
            uint32_t n = uint32_t(segments), next = (i + 1) % n, a = r * n + i, b = r * n + next;
            model.Add(a, b, b + n);
            model.Add(a, b + n, a + n);
        }
    return model;
}

/// Along the z axis.
inline qcModel qcCylinderModel(double radius, double half, int segments)
{
    return qcRevolvedModel({{0, -half}, {radius, -half}, {radius, half}, {0, half}}, segments);
}

/// Around the y axis; `radius`: from its centre to the centre of the tube.
inline qcModel qcTorusModel(double radius, double tube, int around, int across)
{
    qcModel model;
    for (int i = 0; i < around; i++)
        for (int j = 0; j < across; j++)
        {
            double u = 2 * qcPi * i / around, v = 2 * qcPi * j / across;
            double r = radius + tube * std::cos(v);
            model.Add(r * std::cos(u), tube * std::sin(v), r * std::sin(u));
        }
    for (int i = 0; i < around; i++)
        for (int j = 0; j < across; j++)
        {
            auto at = [&](int k, int l) { return uint32_t(k % around * across + l % across); };
            model.Add(at(i, j), at(i, j + 1), at(i + 1, j));
            model.Add(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
        }
    return model;
}

/// A square around the origin at height 0, facing up.
inline qcModel qcFloorModel(double half, int n)
{
    qcModel model;
    btScalar h = btScalar(half);
    qcAddGrid(&model, btVector3(-h, 0, -h), btVector3(0, 0, 2 * h), btVector3(2 * h, 0, 0), n, n);
    return model;
}

/// Such a square with gentle hills.
inline qcModel qcHillsModel(double half, int n)
{
    qcModel model = qcFloorModel(half, n);
    for (size_t i = 0; i < model.positions.size(); i += 3)
        model.positions[i + 1] = btScalar(0.3) * btSin(model.positions[i] / 2) * btCos(model.positions[i + 2] / 2);
    return model;
}

#endif
