// A BVH over triangles with eight boxes a node, split at medians like a kd-tree (Bentley: Multidimensional binary
// search trees, 1975). Levels are full from the left, so that there are no pointers.
#ifndef QC_GLUE_MESH_SHAPE_TRIANGLE_TREE_H
#define QC_GLUE_MESH_SHAPE_TRIANGLE_TREE_H

#include <LinearMath/btVector3.h>

#include <cstdint>
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

    static void Clear(Block* block);
    void AddLevel();

    static bool IsHit(const Block& block, int i, const Sweep& sweep, btScalar fraction, btScalar* near);

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
            test(m_blocks[m_levels[item.level].first + item.block], hit);
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

/// True if the sweep hits box `i` before `fraction` of its way. `near` receives the fraction at which it enters.
inline bool qcMeshTree::IsHit(const Block& block, int i, const Sweep& sweep, btScalar fraction, btScalar* near)
{
    *near = 0;
    btScalar far = fraction;
    for (int axis = 0; axis < 3; axis++)
    {
        btScalar lower = block.lower[axis][i], upper = block.upper[axis][i];
        btScalar way = sweep.to[axis] - sweep.from[axis];
        // Bullet's test of ray and triangle accepts rays that miss an edge by a ten thousandth of the triangle.
        btScalar slack = (upper - lower + btFabs(way)) * btScalar(1e-3);
        lower -= slack + sweep.from[axis] + sweep.upper[axis];
        upper += slack - sweep.from[axis] - sweep.lower[axis];
        if (way == 0)
        {
            far = lower <= 0 && upper >= 0 ? far : btScalar(-1);
            continue;
        }
        btScalar enter = lower / way, leave = upper / way;
        *near = btMax(*near, btMin(enter, leave));
        far = btMin(far, btMax(enter, leave));
    }
    return *near <= far && block.lower[0][i] <= block.upper[0][i];
}

template <class Visit> void qcMeshTree::VisitSweep(const Sweep& sweep, const btScalar& fraction, Visit visit) const
{
    if (m_levels.empty())
        return;
    RayItem stack[s_stack];
    int depth = 0;
    stack[depth++] = {{uint32_t(m_levels.size()) - 1, 0}, 0};
    while (depth > 0)
    {
        RayItem entry = stack[--depth];
        if (entry.near > fraction)
            continue;
        const Block& block = m_blocks[m_levels[entry.item.level].first + entry.item.block];
        int first = depth;
        for (int i = 0; i < s_width; i++)
        {
            btScalar near;
            if (!IsHit(block, i, sweep, fraction, &near))
                continue;
            uint32_t child = entry.item.block * s_width + uint32_t(i);
            if (entry.item.level == 0)
            {
                visit(m_order[child]);
                continue;
            }
            // Sorted in, so that the nearest child is on top.
            int at = depth++;
            for (; at > first && stack[at - 1].near < near; at--)
                stack[at] = stack[at - 1];
            stack[at] = {{entry.item.level - 1, child}, near};
        }
    }
}

#endif
