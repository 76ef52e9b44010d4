// An object of a world that holds meshes, or cores of convex shapes, with its motion in a step.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_OBJECT_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_OBJECT_H

#include "common/bisection.h"
#include "common/rigid_motion.h"
#include "mesh_contact/limits/swept_motion.h"
#include "mesh_contact/limits/swept_multibody.h"
#include "mesh_contact/limits/swept_shape.h"
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

struct qcSweptObject : qcSweptShape, qcSweptMotion
{
    btCollisionObject* object = nullptr;
    uint32_t number = 0; ///< in the order in which objects entered the world; see qcIdCounter
    uint32_t index = 0;  ///< in the present list of objects

    //  What moves it.
    btRigidBody* body = nullptr;           ///< null: no rigid body that Bullet moves
    const btMultiBody* owner = nullptr;    ///< of a link
    qcSweptMultiBody* multibody = nullptr; ///< of a link that joints move
    bool isDynamic = false;                ///< Bullet moves it alone: `body`, or a link of a multibody with a free base
    bool isHeld = false;                   ///< stays where it is, though Bullet moves it

    //  When the step started.
    bool isNew = true;      ///< it is in its first step
    bool wasActive = false; ///< a dynamic body that did not sleep when contact was searched
    bool wasFinite = true;
    /// Velocity of a body when contact was searched: without the step's forces. Empty: nothing had contact.
    std::optional<btVector3> before;

    //  Which part it takes in the step.
    uint64_t step = 0;                    ///< the last update that found the object in the world
    uint64_t detection = 0;               ///< the last one of triangles that has it
    bool isPaired = false;                ///< it was in a pair in this step
    bool rests = false;                   ///< see qcRestingMeshes
    const qcBatchObject* known = nullptr; ///< the object in the scene of contact, or null
    bool isLookedUp = false;              ///< `known` is of this step

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
    /// The end if the object makes no more than this part. Objects that don't move freely make all of their motion.
    btTransform EndAt(btScalar part) const
    {
        return IsFree() && part < MadePart() ? At(part) : end;
    }
    /// True if a mesh of another object is inside of one of its cores of this kind at the start of the step.
    bool EnclosesAtStart(qcSweptPart core, const qcSweptObject& other) const;
    /// Reads the children of a compound that stays, once a step.
    void ReadChildren();
    /// Sets `travel`.
    void FindTravel();
    /// Sets `moves` and the box, from start and end.
    void FindBox();
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
