// What meshes come upon in the course of a step, further ahead than contact points reach at its beginning.
#ifndef QC_GLUE_MESH_CONTACT_TIME_OF_IMPACT_H
#define QC_GLUE_MESH_CONTACT_TIME_OF_IMPACT_H

#include "mesh_contact/rigid_motion.h"
#include "mesh_contact/contact_reduction.h"

#include <unordered_map>

/// A mesh of the scene at the beginning of a step.
struct qcMovingMesh
{
    const btCollisionObject* object;
    qcBodyId id;
    btTransform transform; ///< as the scene has it
    const std::vector<qcTriangleSource>* sources;
    btScalar radius;    ///< of the object, from its origin
    btScalar threshold; ///< contact breaking threshold of the object
    btScalar reach;     ///< how far beyond its shell contact points are found at the beginning of the step
    btScalar margin;    ///< the shell
};

/// A step as a row of moments. Bodies are carried along as they move when the step begins, and at each moment the pairs
/// that move fast are looked at as if it were the beginning of a step. A point of contact found there is one that the
/// solver has to know of now: Bullet's constraint for a point at a distance lets the bodies come as far as that.
///
/// Then again, for who follows: a body that came upon one that stands still stays where it met that, and pairs that
/// move along with each other are looked at if one of them stays, and so on. So a column that falls is stopped from its
/// foot to its head in one step.
///
/// Conservative advancement (Mirtich 1996) would need the distance of two soups at each of its steps;
/// this needs contact only, which is what the scene is quick at.
class qcMeshAhead
{
  public:
    /// Forgets the step before.
    void Begin(btScalar timeStep);
    /// Takes the pair in if one of the two comes by more in the step than contact points reach.
    void Consider(const qcMovingMesh& a, const qcMovingMesh& b);
    /// Looks at all moments. `def`: of the query at the beginning. The scene's bodies are where they were afterwards,
    /// its last result is not. Nothing is done if no pair passes by fast.
    qcStatus Find(qcScene* scene, const qcDetectDef& def);
    /// Adds what a pair comes upon, with its ends on the bodies as they are now.
    void Append(qcBodyId a, const btTransform& transformA, qcBodyId b, const btTransform& transformB,
                std::vector<qcMeshPoint>* points) const;

    /// That were looked at.
    int GetMomentCount() const
    {
        return m_momentCount;
    }

  private:
    struct Mesh
    {
        qcMovingMesh moving;
        qcMeshMotion motion;
        btScalar stop = BT_LARGE_FLOAT; ///< when it meets what stands still

        bool Stays(btScalar time) const
        {
            return stop <= time;
        }
    };

    /// Two meshes, by index: the slot of the first is lower.
    struct Pair
    {
        uint32_t slotA, slotB;
        size_t a, b;
        int moments;
        btScalar speed;                  ///< at which the two pass each other, at most
        btScalar reach;                  ///< what is nearer at the beginning is found without this
        bool still[2];                   ///< one as slow that the other, where it meets it, stays
        bool follows;                    ///< one the other: to be looked at if one of them stays
        btScalar before = 0;             ///< its last moment
        bool asked = false;              ///< in this round
        bool due = false;                ///< to be looked at in this moment
        bool over = false;               ///< was asked for, or nothing that follows would mean anything
        std::vector<qcMeshPoint> points; ///< each end in the frame of its mesh
    };

    size_t Keep(const qcMovingMesh& mesh);
    const Pair* PairOf(uint32_t slotA, uint32_t slotB) const;
    static btTransform At(const Mesh& mesh, btScalar time);
    qcStatus Place(qcScene* scene, btScalar time) const;
    bool ChooseAsked(bool first);
    bool ChooseDue(int moment, int moments);
    qcStatus Look(qcScene* scene, const qcDetectDef& def);
    void Take(const qcResult& result, btScalar time, Pair* pair);
    static bool IsDue(void* context, uint32_t slotA, uint32_t slotB);

    btScalar m_timeStep = 0;
    int m_momentCount = 0;
    std::vector<Mesh> m_meshes;
    std::vector<btScalar> m_stops;                  ///< of the meshes, as they are found
    std::unordered_map<uint32_t, size_t> m_indexOf; ///< of a mesh, by slot
    std::vector<Pair> m_pairs;                      ///< in order of slots, once they are looked at
};

#endif
