// Results of the last query of each pair of objects in a world: contact points, and the distance of their meshes. A
// result holds until the two move against each other. Proof: plugin/docs/proofs/pair_reuse.md.
#ifndef QC_GLUE_MESH_CONTACT_POINTS_PAIR_CONTACTS_H
#define QC_GLUE_MESH_CONTACT_POINTS_PAIR_CONTACTS_H

#include "common/hash_table.h"
#include "common/rigid_motion.h"
#include "mesh_contact/points/contact_reduction.h"

#include <vector>

/// A contact point of two meshes of a pair: its ends are in the frames of the meshes, its normal in that of B.
struct qcKnownPoint
{
    uint32_t meshA, meshB; ///< indices in their objects
    bool isAhead;          ///< found by impact sampling
    qcMeshPoint point;

    /// The point in world space, at these transforms of the meshes.
    qcMeshPoint At(const btTransform& a, const btTransform& b) const;
};

/// A pair of objects. A is the one that was added to the batch first.
struct qcPairContact
{
    bool isKnown = false;                       ///< it has been queried
    bool isDue = false;                         ///< the present check requires a query
    uint64_t checked = 0;                       ///< number of the last check that found the pair in the world
    uint64_t versionA = 0, versionB = 0;        ///< of the objects at the query; see qcBatchObject
    btTransform a = btTransform::getIdentity(); ///< of the objects at the query
    btTransform b = btTransform::getIdentity();
    btScalar reach = 0;               ///< contact distance up to which the query has all points
    double gap = 0;                   ///< lower bound of the distance between triangles of the two
    int regions = 0;                  ///< of contact
    std::vector<qcKnownPoint> points; ///< sorted by meshes
};

/// A motion of an object, from a transform to another; refers to both.
struct qcObjectMotion
{
    const btTransform &from, &to;
    btScalar radius; ///< upper bound of the distance of its points from its origin
};

/// Upper bound of the displacement of points of two objects against each other.
btScalar qcRelativeDisplacementBound(const qcObjectMotion& a, const qcObjectMotion& b);

/// Lower bound of the distance between triangles of a pair after motions from where it was queried; 0 or less: none is
/// known. A and B as in qcPairContact.
btScalar qcGapAfter(const qcPairContact& pair, const qcObjectMotion& a, const qcObjectMotion& b);

class qcPairContacts
{
  public:
    /// `a` and `b`: numbers of the objects, in either order; see qcBatchObject::owner. Valid until the next pair is
    /// added.
    qcPairContact& FindOrAdd(uint32_t a, uint32_t b);
    const qcPairContact* Find(uint32_t a, uint32_t b) const;
    qcPairContact* Find(uint32_t a, uint32_t b);
    /// Sums the regions and points of the pairs that a check has found.
    void Count(uint64_t check, int* regions, int* points) const;
    /// Forgets pairs that no check has found lately. `check`: number of the present one.
    void RemoveOld(uint64_t check);
    /// True if the meshes of a known pair have no common point at any time of a step in which their vertices move along
    /// straight lines. A and B as in qcPairContact.
    static bool StayApart(const qcPairContact& pair, const qcObjectMotion& a, const qcObjectMotion& b);

  private:
    static uint64_t KeyOf(uint32_t a, uint32_t b)
    {
        return a < b ? uint64_t(a) << 32 | b : uint64_t(b) << 32 | a;
    }

    /// Its points are moved, not copied, as the vector grows: Bullet's transforms have no noexcept move.
    struct Pair
    {
        uint64_t key;
        qcPairContact contact;

        explicit Pair(uint64_t numbers) : key(numbers)
        {
        }
        Pair(Pair&&) noexcept = default;
        Pair& operator=(Pair&&) noexcept = default;
    };

    std::vector<Pair> m_pairs;                 ///< in the order in which they were added
    qcHashTable<uint64_t, uint32_t> m_indices; ///< of pairs, by key
    uint64_t m_removed = 0;                    ///< number of the check of the last removal
};

#endif
