// Pairs of small meshes that a plane separates: their contact needs no search among triangles.
#ifndef QC_GLUE_MESH_CONTACT_PLANES_PLANE_PAIRS_H
#define QC_GLUE_MESH_CONTACT_PLANES_PLANE_PAIRS_H

#include "mesh_contact/planes/axis_cache.h"
#include "mesh_contact/planes/plane_contact.h"
#include "mesh_contact/scene/batch_scene.h"

#include <array>

class qcPlanePairs
{
  public:
    explicit qcPlanePairs(qcAxisCache& cache) : m_cache(cache)
    {
    }

    enum class Contact
    {
        none,    ///< not known: its triangles have to be tested
        atStart, ///< at the beginning of the step: the two turn, and have to be sampled
        all      ///< of the step
    };
    /// Computes the contact of all pairs of a step, at the transforms that the scene has, and of bodies that follow one
    /// that is stopped in the step. `threads`: see qcWorkersOf.
    void Compute(const std::vector<qcBatchPair>& pairs, btScalar timeStep, unsigned threads);
    /// What is known of a pair, by its index in the last Compute.
    Contact KnownOf(size_t index) const
    {
        return m_results[index].known;
    }
    /// True if Compute has computed the contact of two meshes, named by their slots.
    bool Has(uint32_t slotA, uint32_t slotB) const
    {
        return Find(slotA, slotB) != nullptr;
    }
    /// Appends the points of such a pair, in world space. Returns a lower bound of the distance of its triangles.
    double AppendPoints(qcBodyId a, qcBodyId b, std::vector<qcMeshPoint>* points) const;

    int GetPairCount() const
    {
        return int(m_pairs.size());
    }

  private:
    struct Pair
    {
        uint32_t low, high; ///< slots
        bool isSwapped;     ///< points have the higher slot as A
        uint32_t worker;    ///< whose points the pair has
        size_t begin, end;  ///< points
        btScalar gap;       ///< along the axis
    };

    struct Body
    {
        bool isKnown = false;                ///< in this step
        const qcSupportMesh* mesh = nullptr; ///< null: it does not consist of one small mesh
        qcRigidMotion motion;
        btScalar inverseMass = 0;
        btScalar stopTime = BT_LARGE_FLOAT; ///< when it touches a body that is stopped or quasi-static
    };

    /// A pair in which one body may stop the other.
    struct Link
    {
        qcPlacedSupport a, b;
        uint32_t slotA, slotB;
        bool isQuasiStatic[2]; ///< so slow that the other body stops where it touches this one
        bool hasContact;       ///< its points are known
        qcSeparation separation;
        btScalar margins, rest;
        btScalar reach; ///< `rest`, and what a body moves whose motion does not count since others may stop it
        size_t pair;    ///< index of the step's pair
    };

    /// Result for a pair of the step.
    struct Result
    {
        Contact known;
        bool isTouching; ///< along faces
        Pair pair;       ///< unless nothing is known
    };

    /// Results and scratch of one worker of a loop over pairs.
    struct Worker
    {
        qcPlaneContact contact;
        std::vector<qcMeshPoint> points;
        std::vector<Link> links;
    };

    /// When, where and along which direction the hulls of a pair come within a distance.
    struct Meeting
    {
        btScalar time = 0;
        qcPlacedSupport a, b; ///< at that time
        qcSeparation separation;
    };

    const Pair* Find(uint32_t slotA, uint32_t slotB) const;
    void ReadBody(const btCollisionObject* object, const qcBatchObject& gathered);
    qcPlacedSupport SideOf(const qcBatchObject& gathered) const;
    bool AreSmall(const qcBatchPair& pair) const;
    Result ComputePair(const qcBatchPair& pair, size_t index, uint32_t worker);
    void CollectLinks();
    void Follow();
    void CollectPairs();
    btTransform PlaceAt(uint32_t slot, const btTransform& start, btScalar time) const;
    std::array<btScalar, 3> TimesOf(const Link& link) const;
    qcRigidMotion MotionAt(uint32_t slot, btScalar since, btScalar time) const;
    btScalar ClosingSpeed(const Link& link, const Meeting& since, btScalar time) const;
    btScalar ClosingAfter(const Link& link, const Meeting& since) const;
    btScalar TimeOfClosing(const Link& link, const Meeting& since, btScalar gap) const;
    btScalar ClosingUntil(const Link& link, btScalar time) const;
    btScalar TouchTime(const Link& link) const;
    bool Meet(const Link& link, Meeting* meeting) const;
    bool FindPointsOf(const Link& link, const Meeting& meeting, btScalar distance, bool orClosest,
                      Worker* worker) const;
    bool FollowLink(Link* link);

    qcAxisCache& m_cache;
    btScalar m_timeStep = 0;
    std::vector<Worker> m_workers;
    std::vector<Result> m_results; ///< by index of the step's pair
    std::vector<Pair> m_pairs;     ///< sorted by slots
    std::vector<Body> m_bodies;    ///< by slot
    std::vector<Link> m_links;     ///< by index of their pairs
};

#endif
