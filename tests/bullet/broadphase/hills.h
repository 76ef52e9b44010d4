// Hills of triangles, as a mesh of Bullet's.
#ifndef QC_TESTS_BULLET_BROADPHASE_HILLS_H
#define QC_TESTS_BULLET_BROADPHASE_HILLS_H

#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <vector>

/// `n` by `n` quads around the origin, from -n on: `xStep` wide in x and 2 in z.
struct qcHills
{
    /// Calls height(i, j) for each vertex, in order.
    template <class Height> qcHills(int n, btScalar xStep, Height height)
    {
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= n; j++)
                vertices.insert(vertices.end(),
                                {xStep * btScalar(i) - btScalar(n), btScalar(height(i, j)), btScalar(2 * j - n)});
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
            {
                const int a = i * (n + 1) + j, b = a + n + 1;
                indices.insert(indices.end(), {a, a + 1, b, b, a + 1, b + 1});
            }
        btIndexedMesh part;
        part.m_numTriangles = int(indices.size() / 3);
        part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(indices.data());
        part.m_triangleIndexStride = int(3 * sizeof(int));
        part.m_numVertices = int(vertices.size() / 3);
        part.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices.data());
        part.m_vertexStride = int(3 * sizeof(btScalar));
        mesh.addIndexedMesh(part, PHY_INTEGER);
    }
    qcHills(const qcHills&) = delete;
    qcHills& operator=(const qcHills&) = delete;

    std::vector<btScalar> vertices;
    std::vector<int> indices;
    btTriangleIndexVertexArray mesh;
};

#endif
