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

namespace
{
const btVector3 s_along(1, 0, 0), s_up(0, 1, 0), s_away(0, 0, 1), s_nowhere(0, 0, 0);
const btQuaternion s_upright = btQuaternion::getIdentity();
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

    explicit LinkWorld(const btVector3& gravity)
    {
        world.setGravity(gravity);
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
    Chain(LinkWorld& made, int kind, int links, bool hasFixedBase, const btVector3& at, uint32_t owner)
        : m_made(made), m_body(links, 1, InertiaOf(1), hasFixedBase, false)
    {
        const btVector3 half = btScalar(0.21) * s_along;
        m_body.setBasePos(at);
        for (int link = 0; link < links; link++)
        {
            const btVector3 toJoint = link == 0 && hasFixedBase ? s_nowhere : half;
            if (link % 3 == 2)
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
        Place();
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

    void Place()
    {
        btAlignedObjectArray<btQuaternion> rotations;
        btAlignedObjectArray<btVector3> origins;
        m_body.forwardKinematics(rotations, origins);
        m_body.updateCollisionObjectWorldTransforms(rotations, origins);
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
            const btVector3 gravity(0, -10, 0);
            LinkWorld made(gravity);
            made.Add(qcFloorModel(12, 16), 0, btTransform(s_upright, btVector3(0, btScalar(-3.5), 0)), s_fixed);
            // Every other wall gives way.
            made.AddWall(-2, start % 2 == 0 ? btScalar(0) : btScalar(20));
            Chain chain(made, _i, int(random.Number(1, 5)), false, btVector3(-1, 0, 0) + random.Vector(0.3), 1);
            chain.Body().setBaseVel(-speed * s_away + random.Vector(1));
            chain.Body().setBaseOmega(random.Vector(5));
            int ofStart = 0;
            for (int step = 0; step < 90; step++)
                ofStart += made.StepApart();
            limited += ofStart;
            printf("kind %d, start %u at %.0f m/s: %d limited\n", _i, start, double(speed), ofStart);
        }
    ck_assert_int_gt(limited, 0);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    Suite* suite = suite_create("mesh_multibody");
    TCase* tests = tcase_create("mesh_multibody");
    tcase_set_timeout(tests, 300); // a bound against hanging, not a claim about speed
    tcase_add_loop_test(tests, chains_that_are_thrown_at_walls_pass_none, 0, kind_kinds);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
