// Vertices at the same position, by hashing.
#include "common/weld_vertices.h"

#include "common/hash_table.h"

std::vector<uint32_t> qcFirstAtPosition(const btVector3* vertices, uint32_t count)
{
    qcHashTable<std::array<double, 3>, uint32_t> firstAt;
    firstAt.Clear(count);
    std::vector<uint32_t> first(count);
    for (uint32_t v = 0; v < count; v++)
    {
        const btVector3& p = vertices[v];
        first[v] = firstAt.FindOrAdd({double(p.x()), double(p.y()), double(p.z())}, v);
    }
    return first;
}
