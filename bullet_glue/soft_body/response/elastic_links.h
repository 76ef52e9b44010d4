// Links of multibodies in an elastic system, by unknowns of their joints.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_LINKS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_LINKS_H

#include "common/multibody_motion.h"
#include "soft_body/response/node_elasticity.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <memory>

/// The unknowns of a multibody are such that each is resisted by a mass of 1, and none by another: three make an
/// element of a vector. A multibody that is locked in some directions has fewer of them.
class qcElasticLinks
{
  public:
    using Vector = qcNodeElasticity::Vector;

    void Begin()
    {
        m_bodies.clear();
        m_points.clear();
    }
    /// The number of a point of a link, at `arm` from the link's centre; -1: nothing moves it.
    int AddPoint(const btMultiBodyLinkCollider& link, const btVector3& arm);
    /// Has the unknowns begin with this element of a vector. Returns the element behind the last one.
    int Number(int first);
    btVector3 MotionAt(int point, const Vector& x) const;
    void AddForceAt(int point, const btVector3& force, Vector* to) const;
    /// Sets what resists the unknowns alone.
    void SetMasses(const Vector& x, Vector* result) const;
    /// Adds what a stiffness at the point adds to the diagonal blocks.
    void AddBlocks(int point, const btMatrix3x3& stiffness, std::vector<btMatrix3x3>* blocks) const;
    /// Moves the multibodies, and changes their velocities by the motion.
    void Apply(const Vector& x, btScalar timeStep) const;

  private:
    struct Body
    {
        std::unique_ptr<qcMultiBodyMotion> motion;
        std::vector<int> links;                            ///< by index in the motion
        std::vector<qcMultiBodyMotion::Coordinates> roots; ///< by unknown: displacement of the coordinates
        int first = 0;

        int ElementCount() const
        {
            return int(roots.size() + 2) / 3;
        }
    };

    struct Point
    {
        size_t body;
        std::vector<btMatrix3x3> motions; ///< by element of the body: from the unknowns to the point's motion
    };

    size_t FindOrAdd(btMultiBody* multibody);

    std::vector<Body> m_bodies;
    std::vector<Point> m_points;
};

#endif
