// A soft body or an object that is not finite has no contact; all others move as they would without it.
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_timeStep = btScalar(1.0 / 60);
constexpr int s_breaks = 20, s_meets = 40, s_mends = 50, s_ends = 80; ///< steps
constexpr btScalar s_wall = 8, s_wallHeight = 4, s_height = btScalar(0.3);
constexpr btScalar s_meetingTolerance = btScalar(0.01); ///< of bodies that meet, several at a time

btSoftBody* MakeSheet(btSoftBodyWorldInfo& info, btScalar x, btScalar y)
{
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(info, btVector3(x - 1, y, -1), btVector3(x + 1, y, -1),
                                                       btVector3(x - 1, y, 1), btVector3(x + 1, y, 1), 12, 12, 0, true);
    cloth->setTotalMass(btScalar(0.5));
    return cloth;
}

/// A wall of two triangles across x.
qcModel WallModel()
{
    qcModel model;
    qcAddGrid(&model, btVector3(s_wall, 0, -2), btVector3(0, s_wallHeight, 0), btVector3(0, 0, 4), 1, 1);
    return model;
}

/// What the application does within a step, after Bullet has moved the bodies.
struct Action : btActionInterface
{
    std::function<void()> run;

    void updateAction(btCollisionWorld*, btScalar) override
    {
        if (run)
            run();
        run = nullptr;
    }

    void debugDraw(btIDebugDraw*) override
    {
    }
};

/// Bullet's solver, by the order of bodies and places. That of Bullet's islands depends on all manifolds of the world.
struct OrderedSolver : btSequentialImpulseConstraintSolver
{
    btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds, int manifoldCount,
                        btTypedConstraint** constraints, int constraintCount, const btContactSolverInfo& info,
                        btIDebugDraw* drawer, btDispatcher* dispatcher) override
    {
        std::stable_sort(manifolds, manifolds + manifoldCount,
                         [](const btPersistentManifold* a, const btPersistentManifold* b)
                         { return Key(*a) < Key(*b); });
        return btSequentialImpulseConstraintSolver::solveGroup(bodies, bodyCount, manifolds, manifoldCount, constraints,
                                                               constraintCount, info, drawer, dispatcher);
    }

    static std::vector<btScalar> Key(const btPersistentManifold& manifold)
    {
        std::vector<btScalar> key = {btScalar(manifold.getBody0()->getWorldArrayIndex()),
                                     btScalar(manifold.getBody1()->getWorldArrayIndex())};
        for (int i = 0; i < manifold.getNumContacts(); i++)
            for (int axis = 0; axis < 3; axis++)
                key.push_back(manifold.getContactPoint(i).getPositionWorldOnB()[axis]);
        return key;
    }
};

/// Sheets that fall onto each other and onto a mesh, meshes that are piled up, balls and tori that are thrown at a
/// wall; and, by themselves, what is to break: a sheet, a mesh with another one on it, a kinematic and a static one, a
/// ball that flies, a plane.
struct Scene : qcSoftWorld
{
    OrderedSolver ordered;
    Action action;
    qcMeshShape* torus;
    std::vector<const btRigidBody*> others;  ///< dynamic ones that stay finite
    size_t firstMeeting = 0, meetingEnd = 0; ///< in `others`
    btSoftBody *sheet, *asleep;              ///< the first is to break, like the following
    btRigidBody *dynamic, *kinematic, *fixed, *ball, *plane;
    const btRigidBody* upper; ///< on `dynamic`

    /// `isCrowded`: with so many objects that those near sheets are found by the broadphase.
    explicit Scene(bool isCrowded)
    {
        world.setConstraintSolver(&ordered);
        // Before the action that limits meshes.
        world.addAction(&action);
        meshContact.addTo(&world);
        meshContact.setThreadCount(1);
        AddMesh(qcFloorModel(30, 2), 0, btVector3(0, 0, 0));
        AddMesh(WallModel(), 0, btVector3(0, 0, 0));
        torus = KeepMesh(qcTorusModel(0.5, 0.2, 16, 8));
        for (int i = 0; i < 3; i++)
            others.push_back(AddBody(torus, 1, btVector3(btScalar(0.05) * btScalar(i), btScalar(0.3 + 0.45 * i), 0)));
        AddBody(torus, 0, btVector3(-4, btScalar(0.3), 0));
        for (int i = 0; i < 2; i++)
            AddSheet(-4, btScalar(0.8 + 0.1 * i));
        sheet = AddSheet(-10, btScalar(0.5));
        asleep = AddSheet(40, 5);
        asleep->forceActivationState(ISLAND_SLEEPING);
        dynamic = AddBody(torus, 1, btVector3(-15, btScalar(0.3), 0));
        kinematic = AddBody(torus, 0, btVector3(-15, btScalar(0.3), 5));
        kinematic->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        kinematic->setActivationState(DISABLE_DEACTIVATION);
        fixed = AddBody(torus, 0, btVector3(-15, btScalar(0.3), 10));
        upper = AddBody(torus, 1, btVector3(-15, btScalar(0.75), 0));
        btCollisionShape* sphere = KeepBall();
        ball = AddBody(sphere, 1, btVector3(-15, 1, 15));
        ball->setLinearVelocity(btVector3(0, 50, 0));
        shapes.emplace_back(new btStaticPlaneShape(btVector3(0, 1, 0), 0));
        plane = AddBody(shapes.back().get(), 0, btVector3(-15, -60, 0));
        for (int i = 0; isCrowded && i < 100; i++)
            AddBody(sphere, 0, btVector3(btScalar(i), -50, 0));
    }

