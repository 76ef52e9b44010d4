// An object of a world that holds meshes, or cores of convex shapes, with its motion in a step.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_OBJECT_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_OBJECT_H

#include "common/bisection.h"
#include "common/rigid_motion.h"
#include "mesh_contact/limits/swept_floor.h"
#include "mesh_contact/limits/swept_mesh.h"
#include "mesh_contact/limits/swept_multibody.h"
#include "mesh_contact/scene/batch_scene.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <optional>

/// The body, if Bullet moves it; null otherwise.
inline btRigidBody* qcDynamicBody(btCollisionObject* object)
{
    btRigidBody* body = btRigidBody::upcast(object);
    return body != nullptr && !body->isStaticOrKinematicObject() && body->getInvMass() > 0 ? body : nullptr;
}

/// What of an object is tested as a hull.
struct qcSweptHull
{
    const qcSupportMesh* mesh;
    btTransform local; ///< from its frame to the object's
};

struct qcSweptObject
{
    btCollisionObject* object = nullptr;
    btRigidBody* body = nullptr;           ///< null: no rigid body that Bullet moves
    const btMultiBody* owner = nullptr;    ///< of a link
    qcSweptMultiBody* multibody = nullptr; ///< of a link that joints move
    bool isDynamic = false;                ///< Bullet moves it alone: `body`, or a link of a multibody with a free base
    bool isHeld = false;                   ///< stays where it is, though Bullet moves it
    uint32_t number = 0;                   ///< in the order in which objects entered the world; see qcIdCounter
    uint32_t index = 0;                    ///< in the present list of objects
    uint64_t step = 0;                     ///< the last update that found the object in the world
    uint64_t detection = 0;                ///< the last one of triangles that has it
    btScalar radius = 0;                   ///< of a sphere around its shape, about its origin
    bool hasMesh = false;                  ///< one of its shapes consists of triangles; planes do not
    bool isOurs = false;                   ///< contact of one of its meshes with any other mesh is computed here
    qcConvexCores* cores = nullptr;        ///< its convex shapes are swept as these; null: they are not
    qcConvexCores* innerCores = nullptr;   ///< likewise, for pairs that need them; null: none does
    int coreSteps = 0;                     ///< for how long they are swept yet
    btScalar halfWidth = BT_LARGE_FLOAT;   ///< the least of its cores
    btScalar travel = 0;                   ///< upper bound of its points' motion from start to target
    const qcSupportMesh* hull = nullptr;   ///< its mesh or core, if it consists of one small one
    std::vector<qcSweptHull> hulls;        ///< all that is tested of it; empty: hulls are not all
    bool isNew = true;                     ///< in its first step
    bool wasActive = false;                ///< a dynamic body that did not sleep when contact was searched
    bool wasFinite = true;                 ///< when the step started
    /// Velocity of a body when contact was searched: without the step's forces. Empty: nothing had contact.
    std::optional<btVector3> before;
    bool moves = false;                   ///< its end is not its start
    bool isPaired = false;                ///< it was in a pair in this step
    bool rests = false;                   ///< see qcRestingMeshes
    const qcBatchObject* known = nullptr; ///< the object in the scene of contact, or null
    bool isLookedUp = false;              ///< `known` is of this step
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
    /// True if the application moves the object.
    bool IsSwept() const
    {
        return !IsFree() && moves;
    }
    /// True for a dynamic body, and for a link that joints have moved in the step.
    bool CanBeCut() const
    {
        return body != nullptr || (multibody != nullptr && moves);
    }
    /// True if a plane between it and the other object can push it.
    bool CanBePushedBy(const qcSweptObject& other) const
    {
        return body != nullptr || (multibody != nullptr && (multibody->Yields() || other.IsSwept()));
    }
    /// The gap that contact needs around what is tested. Cores need none: they are inside of their shapes, for some of
    /// which Bullet's margin is their radius.
    btScalar Margin() const
    {
        return cores != nullptr ? btScalar(0) : object->getCollisionShape()->getMargin();
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
    /// Adds what `cores` has: sets `hasMesh`, `halfWidth`, `hulls` and, for a convex shape, `hull`.
    void ReadCores();
    /// True if a mesh of another object is inside of one of its cores of this kind at the start of the step.
    bool EnclosesAtStart(qcSweptPart core, const qcSweptObject& other) const;
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
using qcPairNumbers = std::pair<uint32_t, uint32_t>;           ///< of two objects, the lower one first

inline qcPairNumbers qcNumbersOf(const qcSweptPair& pair)
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
    return qcBisect(btScalar(0), limit, bisections, holds);
}

#endif
