// Cores of convex shapes: polyhedra inside of them that pass no mesh, however fast the shapes' bodies are, and however
// hard they are pressed.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_CONVEX_CORES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_CONVEX_CORES_H

#include "common/compound_children.h"
#include "common/support_mesh.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <memory>
#include <unordered_map>

// The size of cores, as a part of their shapes' size. Contact lets bodies penetrate a little: a core has to be further
// inside.
constexpr btScalar qcCoreSize = btScalar(0.9);
// For pairs whose mesh and core are in each other already.
constexpr btScalar qcInnerCoreSize = btScalar(0.4);

/// The core of a convex shape, in the shape's frame: a part of the hull of its outermost points along some directions.
struct qcConvexCore
{
    const btConvexShape* shape = nullptr;
    std::unique_ptr<qcMeshShape> mesh; ///< null: the shape is flat, empty or not finite
    std::shared_ptr<const qcSupportMesh> hull;
    btScalar halfWidth = 0; ///< smallest distance of the mesh's faces from its centre
};

/// Keeps the cores that have been used lately.
class qcConvexCores
{
  public:
    /// `size`: qcCoreSize or qcInnerCoreSize.
    explicit qcConvexCores(btScalar size) : m_size(size)
    {
    }
    /// Begins a step.
    void BeginStep();
    /// The core, made anew in the first call of a step if the shape is not as it was; see qcConvexRevision. Valid until
    /// the next BeginStep.
    const qcConvexCore& Find(const btConvexShape* shape);
    /// Calls function(core, place) for the cores of a shape's convex parts; `place`: in the shape's frame.
    template <typename Function> void ForEachCore(const btCollisionShape* shape, const Function& function)
    {
        auto find = [this, &function](const btCollisionShape* simple, const btTransform& place)
        {
            if (!simple->isConvex())
                return;
            const qcConvexCore& core = Find(static_cast<const btConvexShape*>(simple));
            if (core.mesh != nullptr)
                function(core, place);
        };
        qcForEachSimpleShape(shape, btTransform::getIdentity(), find);
    }

  private:
    struct Entry
    {
        uint64_t revision = 0;
        uint64_t step = 0; ///< the last one that used it
        qcConvexCore core;
    };

    static qcConvexCore MakeCore(const btConvexShape* shape, btScalar size);

    const btScalar m_size;
    std::unordered_map<const btConvexShape*, Entry> m_entries;
    uint64_t m_step = 1;
};

#endif
