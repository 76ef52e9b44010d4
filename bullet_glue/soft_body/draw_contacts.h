// The candidate triangles of a query, for debugDraw.
#ifndef QC_GLUE_SOFT_BODY_DRAW_CONTACTS_H
#define QC_GLUE_SOFT_BODY_DRAW_CONTACTS_H

#include "quickcullide/scene.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

/// The candidate triangles of a query with contacts: those of the result's PCS, and those that have a vertex or an edge
/// in a contact or are in one themselves. The PCS alone leaves out pairs that are proven disjoint but have a contact.
class qcSoftCandidates
{
  public:
    void Clear();
    void Record(const qcResult& result);
    bool AreEmpty() const;
    /// The candidate pairs, if the query reported them.
    const std::vector<qcCandidate>& Pairs() const
    {
        return m_pairs;
    }
    /// Call it before Contains.
    void Sort();
    /// True if the triangle of the body in a slot, with these corners, is a candidate. O(log contacts).
    bool Contains(uint32_t slot, uint32_t triangle, const uint32_t corners[3]) const;

  private:
    /// A vertex three times, an edge with its second vertex twice, or a face; in ascending order.
    struct Feature
    {
        uint32_t slot;
        std::array<uint32_t, 3> vertices;

        bool operator<(const Feature& other) const
        {
            return std::tie(slot, vertices) < std::tie(other.slot, other.vertices);
        }
    };

    static Feature MakeFeature(uint32_t slot, uint32_t a, uint32_t b, uint32_t c);
    bool ContainsFeature(const Feature& feature) const;

    std::vector<qcTriangleRef> m_pcs; ///< sorted
    std::vector<Feature> m_features;
    std::vector<qcCandidate> m_pairs;
};

#endif
