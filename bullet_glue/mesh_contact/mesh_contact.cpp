// Registering contact of meshes with a world.
#include "quickcullide/bullet_mesh.h"

#include "mesh_contact/collision_algorithm.h"
#include "mesh_contact/compound_mesh_algorithm.h"
#include "mesh_contact/convex_mesh_algorithm.h"
#include "quickcullide/bullet_debug_draw.h"

#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btConvexConcaveCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btEmptyCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btSimpleDynamicsWorld.h>

namespace
{
// Bullet's shape types that consist of triangles.
constexpr int s_meshTypes[] = {TRIANGLE_MESH_SHAPE_PROXYTYPE, SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE,
                               TERRAIN_SHAPE_PROXYTYPE,       MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE,
                               CUSTOM_CONCAVE_SHAPE_TYPE,     FAST_CONCAVE_MESH_PROXYTYPE};

// btPoolAllocator returns slots of the size of Bullet's largest algorithm, whatever size is requested.
static_assert(sizeof(qcMeshMeshAlgorithm) <= sizeof(btConvexConcaveCollisionAlgorithm), "fits into Bullet's pool");
static_assert(sizeof(qcMeshPlaneAlgorithm) <= sizeof(btConvexConcaveCollisionAlgorithm), "fits into Bullet's pool");
static_assert(sizeof(qcCompoundMeshAlgorithm) == sizeof(btCompoundCollisionAlgorithm), "fits into Bullet's pool");
static_assert(sizeof(qcConvexMeshAlgorithm) <= sizeof(btConvexConcaveCollisionAlgorithm), "fits into Bullet's pool");

template <class Algorithm>
btCollisionAlgorithm* Make(btCollisionAlgorithmConstructionInfo& info, qcContactBatch* batch, bool query)
{
    return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Algorithm))) Algorithm(info, batch, query);
}

/// Creates algorithms that read the batch of a world.
struct BatchCreate : btCollisionAlgorithmCreateFunc
{
    BatchCreate(qcContactBatch* ofWorld, bool forQueries) : batch(ofWorld), query(forQueries)
    {
    }

    qcContactBatch* batch;
    bool query;
};

struct MeshMeshCreate : BatchCreate
{
    using BatchCreate::BatchCreate;

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override
    {
        if (qcIsMesh(body0->getCollisionShape()) && qcIsMesh(body1->getCollisionShape()))
            return Make<qcMeshMeshAlgorithm>(info, batch, query);
        // A compound of GImpact: Bullet's own algorithm.
        btGImpactCollisionAlgorithm::CreateFunc gimpact;
        return gimpact.CreateCollisionAlgorithm(info, body0, body1);
    }
};

struct MeshPlaneCreate : BatchCreate
{
    using BatchCreate::BatchCreate;

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override
    {
        // Another class with the shape type of qcMeshShape: Bullet has no algorithm for it.
        if (qcAsMeshShape(body0->getCollisionShape()) == nullptr &&
            qcAsMeshShape(body1->getCollisionShape()) == nullptr)
            return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(btEmptyAlgorithm)))
                btEmptyAlgorithm(info);
        return Make<qcMeshPlaneAlgorithm>(info, batch, query);
    }
};

/// Bullet's worlds run actions right after they have integrated the transforms.
struct LimitAction : btActionInterface
{
    explicit LimitAction(qcContactBatch* ofWorld) : batch(ofWorld)
    {
    }

    void updateAction(btCollisionWorld* world, btScalar timeStep) override
    {
        batch->LimitMotion(timeStep);
        batch->bounces.Apply(static_cast<btDynamicsWorld*>(world));
    }

    void debugDraw(btIDebugDraw*) override
    {
    }

    qcContactBatch* batch;
};
} // namespace

struct qcMeshContact::Implementation
{
    explicit Implementation(qcDevice* device) : batch(device)
    {
    }
    ~Implementation()
    {
        qcRemoveRigidLimits(&batch);
    }

    void Register(int type0, int type1, btCollisionAlgorithmCreateFunc* contact, btCollisionAlgorithmCreateFunc* query);
    void RegisterConvex(int type0, int type1);
    void RegisterCompound(int type);
    void RegisterCompound(int type0, int type1);

    qcContactBatch batch;
    btCollisionDispatcher* dispatcher = nullptr;
    MeshMeshCreate meshContact{&batch, false}, meshQuery{&batch, true};
    LimitAction limitAction{&batch};
    MeshPlaneCreate planeContact{&batch, false}, planeQuery{&batch, true};
    std::vector<std::unique_ptr<qcConvexMeshCreate>> convexContact;
    std::vector<std::unique_ptr<qcCompoundMeshCreate>> compoundContact;
    std::vector<std::unique_ptr<qcCompoundQueryCreate>> compoundQueries;
};

/// Registers for both orders of the types.
void qcMeshContact::Implementation::Register(int type0, int type1, btCollisionAlgorithmCreateFunc* contact,
                                             btCollisionAlgorithmCreateFunc* query)
{
    dispatcher->registerCollisionCreateFunc(type0, type1, contact);
    dispatcher->registerCollisionCreateFunc(type1, type0, contact);
    dispatcher->registerClosestPointsCreateFunc(type0, type1, query);
    dispatcher->registerClosestPointsCreateFunc(type1, type0, query);
}

/// Registers for one order of the types: Bullet has a function for each.
void qcMeshContact::Implementation::RegisterConvex(int type0, int type1)
{
    btCollisionAlgorithmCreateFunc* contact =
        dispatcher->getCollisionConfiguration()->getCollisionAlgorithmCreateFunc(type0, type1);
    convexContact.push_back(std::make_unique<qcConvexMeshCreate>(&batch, contact));
    dispatcher->registerCollisionCreateFunc(type0, type1, convexContact.back().get());
}

