// A BVH over triangles with eight boxes a node, split at medians like a kd-tree (Bentley: Multidimensional binary
// search trees, 1975). Levels are full from the left, so that there are no pointers.
#ifndef QC_GLUE_MESH_SHAPE_TRIANGLE_TREE_H
#define QC_GLUE_MESH_SHAPE_TRIANGLE_TREE_H

#include "common/lanes.h"

#include <LinearMath/btVector3.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

class qcTriangleTree
{
  public:
    /// The arrays are needed during the call only. `workers`: threads that divide large trees.
    qcTriangleTree(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount, uint32_t workers);

    /// Calls visit(triangle) for each triangle whose box overlaps the closed box.
    template <class Visit> void VisitBox(const btVector3& lower, const btVector3& upper, Visit visit) const
    {
        auto overlaps = [&](const Block& block, size_t first)
        {
            auto meet = [&](size_t axis)
            {
                return (qcLoadLanes(block.lower[axis] + first) <= upper[int(axis)]) &
                       (qcLoadLanes(block.upper[axis] + first) >= lower[int(axis)]);
            };
            return meet(0) & meet(1) & meet(2);
        };
        Walk(overlaps, visit);
    }

    /// Calls visit(triangle) for each triangle whose box has a point below the plane normal . x = distance.
    template <class Visit> void VisitBelow(const btVector3& normal, btScalar distance, Visit visit) const
    {
        auto isBelow = [&](const Block& block, size_t first)
        {
            auto lowest = [&](int axis)
            { return qcLoadLanes((normal[axis] >= 0 ? block.lower[axis] : block.upper[axis]) + first) * normal[axis]; };
            return (qcLoadLanes(block.lower[0] + first) <= qcLoadLanes(block.upper[0] + first)) &
                   (lowest(0) + lowest(1) + lowest(2) <= distance);
        };
        Walk(isBelow, visit);
    }

    /// A box that moves along a line; a ray if it has no size.
    struct Sweep
    {
        btVector3 from, to;     ///< the ends of the line
        btVector3 lower, upper; ///< of the box, relative to its point on the line
    };

    /// Calls visit(triangle) for each triangle whose box the sweep hits before `fraction` of its way; visit may lower
    /// `fraction`. Nearer blocks come first.
    template <class Visit> void VisitSweep(const Sweep& sweep, const btScalar& fraction, Visit visit) const;

    /// Visits the triangles of VisitSweep in the order of bound(triangle), a fraction of the way before which the
    /// triangle is not hit.
    template <class Bound, class Visit>
    void VisitInOrder(const Sweep& sweep, const btScalar& fraction, Bound bound, Visit visit) const;

  private:
    static constexpr int s_width = 8;
    /// Boxes of up to eight triangles or blocks. Unused ones are inverted: nothing hits them.
    struct Block
    {
        btScalar lower[3][s_width], upper[3][s_width];
    };
    /// A range of m_blocks.
    struct Level
    {
        uint32_t first, count;
    };
    struct Item
    {
        uint32_t level, block; ///< relative to the level's first block
    };
    // 2^32 triangles have eleven levels. A depth-first search has at most seven blocks of each on its stack.
    static constexpr int s_stack = 7 * 11 + 1;
    struct RayItem
    {
        Item item;
        btScalar near; ///< fraction of the way at which the ray enters the block
    };
    /// A sweep, prepared for tests of blocks.
    struct Slabs
    {
        explicit Slabs(const Sweep& sweep);

        bool backward[3];
        btScalar entry[3], exit[3]; ///< where the sides of a box lie that the sweep enters or leaves at its beginning
        btScalar perWay[3];         ///< fractions of the way for a unit of length
        btScalar slack[3];          ///< fractions of the way for a unit of a box's length
    };

    static void Clear(Block* block);
    void AddLevel();
    const Block& GetBlock(const Item& item) const
    {
        return m_blocks[m_levels[item.level].first + item.block];
    }

    /// The boxes of a block, a bit each, that the sweep enters before `fraction` of its way. `near` receives where.
    static unsigned EnteredBoxes(const Block& block, const Slabs& slabs, btScalar fraction, btScalar near[s_width]);

    /// test(block, first) compares boxes from `first` on, as many as a vector has lanes: true for those whose contents
    /// are visited.
    template <class Test, class Visit> void Walk(Test test, Visit visit) const
    {
        if (m_levels.empty())
            return;
        Item stack[s_stack];
        int depth = 0;
        stack[depth++] = {uint32_t(m_levels.size()) - 1, 0};
        while (depth > 0)
        {
            Item item = stack[--depth];
            const Block& block = GetBlock(item);
            unsigned boxes = 0;
            for (size_t first = 0; first < s_width; first += qcLaneCount)
                boxes |= qcBitsOf(test(block, first)) << first;
            for (; boxes != 0; boxes &= boxes - 1)
            {
                uint32_t child = item.block * s_width + uint32_t(__builtin_ctz(boxes));
                if (item.level == 0)
                    visit(m_order[child]);
                else
                    stack[depth++] = {item.level - 1, child};
            }
        }
    }

    std::vector<uint32_t> m_order; ///< triangles, in the order of the lowest level's boxes
    std::vector<Block> m_blocks;
    std::vector<Level> m_levels; ///< from the boxes of triangles up
};

