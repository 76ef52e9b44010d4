// Meshes never pass each other: objects whose motions are not proven apart over a step are pushed apart at its end;
// where that does not suffice, their motions are cut back to a part that is proven. Proof:
// plugin/docs/proofs/rigid_motion_limits.md.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_MOTION_LIMITER_H
#define QC_GLUE_MESH_CONTACT_LIMITS_MOTION_LIMITER_H

#include "mesh_contact/limits/motion_certificates.h"
#include "mesh_contact/limits/motion_islands.h"
#include "mesh_contact/limits/swept_objects.h"
#include "mesh_contact/limits/swept_scene.h"

#include <map>

/// Runs at the end of a step, after Bullet has integrated the transforms. Not for several threads.
class qcMotionLimiter
{
  public:
    qcMotionLimiter(const qcBatchSettings& settings, qcKnownGaps& gaps, qcAxisCache& axes)
        : m_settings(settings), m_certificates(settings, gaps, axes), m_objects(settings, axes), m_scene(settings)
    {
    }
    qcMotionLimiter(const qcMotionLimiter&) = delete;
    qcMotionLimiter& operator=(const qcMotionLimiter&) = delete;

    /// The step starts: call it before Bullet has integrated the transforms. See qcSweptObjects.
    void MarkStarts()
    {
        m_objects.MarkStarts();
    }
    /// Reads the motions of the step that ends now, certifies them, and moves bodies where it can't. Writes the
    /// limiter's part of the statistics.
    void Limit(btScalar timeStep, qcMeshContactStatistics* statistics);
    /// Certifies a step that Limit has read already again, if bodies have been moved since. Objects in `held`
    /// stay at their starts. Appends the objects that it moves to `moved`.
    void LimitAgain(btScalar timeStep, const std::vector<const btCollisionObject*>& held,
                    const qcStartFunction& startOf, std::vector<const btCollisionObject*>* moved,
                    qcMeshContactStatistics* statistics);
    /// See qcRigidLimits.
    bool HasCertified(const btCollisionObject* object) const
    {
        const qcSweptObject* swept = m_objects.Find(object);
        return swept != nullptr && qcAreSame(swept->next, object->getWorldTransform());
    }
    /// See qcSweptObjects.
    const btCollisionObject* NotFinite() const
    {
        return m_objects.NotFinite();
    }
    /// See qcSweptObjects.
    void KeepTriangles(const btCollisionObject* object)
    {
        m_objects.KeepTriangles(object);
    }
    /// Call it after the triangles of a shape have changed.
    void InvalidateShape(const btCollisionShape* shape)
    {
        m_objects.InvalidateShape(shape);
    }

  private:
    using Numbers = qcPairNumbers;

    /// What a round has done.
    enum class Round
    {
        ended,     ///< nothing is left to do, or the detection failed
        exchanged, ///< cores of pairs for inner ones
        pushed,
        cut
    };

    /// How triangles meet at the start of the step.
    enum class Meeting
    {
        none,
        touches, ///< up to rounding
        penetrates
    };

    /// Two objects whose motions are cut back.
    struct Block
    {
        qcSweptPair pair{nullptr, nullptr};
        btScalar part = 1;     ///< of the motions that is proven apart; below 0: none
        btScalar distance = 0; ///< of the two triangles at the start
        btScalar made = 0;     ///< part of their motions that the objects make in this round
    };

    /// Parts of their motion that the objects of a pair make. Multibodies are cut where no body is left to cut.
    struct MadeParts
    {
        btScalar ofBodies = 0, ofLinks = 0;

        bool CutsBodies() const
        {
            return ofBodies > 0;
        }
        btScalar ThatIsCut() const
        {
            return CutsBodies() ? ofBodies : ofLinks;
        }
    };

    bool IsExempt(const qcSweptObject& a, const qcSweptObject& b) const;
    bool AreInEachOther(const qcSweptObject& a, const qcSweptObject& b, const qcProximity& atStart) const;
    Meeting FindMeeting(const qcPair& pair, const qcSweptTriangles& triangles) const;
    bool IsTestedByCores(const qcSweptPair& pair) const;
    void UseInnerCores(const qcSweptPair& pair);
    bool ExchangeCores(const qcResult& result);
    bool CollectMeetings(const qcResult& result);
    void FindUnproven(const qcResult& result, bool pushes);
    static MadeParts FindMadeParts(const qcSweptPair& pair);
    static void Stop(const qcSweptPair& pair, btScalar part, btScalar distance);
    bool IsStill(const qcSweptPair& pair) const;
    bool Hold(const qcSweptPair& pair);
    void Release(const qcSweptPair& pair);
    std::vector<qcClosingPair> ClosingPairs() const;
    void AddPlanes();
    void EndPlanes();
    void JoinBlocked();
    std::map<Numbers, Block> FindBlocks() const;
    void Cut(int round);
    void FindPairs(bool isFirst);
    void WakeNearDeforming() const;
    void SortPairs();
    void SkipSettledPairs(const std::set<Numbers>& reported);
    bool CanPush() const;
    bool AreDriven() const;
    Round StopPairs(bool pushes, int cuts, std::set<Numbers>* reported);
    qcStatus Certify();
    void CommitAll(btScalar timeStep);
    void Run(btScalar timeStep, qcMeshContactStatistics* statistics);
    void WriteStatistics(double start, qcMeshContactStatistics* statistics);

    const qcBatchSettings& m_settings;
    qcMotionCertificates m_certificates;
    qcSweptObjects m_objects;
    qcMotionIslands m_islands;
    qcSweptScene m_scene;
    std::vector<qcSweptPair> m_pairs;                  ///< to certify
    std::vector<qcSweptPair> m_unprovenPairs;          ///< of the present round, by their objects' numbers
    std::vector<qcSweptTriangles> m_unprovenTriangles; ///< of the last detection
    std::set<Numbers> m_exempt;  ///< objects that penetrate at the start of the step, or can't be kept apart in it
    std::set<Numbers> m_inner;   ///< objects of which inner cores are tested: they are in each other at the start
    std::set<Numbers> m_meeting; ///< objects that touch at the start of the step, up to rounding
    qcMotionPlanes m_planes;
    std::set<Numbers> m_stopped, m_previouslyStopped; ///< objects with planes, in this step and in the previous one
    std::set<Numbers> m_cut, m_previouslyCut;         ///< objects whose motions were cut, likewise
    qcTouchingPairs m_touching;
    qcStatus m_status = qc_statusOk; ///< of the last detection
    int m_unproven = 0;
};

#endif
