// Speculative contacts of fast meshes: samples the rigid motion of a step and keeps the contact points found there.
// Terms, reasons and limits: plugin/docs/mesh_contact.md.
#ifndef QC_GLUE_MESH_CONTACT_IMPACT_SAMPLING_H
#define QC_GLUE_MESH_CONTACT_IMPACT_SAMPLING_H

#include "common/hash_table.h"
#include "common/rigid_motion.h"
#include "mesh_contact/planes/plane_contact.h"
#include "mesh_contact/scene/batch_scene.h"

#include <climits>

/// An object at the beginning of a step, with meshes that are placed in the scene.
struct qcMovingObject
{
    const btCollisionObject* object;
    const qcBatchObject* gathered;
    const qcSupportMesh* hull; ///< its mesh if it is small and the object's only one
};

/// Finds contacts that fast pairs reach within the step, and adds them at its beginning: Bullet's constraint for a
/// point at a distance lets the bodies close exactly that distance. Further passes stop bodies that follow a stopped
/// one.
class qcImpactSampler
{
  public:
    /// Clears the pairs and points of the previous step, and sets the time step.
    void Begin(btScalar timeStep);
    /// Adds the pairs of the meshes of two objects if these pass each other, or one of them moves, by more than contact
    /// distances cover. `axis`: of a plane that separates their hulls, from `a` to `b`; 0: there is none. The objects
    /// are needed until the next Begin. O(meshes) for objects that are new in the step, O(1) for others.
    void AddPair(const qcMovingObject& a, const qcMovingObject& b, const btVector3& axis);
    /// Samples the step. `def`: of the query at the beginning of the step. Bodies of the scene are at the beginning of
    /// the step again afterwards; the scene's last result is lost. No pairs: does nothing.
    qcStatus Sample(qcScene* scene, const qcDetectDef& def);
    /// Appends the speculative contacts of a pair, with ends on the bodies at these transforms.
    void AppendPoints(qcBodyId a, const btTransform& transformA, qcBodyId b, const btTransform& transformB,
                      std::vector<qcMeshPoint>* points) const;

    /// Calls function(slotA, slotB) for the pairs of meshes that may have speculative contacts.
    template <typename Function> void ForEachPair(const Function& function) const
    {
        for (const Pair& pair : m_pairs)
            function(pair.slotA, pair.slotB);
    }

    /// Queries of the last Sample.
    int GetSampleCount() const
    {
        return m_sampleCount;
    }

  private:
    static constexpr int s_never = INT_MAX; ///< a pass that does not come

    struct Object
    {
        qcMovingObject moving;
        qcRigidMotion motion;
        uint64_t meshCount = 0;             ///< in the scene
        btScalar maxMargin = 0;             ///< of these
        uint64_t stoppedCount = 0;          ///< of these, before the previous pass
        uint64_t newlyStoppedCount = 0;     ///< likewise, in the previous pass
        btScalar stopTime = BT_LARGE_FLOAT; ///< the first of those
    };

    /// A mesh of a pair that is kept.
    struct Mesh
    {
        uint32_t object; ///< index
        const qcBatchMesh* placed;
        btScalar stopTime = BT_LARGE_FLOAT; ///< when it touches a body that is stopped or quasi-static
        int stopPass = s_never;             ///< the first pass for which it has stopped

        bool IsStoppedAt(btScalar time) const
        {
            return stopTime <= time;
        }
    };

    /// Two objects; the first slot of the first one is lower. Their motions alone decide how their meshes are sampled.
    struct ObjectPair
    {
        uint32_t a, b; ///< indices of the objects
        int sampleCount;
        btScalar maxSpeed;         ///< upper bound of the speed at which the bodies pass each other
        btScalar contactDistance;  ///< nearer points are found at the beginning of the step
        btScalar threshold;        ///< contact breaking threshold of the pair
        bool isQuasiStatic[2];     ///< so slow that the other body stops where it touches this one
        bool isCoMoving;           ///< sampled only once one of the bodies has stopped
        uint64_t dueCount = 0;     ///< pairs of meshes that the present pass samples further
        btScalar previousTime = 0; ///< of the previous sample of this pass; 0: there is none
        bool isDue = false;        ///< for the present sample
    };

