// A cube of tetrahedra as a soft body.
#ifndef QC_TESTS_BULLET_SOFT_BODY_TETRA_MODEL_H
#define QC_TESTS_BULLET_SOFT_BODY_TETRA_MODEL_H

#include <BulletSoftBody/btSoftBody.h>

#include <utility>
#include <vector>

/// Five tetrahedra for each of cells^3 cells of this size, from a corner on. Without faces, but for those of
/// `withFaces`: all of each tetrahedron.
inline btSoftBody* qcMakeTetraCube(btSoftBodyWorldInfo& info, const btVector3& corner, int cells, btScalar size,
                                   bool withFaces)
{
    const int n = cells + 1;
    std::vector<btVector3> points;
    for (int i = 0; i < n * n * n; i++)
        points.push_back(corner + size * btVector3(btScalar(i % n), btScalar(i / n % n), btScalar(i / n / n)));
    auto* body = new btSoftBody(&info, int(points.size()), points.data(), nullptr);
    // Corners of a cell by the bits of their numbers: x, y, z.
    const int even[5][4] = {{0, 1, 2, 4}, {3, 1, 7, 2}, {5, 1, 4, 7}, {6, 2, 7, 4}, {1, 2, 4, 7}};
    const int odd[5][4] = {{1, 0, 5, 3}, {2, 0, 3, 6}, {4, 0, 6, 5}, {7, 3, 5, 6}, {0, 3, 5, 6}};
    for (int cell = 0; cell < cells * cells * cells; cell++)
    {
        int x = cell % cells, y = cell / cells % cells, z = cell / cells / cells;
        for (const int(&tetra)[4] : (x + y + z) % 2 == 0 ? even : odd)
        {
            int node[4];
            for (int c = 0; c < 4; c++)
                node[c] = x + (tetra[c] & 1) + n * (y + (tetra[c] >> 1 & 1)) + n * n * (z + (tetra[c] >> 2));
            btVector3 edge[3];
            for (int c = 0; c < 3; c++)
                edge[c] = points[size_t(node[c + 1])] - points[size_t(node[0])];
            if (edge[0].cross(edge[1]).dot(edge[2]) < 0)
                std::swap(node[2], node[3]);
            body->appendTetra(node[0], node[1], node[2], node[3]);
            for (int c = 0; c < 4; c++)
                for (int d = c + 1; d < 4; d++)
                    body->appendLink(node[c], node[d], nullptr, true);
            for (int c = 0; c < 4 && withFaces; c++)
                body->appendFace(node[c], node[(c + 1) % 4], node[(c + 2) % 4]);
        }
    }
    return body;
}

#endif
