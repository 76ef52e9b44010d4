// Links and anchors of ropes, and of cloth with loads at its anchors, in contact: solved again between the sweeps of
// contact response.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H

#include "soft_body/scene/soft_scene.h"

class qcRopeLinks
{
  public:
    /// Reads the links with an end that belongs to no face, of moving bodies in contact, and the anchors of these. Of
    /// bodies whose anchors tie something to them that moves, all links.
    void Collect(qcSoftBodyScene& scene);
    bool IsEmpty() const
    {
        return m_links.empty();
    }
    /// One Gauss-Seidel sweep, by the formulas of btSoftBody::PSolve_Links and PSolve_Anchors. Bodies that move get
    /// the impulses of their anchors.
    void Solve() const;
    /// Takes from the velocities what the links have added to the kinetic energy, after the sweeps.
    void LimitVelocities() const;

  private:
    /// A body whose links are solved, and how far these have moved its nodes.
    struct Body
    {
        qcSceneSoftBody* soft;
        std::vector<btVector3> byLinks; ///< by node
    };

    /// A link as a constraint on the positions of its two nodes.
    struct Link
    {
        btVector3* position[2];
        btVector3* byLinks[2]; ///< in its Body
        btScalar inverseMass[2];
        btScalar restLength2;
        btScalar divisor; ///< sum of the inverse masses, divided by the link's stiffness
    };

    /// A constraint that holds a node at a place of a rigid body.
    struct Anchor
    {
        btVector3* position;
        btRigidBody* body;
        btVector3 place, arm;
        btMatrix3x3 impulse;   ///< for a displacement of the node from its place
        btScalar displacement; ///< of the node by an impulse
    };

    void AddLink(Body* body, const btSoftBody::Link& link);
    void AddAnchor(qcSceneSoftBody& soft, const btSoftBody::Anchor& anchor);

    std::vector<Body> m_bodies;
    std::vector<Link> m_links;
    std::vector<Anchor> m_anchors;
};

#endif
