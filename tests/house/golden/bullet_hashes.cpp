// Hashes of short Bullet worlds with our glue, bit by bit: positions and velocities after each step, contacts and
// queries. Uses the public headers only. Results depend on Bullet's own build and on libm: the first line names both.
#include "quickcullide/bullet.h"
#include "quickcullide/bullet_deformable.h"
#ifdef QC_GOLDEN_FRACTURE
#include "quickcullide/bullet_fracture.h"
#endif

#include "house/golden/bullet_worlds.h"

#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <link.h>

namespace
{
//  ---- meshes ------------------------------------------------------------------------------------------------------

/// Meshes of all kinds fall onto a rough floor and a plane; one is fast.
void HashPile(const char* name, unsigned threads, bool mixed)
{
    RigidWorld w(threads);
    qcRandom random = {mixed ? 3u : 2u};
    w.bodies.Add(w.world, w.bodies.Keep(MakeShape(Model(MakeFloor(8, 4)))), 0, btVector3(0, 0, 0));
    Model ball(MakeMesh(1)); // outlives the interface
    btTriangleIndexVertexArray interface(int(ball.indices.size() / 3), reinterpret_cast<int*>(ball.indices.data()),
                                         3 * int(sizeof(int)), int(ball.positions.size() / 3), ball.positions.data(),
                                         3 * int(sizeof(btScalar)));
    if (mixed)
    {
        w.contact.takeOverGImpact();
        w.bodies.Add(w.world, w.bodies.Keep(std::make_unique<btStaticPlaneShape>(btVector3(1, 0, 0), -2)), 0,
                     btVector3(0, 0, 0));
    }
    for (uint32_t i = 0; i < 15; i++)
    {
        btVector3 at = Point(random, -0.8, 0.8) + btVector3(0, btScalar(0.8 + 0.4 * i), 0);
        btCollisionShape* shape = w.bodies.Keep(MakeShape(Model(MakeMesh(i))));
        if (mixed && i % 5 == 1)
        {
            auto gimpact = std::make_unique<btGImpactMeshShape>(&interface);
            gimpact->updateBound();
            shape = w.bodies.Keep(std::move(gimpact));
        }
        if (mixed && i % 5 == 2)
        {
            auto compound = std::make_unique<btCompoundShape>();
            for (int side = -1; side <= 1; side += 2)
                compound->addChildShape(
                    btTransform(btQuaternion::getIdentity(), btVector3(btScalar(side * 0.25), 0, 0)), shape);
            shape = w.bodies.Keep(std::move(compound));
        }
        if (mixed && i % 5 == 3)
            shape = w.bodies.Keep(std::make_unique<btSphereShape>(btScalar(0.3)));
        btRigidBody* body = w.bodies.Add(w.world, shape, 1, at, Turn(random));
        if (i == 7)
            body->setLinearVelocity(btVector3(0, -60, 3));
    }
    for (int step = 0; step < 100; step++)
        w.Step();
    w.PrintAs(name);
}

/// Adds random meshes to a compound, some of them in compounds of their own, and some twice.
void AddRandomChildren(RigidWorld& w, qcRandom& random, uint32_t count, double size, btCompoundShape* compound)
{
    for (uint32_t i = 0; i < count; i++)
    {
        const btTransform place(Turn(random), Point(random, -size, size));
        btCollisionShape* child = w.bodies.Keep(MakeShape(Model(MakeMesh(i))));
        if (size > 0.5 && i % 3 == 2)
        {
            auto inner = std::make_unique<btCompoundShape>();
            AddRandomChildren(w, random, 3, size / 2, inner.get());
            child = w.bodies.Keep(std::move(inner));
        }
        compound->addChildShape(place, child);
        if (i % 5 == 4)
            compound->addChildShape(place, child);
    }
}

/// Compounds of meshes are thrown at each other above a level of tiles, and one that the application moves; one of them
/// loses a child.
void HashCompounds(const char* name, unsigned threads, double speed)
{
    RigidWorld w(threads);
    qcRandom random = {uint64_t(speed) + 5};
    auto level = std::make_unique<btCompoundShape>();
    btCollisionShape* tile = w.bodies.Keep(MakeShape(Model(MakeFloor(2, 0.5))));
    for (int i = 0; i < 64; i++)
        level->addChildShape(btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(0.1 * (i % 3))),
                                         btVector3(btScalar(i % 8 - 3.5), 0, btScalar(i / 8 - 3.5))),
                             tile);
    w.bodies.Add(w.world, w.bodies.Keep(std::move(level)), 0, btVector3(0, 0, 0));
    std::vector<btCompoundShape*> compounds;
    for (uint32_t i = 0; i < 8; i++)
    {
        auto compound = std::make_unique<btCompoundShape>(i % 2 == 0);
        AddRandomChildren(w, random, 4 + i, 0.6, compound.get());
        compounds.push_back(compound.get());
        const btVector3 at = Point(random, -0.4, 0.4) + btVector3(btScalar(i % 2 * 2) - 1, btScalar(2 + i), 0);
        btRigidBody* body = w.bodies.Add(w.world, w.bodies.Keep(std::move(compound)), i > 0 ? 2 : 0, at, Turn(random));
        if (i == 0)
        {
            body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
            body->setActivationState(DISABLE_DEACTIVATION);
        }
        body->setLinearVelocity((btVector3(0, 1, 0) - at).normalized() * btScalar(speed));
        body->setAngularVelocity(Point(random, -speed / 2, speed / 2));
    }
    for (int step = 0; step < 60; step++)
    {
        btRigidBody* moved = w.bodies.bodies[1].get();
        btTransform place(moved->getWorldTransform());
        place.getOrigin() += btVector3(btScalar(0.02), btScalar(-0.01), 0);
        moved->setWorldTransform(place);
        if (step == 20)
            compounds[3]->removeChildShapeByIndex(1);
        w.Step();
    }
    w.PrintAs(name);
}

