// The objects of a world that hold meshes, and its fast convex shapes, with their motion in a step, and the pairs whose
// motions overlap.
#ifndef QC_GLUE_MESH_CONTACT_SWEPT_OBJECTS_H
#define QC_GLUE_MESH_CONTACT_SWEPT_OBJECTS_H

#include "common/rigid_limits.h"
#include "mesh_contact/axis_cache.h"
#include "mesh_contact/batch_scene.h"
#include "mesh_contact/swept_mesh.h"
#include "mesh_contact/swept_multibody.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <memory>

/// A static plane under a small mesh. Limits move the mesh no deeper into it than it was at the target.
struct qcSweptFloor
{
    btVector3 normal; ///< unit, upwards
    btScalar level;   ///< least product of a vertex with the normal

    /// Height of the mesh's lowest vertex above the level, where it has this transform.
    btScalar HeightOf(const qcSupportMesh& mesh, const btTransform& place) const;
};

struct qcSweptObject
{
    btCollisionObject* object = nullptr;
    btRigidBody* body = nullptr;           ///< null: no rigid body that Bullet moves
    const btMultiBody* owner = nullptr;    ///< of a link
    qcSweptMultiBody* multibody = nullptr; ///< of a link that has moved, so that its motion can be cut
    bool isDynamic = false;                ///< Bullet moves it alone: `body`, or a link of a multibody with a free base
    uint32_t number = 0;                   ///< in the order in which objects entered the world; see qcIdCounter
    uint32_t index = 0;                    ///< in the present list of objects
    uint64_t step = 0;                     ///< the last update that found the object in the world
    bool hasMesh = false;                  ///< one of its shapes consists of triangles; planes do not
    bool isOurs = false;                   ///< contact of one of its meshes with any other mesh is computed here
    qcConvexCores* cores = nullptr;        ///< its convex shapes are swept as these; null: they are not
    int coreSteps = 0;                     ///< for how long they are swept yet
    btScalar halfWidth = BT_LARGE_FLOAT;   ///< the least of its cores
    btScalar travel = 0;                   ///< upper bound of its points' motion from start to target
    const qcSupportMesh* hull = nullptr;   ///< its mesh or core, if it consists of one small one
    bool isNew = true;                     ///< in its first step
    bool wasActive = false;                ///< a dynamic body that did not sleep when contact was searched
    bool wasFinite = true;                 ///< when the step started
    bool moves = false;                    ///< its end is not its start
    const qcBatchObject* known = nullptr;  ///< the object in the scene of contact, or null
    bool isLookedUp = false;               ///< `known` is of this step
    btTransform start, target; ///< before and after the step; the target is Bullet's, or where planes have pushed it
    btTransform carried;       ///< the start, moved by the common motion of its island
    btTransform end;           ///< after the step, as the limiter has it so far
    btTransform tested;        ///< the end at the last detection of this step
    btTransform certified;     ///< the end in the last round of certificates
    bool isUnmoved = false;    ///< the end is the one certified in this step's last round
    btTransform next;          ///< where the next step starts
    btTransform last;          ///< where the previous step ended
    uint32_t pushes = 0;       ///< number of times that planes have moved the end
    btScalar fraction = 1;     ///< of the motion from `carried` to the target that the body makes
    btVector3 motion{0, 0, 0}; ///< of the origin in the previous step, for objects that Bullet does not move
    btScalar lost = 0;         ///< part of its own motion that the object has not made in this step
    bool isLimited = false;    ///< it does not end this step where Bullet had moved it
    btVector3 lower, upper;    ///< box around the meshes at start and end
    std::vector<qcSweptFloor> floors; ///< of a dynamic body that consists of one small mesh
    /// Empty until the object is near another one, has contact, or its triangles are moved by the application.
    std::vector<qcSweptMesh> meshes;
    uint64_t revision = 0; ///< of the triangles of an object that Bullet does not move, in the last step; 0: none

    /// False: the application alone moves the object, and its motion is not cut.
    bool IsFree() const
    {
        return body != nullptr || multibody != nullptr;
    }
    /// True if planes can push the object.
    bool CanPush() const
    {
        return body != nullptr || (multibody != nullptr && multibody->Yields());
    }
    /// The part of its motion that the object makes.
    btScalar MadePart() const
    {
        return multibody != nullptr ? multibody->Fraction() : fraction;
    }
    /// The transform after this part of the motion; `carried` and target exactly for 0 and 1. For links about.
    btTransform At(btScalar part) const;
    /// The end if the object makes no more than this part. Objects that don't move freely make all of their motion.
    btTransform EndAt(btScalar part) const
    {
        return IsFree() && part < MadePart() ? At(part) : end;
    }
    /// Sets `travel`.
    void FindTravel();
    /// Sets `moves` and the box, from start and end.
    void FindBox();
    /// True if a mesh of it deforms in the step.
    bool Deforms() const
    {
        return std::any_of(meshes.begin(), meshes.end(), [](const qcSweptMesh& mesh) { return mesh.Deforms(); });
    }
};

using qcSweptPair = std::pair<qcSweptObject*, qcSweptObject*>; ///< the lower number first

/// The numbers of two objects, the lower one first.
inline std::pair<uint32_t, uint32_t> qcNumbersOf(const qcSweptPair& pair)
{
    return std::minmax(pair.first->number, pair.second->number);
}

/// The order of pairs, by the numbers of their objects.
inline bool qcIsBefore(const qcSweptPair& x, const qcSweptPair& y)
{
    return qcNumbersOf(x) < qcNumbersOf(y);
}

