// Small meshes as their convex hulls: extreme vertices along a direction, and the directions of their faces.
#ifndef QC_GLUE_COMMON_SUPPORT_MESH_H
#define QC_GLUE_COMMON_SUPPORT_MESH_H

#include "common/extreme_vertices.h"
#include "common/shape_triangles.h"

#include <atomic>
#include <memory>
#include <mutex>

/// A mesh in its own frame. Refers to the shape, as qcMeshTriangles does. Thread-safe.
class qcSupportMesh
{
  public:
    /// O(triangles * faces of similar direction).
    explicit qcSupportMesh(const btCollisionShape* shape);

    /// The mesh has few enough triangles that contact by the hulls of two is worth a search of all vertices.
    static bool IsSmall(size_t triangleCount);

    /// The largest product of a vertex with the direction; see qcExtremeVertices.
    btScalar Max(const btVector3& direction) const
    {
        return m_vertices.Max(direction);
    }
    const qcExtremeVertices& Vertices() const
    {
        return m_vertices;
    }

    const qcMeshTriangles& Triangles() const
    {
        return m_triangles;
    }
    /// Unit normals of the triangles; 0 for degenerate ones.
    const std::vector<btVector3>& Normals() const
    {
        return m_normals;
    }

    struct Edge
    {
        uint32_t from, to;
        uint32_t triangle; ///< one of its triangles
    };
    /// Each edge once, but those within flat faces.
    const std::vector<Edge>& Edges() const
    {
        return FoundEdges().edges;
    }

    /// Numbers by vertex.
    struct Lists
    {
        std::vector<uint32_t> starts, numbers;

        const uint32_t* begin(uint32_t vertex) const
        {
            return numbers.data() + starts[vertex];
        }
        const uint32_t* end(uint32_t vertex) const
        {
            return numbers.data() + starts[vertex + 1];
        }
    };
    const Lists& TrianglesOf() const
    {
        return m_trianglesOf;
    }
    const Lists& EdgesOf() const
    {
        return FoundEdges().edgesOf;
    }

    struct Box
    {
        btVector3 lower, upper;
    };
    /// By run of the vertices: the box around their triangles.
    const std::vector<Box>& BoxesOfRuns() const
    {
        return m_boxesOfRuns;
    }

    struct Face
    {
        btVector3 normal; ///< of length 1
        btScalar max;     ///< the largest product of a vertex with the normal
    };
    /// The largest faces, coplanar triangles together; the largest first.
    const std::vector<Face>& Faces() const
    {
        return m_faces;
    }
    /// These faces by their `max`, the least first.
    const std::vector<Face>& FacesByMax() const
    {
        return m_facesByMax;
    }
    /// True if no vertex is above a triangle by more than rounding: the mesh is its hull. The first call takes
    /// O(triangles * vertices).
    bool IsConvex() const;
    /// Upper bound of the vertices' distance from the origin.
    btScalar Radius() const
    {
        return m_radius;
    }

  private:
    struct EdgeLists
    {
        std::vector<Edge> edges;
        Lists edgesOf;
    };

    void FindFaces();
    void FindBoxesOfRuns();
    bool FindIsConvex() const;
    EdgeLists FindEdges() const;
    /// Found by the first call: meshes that touch along common faces, or nothing at all, need none.
    const EdgeLists& FoundEdges() const
    {
        const EdgeLists* found = m_foundEdges.load(std::memory_order_acquire);
        return found != nullptr ? *found : KeepEdges();
    }
    const EdgeLists& KeepEdges() const;

    qcMeshTriangles m_triangles;
    qcExtremeVertices m_vertices;
    std::vector<btVector3> m_normals;
    std::vector<Face> m_faces, m_facesByMax;
    Lists m_trianglesOf;
    std::vector<Box> m_boxesOfRuns;
    mutable std::mutex m_edgesMutex;
    mutable std::unique_ptr<const EdgeLists> m_edges;
    mutable std::atomic<const EdgeLists*> m_foundEdges{nullptr};
    mutable std::once_flag m_convexityOnce;
    mutable bool m_isConvex = false; ///< once it has been found
    btScalar m_radius = 0;
};

/// A mesh in world space.
struct qcPlacedSupport
{
    const qcSupportMesh* mesh;
    btTransform transform;

    btVector3 ToLocal(const btVector3& direction) const
    {
        return direction * transform.getBasis();
    }
    /// The first vertex with the largest product with the direction.
    uint32_t FindMax(const btVector3& direction) const
    {
        return mesh->Vertices().FindMax(ToLocal(direction));
    }
    btVector3 VertexAt(uint32_t index) const
    {
        return transform * mesh->Triangles().points[index];
    }
    btScalar Radius() const
    {
        return mesh->Radius();
    }
};

#endif