    ~Scene()
    {
        RemoveAll();
        world.removeAction(&action);
    }

    btSoftBody* AddSheet(btScalar x, btScalar y)
    {
        cloths.push_back(MakeSheet(world.getWorldInfo(), x, y));
        world.addSoftBody(cloths.back());
        return cloths.back();
    }

    btCollisionShape* KeepBall()
    {
        shapes.emplace_back(new btSphereShape(btScalar(0.1)));
        return shapes.back().get();
    }

    void Throw(btCollisionShape* shape, const btVector3& from, const btVector3& velocity)
    {
        btRigidBody* body = AddBody(shape, 1, from);
        body->setGravity(btVector3(0, 0, 0));
        body->setLinearVelocity(velocity);
        others.push_back(body);
    }

    void ThrowAtEachOther()
    {
        firstMeeting = others.size();
        for (int i = 0; i < 8; i++)
        {
            const btVector3 side = btVector3(1, 0, 0).rotate(btVector3(0, 0, 1), btScalar(i) * SIMD_2_PI / 8);
            Throw(torus, btVector3(-30, 10, 0) + 2 * side, -90 * side);
        }
        meetingEnd = others.size();
    }

    void Step(int step)
    {
        if (step % 20 == 5)
            Throw(torus, btVector3(s_wall - 2, 2, 0), btVector3(90, 0, 0));
        if (step % 20 == 15)
            Throw(KeepBall(), btVector3(s_wall - 2, 2, 0), btVector3(90, 0, 0));
        if (step == s_meets)
            ThrowAtEachOther();
        world.stepSimulation(s_timeStep, 0);
    }

    /// Checks that what stays finite is where it is in another scene, and behind nothing.
    void Compare(const Scene& expected) const
    {
        for (size_t c = 0; c < 2; c++)
            for (int i = 0; i < cloths[c]->m_nodes.size(); i++)
            {
                const btVector3 &found = cloths[c]->m_nodes[i].m_x, &right = expected.cloths[c]->m_nodes[i].m_x;
                ck_assert_msg(found == right, "node %d of sheet %zu", i, c);
            }
        for (size_t i = 0; i < others.size(); i++)
        {
            const btVector3& found = others[i]->getWorldTransform().getOrigin();
            const btScalar distance = found.distance(expected.others[i]->getWorldTransform().getOrigin());
            ck_assert_msg(distance <= (i >= firstMeeting && i < meetingEnd ? s_meetingTolerance : 0), "body %zu", i);
            ck_assert(found.y() > 0 && (found.x() < s_wall || found.y() > s_wallHeight));
        }
        ck_assert(upper->getWorldTransform().getOrigin().y() > 0);
        ck_assert_int_eq(asleep->getActivationState(), ISLAND_SLEEPING);
    }
};

void PutAt(btRigidBody* body, btScalar value)
{
    btTransform place = body->getWorldTransform();
    place.setOrigin(btVector3(value, value, value));
    body->setWorldTransform(place);
    body->setInterpolationWorldTransform(place);
}

void PutBack(btRigidBody* body, btScalar y, btScalar z)
{
    btTransform place(btQuaternion::getIdentity(), btVector3(-15, y, z));
    body->setWorldTransform(place);
    body->setInterpolationWorldTransform(place);
    body->setLinearVelocity(btVector3(0, 0, 0));
    body->setAngularVelocity(btVector3(0, 0, 0));
    if (!body->isStaticOrKinematicObject())
        body->forceActivationState(ACTIVE_TAG);
}

