// Pairs of small meshes that a plane separates: their contact needs no search among triangles.
#ifndef QC_GLUE_MESH_CONTACT_PLANE_PAIRS_H
#define QC_GLUE_MESH_CONTACT_PLANE_PAIRS_H

#include "mesh_contact/axis_cache.h"
#include "mesh_contact/batch_scene.h"
#include "mesh_contact/plane_contact.h"

class qcPlanePairs
{
  public:
    explicit qcPlanePairs(qcAxisCache& cache) : m_cache(cache)
    {
    }

    /// Clears the pairs and points of the previous step, and sets the time step.
    void Begin(btScalar timeStep);
    enum class Contact
    {
        none,    ///< not known: its triangles have to be tested
        atStart, ///< at the beginning of the step: the two turn, and have to be sampled
        all      ///< of the step
    };
    /// Computes the contact of a pair, at the transforms that the scene has. Returns what of it is known.
    Contact AddPair(const btCollisionObject* object0, const qcBatchObject& a, const btCollisionObject* object1,
                    const qcBatchObject& b);
    /// Call it after the last AddPair, before the following ones. Adds contact of bodies that follow one that is
    /// stopped in the step.
    void End();
    /// True if AddPair has computed the contact of two meshes, named by their slots.
    bool Has(uint32_t slotA, uint32_t slotB) const
    {
        return Find(slotA, slotB) != nullptr;
    }
    /// Appends the points of such a pair, in world space. Returns a lower bound of the distance of its triangles.
    double AppendPoints(qcBodyId a, qcBodyId b, std::vector<qcMeshPoint>* points) const;

    int GetPairCount() const
    {
        return int(m_pairs.size());
    }
    /// Pairs with contact points.
    int GetContactCount() const
    {
        return m_contactCount;
    }
    int GetPointCount() const
    {
        return int(m_points.size());
    }

  private:
    struct Pair
    {
        uint32_t low, high; ///< slots
        bool isSwapped;     ///< points have the higher slot as A
        size_t begin, end;  ///< points
        btScalar gap;       ///< along the axis
    };

    struct Body
    {
        bool isKnown = false;                ///< in this step
        const qcSupportMesh* mesh = nullptr; ///< null: it does not consist of one small mesh
        qcRigidMotion motion;
        btScalar stopTime = BT_LARGE_FLOAT; ///< when it touches a body that is stopped or quasi-static
    };

    /// A pair in which one body may stop the other.
    struct Link
    {
        qcPlacedSupport a, b;
        uint32_t slotA, slotB;
        bool isQuasiStatic[2]; ///< so slow that the other body stops where it touches this one
        bool hasContact;       ///< its points are known
        qcSeparation separation;
        btScalar margins, rest;
        size_t pair; ///< index
    };

    const Pair* Find(uint32_t slotA, uint32_t slotB) const;
    Body& BodyOf(const btCollisionObject* object, const qcBatchObject& gathered);
    btScalar ClosingUntil(const Link& link, btScalar time) const;
    btScalar TouchTime(const Link& link) const;
    bool FollowLink(Link* link);

    qcAxisCache& m_cache;
    btScalar m_timeStep = 0;
    int m_contactCount = 0;
    std::vector<Pair> m_pairs; ///< sorted by slots after End
    std::vector<qcMeshPoint> m_points;
    std::vector<Body> m_bodies; ///< by slot
    std::vector<Link> m_links;
    qcPlaneContact m_contact;
};

#endif
