// A soft body's or a mesh's triangles as a graph of vertices and edges, at the start of the step.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SURFACE_GRAPH_H
#define QC_GLUE_SOFT_BODY_SCENE_SURFACE_GRAPH_H

#include "soft_body/scene/soft_scene.h"

#include <algorithm>

class qcSurfaceGraph
{
  public:
    /// The surface in a slot of the scene. O(triangles).
    qcSurfaceGraph(qcSoftBodyScene& scene, uint32_t slot);

    /// The three vertices of a triangle. In a mesh, vertices at one position are one.
    const uint32_t* Corners(uint32_t triangle) const
    {
        return &m_indices[3 * size_t(triangle)];
    }
    /// At the start of the step, in world space.
    btVector3 Position(uint32_t vertex) const;
    uint32_t VertexCount() const
    {
        return m_vertexCount;
    }
    /// True if one triangle only has the edge.
    bool IsOnBoundary(uint32_t from, uint32_t to) const
    {
        return std::count(&m_neighbours[m_first[from]], &m_neighbours[m_first[from + 1]], to) == 1;
    }
    /// Calls function(vertex) for each vertex that has a common edge with this one, maybe more than once.
    template <typename Function> void ForEachNeighbour(uint32_t vertex, Function function) const
    {
        for (uint32_t i = m_first[vertex]; i < m_first[vertex + 1]; i++)
            function(m_neighbours[i]);
    }

    qcSceneSoftBody* soft;
    qcSceneRigid* rigid = nullptr; ///< null for a soft body
    const qcSceneMesh* mesh = nullptr;

  private:
    void Connect();

    uint32_t m_vertexCount = 0;
    btTransform m_transform = btTransform::getIdentity(); ///< of the mesh
    std::vector<uint32_t> m_indices;
    std::vector<uint32_t> m_first, m_neighbours; ///< of vertex v: from m_first[v] to before m_first[v + 1]
};

#endif
