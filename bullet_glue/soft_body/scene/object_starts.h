// Where the objects of a world were at the start of a step: the application may move any of them between two steps, and
// over soft bodies.
#ifndef QC_GLUE_SOFT_BODY_SCENE_OBJECT_STARTS_H
#define QC_GLUE_SOFT_BODY_SCENE_OBJECT_STARTS_H

#include "common/object_key.h"
#include "common/object_motion.h"
#include "common/rigid_limits.h"
#include "soft_body/scene/objects_in_box.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <LinearMath/btAabbUtil2.h>

#include <functional>
#include <unordered_map>
#include <utility>
#include <vector>

class qcObjectStarts
{
  public:
    using ObjectFunction = std::function<void(const btCollisionObject*)>;
    /// The step starts: reads where the application has left the bodies that Bullet moves. Calls function(object) for
    /// each object. O(objects).
    void Begin(const qcBroadphases& broadphases, const ObjectFunction& function);
    /// Reads again where the application has left these bodies, after its callbacks within the step.
    void ReadBegin(const qcBroadphases& broadphases);
    /// True if the application has moved all objects that were there by one translation since the previous step.
    /// Kinematic ones may move in addition.
    /// O(objects).
    bool AreShiftedBy(const qcTranslation& translation, const qcBroadphases& broadphases) const;
    /// From now on what the application has moved by this translation since the previous step was put where it is, in
    /// this step: the origin of the world is another one.
    void SetShift(const qcTranslation& translation)
    {
        m_shift = translation;
    }
    /// True: whatever the application has moved since the previous step was put where it is.
    void SetRestored(bool isRestored)
    {
        m_isRestored = isRestored;
    }
    /// Reads the objects of the step, after Bullet has moved them, but those that are not finite. Objects that have
    /// left the broadphases are forgotten. `limits`: what they have moved is not put elsewhere; or null. O(objects).
    void Read(const qcBroadphases& broadphases, btScalar timeStep, const qcRigidLimits* limits);
    using BoxFunction = std::function<void(const btVector3&, const btVector3&)>;
    /// Calls function(lower, upper) for the motion of each object that the application has moved since the previous
    /// step, Bullet does not move and others respond to. O(objects).
    void ForEachPlaced(const qcBroadphases& broadphases, const BoxFunction& function) const;
    /// The object's transform at the start of the step: where the previous one left it, unless it was put elsewhere
    /// since. Read has seen it.
    const btTransform& StartOf(const btCollisionObject* object) const;
    /// True if the object starts the step where it began: the application has not moved it since the previous one.
    bool StartsAtBegin(const btCollisionObject* object) const;
    /// The object's motion ends the step at its present transform. For those that contacts have moved since Read.
    void RecordEnd(const btCollisionObject* object);
    /// The objects of a step, soft bodies left out, and the broadphase of each.
    struct Present
    {
        btCollisionObject* object;
        btBroadphaseInterface* broadphase;
    };

    /// Those that Read has seen. Valid until the next step.
    const std::vector<Present>& Objects() const
    {
        return m_present;
    }
    /// True for one of those, and for one that has entered the world since the step began.
    bool Has(const qcObjectKey& key) const
    {
        return m_states.count(key) > 0;
    }
    /// One of the objects that the last Read has left out, since they are not finite; null: there is none.
    const btCollisionObject* NotFinite() const
    {
        return m_notFinite;
    }
    /// Calls function(object) for each object whose motion over the step overlaps a box.
    template <typename Function>
    void ForEachMoved(const btVector3& lower, const btVector3& upper, Function function) const
    {
        for (const Moved& moved : m_moved)
            if (TestAabbAgainstAabb2(moved.lower, moved.upper, lower, upper))
                function(moved.object);
    }

  private:
    struct State
    {
        btTransform start = btTransform::getIdentity(); ///< of the step
        btTransform begin =
            start; ///< of the step as the application has left it: of bodies that Bullet moves, and of all that rest
        btTransform end = start;   ///< of the step; before Read that of the previous one
        btVector3 motion{0, 0, 0}; ///< of the origin in the step
        uint64_t step = 0;         ///< the last one that has read the object; that of a resting one is older
        size_t place = 0;          ///< in m_places
    };

    /// What the steps of most objects need: they rest, and nothing else of them is read.
    struct Place
    {
        qcObjectKey key;
        State* state;
        bool rests;     ///< it was at `at` from the beginning of the last step to its end
        btTransform at; ///< set if it rests

        /// True if it rests, and is there.
        bool RestsAt(const btTransform& now) const
        {
            return rests && qcAreSame(at, now);
        }
    };

    struct Moved
    {
        btCollisionObject* object;
        btVector3 lower, upper;
    };

    Place* FindPlace(const btCollisionObject* object, size_t index);
    std::pair<Place*, bool> FindOrAdd(const btCollisionObject* object);
    void Wake(const State& state);
    void BeginObject(const btCollisionObject* object, size_t index);
    void ForgetAbsent();
    static Moved MakeMoved(btCollisionObject* object, const btTransform& from);
    void ReadState(btCollisionObject* object, State* read, bool isNew, btScalar timeStep, const qcRigidLimits* limits);
    void ReadObject(btCollisionObject* object, btScalar timeStep, const qcRigidLimits* limits);

    std::unordered_map<qcObjectKey, State, qcObjectKeyHash> m_states;
    std::vector<Place> m_places; ///< those of the last step's m_present
    std::vector<Present> m_present;
    std::vector<Moved> m_moved;
    const btCollisionObject* m_notFinite = nullptr;
    qcTranslation m_shift; ///< see SetShift
    bool m_isRestored = false;
    size_t m_count = 0; ///< objects read in this step
    uint64_t m_step = 0;
};

#endif
