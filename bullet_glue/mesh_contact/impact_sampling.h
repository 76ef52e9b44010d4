// Speculative contacts of fast meshes: samples the rigid motion of a step and keeps the contact points found there.
// Terms, reasons and limits: plugin/docs/mesh_contact.md.
#ifndef QC_GLUE_MESH_CONTACT_IMPACT_SAMPLING_H
#define QC_GLUE_MESH_CONTACT_IMPACT_SAMPLING_H

#include "common/rigid_motion.h"
#include "mesh_contact/planes/plane_contact.h"

#include <unordered_map>

/// A mesh of the scene at the beginning of a step.
struct qcMovingMesh
{
    const btCollisionObject* object;
    qcBodyId id;
    btTransform transform; ///< in the scene
    const std::vector<qcTriangleSource>* sources;
    btScalar radius;           ///< upper bound of the distance of the object's points from its origin
    btScalar threshold;        ///< contact breaking threshold of the object
    btScalar margin;           ///< collision margin
    btScalar contactDistance;  ///< contact is found up to this distance from its margin at the beginning of the step
    const qcSupportMesh* hull; ///< the mesh if it is small and the object's only one
};

/// Finds contacts that fast pairs reach within the step, and adds them at its beginning: Bullet's constraint for a
/// point at a distance lets the bodies close exactly that distance. Further passes stop bodies that follow a stopped
/// one.
class qcImpactSampler
{
  public:
    /// Clears the pairs and points of the previous step, and sets the time step.
    void Begin(btScalar timeStep);
    /// Adds a pair if its bodies pass each other, or one of them moves, by more than contact distances cover. `axis`:
    /// of a plane that separates their hulls, from `a` to `b`; 0: there is none.
    void AddPair(const qcMovingMesh& a, const qcMovingMesh& b, const btVector3& axis);
    /// Samples the step. `def`: of the query at the beginning of the step. Bodies of the scene are at the beginning of
    /// the step again afterwards; the scene's last result is lost. No pairs: does nothing.
    qcStatus Sample(qcScene* scene, const qcDetectDef& def);
    /// Appends the speculative contacts of a pair, with ends on the bodies at these transforms.
    void AppendPoints(qcBodyId a, const btTransform& transformA, qcBodyId b, const btTransform& transformB,
                      std::vector<qcMeshPoint>* points) const;

    /// Queries of the last Sample.
    int GetSampleCount() const
    {
        return m_sampleCount;
    }

  private:
    struct Mesh
    {
        qcMovingMesh moving;
        qcRigidMotion motion;
        btScalar stopTime = BT_LARGE_FLOAT; ///< when it touches a body that is stopped or quasi-static

        bool IsStoppedAt(btScalar time) const
        {
            return stopTime <= time;
        }
    };

    /// Two meshes; the slot of the first is lower.
    struct Pair
    {
        uint32_t slotA, slotB;
        size_t a, b; ///< indices of the meshes
        int sampleCount;
        btScalar maxSpeed;         ///< upper bound of the speed at which the bodies pass each other
        btScalar contactDistance;  ///< nearer points are found at the beginning of the step
        btScalar threshold;        ///< contact breaking threshold of the pair
        bool isQuasiStatic[2];     ///< so slow that the other body stops where it touches this one
        bool isCoMoving;           ///< sampled only once one of the bodies has stopped
        btScalar previousTime = 0; ///< of the pair's previous sample
        bool isSelected = false;   ///< for the present pass
        bool isDue = false;        ///< for the present sample
        bool isDone = false;       ///< sampled, or stopped, so that further samples mean nothing
        btVector3 axis; ///< of the plane between small meshes at the previous sample, from A to B; 0: there is none
        bool isByPlane = false;          ///< in the present sample
        std::vector<qcMeshPoint> points; ///< ends in the frames of their meshes
    };

    /// The transforms of a pair at a time.
    struct PairTransforms
    {
        btTransform a, b;

        /// Distance of a point's ends along its normal. The ends are in the frames of their meshes.
        btScalar DistanceOf(const qcMeshPoint& point) const
        {
            return (a * point.onA - b * point.onB).dot(point.normal);
        }
    };

    size_t AddMesh(const qcMovingMesh& mesh);
    const Pair* FindPair(uint32_t slotA, uint32_t slotB) const;
    static btTransform TransformAt(const Mesh& mesh, btScalar time);
    PairTransforms TransformsAt(const Pair& pair, btScalar time) const;
    qcStatus SetTransforms(qcScene* scene, btScalar time) const;
    bool SelectPairs(bool firstPass);
    bool SelectDue(int sample, int sampleCount);
    void SortPairs();
    qcDetectDef SampleDef(const qcDetectDef& def);
    qcStatus RunPass(qcScene* scene, const qcDetectDef& def);
    qcStatus TestTriangles(qcScene* scene, const qcDetectDef& def, btScalar time);
    bool TestPlane(btScalar distance, btScalar time, Pair* pair);
    void TakePoints(std::vector<qcMeshPoint>* points, btScalar time, Pair* pair);
    bool IsStoppedBy(const std::vector<qcMeshPoint>& points, btScalar time, const Pair& pair) const;
    btScalar TakeRegion(qcMeshPoint* begin, qcMeshPoint* end, btScalar time, Pair* pair);
    static bool IsDue(void* context, uint32_t slotA, uint32_t slotB);

    btScalar m_timeStep = 0;
    int m_sampleCount = 0;
    bool m_isFine = false; ///< points have no known side where fine meshes overlap
    std::vector<Mesh> m_meshes;
    std::vector<btScalar> m_stopTimes;              ///< of the meshes, found in the present pass
    std::unordered_map<uint32_t, size_t> m_indexOf; ///< of a mesh, by slot
    std::vector<Pair> m_pairs;                      ///< sorted by slots while they are sampled
    qcPlaneContact m_contact;
    std::vector<qcMeshPoint> m_points; ///< scratch
};

#endif