//  ---- the broadphase ----------------------------------------------------------------------------------------------

struct RayHits : btBroadphaseRayCallback
{
    qcHash* hash;

    bool process(const btBroadphaseProxy* proxy) override
    {
        qcHash_AddArray(hash, &proxy->m_uniqueId, 1, sizeof proxy->m_uniqueId);
        return true;
    }
};

struct BoxHits : btBroadphaseAabbCallback
{
    qcHash* hash;

    bool process(const btBroadphaseProxy* proxy) override
    {
        qcHash_AddArray(hash, &proxy->m_uniqueId, 1, sizeof proxy->m_uniqueId);
        return true;
    }
};

void HashQueries(RigidWorld& w, qcRandom& random, qcHash& queries)
{
    btVector3 from = Point(random, -4.0, 4.0), to = Point(random, -4.0, 4.0);
    btCollisionWorld::ClosestRayResultCallback closest(from, to);
    w.world.rayTest(from, to, closest);
    if (closest.hasHit())
        AddHash(queries, closest.m_hitPointWorld);
    BoxHits boxes;
    boxes.hash = &queries;
    btVector3 half(1, 2, 1);
    w.broadphase.aabbTest(from - half, from + half, boxes);
    RayHits rays;
    rays.hash = &queries;
    btVector3 way = to - from;
    rays.m_lambda_max = way.length();
    way /= rays.m_lambda_max;
    for (int axis = 0; axis < 3; axis++)
    {
        rays.m_rayDirectionInverse[axis] = way[axis] == 0 ? btScalar(BT_LARGE_FLOAT) : 1 / way[axis];
        rays.m_signs[axis] = rays.m_rayDirectionInverse[axis] < 0;
    }
    w.broadphase.rayTest(from, to, rays);
}

