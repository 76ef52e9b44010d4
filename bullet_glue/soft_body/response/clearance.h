// Soft bodies proven apart over the step by their distance alone: where a query found no contact, a small motion needs
// no certificate for each pair of triangles. Proof: plugin/docs/proofs/clearance.md.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_CLEARANCE_H
#define QC_GLUE_SOFT_BODY_RESPONSE_CLEARANCE_H

#include "quickcullide/scene.h"

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <utility>
#include <vector>

/// Bodies are named by their slots in the scene. Record all bodies and the result of the query for contacts in the same
/// positions; then measure where they end.
class qcSoftClearance
{
  public:
    /// Nothing is proven until the next record.
    void Clear();
    /// `thickness`: contacts were found within the mean of both bodies' thicknesses. `start`: of the step. O(nodes).
    void Record(uint32_t slot, btScalar thickness, const std::vector<btVector3>& start,
                const std::vector<btVector3>& positions);
    /// O(contacts).
    void RecordNear(const qcResult& result);
    /// Measures the motion from the recorded positions to the present ones. O(nodes).
    void MeasureEnd(uint32_t slot, const std::vector<btVector3>& positions);
    /// True if no triangles of the two bodies (or of one with itself) without a common node meet between the start of
    /// the step and the measured end. False for a slot that is not recorded.
    bool KeepsApart(uint32_t slotA, uint32_t slotB) const;
    /// True if none of these triangles meet at the measured end.
    bool AreApartAtEnd(uint32_t slotA, uint32_t slotB) const;

  private:
    using SlotPair = std::pair<uint32_t, uint32_t>; ///< the smaller one first

    /// Mean displacement of all nodes from the recorded positions, and the largest deviation from it.
    struct Motion
    {
        btVector3 mean{0, 0, 0};
        btScalar radius = 0;
    };
    struct Body
    {
        btScalar thickness = 0; ///< 0: not recorded
        Motion toStart, toEnd;
        std::vector<btVector3> recorded;
    };

    static Motion Measure(const std::vector<btVector3>& from, const std::vector<btVector3>& to);
    static bool IsWithin(const Motion& a, const Motion& b, btScalar distance);

    std::vector<Body> m_bodies;   ///< by slot
    std::vector<SlotPair> m_near; ///< with a contact or a penetrating pair; sorted
};

#endif
