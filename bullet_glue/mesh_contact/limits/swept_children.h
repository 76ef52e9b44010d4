// The meshes and cores of a compound that stays in a step, with boxes around them: many hulls pass a level, each near
// few of them.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_CHILDREN_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_CHILDREN_H

#include "common/lanes.h"
#include "mesh_contact/limits/convex_cores.h"

#include <vector>

class qcSweptChildren
{
  public:
    struct Child
    {
        const qcMeshShape* mesh;
        const btConvexShape* convex; ///< whose core the mesh is; null: the mesh is the shape
        const qcSupportMesh* core;   ///< the core as a hull; null likewise
        btTransform local;           ///< from its frame to the object's
    };

    /// Reads the meshes in a compound of any depth, then the cores of its convex shapes unless `cores` is null.
    /// Bullet's tree of a compound is not enough: it has the boxes of when a child was added. O(children).
    void Read(const btCollisionShape* compound, qcConvexCores* cores);
    /// Forgets them.
    void Clear();

    /// False: Read has not been called since Clear.
    bool AreRead() const
    {
        return m_areRead;
    }
    /// True if all meshes are qcMeshShapes.
    bool AreAll() const
    {
        return m_areAll;
    }
    size_t Count() const
    {
        return m_children.size();
    }
    /// The first ones are meshes, the others cores.
    size_t MeshCount() const
    {
        return m_meshCount;
    }
    const Child& operator[](size_t child) const
    {
        return m_children[child];
    }
    /// Upper bound of the distance of the boxes' points from the object's origin.
    btScalar Radius() const
    {
        return m_radius;
    }
    /// Calls visit(number) for the children whose boxes meet the closed box, in their order.
    template <typename Visit> void VisitBox(const btVector3& lower, const btVector3& upper, const Visit& visit) const
    {
        for (size_t block = 0; block < m_blocks.size(); block++)
            for (size_t first = 0; first < s_width; first += qcLaneCount)
            {
                auto meet = [&](size_t axis)
                {
                    return (qcLoadLanes(m_blocks[block].lower[axis] + first) <= upper[int(axis)]) &
                           (qcLoadLanes(m_blocks[block].upper[axis] + first) >= lower[int(axis)]);
                };
                for (unsigned boxes = qcBitsOf(meet(0) & meet(1) & meet(2)); boxes != 0; boxes &= boxes - 1)
                    visit(block * s_width + first + unsigned(__builtin_ctz(boxes)));
            }
    }

  private:
    static constexpr size_t s_width = 8;
    /// Unused boxes are inverted: nothing meets them.
    struct Block
    {
        btScalar lower[3][s_width], upper[3][s_width];
    };

    void Add(const Child& child);

    std::vector<Child> m_children;
    std::vector<Block> m_blocks; ///< of the children, margins included
    size_t m_meshCount = 0;
    btScalar m_radius = 0;
    bool m_areRead = false, m_areAll = true;
};

#endif
