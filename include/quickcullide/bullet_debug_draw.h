/// @file
/// What this library finds in a Bullet world, drawn by whatever draws the world's debug lines (Bullet's ExampleBrowser,
/// an engine's own btIDebugDraw):
///
///     qcDebugDraw debugDraw(&world);
///     debugDraw.add(&softSolver);    // and add(&meshContact), as far as the world has them
///     world.addAction(&debugDraw);   // from now on debugDrawWorld draws it, too
#ifndef QUICKCULLIDE_BULLET_DEBUG_DRAW_H
#define QUICKCULLIDE_BULLET_DEBUG_DRAW_H

#include "base.h"

#include <BulletDynamics/Dynamics/btActionInterface.h>

#include <vector>

class btCollisionWorld;
class qcMeshContact;
class qcSoftBodyContact;

/// What to draw; bits.
enum qcDebugDrawMode
{
    qc_drawPcs = 1,         ///< red: the triangles in candidate pairs of the last step
    qc_drawCandidates = 2,  ///< orange: a line between the centroids of each candidate pair
    qc_drawContacts = 4,    ///< each point of the dispatcher's manifolds with its normal
    qc_drawManifolds = 8,   ///< cyan: the outline of each manifold's points
    qc_drawBoxes = 16,      ///< the box of each object in the broadphase, and a line between the centres of each pair
    qc_drawPlanes = 32,     ///< yellow: separating planes of soft bodies; magenta: nodes that moved as one
    qc_drawEverything = 63, ///< all of these
};

/// Draws the work of the last step. Contacts, manifolds and boxes are those of the whole world, whichever code made
/// them, with any broadphase; the rest is that of the contact classes added.
///
/// Candidate pairs are reported by queries on request only, which costs a sort of them in each step: this class
/// requests them as long as its modes contain qc_drawCandidates.
///
/// Destroy it before the world and the contact classes, and after removeAction if further steps follow. Thread-safety:
/// as the world's.
class QC_API qcDebugDraw : public btActionInterface
{
  public:
    /// All modes but the boxes and the candidate pairs, which hide the rest in most scenes.
    explicit qcDebugDraw(btCollisionWorld* world, int modes = qc_drawEverything - qc_drawBoxes - qc_drawCandidates);
    /// The contact classes report candidates no longer.
    ~qcDebugDraw() override;
    qcDebugDraw(const qcDebugDraw&) = delete;
    qcDebugDraw& operator=(const qcDebugDraw&) = delete;

    /// Draws the soft bodies' contact, too: a qcSoftBodySolver or a qcDeformableWorld. Null: nothing.
    void add(qcSoftBodyContact* contact);
    /// Draws the meshes' contact, too. Null: nothing.
    void add(qcMeshContact* contact);

    /// Bits of qcDebugDrawMode. Candidate pairs are drawn from the next step on.
    void setModes(int modes);
    int getModes() const; ///< as set

    /// Draws. Called by debugDrawWorld if this is an action of a btDynamicsWorld and the drawer's debug mode has
    /// DBG_DrawWireframe or DBG_DrawAabb; otherwise call it between steps. The drawer's own debug mode is ignored.
    void debugDraw(btIDebugDraw* drawer) override;
    /// Does nothing.
    void updateAction(btCollisionWorld* world, btScalar timeStep) override;

  private:
    btCollisionWorld* m_world;
    int m_modes;
    std::vector<qcSoftBodyContact*> m_softContacts;
    std::vector<qcMeshContact*> m_meshContacts;
};

#endif
