// The meshes of a compound that stays in a step, with boxes around them: many hulls pass a level, each near few of
// them.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_CHILDREN_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_CHILDREN_H

#include "common/lanes.h"
#include "quickcullide/bullet_mesh.h"

#include <vector>

class qcSweptChildren
{
  public:
    struct Child
    {
        const qcMeshShape* mesh;
        btTransform local; ///< from its frame to the object's
    };

    /// Reads the shapes in a compound of any depth. Bullet's tree of a compound is not enough: it has the boxes of when
    /// a child was added. O(children).
    void Read(const btCollisionShape* compound);
    /// Forgets them.
    void Clear();

    /// False: Read has not been called since Clear.
    bool AreRead() const
    {
        return m_areRead;
    }
    /// True if all shapes are qcMeshShapes.
    bool AreMeshes() const
    {
        return m_areMeshes;
    }
    /// Upper bound of the distance of the boxes' points from the object's origin.
    btScalar Radius() const
    {
        return m_radius;
    }
    /// Calls visit(child) for the children whose boxes meet the closed box, in their order.
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
                    visit(m_children[block * s_width + first + unsigned(__builtin_ctz(boxes))]);
            }
    }

  private:
    static constexpr size_t s_width = 8;
    /// Unused boxes are inverted: nothing meets them.
    struct Block
    {
        btScalar lower[3][s_width], upper[3][s_width];
    };

    void Add(const btCollisionShape* shape, const btTransform& local);

    std::vector<Child> m_children;
    std::vector<Block> m_blocks; ///< of the children, margins included
    btScalar m_radius = 0;
    bool m_areRead = false, m_areMeshes = true;
};

#endif
