// A tree of boxes over triangles: eight to a block, eight blocks to a block of the next level, cut at medians as a
// kd-tree is (Bentley: Multidimensional binary search trees, 1975). Full from the left, so that there are no pointers.
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

    /// Calls visit(triangle) for each triangle whose box meets the closed box.
    template <class Visit> void VisitBox(const btVector3& lower, const btVector3& upper, Visit visit) const
    {
        auto meets = [&](const Block& block, Lane* meet)
        {
            // A bitwise and: no branches, so that it becomes a few vector instructions.
            for (int i = 0; i < s_width; i++)
                meet[i] = Lane(block.lower[0][i] <= upper.x()) & Lane(block.upper[0][i] >= lower.x()) &
                          Lane(block.lower[1][i] <= upper.y()) & Lane(block.upper[1][i] >= lower.y()) &
                          Lane(block.lower[2][i] <= upper.z()) & Lane(block.upper[2][i] >= lower.z());
        };
        Walk(meets, visit);
    }

    /// Calls visit(triangle) for each triangle whose box reaches below the plane normal . x = distance.
    template <class Visit> void VisitBelow(const btVector3& normal, btScalar distance, Visit visit) const
    {
        auto meets = [&](const Block& block, Lane* meet)
        {
            const btScalar* lowest[3];
            for (int axis = 0; axis < 3; axis++)
                lowest[axis] = normal[axis] >= 0 ? block.lower[axis] : block.upper[axis];
            for (int i = 0; i < s_width; i++)
                meet[i] =
                    Lane(block.lower[0][i] <= block.upper[0][i]) &
                    Lane(normal.x() * lowest[0][i] + normal.y() * lowest[1][i] + normal.z() * lowest[2][i] <= distance);
        };
        Walk(meets, visit);
    }

    /// Calls visit(triangle) for each triangle whose box meets the ray before `fraction` of its way, which may become
    /// less from call to call. Nearer blocks first.
    template <class Visit>
    void VisitRay(const btVector3& from, const btVector3& to, const btScalar& fraction, Visit visit) const;

  private:
    static constexpr int s_width = 8;
    /// As wide as a coordinate: comparisons of vectors yield vectors of these.
    typedef std::conditional_t<sizeof(btScalar) == 8, int64_t, int32_t> Lane;

    /// Boxes of up to eight triangles, or blocks. Those beyond the last are inverted: they meet nothing.
    struct Block
    {
        btScalar lower[3][s_width], upper[3][s_width];
    };
    /// Where in m_blocks the blocks of a level are.
    struct Level
    {
        uint32_t first, count;
    };
    struct Item
    {
        uint32_t level, block; ///< the block counts from the level's first
    };
    // Eleven levels hold 2^32 triangles, and each of them leaves at most seven blocks behind.
    static constexpr int s_stack = 7 * 11 + 1;

    static void Clear(Block* block);
    void AddLevel();

    template <class Meets, class Visit> void Walk(Meets meets, Visit visit) const
    {
        if (m_levels.empty())
            return;
        Item stack[s_stack];
        int depth = 0;
        stack[depth++] = {uint32_t(m_levels.size()) - 1, 0};
        while (depth > 0)
        {
            Item item = stack[--depth];
            Lane meet[s_width];
            meets(m_blocks[m_levels[item.level].first + item.block], meet);
            for (int i = 0; i < s_width; i++)
            {
                if (meet[i] == 0)
                    continue;
                uint32_t child = item.block * s_width + uint32_t(i);
                if (item.level == 0)
                    visit(m_order[child]);
                else
                    stack[depth++] = {item.level - 1, child};
            }
        }
    }

    std::vector<uint32_t> m_order; ///< triangles, leaf by leaf
    std::vector<Block> m_blocks;
    std::vector<Level> m_levels; ///< the first is that of the triangles
};

template <class Visit>
void qcMeshTree::VisitRay(const btVector3& from, const btVector3& to, const btScalar& fraction, Visit visit) const
{
    if (m_levels.empty())
        return;
    struct Entry
    {
        Item item;
        btScalar near;
    };
    btScalar way[3] = {to.x() - from.x(), to.y() - from.y(), to.z() - from.z()};
    Entry stack[s_stack];
    int depth = 0;
    stack[depth++] = {{uint32_t(m_levels.size()) - 1, 0}, 0};
    while (depth > 0)
    {
        Entry entry = stack[--depth];
        if (entry.near > fraction)
            continue;
        const Block& block = m_blocks[m_levels[entry.item.level].first + entry.item.block];
        int first = depth;
        for (int i = 0; i < s_width; i++)
        {
            btScalar near = 0, far = fraction;
            for (int axis = 0; axis < 3; axis++)
            {
                btScalar lower = block.lower[axis][i], upper = block.upper[axis][i];
                // Bullet's test of ray and triangle lets a ray pass an edge by a ten thousandth of the triangle.
                btScalar slack = (upper - lower + btFabs(way[axis])) * btScalar(1e-3);
                lower -= slack + from[axis];
                upper += slack - from[axis];
                if (way[axis] == 0)
                {
                    far = lower <= 0 && upper >= 0 ? far : btScalar(-1);
                    continue;
                }
                btScalar enter = lower / way[axis], leave = upper / way[axis];
                near = btMax(near, btMin(enter, leave));
                far = btMin(far, btMax(enter, leave));
            }
            if (!(near <= far) || !(block.lower[0][i] <= block.upper[0][i]))
                continue;
            uint32_t child = entry.item.block * s_width + uint32_t(i);
            if (entry.item.level == 0)
            {
                visit(m_order[child]);
                continue;
            }
            int at = depth++;
            for (; at > first && stack[at - 1].near < near; at--)
                stack[at] = stack[at - 1];
            stack[at] = {{entry.item.level - 1, child}, near};
        }
    }
}

#endif
