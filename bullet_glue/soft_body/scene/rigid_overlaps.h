// Rigid objects with meshes that are near soft bodies, or may have been within the step.
#ifndef QC_GLUE_SOFT_BODY_SCENE_RIGID_OVERLAPS_H
#define QC_GLUE_SOFT_BODY_SCENE_RIGID_OVERLAPS_H

#include "soft_body/scene/object_starts.h"

#include <array>
#include <vector>

/// An object near a soft body.
struct qcRigidOverlap
{
    btCollisionObject* object;
    bool withSurfaces; ///< the surfaces of Bullet's own shapes count, too
    btVector3 box[2];  ///< around the soft bodies near it
};

class qcRigidOverlaps
{
  public:
    /// Begins a step, of which `starts` has the objects.
    void Begin(const qcObjectStarts& starts);
    /// The objects of the step that may have meshes.
    const std::vector<qcObjectStarts::Present>& Candidates() const
    {
        return m_candidates;
    }
    /// Adds the objects whose proxies or motions over the step overlap the box of a soft body. `withSurfaces`: also
    /// those without a qcMeshShape. An object may be added more than once.
    void Collect(const qcObjectStarts& starts, btBroadphaseInterface* broadphase, const btVector3& lower,
                 const btVector3& upper, bool withSurfaces);
    /// True if a box overlaps one of Collect's since Begin or ForgetBoxes.
    bool IsNear(const btVector3 box[2]) const;
    void ForgetBoxes()
    {
        m_boxes.clear();
    }
    /// Adds overlaps of other objects, merged.
    void Add(const std::vector<qcRigidOverlap>& overlaps);
    /// True if there is one of the object. Call it only while they are merged. O(log n).
    bool Has(const btCollisionObject* object) const;
    /// Leaves one overlap for each object, in the order in which they were added to the world.
    void Merge();
    /// Adds the other links of multibodies, merged: pushes on one link move all.
    void AddLinks();
    const std::vector<qcRigidOverlap>& All() const
    {
        return m_overlaps;
    }
    void Clear()
    {
        m_overlaps.clear();
    }

  private:
    std::vector<qcObjectStarts::Present> m_candidates;
    std::vector<qcRigidOverlap> m_overlaps;
    std::vector<std::array<btVector3, 2>> m_boxes;
};

#endif
