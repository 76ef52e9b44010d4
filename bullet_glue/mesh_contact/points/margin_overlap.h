// Margins that overlap when contact begins of two bodies that hardly move against each other, such as the pieces of a
// body that breaks. Bullet's solver would push them apart within some steps, and the pieces would fly: here they give
// way slowly.
#ifndef QC_GLUE_MESH_CONTACT_POINTS_MARGIN_OVERLAP_H
#define QC_GLUE_MESH_CONTACT_POINTS_MARGIN_OVERLAP_H

#include "common/rigid_motion.h"
#include "mesh_contact/points/contact_reduction.h"

/// The overlap of one pair. A penetration of the meshes themselves is no overlap of margins.
class qcMarginOverlap
{
  public:
    /// False: there is nothing left to apply.
    bool IsOpen() const
    {
        return !m_hasBegun || m_rest > 0;
    }
    /// Begins or continues the contact of a pair, once in each step while it is open, also where it has no points.
    /// Increases the distances of its points, which are beyond the margins, by what remains of the overlap at the
    /// beginning: it falls to 0 within a second, and is never larger than the present overlap. `margins`: of both
    /// meshes. Bodies that pass each other there by more than that in the first step have none, and get the whole push.
    void Apply(const btCollisionObject* object0, const btCollisionObject* object1, btScalar margins, btScalar timeStep,
               std::vector<qcMeshPoint>* points);

  private:
    bool m_hasBegun = false;
    btScalar m_rest = 0; ///< of the overlap at the beginning
};

#endif
