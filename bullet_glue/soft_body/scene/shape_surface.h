// The surfaces of Bullet's simple shapes as triangles, as soft bodies collide with them, kept per shape.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SHAPE_SURFACE_H
#define QC_GLUE_SOFT_BODY_SCENE_SHAPE_SURFACE_H

#include "common/shape_owners.h"
#include "quickcullide/bullet_mesh.h"

#include <functional>
#include <map>
#include <memory>
#include <tuple>

/// True if qcSurfaceCache has triangles of such a shape: a convex one, a mesh, a terrain or a plane, but no compound,
/// btSdfCollisionShape or qcMeshShape. A cheap test of its type.
bool qcHasSurface(const btCollisionShape* shape);

/// The triangles of a shape in its frame.
struct qcShapeSurface
{
    /// Its margin is the distance at which soft bodies are kept from the triangles. Null: there are no triangles.
    std::unique_ptr<qcMeshShape> mesh;
    bool isWhole = true;       ///< false: the mesh has what lies in the region
    bool isConvex = false;     ///< a closed convex surface
    btVector3 inside{0, 0, 0}; ///< a point inside of it, in the shape's frame
    btVector3 region[2];       ///< lower and upper corner, in the shape's frame
    uint64_t sourcesHash = 0;  ///< of the numbers that the triangles have in Bullet; 0: not a mesh, or a part of one

    /// True if the mesh has all of the surface that overlaps the box.
    bool Covers(const btVector3 box[2]) const;
};

/// Surfaces by shape. Planes and very large meshes have theirs by object: what lies near the soft bodies.
class qcSurfaceCache
{
  public:
    /// A number that changes with the shape, by what Bullet's functions change.
    static uint64_t RevisionOf(const btCollisionShape* shape);
    /// The surface of a shape with this revision. `box`: lower and upper corner, in the shape's frame, of the region
    /// that it has to cover. isLive(key): an object is in its world.
    std::shared_ptr<const qcShapeSurface> Find(const btCollisionShape* shape, uint64_t revision,
                                               const btCollisionObject* object, const btVector3 box[2],
                                               const std::function<bool(const qcObjectKey&)>& isLive);
    /// The shape's triangles have changed where its revision doesn't show it: they are read anew.
    void Forget(const btCollisionShape* shape);
    /// Call it once in a step: frees what was not in use for some seconds.
    void EndStep();

  private:
    struct Entry
    {
        uint64_t revision;
        std::shared_ptr<const qcShapeSurface> surface;
        uint64_t lastStep; ///< in which an object had it
        qcShapeOwners owners;
    };

    std::map<std::tuple<const void*, const void*>, Entry> m_entries; ///< by shape and, in part, object
    uint64_t m_step = 0;
};

#endif
