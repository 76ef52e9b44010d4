// Which objects have their triangles moved by the application.
#ifndef QC_GLUE_SOFT_BODY_SCENE_RESHAPED_OBJECTS_H
#define QC_GLUE_SOFT_BODY_SCENE_RESHAPED_OBJECTS_H

#include "common/changed_shapes.h"
#include "soft_body/scene/object_starts.h"
#include "soft_body/scene/shape_surface.h"

class qcReshapedObjects
{
  public:
    /// Reads the shapes of a step's objects, but of those that Bullet moves. O(objects).
    void Read(const std::vector<qcObjectStarts::Present>& objects);
    /// The triangles of one of Bullet's own shapes have changed where its revision doesn't show it.
    void InvalidateShape(const btCollisionShape* shape);
    /// Those whose triangles are not the ones that the first Read found, in the order of the last Read.
    const std::vector<btCollisionObject*>& Objects() const
    {
        return m_reshaped;
    }

  private:
    struct State
    {
        uint64_t revision;       ///< of all its triangles
        uint64_t step;           ///< the last one that has read the object
        bool isReshaped = false; ///< the revision has changed
    };

    void ReadObject(btCollisionObject* object);

    std::unordered_map<qcObjectKey, State, qcObjectKeyHash> m_states;
    qcChangedShapes m_changedShapes; ///< since the last Read
    std::vector<btCollisionObject*> m_reshaped;
    uint64_t m_step = 0;
};

#endif