void HashBroadphase(const char* name, int count)
{
    RigidWorld w(1);
    qcRandom random = {uint64_t(count)};
    qcHash pairs = qcHash_Start(), queries = qcHash_Start();
    btCollisionShape* const shapes[5] = {
        w.bodies.Keep(std::make_unique<btBoxShape>(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.4)))),
        w.bodies.Keep(std::make_unique<btSphereShape>(btScalar(0.3))),
        w.bodies.Keep(std::make_unique<btCapsuleShape>(btScalar(0.2), btScalar(0.5))),
        w.bodies.Keep(std::make_unique<btConeShape>(btScalar(0.3), btScalar(0.6))),
        w.bodies.Keep(MakeShape(Model(MakeMesh(2))))};
    w.bodies.Add(w.world, w.bodies.Keep(std::make_unique<btBoxShape>(btVector3(6, 1, 6))), 0, btVector3(0, -1, 0));
    for (int step = 0; step < 90; step++)
    {
        if (step % 5 == 0 && int(w.bodies.bodies.size()) <= count)
            for (uint32_t i = 0; i < uint32_t(count) / 8; i++)
            {
                // Compilers evaluate arguments in different orders.
                btQuaternion turn = Turn(random);
                w.bodies.Add(w.world, shapes[(i + uint32_t(step)) % 5], 1,
                             Point(random, -1.5, 1.5) + btVector3(0, 3, 0), turn);
            }
        if (step % 9 == 8)
        {
            size_t at = 1 + qcRandom_Below(&random, uint32_t(w.bodies.bodies.size() - 1));
            w.world.removeRigidBody(w.bodies.bodies[at].get());
            w.bodies.bodies.erase(w.bodies.bodies.begin() + ptrdiff_t(at));
        }
        w.Step();
        const btBroadphasePairArray& all = w.broadphase.getOverlappingPairCache()->getOverlappingPairArray();
        for (int i = 0; i < all.size(); i++)
        {
            const int ids[2] = {all[i].m_pProxy0->m_uniqueId, all[i].m_pProxy1->m_uniqueId};
            qcHash_AddArray(&pairs, ids, 1, sizeof ids);
        }
        HashQueries(w, random, queries);
    }
    std::printf("%s", name);
    Print("motion", w.motion);
    Print("contacts", w.contacts);
    Print("pairs", pairs);
    Print("queries", queries);
    std::putchar('\n');
}

//  ---- soft worlds -------------------------------------------------------------------------------------------------

/// Cloths and a rope over meshes, in Bullet's classic world or its deformable one.
struct SoftScene
{
    Bodies bodies;
    std::vector<std::unique_ptr<btSoftBody>> softBodies;
    qcHash motion = qcHash_Start(), rigid = qcHash_Start(), contacts = qcHash_Start(), counts = qcHash_Start();

    void AddMeshes(btDiscreteDynamicsWorld& world)
    {
        world.setGravity(btVector3(0, -10, 0));
        bodies.Add(world, bodies.Keep(MakeShape(Model(MakeFloor(8, 3)))), 0, btVector3(0, btScalar(-0.3), 0));
        bodies.Add(world, bodies.Keep(MakeShape(Model(MakeMesh(1)))), 0, btVector3(0, btScalar(0.3), 0));
        bodies.Add(world, bodies.Keep(MakeShape(Model(MakeMesh(0)))), 2, btVector3(btScalar(0.6), btScalar(0.4), 0));
    }

    /// A sheet from the corner `at` along two sides.
    btSoftBody* MakeCloth(btSoftBodyWorldInfo& info, const btVector3& at, const btVector3& u, const btVector3& v)
    {
        softBodies.emplace_back(btSoftBodyHelpers::CreatePatch(info, at, at + u, at + v, at + u + v, 14, 14, 0, true));
        softBodies.back()->getCollisionShape()->setMargin(btScalar(0.02));
        softBodies.back()->setTotalMass(btScalar(0.5));
        return softBodies.back().get();
    }

    void Note(btDispatcher& dispatcher, const qcSoftBodyStatistics& s)
    {
        CheckOk(s.status, "qcSoftBodyContact");
        for (const auto& body : softBodies)
            AddHash(motion, *body);
        bodies.AddTo(rigid);
        AddContacts(contacts, dispatcher);
        const int all[] = {s.contacts,  s.penetrating, s.rounds,   s.planes, s.zoneNodes,
                           s.remaining, s.exempt,      s.unproven, s.meshes, s.sweptNodes};
        qcHash_AddArray(&counts, all, sizeof all / sizeof all[0], sizeof all[0]);
    }

    void PrintAs(const char* name) const
    {
        std::printf("%s", name);
        Print("motion", motion);
        Print("rigid", rigid);
        Print("contacts", contacts);
        Print("counts", counts);
        std::putchar('\n');
    }
};

