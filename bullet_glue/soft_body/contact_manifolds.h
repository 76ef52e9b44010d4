// Contacts of soft bodies as Bullet manifolds, for whoever listens to the dispatcher or to Bullet's callbacks.
#ifndef QC_GLUE_SOFT_BODY_CONTACT_MANIFOLDS_H
#define QC_GLUE_SOFT_BODY_CONTACT_MANIFOLDS_H

#include "soft_body/response/position_constraints.h"

#include <tuple>

class btBroadphaseInterface;
class btDispatcher;
class btPersistentManifold;
class qcLiveObjects;

/// Manifolds are new ones in each step; what starts and ends is the contact of two bodies.
class qcManifolds
{
  public:
    ~qcManifolds();

    /// Gives all manifolds back. Nobody is told of an end: gContactDestroyedCallback alone, of points with user data.
    void Release();

    /// Reports the contacts that became constraints. Distances are between surfaces of the bodies' thickness: negative
    /// where they press into each other. Bodies whose world has no dispatcher are left out.
    void Publish(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& contacts);

    /// Tells Bullet's callbacks of what the last Publish changed: gContactStartedCallback of bodies that were not in
    /// contact before, gContactProcessedCallback of every point, gContactEndedCallback, with a manifold without points,
    /// of bodies that no longer are. Of bodies that have left the world nobody is told: what starts and ends may remove
    /// any.
    void Tell();

    /// That of the last Publish, until the next Release; else null.
    btBroadphaseInterface* GetBroadphase() const
    {
        return m_broadphase;
    }

  private:
    /// Two bodies in contact, of two soft ones the one that was added first first. An address may be another body
    /// later; what the broadphase numbers anew when a body is added tells them apart.
    struct Meeting
    {
        const btCollisionObject *a, *b;
        int uniqueIdA, uniqueIdB;

        bool IsPresent(qcLiveObjects* liveObjects) const;

        bool operator<(const Meeting& other) const
        {
            return std::tie(uniqueIdA, uniqueIdB, a, b) < std::tie(other.uniqueIdA, other.uniqueIdB, other.a, other.b);
        }
    };

    struct Published
    {
        btDispatcher* dispatcher; ///< that it came from
        btPersistentManifold* manifold;
        Meeting meeting;
        bool starts; ///< the first manifold of a contact that was not there before
    };

    bool Insert(const Meeting& meeting);
    btPersistentManifold* Next(btDispatcher* dispatcher, const Meeting& meeting);
    static bool AreAtRest(qcSoftBodyScene& scene, const Meeting& meeting);
    void TellStarts(qcLiveObjects* liveObjects);
    void TellPoints(qcLiveObjects* liveObjects);
    void TellEnds(const std::vector<Meeting>& ended, qcLiveObjects* liveObjects);

    std::vector<Published> m_manifolds;
    btBroadphaseInterface* m_broadphase = nullptr; ///< of the last Publish; null: there was none in this step
    std::vector<Meeting> m_meetings, m_before;     ///< of the last Publish, and as they were last told; in order
};

#endif
