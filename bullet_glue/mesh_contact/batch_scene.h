// The meshes of a world as bodies of one scene.
#ifndef QC_GLUE_MESH_CONTACT_BATCH_SCENE_H
#define QC_GLUE_MESH_CONTACT_BATCH_SCENE_H

#include "common/object_key.h"
#include "common/shape_triangles.h"
#include "mesh_contact/rigid_motion.h"

#include <unordered_map>

/// A mesh of an object.
struct qcBatchMesh
{
    const btCollisionShape* shape;
    btTransform transform;
    uint64_t revision = 0; ///< see qcMeshRevision; 0: stale
    btScalar margin = 0;
    bool inScene = false;
    bool placed = false;                  ///< the mesh is in the scene, at this transform
    btScalar radius = 0;                  ///< upper bound of its points' distance from its origin
    btScalar edgeLength = BT_LARGE_FLOAT; ///< estimate; this value until triangles of Bullet's shapes are counted
    btScalar tolerance = 0;               ///< its points may move this far before the scene is updated
    qcBodyId id{};
    std::vector<qcTriangleSource> sources;

    /// True if the scene has the mesh at this transform, within the tolerance.
    bool IsAt(const btTransform& at) const;
    /// True if the scene has the mesh with the shape's present triangles, at this transform within the tolerance.
    bool IsCurrent(const btCollisionShape* present, const btTransform& at) const;
};

/// Appends the meshes of a shape, at the transforms of Bullet's compound algorithms, to the last bit.
void qcCollectMeshes(const btCollisionShape* shape, const btTransform& transform, std::vector<qcBatchMesh>* meshes);

/// State that changes only between two dispatches, unless the application moves the object.
struct qcObjectState
{
    btTransform transform;
    btVector3 linear, angular;
    bool active;

    static qcObjectState Of(const btCollisionObject* object);
    bool IsStateOf(const btCollisionObject* object) const;
};

/// An object that may hold meshes. Contact distances exclude the margins of both meshes.
struct qcBatchObject
{
    uint32_t owner = 0;    ///< of its meshes: children of a compound aren't tested with each other
    unsigned gathered = 0; ///< number of the last gathering that updated the object
    unsigned present = 0;  ///< number of the last gathering that found the object in the world
    bool isOurs = false;   ///< the library computes contact of one of its meshes with any other mesh
    bool inScene = false;  ///< its meshes are in the scene: from its first pair that the library computes
    qcActivity activity = qc_activityMoving;
    btScalar threshold = 0;          ///< upper bound of its contact breaking threshold
    btScalar margin = 0;             ///< largest of its meshes, tolerance included
    btScalar radius = 0;             ///< upper bound of its points' distance from its origin
    btScalar maxContactDistance = 0; ///< upper bound of its contact distance and of maxClosing
    btScalar maxClosing = 0;         ///< upper bound of its motion in a step relative to the mean motion
    qcObjectState state;             ///< at the last gathering or check
    unsigned checked = 0;            ///< number of the last check of the object (qcBatchValidity)
    bool isValid = false;            ///< result of that check
    std::vector<qcBatchMesh> meshes;
};

/// Settings of the application.
struct qcBatchSettings
{
    btCollisionWorld* world = nullptr;
    bool gimpact = false; ///< contact of GImpact meshes with each other is computed here, too
    unsigned threads = 0;
    qcMethod method = qc_methodAuto;
    bool reportsCandidates = false; ///< the result of a batch has candidate pairs
};

class qcBatchScene
{
  public:
    explicit qcBatchScene(const qcBatchSettings& settings) : m_settings(settings)
    {
    }
    ~qcBatchScene();
    qcBatchScene(const qcBatchScene&) = delete;
    qcBatchScene& operator=(const qcBatchScene&) = delete;

    qcStatus Create(qcDevice* device);
    /// Brings the scene up to date with the world. Returns the last error; an object with an error has no contact.
    qcStatus Gather();
    /// Makes the next gathering read the shape anew.
    void InvalidateShape(const btCollisionShape* shape);

    /// The object as last gathered; null: never gathered.
    const qcBatchObject* Find(const btCollisionObject* object) const;
    qcBatchObject* Find(const btCollisionObject* object);
    /// True if the last gathering updated the object, and its contact distance covers the object's motion in the step.
    bool IsUpToDate(const btCollisionObject* object, const qcBatchObject& gathered) const;
    /// Calls function(object0, object1) for the world's pairs of objects that may hold meshes.
    template <typename Function> void ForEachPair(Function function) const;

    /// Null before Create.
    qcScene* Get() const
    {
        return m_scene;
    }
    const qcBatchSettings& GetSettings() const
    {
        return m_settings;
    }
    /// The time step of the present dispatch; 0: unknown.
    void SetTimeStep(btScalar timeStep)
    {
        m_timeStep = timeStep;
    }
    btScalar GetTimeStep() const
    {
        return m_timeStep;
    }
    /// Distance between triangles up to which the last gathering requires contact.
    btScalar GetMargin() const
    {
        return m_margin;
    }
    /// Meshes in the scene that the last gathering updated.
    int GetBodyCount() const
    {
        return m_bodyCount;
    }

  private:
    /// Contact is searched up to the motion of the bodies in the step, plus this part of the threshold.
    static constexpr btScalar s_restDistance = btScalar(0.05);

    void Measure(const btCollisionShape& root, qcBatchObject* object) const;
    void Refresh(const btCollisionObject* object, qcBatchObject* gathered);
    qcBatchObject* Update(const btCollisionObject* object);
    void FindMeanMotion();
    void UpdatePairs();
    qcStatus UpdateMesh(qcBatchMesh* mesh, const qcBatchObject& gathered, qcActivity activity);
    void UpdateScene(const btCollisionObject* object, qcBatchObject* gathered);
    void RemoveMeshes(qcBatchObject* object);
    void RemoveGone();

    const qcBatchSettings& m_settings;
    qcScene* m_scene = nullptr;
    std::unordered_map<qcObjectKey, qcBatchObject, qcObjectKeyHash> m_objects;
    std::vector<qcBatchMesh> m_present; ///< scratch
    unsigned m_gathering = 0;           ///< number of the last gathering
    uint32_t m_ownerCount = 0;
    int m_bodyCount = 0;
    qcStatus m_status = qc_statusOk;
    btScalar m_margin = 0;
    btScalar m_timeStep = 0;
    qcRigidMotion m_meanMotion; ///< of all moving bodies; closing distances are relative to it
};

template <typename Function> void qcBatchScene::ForEachPair(Function function) const
{
    const btBroadphasePairArray& pairs = m_settings.world->getPairCache()->getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); i++)
    {
        const auto* object0 = static_cast<const btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject);
        const auto* object1 = static_cast<const btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject);
        if (qcMayHoldMeshes(object0->getCollisionShape()) && qcMayHoldMeshes(object1->getCollisionShape()))
            function(object0, object1);
    }
}

#endif