/// Hashes a soft world. `tangled`: two sheets penetrate at the start.
void HashSoft(const char* name, unsigned threads, bool tangled)
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);
    qcMeshContact meshContact;
    meshContact.addTo(&world);
    softSolver.setThreadCount(threads);
    meshContact.setThreadCount(threads);
    SoftScene scene;
    scene.AddMeshes(world);
    btSoftBodyWorldInfo& info = world.getWorldInfo();
    info.m_gravity = world.getGravity();
    btScalar high = btScalar(tangled ? 0.9 : 0.75);
    // One lies, one stands and folds as it falls.
    btSoftBody* lying = scene.MakeCloth(info, btVector3(btScalar(-0.7), high, btScalar(-0.7)),
                                        btVector3(btScalar(1.4), 0, 0), btVector3(0, btScalar(0.1), btScalar(1.4)));
    btSoftBody* standing =
        scene.MakeCloth(info, btVector3(btScalar(-0.6), btScalar(tangled ? 0.7 : 1.0), btScalar(0.05)),
                        btVector3(btScalar(1.2), 0, btScalar(0.1)), btVector3(btScalar(0.1), btScalar(1.2), 0));
    scene.softBodies.emplace_back(btSoftBodyHelpers::CreateRope(info, btVector3(-1, btScalar(2.4), btScalar(0.3)),
                                                                btVector3(1, btScalar(2.4), btScalar(0.2)), 30, 0));
    scene.softBodies.back()->getCollisionShape()->setMargin(btScalar(0.03));
    for (btSoftBody* cloth : {lying, standing})
    {
        cloth->m_cfg.piterations = 3;
    }
    qcSoftBodySettings settings;
    settings.friction = btScalar(0.5);
    softSolver.setSettings(standing, settings);
    for (const auto& body : scene.softBodies)
        world.addSoftBody(body.get());
    for (int step = 0; step < 110; step++)
    {
        world.stepSimulation(btScalar(1.0 / 120), 0);
        scene.Note(dispatcher, softSolver.getStatistics());
    }
    scene.PrintAs(name);
    for (const auto& body : scene.softBodies)
        world.removeSoftBody(body.get());
    scene.bodies.RemoveFrom(world);
}

void HashDeformable(const char* name, unsigned threads)
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver solver;
    solver.setDeformableSolver(&deformableSolver);
    qcDeformableWorld world(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver);
    qcMeshContact meshContact;
    meshContact.addTo(&world);
    world.setThreadCount(threads);
    btDeformableMassSpringForce springs(10, btScalar(0.05), true);
    btDeformableGravityForce gravity(btVector3(0, -10, 0));
    SoftScene scene;
    scene.AddMeshes(world);
    btSoftBodyWorldInfo& info = world.getWorldInfo();
    info.m_gravity = world.getGravity();
    info.m_sparsesdf.setDefaultVoxelsz(btScalar(0.25));
    scene.MakeCloth(info, btVector3(btScalar(-0.6), btScalar(0.7), btScalar(-0.6)), btVector3(btScalar(1.2), 0, 0),
                    btVector3(0, btScalar(0.1), btScalar(1.2)));
    scene.MakeCloth(info, btVector3(btScalar(-0.5), btScalar(0.9), 0), btVector3(1, 0, btScalar(0.1)),
                    btVector3(btScalar(0.1), 1, 0));
    for (const auto& body : scene.softBodies)
    {
        world.addSoftBody(body.get());
        world.addForce(body.get(), &springs);
        world.addForce(body.get(), &gravity);
    }
    for (int step = 0; step < 90; step++)
    {
        world.stepSimulation(btScalar(1.0 / 200), 0);
        scene.Note(dispatcher, world.getStatistics());
    }
    scene.PrintAs(name);
    for (const auto& body : scene.softBodies)
        world.removeSoftBody(body.get());
    scene.bodies.RemoveFrom(world);
}

//  ---- fracture ----------------------------------------------------------------------------------------------------

