// Pairs of objects whose motions in a step are proven apart as a whole, without a look at their triangles' motions.
// Proof: plugin/docs/proofs/rigid_motion_limits.md.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_MOTION_CERTIFICATES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_MOTION_CERTIFICATES_H

#include "mesh_contact/limits/touching_pairs.h"
#include "mesh_contact/planes/axis_cache.h"

#include <functional>
#include <set>

/// A step of an object in the scene of contact.
struct qcKnownStep
{
    const qcBatchObject& object;
    const btTransform &start, &end;
};

/// Lower bounds of the distances between objects, from their contact.
class qcKnownGaps
{
  public:
    virtual ~qcKnownGaps() = default;
    /// The object in the scene of contact; null: its meshes there are not the present ones. Valid until contact is
    /// computed anew.
    virtual const qcBatchObject* FindCurrent(const btCollisionObject* object) = 0;
    /// True if the meshes of two objects have no common point at any time of a step in which their vertices move along
    /// straight lines. False proves nothing. It may run on several threads at once.
    virtual bool StayApart(const qcKnownStep& a, const qcKnownStep& b) = 0;
};

/// True if the hulls of two objects stand for what of them is tested. `inner`: pairs of which inner cores are tested.
bool qcHaveHulls(const qcSweptObject& a, const qcSweptObject& b, const std::set<qcPairNumbers>& inner);

/// Not for several threads; its functions use several.
class qcMotionCertificates
{
  public:
    qcMotionCertificates(const qcBatchSettings& settings, qcKnownGaps& gaps, qcAxisCache& axes)
        : m_settings(settings), m_gaps(gaps), m_axes(axes)
    {
    }

    /// Removes the pairs whose motion is small against the gap between them, and those of a hull and meshes that stay,
    /// where one plane is between it and each triangle near its path.
    void RemoveApart(const std::set<qcPairNumbers>& inner, std::vector<qcSweptPair>* pairs);
    /// Removes the pairs of small meshes that one direction separates as a whole at the start and at the end of the
    /// step, and begins a round of `touching`. New objects that touch, up to rounding, are exempt: planes only keep
    /// them from going deeper.
    void RemoveSeparated(const std::set<qcPairNumbers>& inner, qcTouchingPairs* touching, qcMotionPlanes* planes,
                         std::vector<qcSweptPair>* pairs);

  private:
    /// Where two small meshes touch at the start of the step, if they do.
    struct Touch
    {
        bool touches;
        btVector3 axis;
        btScalar depth; ///< up to rounding
    };

    void Remove(size_t block, const std::function<bool(size_t)>& isProven, std::vector<qcSweptPair>* pairs);
    void LookUp(qcSweptObject* swept);
    bool IsSeparated(const qcSweptPair& pair, const qcTouchingPairs& touching, Touch* touch) const;

    const qcBatchSettings& m_settings;
    qcKnownGaps& m_gaps;
    qcAxisCache& m_axes;
    std::vector<uint8_t> m_isProven; ///< by pair; scratch
    std::vector<Touch> m_touches;    ///< likewise
};

#endif