void MendSheet(Scene& scene)
{
    const btSoftBody* whole = scene.cloths[0];
    for (int i = 0; i < scene.sheet->m_nodes.size(); i++)
    {
        btSoftBody::Node& node = scene.sheet->m_nodes[i];
        node.m_x = node.m_q = whole->m_nodes[i].m_x + btVector3(-6, 2, 0);
        node.m_v = node.m_f = btVector3(0, 0, 0);
    }
    btSoftBody::Link& link = scene.sheet->m_links[3];
    link.m_c1 = link.m_rl * link.m_rl;
    scene.sheet->forceActivationState(ACTIVE_TAG);
}

/// A way in which something ceases to be finite.
struct Break
{
    const char* name;
    void (*apply)(Scene&, btScalar);
    btRigidBody* Scene::*body; ///< null: the sheet
    btScalar y, z;             ///< where the body is put back
    bool isOfMeshes;           ///< contact of meshes reports it

    const btCollisionObject* ObjectOf(const Scene& scene) const
    {
        return body != nullptr ? scene.*body : static_cast<const btCollisionObject*>(scene.sheet);
    }

    void Mend(Scene& scene) const
    {
        if (body != nullptr)
            PutBack(scene.*body, y, z);
        else
            MendSheet(scene);
    }
};

const Break s_ways[] = {
    {"a node", [](Scene& scene, btScalar value) { scene.sheet->m_nodes[7].m_x.setY(value); }, nullptr, 0, 0, false},
    {"a node's velocity", [](Scene& scene, btScalar value) { scene.sheet->m_nodes[7].m_v.setY(value); }, nullptr, 0, 0,
     false},
    // Bullet's solver then computes infinity / infinity.
    {"a link's squared length",
     [](Scene& scene, btScalar) { scene.sheet->m_links[3].m_c1 = std::numeric_limits<btScalar>::infinity(); }, nullptr,
     0, 0, false},
    {"the transform of a dynamic body", [](Scene& scene, btScalar value) { PutAt(scene.dynamic, value); },
     &Scene::dynamic, s_height, 2, true},
    {"the velocity of a dynamic body",
     [](Scene& scene, btScalar value) { scene.dynamic->setAngularVelocity(btVector3(0, value, 0)); }, &Scene::dynamic,
     s_height, 2, true},
    {"the transform of a fast ball", [](Scene& scene, btScalar value) { PutAt(scene.ball, value); }, &Scene::ball,
     s_height, 15, false},
    {"the transform of a kinematic body", [](Scene& scene, btScalar value) { PutAt(scene.kinematic, value); },
     &Scene::kinematic, s_height, 5, true},
    {"the transform of a plane", [](Scene& scene, btScalar value) { PutAt(scene.plane, value); }, &Scene::plane, -60, 0,
     true},
    {"the transform of a static body", [](Scene& scene, btScalar value) { PutAt(scene.fixed, value); }, &Scene::fixed,
     s_height, 10, true},
};
constexpr int s_wayCount = int(sizeof s_ways / sizeof s_ways[0]);
constexpr int s_lastWay = s_wayCount - 1; ///< a static body at infinity is far from everything

/// `isMendedWithin`: within a step, from when on it is finite; otherwise after the comparison.
void CheckBreak(const Break& way, btScalar value, bool isCrowded, bool isMendedWithin)
{
    Scene scene(isCrowded), whole(isCrowded);
    for (int step = 0; step < s_ends; step++)
    {
        if (step == s_breaks)
            way.apply(scene, value);
        const bool isMended = isMendedWithin && step == s_mends;
        if (isMended)
            scene.action.run = [&] { way.Mend(scene); };
        scene.Step(step);
        whole.Step(step);
        scene.Compare(whole);
        const qcSoftBodyStatistics& soft = scene.softSolver.getStatistics();
        const qcMeshContactStatistics& mesh = scene.meshContact.getStatistics();
        const bool isBroken = step >= s_breaks && (!isMendedWithin || step < s_mends);
        ck_assert_msg((soft.status == qc_statusBadInput) == isBroken, "%s: step %d", way.name, step);
        ck_assert_ptr_eq(soft.notFinite, isBroken ? way.ObjectOf(scene) : nullptr);
        ck_assert_ptr_eq(mesh.notFinite, isBroken && way.isOfMeshes ? way.ObjectOf(scene) : nullptr);
        ck_assert_int_eq(mesh.status, mesh.notFinite != nullptr ? qc_statusBadInput : qc_statusOk);
        if (isBroken)
            ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "not finite"));
    }
    if (!isMendedWithin)
        way.Mend(scene);
    for (int step = 0; step < 60; step++)
    {
        scene.world.stepSimulation(s_timeStep, 0);
        ck_assert_msg(scene.softSolver.getStatistics().status == qc_statusOk, "%s: mended", way.name);
        ck_assert_int_eq(scene.meshContact.getStatistics().status, qc_statusOk);
    }
    ck_assert(qcLowestNode(scene.sheet) > 0);
    ck_assert(scene.dynamic->getWorldTransform().getOrigin().y() > btScalar(0.1));
}

