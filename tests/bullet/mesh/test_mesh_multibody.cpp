// Links of multibodies (btMultiBody) and meshes: no link passes a mesh, with a mesh or a convex shape of its own.
#include "bullet/mesh/core_model.h"
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/motion_oracle.h"

#include "bullet/moving_links.h"
#include "bullet/random_numbers.h"
#include "support/long_form.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <limits>

namespace
{
const btVector3 s_along(1, 0, 0), s_up(0, 1, 0), s_away(0, 0, 1), s_nowhere(0, 0, 0), s_gravity(0, -10, 0);
const btQuaternion s_upright = btQuaternion::getIdentity();
// Bullet integrates joints with errors.
constexpr double s_drift = 1.01;
constexpr uint32_t s_fixed = 1000; ///< owner of what does not move, for the oracle

/// A shape of a link, 40 cm long, and what of it passes no mesh.
struct LinkShape
{
    std::unique_ptr<btCollisionShape> shape;
    qcModel model;
};

enum Kind
{
    kind_mesh,
    kind_capsule,
    kind_box,
    kind_kinds
};

const btVector3 s_half(btScalar(0.2), btScalar(0.06), btScalar(0.06));

LinkShape MakeLink(int kind)
{
    LinkShape link;
    switch (kind)
    {
        case kind_capsule:
            link.shape = std::make_unique<btCapsuleShapeX>(btScalar(0.08), btScalar(0.2));
            link.model = qcCoreModel(link.shape.get());
            break;
        case kind_box:
            link.shape = std::make_unique<btBoxShape>(s_half);
            link.model = qcCoreModel(link.shape.get());
            break;
        default: link.model = qcBoxModel(s_half, 2); link.shape = link.model.MakeShape();
    }
    return link;
}

/// A world of multibodies with contact of meshes.
struct LinkWorld
{
    qcMeshContact contact;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    qcMotionOracle oracle;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    std::vector<std::unique_ptr<qcMeshShape>> shapes;
    std::vector<std::unique_ptr<qcModel>> models;

    explicit LinkWorld(const btVector3& gravity, bool isPlain = false)
    {
        world.setGravity(gravity);
        if (!isPlain)
            contact.addTo(&world);
        contact.setThreadCount(1);
    }
    ~LinkWorld()
    {
        for (const auto& body : bodies)
            world.removeRigidBody(body.get());
    }
    LinkWorld(const LinkWorld&) = delete;
    LinkWorld& operator=(const LinkWorld&) = delete;

    btRigidBody* Add(const qcModel& model, btScalar mass, const btTransform& place, uint32_t owner = 0)
    {
        models.emplace_back(new qcModel(model));
        shapes.push_back(models.back()->MakeShape());
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shapes.back()->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes.back().get(), inertia);
        info.m_startWorldTransform = place;
        bodies.emplace_back(new btRigidBody(info));
        world.addRigidBody(bodies.back().get());
        oracle.Add(*models.back(), bodies.back().get(), owner);
        return bodies.back().get();
    }

    /// A wall of 2 cm at right angles to z.
    btRigidBody* AddWall(btScalar z, btScalar mass = 0)
    {
        return Add(qcBoxModel(btVector3(3, 3, btScalar(0.01)), 4), mass, btTransform(s_upright, btVector3(0, 0, z)),
                   mass > 0 ? 0 : s_fixed);
    }

    /// One step, in which nothing passes anything. Returns the number of limited objects.
    int StepApart()
    {
        world.stepSimulation(qcStep, 0);
        const qcMeshContactStatistics& statistics = contact.getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_eq(statistics.unproven, 0);
        ck_assert_uint_eq(oracle.Count(), 0);
        return statistics.limited;
    }
};

