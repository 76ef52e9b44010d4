// Shapes whose triangles the application has changed in place, which the revisions of Bullet's own shapes don't show:
// what is known of them is marked as stale at once, and objects that have them are found when they are next read.
#ifndef QC_GLUE_COMMON_CHANGED_SHAPES_H
#define QC_GLUE_COMMON_CHANGED_SHAPES_H

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <algorithm>
#include <cstdint>
#include <vector>

/// Revision of a mesh whose shape has changed since the mesh was read. No shape has it; see qcMeshRevision.
constexpr uint64_t qcStaleRevision = 0;

class qcChangedShapes
{
  public:
    void Add(const btCollisionShape* shape)
    {
        if (!Has(shape))
            m_shapes.push_back(shape);
    }
    bool Has(const btCollisionShape* shape) const
    {
        return std::find(m_shapes.begin(), m_shapes.end(), shape) != m_shapes.end();
    }
    /// All objects have been read.
    void Clear()
    {
        m_shapes.clear();
    }

  private:
    std::vector<const btCollisionShape*> m_shapes;
};

#endif