    /// Two meshes that have been near each other, or may be; the slot of the first is lower. All others of their
    /// objects are in the same state, without points.
    struct Pair
    {
        size_t objects; ///< index of the pair of objects
        uint32_t slotA, slotB;
        size_t a, b;               ///< indices of the meshes
        btScalar previousTime = 0; ///< of the pair's previous sample
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

    /// The place of a mesh among those of a world at the beginning of the step.
    struct Slot
    {
        uint32_t object = 0; ///< one more than its index; 0: none that is fast
        uint32_t mesh = 0;   ///< index in the object
    };

    static uint64_t KeyOf(uint32_t low, uint32_t high)
    {
        return uint64_t(low) << 32 | high;
    }

    uint32_t AddObject(const qcMovingObject& moving);
    size_t AddMesh(uint32_t slot);
    Pair& AddMeshes(size_t objects, uint32_t slotA, uint32_t slotB);
    void AddReported(const qcResult& result);
    const ObjectPair* FindObjects(uint32_t slotA, uint32_t slotB) const;
    const Mesh* FindMesh(uint32_t slot) const;
    const Pair* FindPair(uint32_t slotA, uint32_t slotB) const;
    bool IsOfPass(const ObjectPair& objects, const Mesh* a, const Mesh* b) const;
    bool IsClosing(const ObjectPair& objects, const Mesh* a, const Mesh* b, btScalar time) const;
    uint64_t CountOfPass(const ObjectPair& objects) const;
    btTransform TransformAt(const Mesh& mesh, btScalar time) const;
    PairTransforms TransformsAt(const Pair& pair, btScalar time) const;
    qcStatus SetTransforms(qcScene* scene, const Object& object, btScalar time) const;
    qcStatus SetTransforms(qcScene* scene, btScalar time) const;
    bool SelectPairs();
    bool SelectDue(int sample, int sampleCount);
    bool TestPlanes(btScalar distance);
    void EndPass();
    qcDetectDef SampleDef(const qcDetectDef& def);
    qcStatus RunPass(qcScene* scene, const qcDetectDef& def);
    qcStatus TestTriangles(qcScene* scene, const qcDetectDef& def);
    bool TestPlane(btScalar distance, Pair* pair);
    void TakePoints(std::vector<qcMeshPoint>* points, Pair* pair);
    bool IsStoppedBy(const std::vector<qcMeshPoint>& points, const Pair& pair) const;
    btScalar TakeRegion(qcMeshPoint* begin, qcMeshPoint* end, Pair* pair);
    static bool IsDue(void* context, uint32_t slotA, uint32_t slotB);

    btScalar m_timeStep = 0;
    int m_sampleCount = 0;
    int m_pass = 0;        ///< the present one, from 0
    btScalar m_time = 0;   ///< of the present sample
    bool m_isFine = false; ///< points have no known side where fine meshes overlap
    std::vector<Object> m_objects;
    std::vector<ObjectPair> m_objectPairs;
    qcHashTable<uint64_t, uint32_t> m_objectPairOf; ///< by indices of the objects
    std::vector<Slot> m_slots;                      ///< by slot
    std::vector<Mesh> m_meshes;
    std::vector<btScalar> m_stopTimes;        ///< of the meshes, found in the present pass
    qcHashTable<uint64_t, uint32_t> m_meshOf; ///< by slot
    std::vector<Pair> m_pairs;
    qcHashTable<uint64_t, uint32_t> m_pairOf; ///< by slots
    qcPlaneContact m_contact;
    std::vector<qcMeshPoint> m_points; ///< scratch
};

#endif