/// Registers for compounds and a type, in both orders.
void qcMeshContact::Implementation::RegisterCompound(int type)
{
    RegisterCompound(COMPOUND_SHAPE_PROXYTYPE, type);
    if (type != COMPOUND_SHAPE_PROXYTYPE)
        RegisterCompound(type, COMPOUND_SHAPE_PROXYTYPE);
}

void qcMeshContact::Implementation::RegisterCompound(int type0, int type1)
{
    btCollisionConfiguration& configuration = *dispatcher->getCollisionConfiguration();
    compoundContact.push_back(
        std::make_unique<qcCompoundMeshCreate>(configuration.getCollisionAlgorithmCreateFunc(type0, type1)));
    dispatcher->registerCollisionCreateFunc(type0, type1, compoundContact.back().get());
    compoundQueries.push_back(
        std::make_unique<qcCompoundQueryCreate>(configuration.getClosestPointsAlgorithmCreateFunc(type0, type1)));
    dispatcher->registerClosestPointsCreateFunc(type0, type1, compoundQueries.back().get());
}

qcMeshContact::qcMeshContact(qcDevice* device) : m_implementation(new Implementation(device))
{
}

qcMeshContact::~qcMeshContact() = default;

qcStatus qcMeshContact::addTo(btCollisionWorld* world)
{
    Implementation& my = *m_implementation;
    if (world == nullptr)
        return qcFail(qc_statusBadInput, "qcMeshContact::addTo: world is null");
    if (my.dispatcher != nullptr)
        return qcFail(qc_statusBadInput, "qcMeshContact::addTo: it has a world already");
    my.dispatcher = dynamic_cast<btCollisionDispatcher*>(world->getDispatcher());
    if (my.dispatcher == nullptr)
        return qcFail(qc_statusBadInput, "qcMeshContact::addTo: the world's dispatcher is no btCollisionDispatcher");
    my.batch.settings.world = world;
    if (auto* dynamics = dynamic_cast<btDynamicsWorld*>(world))
    {
        dynamics->addAction(&my.limitAction);
        // It takes no actions.
        if (dynamic_cast<btSimpleDynamicsWorld*>(world) == nullptr)
            my.batch.bounces.Enable();
        qcAddRigidLimits(my.dispatcher, &my.batch);
        for (int type = 0; type < CONCAVE_SHAPES_START_HERE; type++)
        {
            my.RegisterConvex(type, FAST_CONCAVE_MESH_PROXYTYPE);
            my.RegisterConvex(FAST_CONCAVE_MESH_PROXYTYPE, type);
        }
    }
    for (int type = 0; type < CONCAVE_SHAPES_START_HERE; type++)
        my.RegisterCompound(type);
    for (int type : s_meshTypes)
        my.RegisterCompound(type);
    my.RegisterCompound(STATIC_PLANE_PROXYTYPE);
    my.RegisterCompound(COMPOUND_SHAPE_PROXYTYPE);
    for (int type : s_meshTypes)
        my.Register(FAST_CONCAVE_MESH_PROXYTYPE, type, &my.meshContact, &my.meshQuery);
    my.Register(FAST_CONCAVE_MESH_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE, &my.meshContact, &my.meshQuery);
    my.Register(FAST_CONCAVE_MESH_PROXYTYPE, STATIC_PLANE_PROXYTYPE, &my.planeContact, &my.planeQuery);
    return qc_statusOk;
}

qcStatus qcMeshContact::takeOverGImpact()
{
    Implementation& my = *m_implementation;
    if (my.dispatcher == nullptr)
        return qcFail(qc_statusBadInput, "qcMeshContact::takeOverGImpact: it has no world yet");
    my.batch.settings.gimpact = true;
    for (int type : s_meshTypes)
        my.Register(GIMPACT_SHAPE_PROXYTYPE, type, &my.meshContact, &my.meshQuery);
    my.Register(GIMPACT_SHAPE_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE, &my.meshContact, &my.meshQuery);
    return qc_statusOk;
}

void qcMeshContact::updateShape(const btCollisionShape* shape)
{
    m_implementation->batch.InvalidateShape(shape);
}

void qcMeshContact::setThreadCount(unsigned threads)
{
    m_implementation->batch.settings.threads = threads;
}

qcStatus qcMeshContact::setMethod(qcMethod method)
{
    switch (method)
    {
        case qc_methodCullide:
        case qc_methodQuick:
            return qcFail(qc_statusBadInput, "qcMeshContact::setMethod: %s misses pairs", qcMethod_Name(method));
        case qc_methodAuto:
        case qc_methodBrute:
        case qc_methodLayers:
        case qc_methodSweep: m_implementation->batch.settings.method = method; return qc_statusOk;
    }
    return qcFail(qc_statusBadInput, "qcMeshContact::setMethod: unknown method %d", int(method));
}

void qcMeshContact::debugDraw(btIDebugDraw* drawer) const
{
    m_implementation->batch.Draw(drawer, qc_drawPcs);
}

void qcMeshContact::debugDraw(btIDebugDraw* drawer, int modes) const
{
    m_implementation->batch.Draw(drawer, modes);
}

void qcMeshContact::setReportCandidates(bool report)
{
    m_implementation->batch.settings.reportsCandidates = report;
}

const qcMeshContactStatistics& qcMeshContact::getStatistics() const
{
    return m_implementation->batch.statistics;
}