#ifdef QC_GOLDEN_FRACTURE
/// Hashes the pieces of a mesh, and their fall.
void HashFracture(const char* name, uint32_t kind)
{
    Model model(MakeMesh(kind));
    qcFractureDef def;
    for (size_t i = 0; i < model.positions.size(); i += 3)
        def.vertices.emplace_back(model.positions[i], model.positions[i + 1], model.positions[i + 2]);
    def.indices = model.indices;
    btScalar half(btScalar(0.6));
    btVector3 impact(btScalar(0.3), 0, 0);
    def.sites = qcScatterSites(btVector3(-half, -half, -half), btVector3(half, half, half), 24, kind, &impact);
    qcFracture fracture = qcFracture_Split(def);
    CheckOk(fracture.status, fracture.message.c_str());
    RigidWorld w(1);
    qcHash sites = qcHash_Start(), pieces = qcHash_Start();
    for (const btVector3& site : def.sites)
        AddHash(sites, site);
    auto shape = MakeShape(model);
    btVector3 inertia;
    shape->calculateLocalInertia(5, inertia);
    btRigidBody whole(5, nullptr, shape.get(), inertia);
    whole.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.9), 0)));
    whole.setLinearVelocity(btVector3(1, -3, 0));
    whole.setAngularVelocity(btVector3(0, 1, 2));
    w.bodies.Add(w.world, w.bodies.Keep(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0)), 0,
                 btVector3(0, 0, 0));
    for (const qcPiece& piece : fracture.pieces)
    {
        for (const btVector3& vertex : piece.vertices)
            AddHash(pieces, vertex);
        qcHash_AddArray(&pieces, piece.indices.data(), piece.indices.size(), sizeof piece.indices[0]);
        qcHash_AddArray(&pieces, &piece.volume, 1, sizeof piece.volume);
        const uint32_t rest[2] = {piece.firstCutTriangle, piece.site};
        qcHash_AddArray(&pieces, rest, 1, sizeof rest);
        AddHash(pieces, piece.frame);
        qcPieceMotion motion = qcMotionOfPiece(whole, fracture, piece);
        auto pieceShape = std::make_unique<qcMeshShape>(&piece.vertices[0], qc_scalarType, sizeof(btVector3),
                                                        uint32_t(piece.vertices.size()), piece.indices.data(),
                                                        uint32_t(piece.indices.size() / 3));
        btRigidBody* body =
            w.bodies.Add(w.world, w.bodies.Keep(std::move(pieceShape)), motion.mass, btVector3(0, 0, 0));
        body->setWorldTransform(motion.transform);
        body->setInterpolationWorldTransform(motion.transform);
        body->setLinearVelocity(motion.linearVelocity);
        body->setAngularVelocity(motion.angularVelocity);
    }
    for (int step = 0; step < 40; step++)
        w.Step();
    std::printf("%s", name);
    Print("sites", sites);
    Print("pieces", pieces);
    Print("motion", w.motion);
    Print("contacts", w.contacts);
    std::putchar('\n');
}
#endif

//  ---- what the results depend on ----------------------------------------------------------------------------------

int NoteLibrary(dl_phdr_info* info, size_t, void* context)
{
    std::string path = info->dlpi_name;
    for (const char* part : {"/libBullet", "/libLinearMath", "/libGLU", "/libvoro"})
        if (path.find(part) != std::string::npos)
            static_cast<std::vector<std::string>*>(context)->push_back(path);
    return 0;
}

/// The bytes of Bullet's libraries, and what libm computes: it has variants for processors.
void PrintGround()
{
    std::vector<std::string> paths;
    dl_iterate_phdr(NoteLibrary, &paths);
    std::sort(paths.begin(), paths.end());
    qcHash libraries = qcHash_Start(), libm = qcHash_Start();
    for (const std::string& path : paths)
    {
        std::ifstream file(path, std::ios::binary);
        const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        qcHash_AddArray(&libraries, bytes.data(), bytes.size(), 1);
    }
    qcRandom random = {1};
    for (int i = 0; i < 3000; i++)
    {
        btScalar x = Uniform(random, -4.0, 4.0), y = Uniform(random, -1.0, 1.0);
        const btScalar values[] = {std::sin(x),  std::cos(x),  std::tan(x),        std::atan2(x, y),
                                   std::asin(y), std::acos(y), std::pow(x * x, y), std::exp(x)};
        qcHash_AddArray(&libm, values, 8, sizeof values[0]);
    }
    std::printf("# Bullet %d", BT_BULLET_VERSION);
    Print("libraries", libraries);
    Print("libm", libm);
#ifndef QC_GOLDEN_FRACTURE
    std::printf(" without fracture");
#endif
    std::putchar('\n');
}
} // namespace

int main()
{
    PrintGround();
    HashPile("pile", 1, false);
    HashPile("pile/threads", 2, false);
    HashPile("pile/mixed", 1, true);
    HashCompounds("compounds/slow", 1, 0.5);
    HashCompounds("compounds/fast", 2, 30);
    HashBroadphase("broadphase/few", 32);
    HashBroadphase("broadphase/many", 120);
    HashSoft("soft", 1, false);
    HashSoft("soft/threads", 2, false);
    HashSoft("soft/tangled", 1, true);
    HashDeformable("deformable", 1);
#ifdef QC_GOLDEN_FRACTURE
    HashFracture("fracture/torus", 0);
    HashFracture("fracture/ball", 1);
    HashFracture("fracture/box", 2);
#endif
    return 0;
}
