// What debugDraw shows of a step of soft bodies.
#ifndef QC_GLUE_SOFT_BODY_DRAW_CONTACTS_H
#define QC_GLUE_SOFT_BODY_DRAW_CONTACTS_H

#include "quickcullide/scene.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

/// The candidate triangles of a query with contacts. A result's PCS leaves out pairs that are proven disjoint, which
/// are candidates for contacts nevertheless: a triangle that has a vertex or an edge in a contact is in such a pair.
class qcSoftCandidates
{
  public:
    void Clear();
    void Note(const qcResult& result);
    bool AreEmpty() const;
    /// Before Has.
    void Sort();
    /// Is this triangle of the body of a slot, with these corners, one of them?
    bool Has(uint32_t slot, uint32_t triangle, const uint32_t corners[3]) const;

  private:
    /// A vertex thrice, an edge with its second vertex twice, or a face; in ascending order.
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
    bool HasFeature(const Feature& feature) const;

    std::vector<qcTriangleRef> m_pcs; ///< in order
    std::vector<Feature> m_features;
};

#endif
