// Pairs of small meshes that touch at the start of a step up to rounding, such as the pieces of a cut. No certificate
// holds for them; their hulls come no deeper into each other than they start.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_TOUCHING_PAIRS_H
#define QC_GLUE_MESH_CONTACT_LIMITS_TOUCHING_PAIRS_H

#include "mesh_contact/limits/motion_planes.h"

#include <map>

/// A pair whose hulls end the step deeper in each other than they may.
struct qcClosingPair
{
    qcSweptPair pair;
    btVector3 axis;  ///< along which they touch, from the first to the second
    btScalar minGap; ///< of their hulls at the end

    /// The largest part of the motions, up to `limit` and bisection, that leaves that gap; below 0: none.
    btScalar FindPart(btScalar limit) const;
};

class qcTouchingPairs
{
  public:
    /// A step begins.
    void BeginStep();
    /// A round of certificates begins.
    void BeginRound();
    /// From now on the pair counts as one that touches at the start of the step. False: it does already.
    bool Add(const std::pair<uint32_t, uint32_t>& numbers)
    {
        return m_touching.insert({numbers, false}).second;
    }
    /// True if the pair has been added, or has ended the previous step, or an earlier certification of this one,
    /// touching.
    bool Include(const qcSweptPair& pair) const;
    /// Adds a plane between the hulls of two objects that touch at the start, unless they end apart. `error`: of gaps.
    void Keep(const qcSweptPair& pair, const btVector3& axis, btScalar error, qcMotionPlanes* planes);

    /// True if a pair of this round does not end apart.
    bool AnyTouches() const
    {
        return m_anyTouches;
    }
    /// The pairs of this round that end too deep.
    const std::vector<qcClosingPair>& Closing() const
    {
        return m_closing;
    }

  private:
    /// By the numbers of the objects: true if they touch at the end, too.
    std::map<std::pair<uint32_t, uint32_t>, bool> m_touching;
    std::vector<qcClosingPair> m_closing;
    bool m_anyTouches = false;
};

#endif
