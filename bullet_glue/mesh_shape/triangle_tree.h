// A BVH over triangles with eight boxes a node, split at medians like a kd-tree (Bentley: Multidimensional binary
// search trees, 1975). Levels are full from the left, so that there are no pointers.
#ifndef QC_GLUE_MESH_SHAPE_TRIANGLE_TREE_H
#define QC_GLUE_MESH_SHAPE_TRIANGLE_TREE_H

#include <LinearMath/btVector3.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

class qcMeshTree
{
  public:
    /// The arrays are needed during the call only.
    qcMeshTree(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount);

    /// Calls visit(triangle) for each triangle whose box overlaps the closed box.
    template <class Visit> void VisitBox(const btVector3& lower, const btVector3& upper, Visit visit) const
    {
        auto overlaps = [&](const Block& block, Lane* hit)
        {
            // Bitwise, without branches: a few vector instructions.
            for (int i = 0; i < s_width; i++)
                hit[i] = Lane(block.lower[0][i] <= upper.x()) & Lane(block.upper[0][i] >= lower.x()) &
                         Lane(block.lower[1][i] <= upper.y()) & Lane(block.upper[1][i] >= lower.y()) &
                         Lane(block.lower[2][i] <= upper.z()) & Lane(block.upper[2][i] >= lower.z());
        };
        Walk(overlaps, visit);
    }

    /// Calls visit(triangle) for each triangle whose box has a point below the plane normal . x = distance.
    template <class Visit> void VisitBelow(const btVector3& normal, btScalar distance, Visit visit) const
    {
        auto isBelow = [&](const Block& block, Lane* hit)
        {
            const btScalar* lowest[3];
            for (int axis = 0; axis < 3; axis++)
                lowest[axis] = normal[axis] >= 0 ? block.lower[axis] : block.upper[axis];
            for (int i = 0; i < s_width; i++)
                hit[i] =
                    Lane(block.lower[0][i] <= block.upper[0][i]) &
                    Lane(normal.x() * lowest[0][i] + normal.y() * lowest[1][i] + normal.z() * lowest[2][i] <= distance);
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
    /// The result type of a vectorized comparison of coordinates: an integer of their size.
    typedef std::conditional_t<sizeof(btScalar) == 8, int64_t, int32_t> Lane;

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
    static unsigned BitsOf(const Lane hit[s_width]);

    /// test(block, hit) sets a flag for each box of a block whose contents are visited.
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
            Lane hit[s_width];
            test(GetBlock(item), hit);
            for (int i = 0; i < s_width; i++)
            {
                if (hit[i] == 0)
                    continue;
                uint32_t child = item.block * s_width + uint32_t(i);
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

inline qcMeshTree::Slabs::Slabs(const Sweep& sweep)
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

inline unsigned qcMeshTree::BitsOf(const Lane hit[s_width])
{
    unsigned bits = 0;
    for (int i = 0; i < s_width; i++)
        bits |= unsigned(hit[i] != 0) << i;
    return bits;
}

inline unsigned qcMeshTree::EnteredBoxes(const Block& block, const Slabs& slabs, btScalar fraction,
                                         btScalar near[s_width])
{
    btScalar far[s_width];
    for (int i = 0; i < s_width; i++)
    {
        near[i] = 0;
        far[i] = fraction;
    }
    for (int axis = 0; axis < 3; axis++)
    {
        const btScalar *lower = block.lower[axis], *upper = block.upper[axis];
        const btScalar* first = slabs.backward[axis] ? upper : lower;
        const btScalar* last = slabs.backward[axis] ? lower : upper;
        btScalar entry = slabs.entry[axis], exit = slabs.exit[axis], perWay = slabs.perWay[axis],
                 slack = slabs.slack[axis];
        for (int i = 0; i < s_width; i++)
        {
            btScalar wider = (upper[i] - lower[i]) * slack;
            btScalar enter = (first[i] - entry) * perWay - wider, leave = (last[i] - exit) * perWay + wider;
            near[i] = enter > near[i] ? enter : near[i];
            far[i] = leave < far[i] ? leave : far[i];
        }
    }
    Lane hit[s_width];
    for (int i = 0; i < s_width; i++)
        hit[i] = Lane(near[i] <= far[i]) & Lane(block.lower[0][i] <= block.upper[0][i]);
    return BitsOf(hit);
}

template <class Visit> void qcMeshTree::VisitSweep(const Sweep& sweep, const btScalar& fraction, Visit visit) const
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
void qcMeshTree::VisitInOrder(const Sweep& sweep, const btScalar& fraction, Bound bound, Visit visit) const
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
