// Where the meshes of an object have their origins.
#include "mesh_contact/scene/mesh_places.h"

#include "common/hash_table.h"

#include <cmath>

namespace
{
// Cells are so many times as large as the box around a place that is searched: it mostly meets one.
constexpr btScalar s_cellFactor = 32;
// What is further from the origin, in cells, or not finite, has the number 0.
constexpr btScalar s_maxCell = btScalar(1e9);

int64_t NumberOf(btScalar coordinate, btScalar cellSize)
{
    const btScalar number = std::floor(coordinate / cellSize);
    return btFabs(number) < s_maxCell ? int64_t(number) : 0;
}
} // namespace

qcMeshPlaces::qcMeshPlaces(const std::vector<btVector3>& origins, btScalar distance) : m_count(origins.size())
{
    if (m_count < s_minCount || !(distance > 0))
        return;
    m_cellSize = 2 * s_cellFactor * distance;
    for (const btVector3& origin : origins)
        m_keys.emplace_back(KeyOf(CellOf(origin)), uint32_t(m_keys.size()));
    std::sort(m_keys.begin(), m_keys.end());
}

qcMeshPlaces::Cell qcMeshPlaces::CellOf(const btVector3& place) const
{
    return {NumberOf(place.x(), m_cellSize), NumberOf(place.y(), m_cellSize), NumberOf(place.z(), m_cellSize)};
}

uint64_t qcMeshPlaces::KeyOf(const Cell& cell)
{
    return qcMixHash(qcMixHash(qcMixHash(0, uint64_t(cell.x)), uint64_t(cell.y)), uint64_t(cell.z));
}
