// Contacts of soft bodies as Bullet manifolds, for readers of the dispatcher and for Bullet's callbacks.
#ifndef QC_GLUE_SOFT_BODY_CONTACT_MANIFOLDS_H
#define QC_GLUE_SOFT_BODY_CONTACT_MANIFOLDS_H

#include "soft_body/response/position_constraints.h"

#include <tuple>

class btBroadphaseInterface;
class btDispatcher;
class btPersistentManifold;
class qcLiveObjects;

/// Manifolds are new in each step; a contact of two bodies lasts from its start to its end over many steps.
class qcContactManifolds
{
  public:
    ~qcContactManifolds();

    /// Returns all manifolds to their dispatchers. Calls gContactDestroyedCallback for points with user data, and no
    /// other callback.
    void Release();

    /// Makes manifolds of the contacts that became constraints. Distances are between surfaces of the bodies'
    /// thickness: negative where they press into each other. Bodies whose world has no dispatcher are left out.
    void Publish(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& contacts);

    /// Calls gContactStartedCallback for each pair of bodies in contact that was not in the previous Publish,
    /// gContactProcessedCallback for each point, and gContactEndedCallback, with a manifold without points, for each
    /// pair of the previous Publish that is no longer in contact. Pairs with a body that has left the world are left
    /// out; the callbacks of starts and ends may remove bodies.
    void DispatchCallbacks();

    /// The broadphase of the last Publish; null after Release.
    btBroadphaseInterface* GetBroadphase() const
    {
        return m_broadphase;
    }

  private:
    /// Two bodies in contact; `a` is soft, and the one that was added first if both are.
    struct BodyPair
    {
        const btCollisionObject *a, *b;
        int uniqueIdA, uniqueIdB; ///< see qcUniqueIdOf

        bool IsLive(qcLiveObjects* liveObjects) const;

        bool operator<(const BodyPair& other) const
        {
            return std::tie(uniqueIdA, uniqueIdB, a, b) < std::tie(other.uniqueIdA, other.uniqueIdB, other.a, other.b);
        }
    };

    struct Published
    {
        btDispatcher* dispatcher; ///< owner of the manifold
        btPersistentManifold* manifold;
        BodyPair pair;
        bool starts; ///< first manifold of a contact that starts in this step
    };

    static BodyPair PairOf(qcSoftContactView* view);
    bool Insert(const BodyPair& pair);
    btPersistentManifold* NextManifold(btDispatcher* dispatcher, const BodyPair& pair);
    static bool AreAtRest(qcSoftBodyScene& scene, const BodyPair& pair);
    void DispatchStarts(qcLiveObjects* liveObjects) const;
    void DispatchPoints(qcLiveObjects* liveObjects) const;
    static void DispatchEnds(const std::vector<BodyPair>& ended, qcLiveObjects* liveObjects);

    std::vector<Published> m_manifolds;
    btBroadphaseInterface* m_broadphase = nullptr; ///< of the last Publish; null: there was none in this step
    std::vector<BodyPair> m_pairs;                 ///< of the last Publish, sorted
    std::vector<BodyPair> m_previousPairs;         ///< of the last DispatchCallbacks, sorted
};

#endif
