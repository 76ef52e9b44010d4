// Contact of all pairs of meshes in a world from one query a step.
#ifndef QC_GLUE_MESH_CONTACT_CONTACT_BATCH_H
#define QC_GLUE_MESH_CONTACT_CONTACT_BATCH_H

#include "common/loop_mutex.h"
#include "common/rigid_limits.h"
#include "mesh_contact/bounces.h"
#include "mesh_contact/impact_sampling.h"
#include "mesh_contact/limits/motion_limiter.h"
#include "mesh_contact/planes/plane_pairs.h"
#include "mesh_contact/scene/batch_scene.h"
#include "mesh_contact/scene/batch_validity.h"

#include <array>
#include <atomic>

class btIDebugDraw;

/// A mesh at the transform of an algorithm's call: children of a compound have their own.
struct qcPlacedMesh
{
    const btCollisionObject* object;
    const btCollisionShape* shape;
    btTransform transform;
};

/// Thread-safety: the functions may run on several threads at once, except where noted.
class qcContactBatch : public qcRigidLimits, public qcKnownGaps
{
  public:
    explicit qcContactBatch(qcDevice* device)
        : m_device(device), m_scene(settings), m_validity(m_scene, m_pairs), m_axes(settings),
          m_limiter(settings, *this, m_axes), m_planes(m_axes)
    {
    }
    qcContactBatch(const qcContactBatch&) = delete;
    qcContactBatch& operator=(const qcContactBatch&) = delete;

    /// Appends the contact points of a pair, up to the contact distance and within the motion of the step: from the
    /// last batch that had the pair if it still holds, else from a new one, for all pairs of the world of which nothing
    /// holds. Pairs that are not in the batch are queried alone. `check`: state of the pair's algorithm, 0 at first.
    void FindPoints(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar timeStep, uint64_t* check,
                    std::vector<qcMeshPoint>* points);
    /// Notes where bodies start the step, once a step, when a pair of two objects is processed. `mark`: state of the
    /// pair's algorithm, 0 at first. New algorithms and pairs of ghosts note nothing: Bullet also processes those
    /// outside of steps.
    void MarkStarts(const btCollisionObject* a, const btCollisionObject* b, uint64_t* mark);
    /// Appends the contact points of a pair whose triangles are at most `distance` apart, from a query for it alone.
    void QueryPair(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar distance, std::vector<qcMeshPoint>* points);
    /// Ends a step, after Bullet has integrated the transforms: see qcMotionLimiter. Soft bodies may have done it.
    void LimitMotion(btScalar timeStep);
    void LimitFirst(btScalar timeStep) override;
    bool HasCertified(const btCollisionObject* object) const override
    {
        return m_limiter.HasCertified(object);
    }
    void LimitAgain(btScalar timeStep, const std::vector<const btCollisionObject*>& held,
                    const qcStartFunction& startOf, std::vector<const btCollisionObject*>* moved) override;
    const qcBatchObject* FindCurrent(const btCollisionObject* object) override;
    bool StayApart(const qcKnownStep& a, const qcKnownStep& b) override;
    /// Call it after the triangles of a shape have changed.
    void InvalidateShape(const btCollisionShape* shape);
    /// Draws the candidates of the last batch, at the present transforms of their objects. `modes`: qcDebugDrawMode.
    void Draw(btIDebugDraw* drawer, int modes);

    qcBounces bounces;
    qcBatchSettings settings;           ///< between steps only
    qcMeshContactStatistics statistics; ///< between steps only

  private:
    /// A mesh of a due pair.
    struct Slot
    {
        uint32_t owner = 0; ///< see qcBatchObject; 0: none
        uint32_t mesh = 0;  ///< index in the object
    };
    using MeshPair = std::array<uint32_t, 4>; ///< owners of two objects, the lower one first, and indices of meshes

    void MarkStarts();
    void Note(qcStatus status);
    void ClearStatistics();
    void LeaveOut(const btCollisionObject* object);
    void ForgetLeftOut();
    void Limit(btScalar timeStep);
    bool AreLeftOut(const qcPlacedMesh& a, const qcPlacedMesh& b);
    qcDetectDef DetectDef(btScalar margin, btScalar spacing) const;
    void ReadPairs();
    void SampleImpacts();
    qcStatus Detect();
    qcPairContact* FindPair(uint32_t slotA, uint32_t slotB);
    qcPairContact* FindDue(uint32_t slotA, uint32_t slotB);
    static bool HasPair(void* context, uint32_t slotA, uint32_t slotB);
    static bool NeedsTriangles(void* context, uint32_t slotA, uint32_t slotB);
    void MarkTriangles(const qcBatchObject& gathered);
    void NumberSlots();
    void ListMeshPairs();
    void StorePoints(const qcBatchPair& pair, uint32_t i, uint32_t j, std::vector<qcMeshPoint>* scratch,
                     qcPairContact* contact) const;
    void StorePoints(const qcBatchPair& pair, std::vector<qcMeshPoint>* scratch, qcPairContact* contact) const;
    void StorePair(const qcBatchPair& pair, std::vector<qcMeshPoint>* scratch);
    void Store();
    void Run();
    int FindMesh(const qcBatchObject& gathered, const qcPlacedMesh& mesh) const;
    bool ReadPair(const qcPlacedMesh& a, const qcPlacedMesh& b, std::vector<qcMeshPoint>* points) const;

    qcDevice* m_device;
    qcBatchScene m_scene;
    qcPairContacts m_pairs;
    qcBatchValidity m_validity;
    std::vector<Slot> m_slots;         ///< by slot
    std::vector<MeshPair> m_meshPairs; ///< with points of the last batch, sorted
    qcAxisCache m_axes;
    qcMotionLimiter m_limiter;
    bool m_isLimited = false;                       ///< the present step, by LimitFirst
    std::atomic<uint64_t> m_mark{1};                ///< number of the last mark of starts
    std::atomic<bool> m_isMarked{false};            ///< starts of the present step
    qcPlanePairs m_planes;                          ///< of the last batch
    qcImpactSampler m_impacts;                      ///< of the last batch
    std::vector<uint8_t> m_triangleSlots;           ///< not 0: of a pair of the last batch that no plane separates
    std::vector<std::vector<qcMeshPoint>> m_points; ///< scratch, by worker
    const qcResult* m_result = nullptr;             ///< of the last batch; null: none, or it failed
    bool m_reportsCandidates = false;               ///< the last batch was to report candidate pairs
    std::atomic<bool> m_isHelped{false}; ///< waiting threads run other tasks: no more loops on several threads
    qcLoopMutex m_mutex;
};

/// Contact distance of two shapes: points that are farther beyond their margins are no contact.
btScalar qcContactDistance(const btCollisionShape* a, const btCollisionShape* b);

#endif
