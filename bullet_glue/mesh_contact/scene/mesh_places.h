// Where the meshes of an object have their origins, in its frame: a hash grid.
// Ericson: Real-Time Collision Detection, 2005, section 7.1.
#ifndef QC_GLUE_MESH_CONTACT_SCENE_MESH_PLACES_H
#define QC_GLUE_MESH_CONTACT_SCENE_MESH_PLACES_H

#include <LinearMath/btVector3.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

class qcMeshPlaces
{
  public:
    qcMeshPlaces() = default;
    /// `distance`: up to which origins will be searched, but for rounding.
    qcMeshPlaces(const std::vector<btVector3>& origins, btScalar distance);

    /// The first index for which isFound(index) is true, of the origins within `distance` of a place and some others;
    /// the number of origins if there is none.
    template <typename IsFound>
    size_t FindFirst(const btVector3& place, btScalar distance, const IsFound& isFound) const;

  private:
    static constexpr size_t s_minCount = 16; ///< fewer origins are compared one after the other

    struct Cell
    {
        int64_t x, y, z;
    };

    Cell CellOf(const btVector3& place) const;
    static uint64_t KeyOf(const Cell& cell);

    size_t m_count = 0;
    btScalar m_cellSize = 0;                           ///< 0: there are no cells
    std::vector<std::pair<uint64_t, uint32_t>> m_keys; ///< of the cells and indices of their origins; sorted
};

template <typename IsFound>
size_t qcMeshPlaces::FindFirst(const btVector3& place, btScalar distance, const IsFound& isFound) const
{
    size_t first = m_count;
    // A box of at most one cell's size meets at most eight.
    if (m_keys.empty() || !(2 * distance <= m_cellSize))
    {
        for (size_t i = 0; i < first; i++)
            if (isFound(i))
                first = i;
        return first;
    }
    const btVector3 around(distance, distance, distance);
    const Cell lower = CellOf(place - around), upper = CellOf(place + around);
    for (int64_t x = lower.x; x <= upper.x; x++)
        for (int64_t y = lower.y; y <= upper.y; y++)
            for (int64_t z = lower.z; z <= upper.z; z++)
            {
                const uint64_t key = KeyOf({x, y, z});
                auto entry = std::lower_bound(m_keys.begin(), m_keys.end(), std::make_pair(key, uint32_t(0)));
                for (; entry != m_keys.end() && entry->first == key && entry->second < first; ++entry)
                    if (isFound(entry->second))
                        first = entry->second;
            }
    return first;
}

#endif
