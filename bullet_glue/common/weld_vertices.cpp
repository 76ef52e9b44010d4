// By sorting: exact, and the same on every machine.
#include "common/weld_vertices.h"

#include <algorithm>
#include <array>
#include <numeric>

std::vector<uint32_t> qcFirstAtPosition(const btVector3* vertices, uint32_t count)
{
    std::vector<uint32_t> order(count), welded(count);
    std::iota(order.begin(), order.end(), 0);
    auto key = [&](uint32_t v) { return std::array<btScalar, 3>{vertices[v].x(), vertices[v].y(), vertices[v].z()}; };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    for (uint32_t i = 0; i < count; i++)
        welded[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? welded[order[i - 1]] : order[i];
    return welded;
}
