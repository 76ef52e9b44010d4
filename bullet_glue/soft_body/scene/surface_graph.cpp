// A soft body's or a mesh's triangles as a graph.
#include "soft_body/scene/surface_graph.h"

qcSurfaceGraph::qcSurfaceGraph(qcSoftBodyScene& scene, uint32_t slot) : soft(scene.Find(slot))
{
    if (soft != nullptr)
    {
        m_vertexCount = uint32_t(soft->start.size());
        m_indices = soft->topology.indices;
    }
    else
    {
        mesh = scene.meshes.Find(slot, &rigid);
        m_vertexCount = mesh->shape->getVertexCount();
        m_transform = rigid->start * mesh->local;
        m_indices = mesh->WeldedIndices();
    }
    Connect();
}

btVector3 qcSurfaceGraph::Position(uint32_t vertex) const
{
    return soft != nullptr ? soft->start[vertex] : m_transform * mesh->StartVertex(vertex);
}

/// Each corner of a triangle becomes a neighbour of the other two.
void qcSurfaceGraph::Connect()
{
    m_first.assign(size_t(m_vertexCount) + 1, 0);
    for (uint32_t vertex : m_indices)
        m_first[size_t(vertex) + 1] += 2;
    for (size_t v = 0; v < m_vertexCount; v++)
        m_first[v + 1] += m_first[v];
    m_neighbours.resize(2 * m_indices.size());
    std::vector<uint32_t> next(m_first.begin(), m_first.end() - 1);
    for (size_t i = 0; i < m_indices.size(); i++)
    {
        const uint32_t* corners = &m_indices[i - i % 3];
        m_neighbours[next[m_indices[i]]++] = corners[(i + 1) % 3];
        m_neighbours[next[m_indices[i]]++] = corners[(i + 2) % 3];
    }
}