/// A chain of links along x, each joined to the end of the one before. The base is a link unless it is fixed.
class Chain
{
  public:
    /// `holdsFirst`: the first joint is fixed.
    Chain(LinkWorld& made, int kind, int links, bool hasFixedBase, const btVector3& at, uint32_t owner,
          bool holdsFirst = false)
        : m_made(made), m_body(links, 1, InertiaOf(1), hasFixedBase, false)
    {
        const btVector3 half = btScalar(0.21) * s_along;
        m_body.setBasePos(at);
        for (int link = 0; link < links; link++)
        {
            const btVector3 toJoint = link == 0 && hasFixedBase ? s_nowhere : half;
            if (link == 0 && holdsFirst)
                m_body.setupFixed(link, 1, InertiaOf(1), link - 1, s_upright, toJoint, half);
            else if (link % 3 == 2)
                m_body.setupSpherical(link, 1, InertiaOf(1), link - 1, s_upright, toJoint, half, true);
            else
                m_body.setupRevolute(link, 1, InertiaOf(1), link - 1, s_upright, link % 3 == 0 ? s_up : s_away, toJoint,
                                     half, true);
        }
        m_body.finalizeMultiDof();
        m_body.setHasSelfCollision(false);
        m_made.world.addMultiBody(&m_body);
        for (int link = hasFixedBase ? 0 : -1; link < links; link++)
            AddCollider(kind, link);
        qcPlaceColliders(m_body);
        for (const auto& part : m_parts)
            m_made.oracle.Add(part->link.model, &part->collider, owner);
    }
    ~Chain()
    {
        for (const auto& part : m_parts)
            m_made.world.removeCollisionObject(&part->collider);
        m_made.world.removeMultiBody(&m_body);
    }
    Chain(const Chain&) = delete;
    Chain& operator=(const Chain&) = delete;

    btMultiBody& Body()
    {
        return m_body;
    }

    btVector3 At(size_t i) const
    {
        return m_parts[i]->collider.getWorldTransform().getOrigin();
    }

    const btCollisionObject& Collider(size_t i) const
    {
        return m_parts[i]->collider;
    }

  private:
    struct Part
    {
        LinkShape link;
        btMultiBodyLinkCollider collider;

        Part(btMultiBody* body, int kind, int number) : link(MakeLink(kind)), collider(body, number)
        {
            collider.setCollisionShape(link.shape.get());
        }
    };

    static btVector3 InertiaOf(btScalar mass)
    {
        btBoxShape box(s_half);
        btVector3 inertia;
        box.calculateLocalInertia(mass, inertia);
        return inertia;
    }

    void AddCollider(int kind, int link)
    {
        m_parts.emplace_back(new Part(&m_body, kind, link));
        btMultiBodyLinkCollider* collider = &m_parts.back()->collider;
        if (link < 0)
            m_body.setBaseCollider(collider);
        else
            m_body.getLink(link).m_collider = collider;
        m_made.world.addCollisionObject(collider, 1, -1);
    }

    LinkWorld& m_made;
    btMultiBody m_body;
    std::vector<std::unique_ptr<Part>> m_parts;
};

