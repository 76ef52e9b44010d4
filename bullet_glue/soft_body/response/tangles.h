// What penetrates at the start of a step: a step keeps apart what was apart, and lets the rest go.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_TANGLES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_TANGLES_H

#include "soft_body/scene/soft_scene.h"

#include <array>
#include <map>
#include <vector>

/// Tangled: a triangle, or a vertex of a triangle, of one body that penetrates another body (or its own) at the start
/// of the step. Bodies are slots of the scene.
class qcSoftTangles
{
  public:
    /// From the result of a query at the positions of the start.
    void Read(qcSoftBodyScene& scene, const qcResult& result);

    bool IsEmpty() const
    {
        return m_triangles.empty();
    }
    /// Moves the pairs that need not be held apart from `held`, which are numbers of a result's pairs, to `exempt`:
    /// pairs of two tangled triangles; and, where two bodies have no more pairs than at the start, those around them: a
    /// tangle may move but not grow.
    void Split(qcSoftBodyScene& scene, const qcResult& result, std::vector<size_t>* held,
               std::vector<size_t>* exempt) const;
    /// All vertices of one side are tangled with the other side's body: it is not known which way they belong.
    bool IsExempt(const qcContact& contact) const;

  private:
    using Key = std::array<uint32_t, 3>; ///< slot, number in the body, slot of the other body

    using Bodies = std::pair<uint32_t, uint32_t>; ///< slots
    bool IsNear(qcSoftBodyScene& scene, uint32_t body, uint32_t triangle, uint32_t other) const;
    static bool Has(const std::vector<Key>& keys, uint32_t body, uint32_t number, uint32_t other);

    std::vector<Key> m_triangles, m_vertices; ///< sorted
    std::map<Bodies, size_t> m_counts;        ///< of pairs
};

#endif