inline qcTriangleTree::Slabs::Slabs(const Sweep& sweep)
{
    constexpr btScalar epsilon = std::numeric_limits<btScalar>::epsilon();
    btScalar scale = std::numeric_limits<btScalar>::min() / (epsilon * epsilon);
    for (int axis = 0; axis < 3; axis++)
        for (const btVector3* place : {&sweep.from, &sweep.to, &sweep.lower, &sweep.upper})
            scale = btMax(scale, btFabs((*place)[axis]));
    for (int axis = 0; axis < 3; axis++)
    {
        // Rounding moves a side by less. A way of less along an axis is none.
        btScalar error = 16 * epsilon * scale, way = sweep.to[axis] - sweep.from[axis];
        backward[axis] = way < 0;
        btScalar ahead = sweep.from[axis] + sweep.upper[axis] + error,
                 behind = sweep.from[axis] + sweep.lower[axis] - error;
        entry[axis] = backward[axis] ? behind : ahead;
        exit[axis] = backward[axis] ? ahead : behind;
        btScalar size = 1 / btMax(btFabs(way), epsilon / 16 * scale);
        perWay[axis] = backward[axis] ? -size : size;
        // Bullet's test of ray and triangle accepts rays that miss an edge by a ten thousandth of the triangle.
        slack[axis] = size * btScalar(1e-3);
    }
}

inline unsigned qcTriangleTree::EnteredBoxes(const Block& block, const Slabs& slabs, btScalar fraction,
                                             btScalar near[s_width])
{
    unsigned boxes = 0;
    for (size_t i = 0; i < s_width; i += qcLaneCount)
    {
        qcLanes from{}, to = qcLanes{} + fraction;
        for (int axis = 0; axis < 3; axis++)
        {
            const qcLanes lower = qcLoadLanes(block.lower[axis] + i), upper = qcLoadLanes(block.upper[axis] + i);
            const bool backward = slabs.backward[axis];
            const qcLanes wider = (upper - lower) * slabs.slack[axis];
            const qcLanes enter = ((backward ? upper : lower) - slabs.entry[axis]) * slabs.perWay[axis] - wider,
                          leave = ((backward ? lower : upper) - slabs.exit[axis]) * slabs.perWay[axis] + wider;
            from = enter > from ? enter : from;
            to = leave < to ? leave : to;
        }
        std::memcpy(near + i, &from, sizeof from);
        boxes |= qcBitsOf((from <= to) & (qcLoadLanes(block.lower[0] + i) <= qcLoadLanes(block.upper[0] + i))) << i;
    }
    return boxes;
}

template <class Visit> void qcTriangleTree::VisitSweep(const Sweep& sweep, const btScalar& fraction, Visit visit) const
{
    if (m_levels.empty())
        return;
    const Slabs slabs(sweep);
    RayItem stack[s_stack];
    int depth = 0;
    stack[depth++] = {{uint32_t(m_levels.size()) - 1, 0}, 0};
    while (depth > 0)
    {
        RayItem entry = stack[--depth];
        if (entry.near > fraction)
            continue;
        btScalar near[s_width];
        int first = depth;
        for (unsigned boxes = EnteredBoxes(GetBlock(entry.item), slabs, fraction, near); boxes != 0; boxes &= boxes - 1)
        {
            int i = __builtin_ctz(boxes);
            uint32_t child = entry.item.block * s_width + uint32_t(i);
            if (entry.item.level == 0)
            {
                visit(m_order[child]);
                continue;
            }
            // Sorted in, so that the nearest child is on top.
            int at = depth++;
            for (; at > first && stack[at - 1].near < near[i]; at--)
                stack[at] = stack[at - 1];
            stack[at] = {{entry.item.level - 1, child}, near[i]};
        }
    }
}

template <class Bound, class Visit>
void qcTriangleTree::VisitInOrder(const Sweep& sweep, const btScalar& fraction, Bound bound, Visit visit) const
{
    if (m_levels.empty())
        return;
    // Best first: a heap of blocks and triangles.
    constexpr uint32_t triangle = UINT32_MAX; // as a level
    const Slabs slabs(sweep);
    auto isLater = [](const RayItem& a, const RayItem& b) { return a.near > b.near; };
    std::vector<RayItem> heap;
    heap.reserve(256);
    heap.push_back({{uint32_t(m_levels.size()) - 1, 0}, 0});
    while (!heap.empty() && heap.front().near < fraction)
    {
        std::pop_heap(heap.begin(), heap.end(), isLater);
        RayItem entry = heap.back();
        heap.pop_back();
        if (entry.item.level == triangle)
        {
            visit(entry.item.block);
            continue;
        }
        btScalar near[s_width];
        for (unsigned boxes = EnteredBoxes(GetBlock(entry.item), slabs, fraction, near); boxes != 0; boxes &= boxes - 1)
        {
            int i = __builtin_ctz(boxes);
            RayItem child = {{entry.item.level - 1, entry.item.block * s_width + uint32_t(i)}, near[i]};
            if (entry.item.level == 0)
            {
                child.item = {triangle, m_order[child.item.block]};
                child.near = btMax(child.near, bound(child.item.block));
            }
            if (child.near >= fraction)
                continue;
            heap.push_back(child);
            std::push_heap(heap.begin(), heap.end(), isLater);
        }
    }
}

#endif