START_TEST(chains_that_are_thrown_at_walls_pass_none)
{
    int limited = 0;
    for (unsigned start = 1; start <= (qcIsLongForm() ? 60u : 6u); start++)
        for (btScalar speed : {btScalar(10), btScalar(30), btScalar(80)})
        {
            qcRandomNumbers random(start);
            LinkWorld made(s_gravity);
            made.Add(qcFloorModel(12, 16), 0, btTransform(s_upright, btVector3(0, btScalar(-3.5), 0)), s_fixed);
            // Every other wall gives way.
            made.AddWall(-2, start % 2 == 0 ? btScalar(0) : btScalar(20));
            Chain chain(made, _i, int(random.Number(1, 5)), false, btVector3(-1, 0, 0) + random.Vector(0.3), 1);
            chain.Body().setBaseVel(-speed * s_away + random.Vector(1));
            chain.Body().setBaseOmega(random.Vector(5));
            for (int step = 0; step < 90; step++)
            {
                limited += made.StepApart();
                if (chain.Body().getNumLinks() > 2)
                {
                    const btScalar* turn = chain.Body().getJointPosMultiDof(2);
                    const btQuaternion rotation(turn[0], turn[1], turn[2], turn[3]);
                    ck_assert_double_eq_tol(double(rotation.length()), 1, 1e-4);
                }
            }
        }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(meshes_that_are_thrown_at_what_does_not_move_of_a_multibody_pass_none_of_it)
{
    const qcModel cube = qcBoxModel(btVector3(1, 1, 1) * btScalar(0.05), 1);
    int limited = 0;
    // A fixed base, or a link that is joined firmly to one.
    for (bool isBase : {true, false})
        for (unsigned start = 1; start <= 12; start++)
        {
            qcRandomNumbers random(start);
            LinkWorld made(s_nowhere);
            Chain chain(made, _i, isBase ? 0 : 1, !isBase, s_nowhere, 1, !isBase);
            chain.Body().setFixedBase(true);
            const btQuaternion turn(random.Vector(1).normalized(), random.Number(0, 3));
            btRigidBody* thrown = made.Add(cube, 1, btTransform(turn, chain.At(0) + 2 * s_away + random.Vector(0.1)));
            thrown->setLinearVelocity(-60 * s_away);
            for (int step = 0; step < 30; step++)
                limited += made.StepApart();
        }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(chains_do_not_stand_still_at_a_wall)
{
    for (unsigned start = 1; start <= 6; start++)
    {
        qcRandomNumbers random(start);
        LinkWorld made(s_gravity);
        made.AddWall(-2);
        Chain chain(made, _i, 3, false, btVector3(-1, 0, 0) + random.Vector(0.3), 1);
        chain.Body().setBaseVel(-10 * s_away + random.Vector(1));
        chain.Body().setBaseOmega(random.Vector(5));
        int standing = 0;
        for (int step = 0; step < 120; step++)
        {
            std::vector<btVector3> before;
            for (size_t i = 0; i < 4; i++)
                before.push_back(chain.At(i));
            made.StepApart();
            btScalar moved = 0;
            for (size_t i = 0; i < 4; i++)
                moved = std::max(moved, before[i].distance(chain.At(i)));
            // By less than a tenth of what the speed of its 4 kg would have it.
            const btScalar speed = btSqrt(qcEnergyOf(chain.Body(), s_nowhere) / 2);
            standing = speed > 1 && moved < speed * qcStep / 10 ? standing + 1 : 0;
            ck_assert_int_lt(standing, 12);
        }
    }
}
END_TEST

START_TEST(links_of_one_chain_are_not_limited_against_each_other)
{
    for (bool isFixed : {false, true})
    {
        LinkWorld made(s_nowhere);
        made.Add(qcFloorModel(4, 8), 0, btTransform(s_upright, btVector3(0, -50, 0)), s_fixed);
        Chain chain(made, _i, 3, false, s_nowhere, 1);
        chain.Body().setFixedBase(isFixed);
        chain.Body().setHasSelfCollision(true);
        chain.Body().setJointVel(0, 30);
        chain.Body().setJointVel(1, 30);
        for (int step = 0; step < 60; step++)
            ck_assert_int_eq(made.StepApart(), 0);
    }
}
END_TEST

/// An arm that lies along x, and turns about the vertical at its fixed base.
struct ArmWorld : LinkWorld
{
    Chain arm;

    ArmWorld(int kind, int links) : LinkWorld(s_nowhere), arm(*this, kind, links, true, s_nowhere, 1)
    {
    }
};

START_TEST(an_arm_that_strikes_a_wall_stops_and_gains_no_energy)
{
    int limited = 0;
    for (btScalar turn : {btScalar(3), btScalar(10), btScalar(40), btScalar(90)})
    {
        ArmWorld made(_i, 1);
        made.AddWall(btScalar(-0.3));
        made.arm.Body().setJointVel(0, turn);
        const double energy = double(qcEnergyOf(made.arm.Body(), s_nowhere));
        double furthest = 0;
        for (int step = 0; step < 120; step++)
        {
            limited += made.StepApart();
            ck_assert_double_le(double(qcEnergyOf(made.arm.Body(), s_nowhere)), energy);
            furthest = std::max(furthest, double(made.arm.Body().getJointPos(0)));
        }
        // It gets to the wall, and contact takes what it has not bounced off with.
        ck_assert_double_gt(furthest, 0.4);
        ck_assert_double_lt(furthest, 0.82);
        ck_assert_double_lt(double(qcEnergyOf(made.arm.Body(), s_nowhere)), 0.1 * energy);
    }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(an_arm_that_falls_onto_a_plate_comes_to_rest_on_it)
{
    LinkWorld made(s_gravity);
    made.Add(qcBoxModel(btVector3(2, btScalar(0.01), 2), 4), 0,
             btTransform(s_upright, btVector3(0, btScalar(-0.25), 0)), s_fixed);
    Chain arm(made, _i, 2, true, s_nowhere, 1);
    // The second joint turns about z: its link falls, and strikes the plate.
    arm.Body().setJointVel(1, -20);
    const double energy = double(qcEnergyOf(arm.Body(), s_gravity));
    for (int step = 0; step < 600; step++)
    {
        made.StepApart();
        ck_assert_double_le(double(qcEnergyOf(arm.Body(), s_gravity)), energy * s_drift);
    }
    ck_assert_double_lt(double(arm.Body().getJointPos(1)), -0.4);
    ck_assert_double_lt(double(btFabs(arm.Body().getJointVel(1))), 1.5); // Bullet's contact makes it tremble
}
END_TEST

START_TEST(a_driven_arm_that_presses_a_mesh_on_a_wall_passes_neither)
{
    for (btScalar turn : {btScalar(2), btScalar(15), btScalar(60)})
    {
        ArmWorld made(_i, 2);
        made.AddWall(btScalar(-0.7));
        btRigidBody* ball =
            made.Add(qcSphereModel(0.15, 2), 1, btTransform(s_upright, btVector3(btScalar(0.5), 0, btScalar(-0.4))));
        ball->setActivationState(DISABLE_DEACTIVATION);
        btMultiBodyJointMotor motor(&made.arm.Body(), 0, turn, 100);
        motor.finalizeMultiDof();
        made.world.addMultiBodyConstraint(&motor);
        for (int step = 0; step < 180; step++)
            made.StepApart();
        ck_assert_double_gt(double(made.arm.Body().getJointPos(0)), 0.2);
        made.world.removeMultiBodyConstraint(&motor);
    }
}
END_TEST

/// A motor presses a link on a plate for 400 steps. Nothing penetrates after `first` of them.
void PressPlate(int kind, btScalar speed, int first)
{
    LinkWorld made(s_nowhere);
    const LinkShape head = MakeLink(kind);
    btMultiBody press(1, 1, btVector3(1, 1, 1), true, false);
    press.setBasePos(s_up);
    press.setupPrismatic(0, 1, btVector3(1, 1, 1) / 100, -1, s_upright, -s_up, btScalar(-0.3) * s_up, s_nowhere, true);
    press.finalizeMultiDof();
    btMultiBodyLinkCollider collider(&press, 0);
    collider.setCollisionShape(head.shape.get());
    press.getLink(0).m_collider = &collider;
    made.world.addCollisionObject(&collider, 1, -1);
    made.world.addMultiBody(&press);
    qcPlaceColliders(press);
    made.oracle.Add(head.model, &collider, 1);
    // The plate lies on two blocks.
    const btVector3 half(1, btScalar(0.01), 1);
    btRigidBody* plate = made.Add(qcBoxModel(half, 6), 5, btTransform::getIdentity());
    for (int side = -1; side <= 1; side += 2)
        made.Add(qcBoxModel(btVector3(btScalar(0.2), btScalar(0.5), btScalar(0.2)), 2), 0,
                 btTransform(s_upright, btVector3(btScalar(0.8 * side), btScalar(-0.54), 0)), s_fixed);
    btMultiBodyJointMotor motor(&press, 0, speed, 1000);
    motor.finalizeMultiDof();
    made.world.addMultiBodyConstraint(&motor);
    for (int step = 0; step < 400; step++)
    {
        if (step == first)
            made.oracle.CountNow();
        if (step >= first)
            made.StepApart();
        else
            made.world.stepSimulation(qcStep, 0);
    }
    const btVector3 place = plate->getWorldTransform().invXform(collider.getWorldTransform().getOrigin());
    ck_assert_double_gt(double(place.y()), 0);
    made.world.removeMultiBodyConstraint(&motor);
    made.world.removeMultiBody(&press);
    made.world.removeCollisionObject(&collider);
}

START_TEST(a_press_drives_no_link_through_a_plate)
{
    for (btScalar speed : {btScalar(0.3), btScalar(1), btScalar(3)})
        PressPlate(_i, speed, 0);
}
END_TEST

/// Bullet's contact of a box or a capsule that lies flat on a mesh lacks all points in some step of a hundred.
START_TEST(a_link_that_is_pressed_on_a_plate_stays_out_where_bullets_contact_is_lost)
{
    // The first touch may be deep: the link is slow, and contact pushes it back.
    for (btScalar speed = btScalar(0.3); speed < 3; speed *= btScalar(qcIsLongForm() ? 1.03 : 1.1))
        PressPlate(_i, speed, 100);
}
END_TEST

START_TEST(chains_that_are_thrown_at_each_other_pass_nothing)
{
    int limited = 0;
    for (unsigned start = 1; start <= (qcIsLongForm() ? 40u : 4u); start++)
    {
        qcRandomNumbers random(start);
        LinkWorld made(s_nowhere);
        const btVector3 left(-1, 0, 1), right(-1, 0, -1);
        Chain a(made, kind_mesh, 2, false, left + random.Vector(0.2), 1),
            b(made, _i, 1, false, right + random.Vector(0.2), 2);
        btRigidBody* between = made.Add(qcSphereModel(0.2, 2), 1, btTransform(s_upright, btVector3(-1, 0, 0)));
        between->setLinearVelocity(random.Vector(3));
        const btScalar speed = random.Number(5, 60);
        a.Body().setBaseVel(-speed * s_away);
        b.Body().setBaseVel(speed * s_away);
        for (int step = 0; step < 60; step++)
            limited += made.StepApart();
    }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(a_link_slides_along_a_wall_that_it_meets_at_an_angle)
{
    LinkWorld made(s_nowhere);
    made.AddWall(-1);
    Chain chain(made, _i, 0, false, btVector3(-2, 0, 0), 1);
    chain.Body().setLinearDamping(0);
    chain.Body().setAngularDamping(0);
    chain.Body().setBaseVel(btVector3(20, 0, -20));
    const_cast<btCollisionObject&>(chain.Collider(0)).setFriction(0);
    for (int step = 0; step < 15; step++)
        made.StepApart();
    // A quarter of a second at 20 m/s, less the steps until contact has turned it.
    ck_assert_double_gt(double(chain.Collider(0).getWorldTransform().getOrigin().x()), -2 + 5 - 0.9);
}
END_TEST

enum LinkExemption
{
    link_none,
    link_trigger,
    link_filter,
    link_ignored,
    link_placed, ///< the application puts it on the other side
    link_kinds
};

START_TEST(a_link_passes_only_what_it_does_not_collide_with)
{
    for (int kind = 0; kind < kind_kinds; kind++)
    {
        LinkWorld made(s_nowhere);
        btRigidBody* wall = made.AddWall(-1);
        Chain chain(made, kind, 0, false, s_nowhere, 1);
        auto& collider = const_cast<btCollisionObject&>(chain.Collider(0));
        if (_i == link_trigger)
            collider.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
        if (_i == link_ignored)
            wall->setIgnoreCollisionCheck(&collider, true); // links ignore their own list, in Bullet
        if (_i == link_filter)
        {
            made.world.removeCollisionObject(&collider);
            made.world.addCollisionObject(&collider, 2, 2);
        }
        chain.Body().setBaseVel(-30 * s_away);
        int limited = 0;
        for (int step = 0; step < 30; step++)
        {
            if (_i == link_placed && step == 1)
            {
                chain.Body().setBasePos(-3 * s_away);
                qcPlaceColliders(chain.Body());
            }
            made.world.stepSimulation(qcStep, 0);
            limited += made.contact.getStatistics().limited;
        }
        const double z = double(collider.getWorldTransform().getOrigin().z());
        if (_i == link_none)
            ck_assert_double_gt(z, -1);
        else
        {
            ck_assert_double_lt(z, -5);
            ck_assert_int_eq(limited, 0);
        }
    }
}
END_TEST

START_TEST(an_arm_on_a_base_that_the_application_moves_passes_no_wall)
{
    for (btScalar speed : {btScalar(2), btScalar(7)})
    {
        ArmWorld made(_i, 2);
        made.AddWall(btScalar(-0.3));
        made.arm.Body().setJointVel(0, 15);
        int limited = 0;
        for (int step = 0; step < 20; step++)
        {
            made.arm.Body().setBasePos(speed * qcStep * btScalar(step) * s_along);
            limited += made.StepApart();
        }
        ck_assert_int_gt(limited, 0);
    }
    // Driven through the wall it leaves no room, which is counted.
    for (btScalar turn : {btScalar(0), btScalar(2)})
    {
        ArmWorld made(_i, 2);
        made.AddWall(btScalar(-0.3));
        made.arm.Body().setJointVel(0, turn);
        int unproven = 0;
        for (int step = 0; step < 8; step++)
        {
            made.arm.Body().setBasePos(btScalar(-7) * qcStep * btScalar(step) * s_away);
            made.world.stepSimulation(qcStep, 0);
            unproven += made.contact.getStatistics().unproven;
        }
        ck_assert_int_gt(unproven, 0);
    }
    // Put elsewhere, where no wall is, its arm turns on.
    ArmWorld made(_i, 2);
    made.AddWall(btScalar(-0.3));
    made.arm.Body().setJointVel(0, 15);
    for (int step = 0; step < 20; step++)
    {
        made.arm.Body().setBasePos(btScalar(5 * step) * s_along);
        made.world.stepSimulation(qcStep, 0);
        ck_assert_int_eq(made.contact.getStatistics().limited, 0);
    }
    ck_assert_double_gt(double(made.arm.Body().getJointPos(0)), 4);
}
END_TEST

/// Has the application move an object from now on.
void MakeKinematic(btRigidBody* body)
{
    body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
}

/// Moves an object as applications do, so that Bullet sees its velocity.
void Drive(btRigidBody* body, const btVector3& by)
{
    btTransform place = body->getWorldTransform();
    place.getOrigin() += by;
    body->setWorldTransform(place);
}

START_TEST(a_wall_that_the_application_moves_takes_chains_at_rest_along)
{
    for (unsigned start = 1; start <= (qcIsLongForm() ? 200u : 4u); start++)
        for (btScalar speed : {btScalar(3), btScalar(10), btScalar(30), btScalar(60)})
        {
            qcRandomNumbers random(start);
            LinkWorld made(s_nowhere);
            btRigidBody* wall = made.AddWall(btScalar(0.5) + random.Number(0, speed * qcStep));
            MakeKinematic(wall);
            Chain chain(made, _i, int(random.Number(0, 3)), false, btVector3(-1, 0, 0) + random.Vector(0.2), 1);
            // Every other chain sleeps.
            chain.Body().setCanSleep(start % 2 == 0);
            for (int step = 0; step < (start % 2 == 0 ? 200 : 1); step++)
                made.StepApart();
            ck_assert(chain.Collider(0).isActive() == (start % 2 != 0));
            const int steps = int(btScalar(3) / (speed * qcStep));
            for (int step = 0; step < steps; step++)
            {
                Drive(wall, -speed * qcStep * s_away);
                made.StepApart();
            }
            for (size_t i = 0; i < size_t(chain.Body().getNumLinks()) + 1; i++)
                ck_assert_double_lt(double(chain.At(i).z()), double(wall->getWorldTransform().getOrigin().z()));
            // It has the energy of the wall's speed, or moves within itself, too.
            const double energy = double(qcEnergyOf(chain.Body(), s_nowhere));
            ck_assert_double_gt(energy, 0.3 * double(speed * speed));
        }
}
END_TEST

START_TEST(a_block_that_the_application_moves_turns_an_arm_at_rest)
{
    for (btScalar speed : {btScalar(3), btScalar(10), btScalar(30)})
    {
        ArmWorld made(_i, 1);
        btRigidBody* block = made.Add(qcBoxModel(btVector3(1, 1, 1) * btScalar(0.1), 2), 0,
                                      btTransform(s_upright, btVector3(btScalar(0.3), 0, btScalar(0.4))), s_fixed);
        MakeKinematic(block);
        made.StepApart();
        for (int step = 0; step < int(btScalar(0.8) / (speed * qcStep)); step++)
        {
            Drive(block, -speed * qcStep * s_away);
            made.StepApart();
        }
        ck_assert_double_gt(double(made.arm.Body().getJointPos(0)), 0.3);
    }
}
END_TEST

START_TEST(an_arm_turns_on_while_what_does_not_move_of_it_is_struck)
{
    btScalar turned[2];
    for (int isStruck = 0; isStruck < 2; isStruck++)
    {
        LinkWorld made(s_nowhere);
        Chain arm(made, kind_mesh, 2, true, s_nowhere, 1, true);
        Chain thrown(made, kind_mesh, 0, false, btVector3(btScalar(0.1), 0, isStruck ? btScalar(0.5) : btScalar(40)),
                     2);
        arm.Body().setJointVel(1, 3);
        thrown.Body().setBaseVel(-60 * s_away);
        int limited = 0;
        for (int step = 0; step < 8; step++)
            limited += made.StepApart();
        ck_assert((limited > 0) == (isStruck != 0));
        turned[isStruck] = arm.Body().getJointPos(1);
    }
    ck_assert_double_eq_tol(double(turned[0]), double(turned[1]), 1e-3);
}
END_TEST

START_TEST(a_multibody_that_was_not_finite_is_limited_again)
{
    LinkWorld made(s_nowhere);
    made.AddWall(-1);
    Chain chain(made, _i, 2, false, s_nowhere, 1);
    for (int step = 0; step < 12; step++)
    {
        const bool breaks = step == 2, mends = step == 4;
        if (breaks || mends)
        {
            for (int link = 0; link < 2; link++)
            {
                chain.Body().setJointPos(link, breaks ? std::numeric_limits<btScalar>::quiet_NaN() : btScalar(0));
                chain.Body().setJointVel(link, 0);
            }
            chain.Body().setBasePos(s_nowhere);
            chain.Body().setWorldToBaseRot(s_upright);
            chain.Body().setBaseOmega(s_nowhere);
            chain.Body().setBaseVel(mends ? -100 * s_away : s_nowhere);
            qcPlaceColliders(chain.Body());
        }
        made.world.stepSimulation(qcStep, 0);
        ck_assert(made.contact.getStatistics().status == qc_statusOk || (step >= 2 && step < 4));
        if (step >= 4)
            ck_assert_double_gt(double(chain.At(0).z()), -1);
    }
}
END_TEST

void MoveOrigin(btCollisionObject* object, const btVector3& shift)
{
    btTransform place = object->getWorldTransform();
    place.getOrigin() += shift;
    object->setWorldTransform(place);
    object->setInterpolationWorldTransform(place);
}

START_TEST(a_new_origin_of_a_world_of_multibodies_moves_nothing_in_it)
{
    // Inside of a closed room, which moves by less than half of its size. A free chain alone, then an arm on a fixed
    // base and a rigid body, so near to walls that these would pass them.
    for (bool isArm : {false, true})
    {
        LinkWorld made(s_nowhere);
        btRigidBody* room = made.Add(qcBoxModel(btVector3(5, 5, 5), 8), 0, btTransform(s_upright, s_nowhere), s_fixed);
        btRigidBody* ball =
            isArm ? made.Add(qcSphereModel(0.1, 1), 1, btTransform(s_upright, btScalar(4.88) * s_away)) : nullptr;
        Chain chain(made, kind_mesh, 2, isArm, isArm ? btScalar(-4.9) * s_away : s_nowhere, 1);
        chain.Body().setLinearDamping(0);
        chain.Body().setAngularDamping(0);
        if (isArm)
            chain.Body().setJointVel(0, -3);
        else
            chain.Body().setBaseVel(s_away);
        btScalar turned = 0;
        for (int step = 0; step < 8; step++)
        {
            const btVector3 shift = step == 3 ? (isArm ? btScalar(0.3) : btScalar(6)) * s_away : s_nowhere;
            MoveOrigin(room, shift);
            if (ball != nullptr)
            {
                ball->activate();
                MoveOrigin(ball, shift);
            }
            chain.Body().setBasePos(chain.Body().getBasePos() + shift);
            qcPlaceColliders(chain.Body());
            const btScalar before = chain.At(0).z();
            made.world.stepSimulation(qcStep, 0);
            ck_assert_int_eq(made.contact.getStatistics().limited, 0);
            ck_assert_int_eq(made.contact.getStatistics().unproven, 0);
            if (!isArm)
                ck_assert_double_eq_tol(double(chain.At(0).z() - before), double(qcStep), 1e-4);
            ck_assert(!isArm || chain.Body().getJointPos(0) < turned - btScalar(0.02));
            turned = isArm ? chain.Body().getJointPos(0) : btScalar(0);
        }
    }
}
END_TEST

START_TEST(a_multibody_that_the_world_does_not_step_goes_where_it_is_put)
{
    LinkWorld made(s_nowhere);
    made.AddWall(btScalar(-0.3));
    Chain chain(made, _i, 0, false, s_nowhere, 1);
    made.world.removeMultiBody(&chain.Body());
    for (int step = 1; step < 60; step++)
    {
        const btVector3 at = btScalar(-0.01) * btScalar(step) * s_away;
        chain.Body().setBasePos(at);
        qcPlaceColliders(chain.Body());
        made.world.stepSimulation(qcStep, 0);
        ck_assert(chain.Body().getBasePos() == at);
        ck_assert_int_eq(made.contact.getStatistics().limited, 0);
    }
    made.world.addMultiBody(&chain.Body());
}
END_TEST

START_TEST(a_chain_that_meets_nothing_moves_as_in_plain_bullet)
{
    LinkWorld made(s_gravity), plain(s_gravity, true);
    made.Add(qcFloorModel(4, 8), 0, btTransform(s_upright, btVector3(0, -50, 0)), s_fixed);
    Chain chain(made, _i, 4, false, s_nowhere, 1), same(plain, _i, 4, false, s_nowhere, 1);
    for (Chain* one : {&chain, &same})
    {
        one->Body().setBaseOmega(btVector3(1, 2, 3));
        one->Body().setJointVel(0, 5);
    }
    for (int step = 0; step < 120; step++)
    {
        made.StepApart();
        plain.world.stepSimulation(qcStep, 0);
        // To the bit.
        for (size_t i = 0; i < 5; i++)
            ck_assert(chain.Collider(i).getWorldTransform() == same.Collider(i).getWorldTransform());
    }
}
END_TEST

START_TEST(slow_links_are_left_to_bullet)
{
    LinkWorld made(s_gravity);
    made.Add(qcFloorModel(4, 8), 0, btTransform(s_upright, s_nowhere), s_fixed);
    Chain chain(made, _i, 2, false, btVector3(-1, btScalar(0.1), 0), 1);
    for (int step = 0; step < 120; step++)
        ck_assert_int_eq(made.StepApart(), 0);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_multibody");
    tcase_add_loop_test(tests, chains_that_are_thrown_at_walls_pass_none, 0, kind_kinds);
    tcase_add_loop_test(tests, chains_do_not_stand_still_at_a_wall, 0, kind_kinds);
    tcase_add_loop_test(tests, links_of_one_chain_are_not_limited_against_each_other, 0, kind_kinds);
    tcase_add_loop_test(tests, an_arm_that_strikes_a_wall_stops_and_gains_no_energy, 0, kind_kinds);
    tcase_add_loop_test(tests, an_arm_that_falls_onto_a_plate_comes_to_rest_on_it, 0, kind_kinds);
    tcase_add_loop_test(tests, a_driven_arm_that_presses_a_mesh_on_a_wall_passes_neither, 0, kind_kinds);
    tcase_add_loop_test(tests, a_press_drives_no_link_through_a_plate, 0, kind_kinds);
    tcase_add_loop_test(tests, a_link_that_is_pressed_on_a_plate_stays_out_where_bullets_contact_is_lost, 0,
                        kind_kinds);
    tcase_add_loop_test(tests, chains_that_are_thrown_at_each_other_pass_nothing, 0, kind_kinds);
    tcase_add_loop_test(tests, a_link_slides_along_a_wall_that_it_meets_at_an_angle, 0, kind_kinds);
    tcase_add_loop_test(tests, meshes_that_are_thrown_at_what_does_not_move_of_a_multibody_pass_none_of_it, 0,
                        kind_kinds);
    tcase_add_loop_test(tests, a_link_passes_only_what_it_does_not_collide_with, 0, link_kinds);
    tcase_add_loop_test(tests, an_arm_on_a_base_that_the_application_moves_passes_no_wall, 0, kind_kinds);
    tcase_add_loop_test(tests, a_wall_that_the_application_moves_takes_chains_at_rest_along, 0, kind_kinds);
    tcase_add_loop_test(tests, a_block_that_the_application_moves_turns_an_arm_at_rest, 0, kind_kinds);
    tcase_add_test(tests, an_arm_turns_on_while_what_does_not_move_of_it_is_struck);
    tcase_add_loop_test(tests, a_multibody_that_was_not_finite_is_limited_again, 0, kind_kinds);
    tcase_add_test(tests, a_new_origin_of_a_world_of_multibodies_moves_nothing_in_it);
    tcase_add_loop_test(tests, a_multibody_that_the_world_does_not_step_goes_where_it_is_put, 0, kind_kinds);
    tcase_add_loop_test(tests, a_chain_that_meets_nothing_moves_as_in_plain_bullet, 0, kind_kinds);
    tcase_add_loop_test(tests, slow_links_are_left_to_bullet, 0, kind_kinds);
    return qcRunCase("mesh_multibody", tests);
}
