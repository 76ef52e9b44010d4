// Links of ropes, and of cloth with loads at its anchors, in contact: solved again between the sweeps of contact
// response.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H

#include "soft_body/scene/soft_scene.h"

class qcRopeLinks
{
  public:
    /// Reads the links of moving bodies in contact: all of those whose anchors tie something to them that moves, and
    /// of others those with an end that belongs to no face.
    void Collect(qcSoftBodyScene& scene);
    bool IsEmpty() const
    {
        return m_links.empty();
    }
    /// One Gauss-Seidel sweep, by the formula of btSoftBody::PSolve_Links.
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

    /// `contracted`: no sweep makes it shorter than this part of its present length.
    void AddLink(Body* body, const btSoftBody::Link& link, btScalar contracted);

    std::vector<Body> m_bodies;
    std::vector<Link> m_links;
    std::vector<bool> m_isAnchored; ///< scratch of Collect, by node of a body
};

#endif