/// The largest part of a motion, up to `limit` and bisection, for which `holds` is true; below 0: none.
template <class Holds> btScalar qcFindLargestPart(btScalar limit, const Holds& holds)
{
    if (holds(limit))
        return limit;
    if (!holds(btScalar(0)))
        return -1;
    constexpr int bisections = 16; // a part of 1e-5 of the motion is left undecided
    btScalar low = 0, high = limit;
    for (int i = 0; i < bisections; i++)
    {
        btScalar middle = (low + high) / 2;
        (holds(middle) ? low : high) = middle;
    }
    return low;
}

class qcSweptObjects
{
  public:
    qcSweptObjects(const qcBatchSettings& settings, qcAxisCache& axes) : m_settings(settings), m_axes(axes)
    {
    }

    /// Keeps the triangles of an object that Bullet does not move, since the application may move them.
    void KeepTriangles(const btCollisionObject* object);
    /// Call it after the triangles of a shape have changed.
    void InvalidateShape(const btCollisionShape* shape)
    {
        m_changes[shape]++;
    }
    /// Dynamic objects start the step here. Without this call within the step, starts follow from velocities.
    void MarkStarts();
    /// Finds the starts of the step that ends now, then does what ReadTargets does.
    bool ReadMotions(btScalar timeStep, qcScene* scene);
    /// Forgets the multibodies that the world steps no more: they may be gone. Call it before what reads the world
    /// again in a step.
    void ForgetGoneMultiBodies()
    {
        FindMultiBodies(false);
    }
    /// Reads the present transforms as the targets. Meshes of objects that left the world, or are not finite, are
    /// removed from the scene.
    /// True if an object has moved.
    bool ReadTargets(const qcStartFunction& startOf, qcScene* scene);
    /// Moves multibodies by the pushes since the last call.
    void CommitMultiBodies();
    /// Moves multibodies whose motion was cut since the last call.
    void MoveMultiBodies();
    /// Returns the multibody of a link to the start of the step, if that is known. If it was not there, all its links
    /// are appended to `moved`.
    void ReturnMultiBody(const btCollisionObject* link, std::vector<const btCollisionObject*>* moved);
    /// Adapts the velocities of multibodies whose motion was cut.
    void UpdateMultiBodies() const;
    /// The pairs that collide and whose boxes overlap; at least one of the two moves, and one is not isUnmoved.
    void FindPairs(std::vector<qcSweptPair>* pairs);
    /// The next step starts at the present transforms.
    void RecordEnds();
    /// True if all objects in the world that are finite are where RecordEnds has seen them.
    bool AreAtEnds();
    /// Calls function(object) for all links of multibodies that were pushed or cut since ReadTargets.
    template <typename Function> void ForEachLimitedLink(Function function) const
    {
        for (const auto& [body, multibody] : m_multibodies)
            if (multibody->IsLimited())
                multibody->ForEachCollider(function);
    }
    /// The entry of an object in the world, or null.
    qcSweptObject* Find(const btCollisionObject* object) const;

    /// An object that may hold meshes and is not finite, which the last ReadTargets has left out, or null.
    const btCollisionObject* NotFinite() const
    {
        return m_notFinite;
    }
    /// All objects, by number.
    const std::vector<qcSweptObject*>& Get() const
    {
        return m_sorted;
    }

  private:
    /// A translation of all dynamic objects since the previous step, by the application. Zero: there is none.
    struct Shift
    {
        btVector3 by{0, 0, 0};
        btScalar error = 0; ///< of a displacement, by rounding

        bool IsOf(const btTransform& from, const btTransform& to) const;
    };

    Shift FindCommonShift() const;
    void StartWherePut();
    qcSweptObject* Add(const btCollisionObject* object);
    static void FindStart(btScalar timeStep, qcSweptObject* swept);
    void ReadTriangles(qcSweptObject* swept, qcScene* scene) const;
    void EndDeformations() const;
    void RemoveGone(qcScene* scene);
    btScalar TravelNear(const btCollisionObject* object) const;
    bool TakesCores(const btCollisionObject* object);
    qcSweptObject& ReadTarget(btCollisionObject* object, bool takesCores, qcScene* scene);
    bool ReadObjects(qcScene* scene);
    void FindMultiBodies(bool adds);
    qcSweptMultiBody* FindMultiBody(const btCollisionObject* object) const;
    void FindPlanes();
    void FindFloors(qcSweptObject* swept) const;
    bool IsLeftOut(const qcSweptObject& a, const qcSweptObject& b) const;
    bool Collide(const qcSweptObject& a, const qcSweptObject& b) const;

    const qcBatchSettings& m_settings;
    qcAxisCache& m_axes;
    qcConvexCores m_cores;
    btScalar m_timeStep = 0;
    std::vector<const qcSweptObject*> m_movingMeshes; ///< of those whose contact is computed here
    const btCollisionObject* m_notFinite = nullptr;
    size_t m_coreCount = 0; ///< objects whose convex shapes are swept
    bool m_anyOurs = false; ///< there is an object whose contact is computed here
    std::unordered_map<qcObjectKey, std::unique_ptr<qcSweptObject>, qcObjectKeyHash> m_objects;
    std::vector<qcSweptObject*> m_sorted;
    std::unordered_map<const btMultiBody*, std::unique_ptr<qcSweptMultiBody>> m_multibodies;
    std::unordered_map<const btCollisionShape*, uint64_t> m_changes; ///< calls of InvalidateShape
    std::vector<const btCollisionObject*> m_planes;                  ///< static ones
    std::vector<qcSweptObject*> m_byLower;                           ///< along the first axis
    qcIdCounter m_numbers;
    uint64_t m_step = 0;
    bool m_isMarked = false;    ///< the starts of the present step
    bool m_findsStarts = false; ///< while motions are read: starts are not marked
};

#endif