START_TEST(finite_bodies_move_as_without_one_that_is_not_a_number_until_it_is_mended)
{
    CheckBreak(s_ways[_i], std::numeric_limits<btScalar>::quiet_NaN(), true, true);
}
END_TEST

START_TEST(finite_bodies_move_as_without_an_infinite_one)
{
    CheckBreak(s_ways[_i], -std::numeric_limits<btScalar>::infinity(), false, false);
}
END_TEST

START_TEST(settings_of_a_body_are_kept_while_it_is_not_finite)
{
    Scene scene(false);
    qcSoftBodySettings settings;
    settings.friction = btScalar(0.7);
    ck_assert_int_eq(scene.softSolver.setSettings(scene.sheet, settings), qc_statusOk);
    for (int step = 0; step < 6; step++)
    {
        if (step == 2)
            scene.sheet->m_nodes[7].m_x.setY(std::numeric_limits<btScalar>::quiet_NaN());
        if (step == 4)
            MendSheet(scene);
        scene.Step(step);
    }
    ck_assert_int_eq(scene.softSolver.getStatistics().status, qc_statusOk);
    ck_assert(scene.softSolver.getSettings(scene.sheet).friction == settings.friction);
}
END_TEST

START_TEST(a_world_may_have_no_finite_soft_body)
{
    qcSoftWorld world;
    for (int i = 0; i < 2; i++)
    {
        world.cloths.push_back(MakeSheet(world.world.getWorldInfo(), 0, btScalar(i)));
        world.world.addSoftBody(world.cloths.back());
        world.cloths.back()->m_nodes[i].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
    }
    for (int step = 0; step < 3; step++)
    {
        world.world.stepSimulation(s_timeStep, 0);
        ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusBadInput);
    }
    world.RemoveCloth();
    world.RemoveCloth();
    world.world.stepSimulation(s_timeStep, 0);
    ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusOk);
}
END_TEST

/// Must outlive the world.
struct Forces
{
    std::vector<std::unique_ptr<btDeformableLagrangianForce>> forces;
};

/// Two deformable sheets above a mesh.
struct DeformableScene : Forces, qcDeformableTestWorld<qcDeformableWorld>
{
    std::unique_ptr<qcMeshShape> shape = qcFloorModel(10, 4).MakeShape();
    btRigidBody floor{0, nullptr, shape.get()};

    DeformableScene()
    {
        world->setThreadCount(1);
        world->getWorldInfo().m_gravity = world->getGravity();
        world->addRigidBody(&floor);
        for (btScalar x : {btScalar(-3), btScalar(3)})
        {
            cloths.push_back(MakeSheet(world->getWorldInfo(), x, btScalar(0.3)));
            world->addSoftBody(cloths.back());
            AddForce(new btDeformableMassSpringForce(15, btScalar(0.5), true));
            AddForce(new btDeformableGravityForce(world->getGravity()));
        }
    }

    ~DeformableScene()
    {
        world->removeRigidBody(&floor);
    }

    void AddForce(btDeformableLagrangianForce* force)
    {
        forces.emplace_back(force);
        world->addForce(cloths.back(), force);
    }
};

START_TEST(a_deformable_sheet_lies_beside_one_that_is_not_finite)
{
    DeformableScene scene;
    for (int step = 0; step < 60; step++)
    {
        if (step == 5)
            for (int i = 0; i < scene.cloths[1]->m_nodes.size(); i++)
                scene.cloths[1]->m_nodes[i].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
        scene.world->stepSimulation(s_timeStep, 0);
        ck_assert_int_eq(scene.world->getStatistics().status, step < 5 ? qc_statusOk : qc_statusBadInput);
        ck_assert_ptr_eq(scene.world->getStatistics().notFinite, step < 5 ? nullptr : scene.cloths[1]);
        ck_assert(qcLowestNode(scene.cloths[0]) > 0);
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("not_finite");
    tcase_add_loop_test(tests, finite_bodies_move_as_without_one_that_is_not_a_number_until_it_is_mended, 0,
                        s_wayCount);
    tcase_add_loop_test(tests, finite_bodies_move_as_without_an_infinite_one, 0, s_lastWay);
    tcase_add_test(tests, settings_of_a_body_are_kept_while_it_is_not_finite);
    tcase_add_test(tests, a_world_may_have_no_finite_soft_body);
    tcase_add_test(tests, a_deformable_sheet_lies_beside_one_that_is_not_finite);
    return qcRunCase("not_finite", tests);
}
