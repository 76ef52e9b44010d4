// The meshes of a world as bodies of one scene.
#ifndef QC_GLUE_MESH_CONTACT_SCENE_BATCH_SCENE_H
#define QC_GLUE_MESH_CONTACT_SCENE_BATCH_SCENE_H

#include "common/id_counter.h"
#include "common/object_key.h"
#include "common/rigid_motion.h"
#include "common/shape_triangles.h"
#include "mesh_contact/scene/mesh_places.h"

#include <algorithm>
#include <unordered_map>

/// A mesh of an object.
struct qcBatchMesh
{
    const btCollisionShape* shape;
    btTransform transform; ///< in the scene
    btTransform local;     ///< from the mesh's frame to the object's
    uint64_t revision = 0; ///< see qcMeshRevision; 0: stale
    btScalar margin = 0;
    bool inScene = false;
    bool placed = false;                  ///< the mesh is in the scene, at this transform
    btScalar radius = 0;                  ///< upper bound of its points' distance from its origin
    btScalar edgeLength = BT_LARGE_FLOAT; ///< estimate; this value until triangles of Bullet's shapes are counted
    btScalar reach = 0;                   ///< its margin in the scene
    qcBodyId id{};
    std::vector<qcTriangleSource> sources;
};

/// An estimate of a mesh's edge length, for an area equal to that of its box.
btScalar qcEdgeLengthOf(const btCollisionShape* mesh, size_t triangleCount);

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

/// Upper bound of a kinematic body's lead, in contact breaking thresholds.
constexpr btScalar qcMaxLead = 4;

/// An object that may hold meshes. Contact distances exclude the margins of both meshes.
struct qcBatchObject
{
    uint32_t owner = 0;    ///< of its meshes: children of a compound aren't tested with each other
    uint64_t gathered = 0; ///< number of the last gathering that updated the object
    uint64_t present = 0;  ///< number of the last gathering that found the object in the world, or added it
    uint64_t version = 0;  ///< of its meshes and their places in the object; no two objects have the same
    bool isOurs = false;   ///< the library computes contact of one of its meshes with any other mesh
    bool inScene = false;  ///< its meshes are in the scene: from its first pair that the library computes
    qcActivity activity = qc_activityMoving;
    btScalar threshold = 0;          ///< upper bound of its contact breaking threshold
    btScalar tolerance = 0;          ///< see qcBatchScene::s_tolerance
    btScalar margin = 0;             ///< largest of its meshes, tolerance included
    btScalar radius = 0;             ///< upper bound of its meshes' points' distance from its origin
    btScalar boxRadius = 0;          ///< that of its box
    btVector3 lower, upper;          ///< box around it in its frame, margins included
    btScalar maxContactDistance = 0; ///< upper bound of its contact distance and of maxClosing
    btScalar edgeLength = 0;         ///< estimate, of its finest mesh
    btScalar pairDistance = 0;       ///< half of the largest contact distance of its pairs
    btScalar maxClosing = 0;         ///< upper bound of its motion in a step relative to the mean motion
    btScalar lead = 0;               ///< of a kinematic body: how far Bullet has moved it ahead of the step
    qcObjectState state;             ///< at the last check
    uint64_t checked = 0;            ///< number of the last check of the object (qcBatchValidity)
    bool isChanged = false;          ///< result of that check: nothing that is known of its pairs holds
    bool isFinite = true;            ///< result of that check
    std::vector<qcBatchMesh> meshes;
    qcMeshPlaces places;   ///< of the meshes
    bool isPlaced = false; ///< all meshes are in the scene, since the last gathering of the object
    btScalar minReach = 0; ///< the smallest of the meshes

    /// Null: no mesh is placed.
    const qcBatchMesh* FirstPlaced() const
    {
        auto isPlacedMesh = [](const qcBatchMesh& mesh) { return mesh.placed; };
        auto first = std::find_if(meshes.begin(), meshes.end(), isPlacedMesh);
        return first != meshes.end() ? &*first : nullptr;
    }
    /// True if contact of the two is computed here.
    bool MeetsHere(const qcBatchObject& other) const
    {
        return !meshes.empty() && !other.meshes.empty() && (isOurs || other.isOurs);
    }
};

/// Two objects whose pair is queried.
struct qcBatchPair
{
    const btCollisionObject *object0, *object1;
    qcBatchObject *gathered0, *gathered1;
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
    /// Brings the objects of these pairs up to date in the scene. Returns the last error; an object with an error has
    /// no contact.
    qcStatus Gather(const std::vector<qcBatchPair>& pairs);
    /// The object, added if it is new, with its present meshes.
    qcBatchObject* FindOrAdd(const btCollisionObject* object);
    /// Reads the object's meshes anew if they are not as last read. True if they were not.
    bool Refresh(const btCollisionObject* object, qcBatchObject* gathered);
    /// Makes the next gathering read the shape anew.
    void InvalidateShape(const btCollisionShape* shape);

    /// The object as last gathered; null: never gathered.
    const qcBatchObject* Find(const btCollisionObject* object) const;
    qcBatchObject* Find(const btCollisionObject* object);
    /// True if the object's meshes are as last read, at the same places in the object.
    bool IsUnchanged(const btCollisionObject* object, const qcBatchObject& gathered) const;
    /// Upper bound of the object's motion in the step; see qcBatchObject::maxClosing.
    btScalar MaxClosing(const btCollisionObject* object, const qcBatchObject& gathered) const;
    /// Distance between the margins of two objects up to which contact is searched.
    static btScalar ContactDistance(const qcBatchObject& a, const qcBatchObject& b);
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
    /// Distance below which Bullet's manifolds don't distinguish points, of the pairs of the last gathering with finer
    /// triangles than that; 0: there are none.
    btScalar GetSpacing() const
    {
        return m_spacing;
    }
    /// Meshes in the scene that the last gathering updated.
    int GetBodyCount() const
    {
        return m_bodyCount;
    }

    /// Contact is searched up to the motion of the bodies in the step, plus this part of the threshold.
    static constexpr btScalar s_restDistance = btScalar(0.05);
    /// What is known of a pair holds until two of its points have moved against each other by this part of both
    /// thresholds: meshes at rest, which creep by a thousandth of that in each step, need no query. The query distance
    /// is larger by the same length.
    static constexpr btScalar s_tolerance = btScalar(0.03);

  private:
    void Measure(const btCollisionShape& root, qcBatchObject* object) const;
    void Update(const btCollisionObject* object, qcBatchObject* gathered);
    void FindMeanMotion();
    void UpdatePairs(const std::vector<qcBatchPair>& pairs);
    qcStatus UpdateMesh(qcBatchMesh* mesh, const qcBatchObject& gathered, qcActivity activity);
    void UpdateScene(const btCollisionObject* object, qcBatchObject* gathered);
    void RemoveMeshes(qcBatchObject* object);
    void RemoveGone();

    const qcBatchSettings& m_settings;
    qcScene* m_scene = nullptr;
    std::unordered_map<qcObjectKey, qcBatchObject, qcObjectKeyHash> m_objects;
    std::vector<qcBatchMesh> m_present; ///< scratch
    uint64_t m_gathering = 0;           ///< number of the last gathering
    qcIdCounter m_owners;
    uint64_t m_lastVersion = 0;
    int m_bodyCount = 0;
    qcStatus m_status = qc_statusOk;
    btScalar m_margin = 0, m_spacing = 0;
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
