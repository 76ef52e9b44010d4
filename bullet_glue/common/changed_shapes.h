// Shapes whose triangles the application has changed in place, which the revisions of Bullet's own shapes don't show:
// what is known of them is marked as stale at once, and objects that have them are found when they are next read.
#ifndef QC_GLUE_COMMON_CHANGED_SHAPES_H
#define QC_GLUE_COMMON_CHANGED_SHAPES_H

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <cstdint>
#include <unordered_set>

/// Revision of a mesh whose shape has changed since the mesh was read. No shape has it; see qcMeshRevision.
constexpr uint64_t qcStaleRevision = 0;

class qcChangedShapes
{
  public:
    void Add(const btCollisionShape* shape)
    {
        m_shapes.insert(shape);
    }
    bool Has(const btCollisionShape* shape) const
    {
        return m_shapes.count(shape) > 0;
    }
    /// All objects have been read.
    void Clear()
    {
        m_shapes.clear();
    }

  private:
    std::unordered_set<const btCollisionShape*> m_shapes;
};

#endif
