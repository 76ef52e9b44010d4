// All meshes of a world in one scene: one query a step, whose result the algorithms of the pairs read.
#ifndef QC_GLUE_MESH_CONTACT_CONTACT_BATCH_H
#define QC_GLUE_MESH_CONTACT_CONTACT_BATCH_H

#include "mesh_contact/time_of_impact.h"
#include "mesh_contact/rigid_motion.h"

#include <mutex>
#include <unordered_map>

class btIDebugDraw;

/// A mesh at the place where an algorithm is asked about it: a child of a compound has a place of its own.
struct qcPlacedMesh
{
    const btCollisionObject* object;
    const btCollisionShape* shape;
    btTransform transform;
};

class qcMeshBatch
{
  public:
    explicit qcMeshBatch(qcDevice* device) : m_device(device)
    {
    }
    ~qcMeshBatch();
    qcMeshBatch(const qcMeshBatch&) = delete;
    qcMeshBatch& operator=(const qcMeshBatch&) = delete;

    /// The points of a pair, as far as margins and the motion of a step reach, within the contact breaking threshold:
    /// from the last query if all pairs of the world were there at these places, else from a new one; so the answer
    /// does not depend on which pair is asked for first. `check` is the pair's own, 0 at first. Any thread.
    void Find(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar timeStep, unsigned* check,
              std::vector<qcMeshPoint>* points);
    /// The points of a pair no further apart than `reach`, from a query for it alone. Any thread.
    void Query(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar reach, std::vector<qcMeshPoint>* points);

    /// The triangles of a shape are others now. Any thread.
    void Change(const btCollisionShape* shape);

    /// Draws the candidate triangles of the last query where their objects are now.
    void Draw(btIDebugDraw* drawer);

    /// How far beyond its shells a pair of shapes has contact points.
    btScalar Reach(const btCollisionShape* a, const btCollisionShape* b) const;

    btCollisionWorld* world = nullptr;
    bool gimpact = false; ///< GImpact meshes among each other are ours, too
    unsigned threads = 0;
    qcMethod method = qc_methodAuto;
    qcMeshContactStatistics statistics;

  private:
    /// A mesh of an object.
    struct Mesh
    {
        const btCollisionShape* shape;
        btTransform transform;
        uint64_t revision = 0;
        btScalar margin = 0;
        bool inScene = false;
        bool placed = false;            ///< the scene has it at this transform
        btScalar radius = 0;            ///< of its points, from its origin
        btScalar edge = BT_LARGE_FLOAT; ///< about; this while the triangles of Bullet's own shapes are not yet counted
        btScalar slack = 0;             ///< how far a point may move before the scene is told
        qcBodyId id{};
        std::vector<qcTriangleSource> sources;
    };
    /// Points are looked for as far as bodies may come in this step, and this part of the threshold further.
    static constexpr btScalar s_rest = btScalar(0.05);

    /// What stays the same while one step's pairs are asked for.
    struct State
    {
        btTransform transform;
        btVector3 linear, angular;
        bool active;
    };
    /// What the batch knows of a collision object. The same address may be another object later: what the broadphase
    /// numbers anew when an object is added tells them apart.
    struct Object
    {
        int uniqueId = -1;
        uint32_t owner = 0;   ///< of its meshes: children of a compound don't meet each other
        unsigned seen = 0;    ///< the last gathering that looked at it
        unsigned present = 0; ///< the last gathering that found it in the world
        bool ours = false;    ///< one of its meshes is contact of this kind with any other
        bool wanted = false;  ///< it was in a pair that is ours
        qcActivity activity = qc_activityMoving;
        btScalar threshold = 0; ///< how far beyond its shells it may have contact points
        btScalar margin = 0;    ///< of its shells, slack included
        btScalar radius = 0;    ///< of its shape
        btScalar limit = 0;     ///< how far beyond its shells contact points are looked for at most
        btScalar approach = 0;  ///< how far it may come in a step
        unsigned checked = 0;   ///< the last check that looked at it,
        bool held = false;      ///< found: the last query holds for it,
        State state;            ///< as the last query or check saw it
        std::vector<Mesh> meshes;
    };

    void CollectMeshes(const btCollisionShape* shape, const btTransform& transform, std::vector<Mesh>* meshes) const;
    static bool IsAt(const Mesh& mesh, const btTransform& transform);
    static bool IsAs(const Mesh& held, const btCollisionShape* shape, const btTransform& transform);
    void Measure(const btCollisionShape& root, Object* known) const;
    void Refresh(const btCollisionObject* object, Object* known);
    Object* Know(const btCollisionObject* object);
    void FindDrift();
    void WantPairs();
    void Place(const btCollisionObject* object, Object* known);
    void Forget(Object* known);
    void ForgetGone();
    qcStatus Detect();
    void LookAhead();
    void Gather();
    void Run();
    /// The world's pairs of objects that may hold meshes.
    template <typename Function> void ForEachPair(Function function) const
    {
        const btBroadphasePairArray& pairs = world->getPairCache()->getOverlappingPairArray();
        for (int i = 0; i < pairs.size(); i++)
        {
            const auto* object0 = static_cast<const btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject);
            const auto* object1 = static_cast<const btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject);
            if (qcMayHoldMeshes(object0->getCollisionShape()) && qcMayHoldMeshes(object1->getCollisionShape()))
                function(object0, object1);
        }
    }
    static State StateOf(const btCollisionObject* object);
    static bool IsInState(const btCollisionObject* object, const State& state);
    bool IsSeen(const btCollisionObject* object, const Object& known) const;
    bool IsHeld(const btCollisionObject* object, const Object& known);
    Object* Check(const btCollisionObject* object);
    bool IsAsChecked(const btCollisionObject* object) const;
    bool CheckAll();
    const Mesh* Held(const qcPlacedMesh& mesh, bool* moving) const;
    bool Read(const qcPlacedMesh& a, const qcPlacedMesh& b, std::vector<qcMeshPoint>* points) const;
    void DrawObject(const btCollisionObject* object, btIDebugDraw* drawer) const;
    void Note(qcStatus status);
    qcDetectDef DetectDef(btScalar margin) const;

    qcDevice* m_device;
    qcScene* m_scene = nullptr;
    const qcResult* m_result = nullptr; ///< null: none, or the last query failed
    std::unordered_map<const btCollisionObject*, Object> m_objects;
    std::vector<Mesh> m_collected;
    unsigned m_gathering = 0;
    uint32_t m_owners = 0;   ///< owners given so far
    unsigned m_check = 0;    ///< number of the last check
    btScalar m_margin = 0;   ///< of the next query
    btScalar m_timeStep = 0; ///< of the dispatch; 0: not known
    qcMeshAhead m_ahead;     ///< of the last query
    qcMeshMotion m_drift;    ///< approaches are as seen by who drifts
    std::mutex m_mutex;
};

#endif
