// The meshes that move in a step, sorted by their places.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_MOVING_MESHES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_MOVING_MESHES_H

#include "mesh_contact/limits/swept_object.h"

class qcMovingMeshes
{
  public:
    void Clear()
    {
        m_sorted.clear();
    }
    /// Adds an object whose box and travel are known. Sort follows.
    void Add(const qcSweptObject* mesh)
    {
        m_sorted.push_back(mesh);
    }
    void Sort();
    bool IsEmpty() const
    {
        return m_sorted.empty();
    }
    /// The largest travel of one whose box overlaps this one; 0: there is none.
    btScalar LargestTravelIn(const btVector3& lower, const btVector3& upper) const;

  private:
    std::vector<const qcSweptObject*> m_sorted; ///< by the lower ends of their boxes along m_axis
    int m_axis = 0;                             ///< see qcAxisOfSpread
    btScalar m_widest = 0;                      ///< the largest extent of these along m_axis
};

#endif
