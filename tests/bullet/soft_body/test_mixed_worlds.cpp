// Worlds of everything at once, in random motion: whatever meets within a step is counted.
#include "bullet/soft_body/multibody_world.h"

#include "bullet/mesh/moved_mesh.h"
#include "bullet/random_numbers.h"
#include "bullet/soft_body/meeting_oracle.h"
#include "support/long_form.h"

#include <list>

namespace
{
const btVector3 s_fall(0, -10, 0), s_linkHalf(btScalar(0.2), btScalar(0.06), btScalar(0.06));
// A slow convex shape may enter a mesh, until contact pushes it out; one that lies in a mesh further than this at the
// start of a step may pass it. As parts of its size.
constexpr double s_inner = 0.4, s_outer = 0.9;
constexpr int s_steps = 120;

/// A shape with its triangles: those of a qcMeshShape, or a smaller and a larger copy of a convex one.
struct Form
{
    std::string name;
    bool isConvex;
    qcModel inner, outer;
    std::vector<std::unique_ptr<btCollisionShape>> shapes; ///< the last one has the others as children

    btCollisionShape* Shape() const
    {
        return shapes.back().get();
    }
};

/// An object that the application moves to and fro.
struct Driven
{
    btRigidBody* body;
    btTransform place;
    btVector3 way, axis;
    btScalar speed, spin, phase = 0, turned = 0;
};

class MixedWorld
{
  public:
    MixedWorld(bool isDeformable, unsigned start)
        : m_random(start), m_made(qcMakeMultiBodyWorld(isDeformable, s_fall)), m_world(m_made->World())
    {
        m_meshContact.addTo(&m_world);
        m_meshContact.setThreadCount(1);
        AddGround();
        for (int i = Below(3); i > 0; i--)
            AddDriven();
        if (IsOneOf(2))
            AddBody(*RandomConvex(1.5), 0, Turned(Beside(0.3)));
        for (int i = 1 + Below(5); i > 0; i--)
            AddThrown(*RandomMesh(1));
        for (int i = Below(4); i > 0; i--)
            AddThrown(*RandomConvex(1));
        if (IsOneOf(2))
            AddThrown(*MakeCompound(false));
        if (IsOneOf(3))
            AddThrown(*MakeCompound(true));
        if (IsOneOf(2))
            AddChain();
        if (IsOneOf(3))
            AddHinge();
        for (int i = Below(3); i > 0; i--)
            AddCloth();
        // Where Bullet's continuous collision stops a convex shape in the first step of a world is not known.
        m_world.stepSimulation(m_made->TimeStep(), 0);
        for (btRigidBody* body : m_thrown)
            if (IsOneOf(2))
                Throw(body, 40);
    }
    ~MixedWorld()
    {
        if (m_hinge != nullptr)
            m_world.removeConstraint(m_hinge.get());
        for (const auto& link : m_links)
            m_world.removeCollisionObject(link.get());
        if (m_chain != nullptr)
            m_world.removeMultiBody(m_chain.get());
        for (const auto& body : m_bodies)
            m_world.removeRigidBody(body.get());
    }
    MixedWorld(const MixedWorld&) = delete;
    MixedWorld& operator=(const MixedWorld&) = delete;

    /// Returns the objects that meet in the step and are not counted.
    std::vector<std::string> Step(int number)
    {
        if (IsOneOf(25))
            Throw(m_thrown[size_t(Below(int(m_thrown.size())))], 60);
        if (IsOneOf(60))
            for (btSoftBody* cloth : m_cloths)
            {
                cloth->activate();
                cloth->addVelocity(m_random.Vector(15));
            }
        if (IsOneOf(60) && m_chain != nullptr)
            KickChain();
        if (IsOneOf(80) && m_thrown.size() > 1 && m_hinge == nullptr)
            RemoveThrown();
        if (IsOneOf(80))
        {
            AddThrown(*RandomMesh(1));
            Throw(m_thrown.back(), 40);
        }
        if (IsOneOf(200))
            m_world.setGravity(m_random.Vector(15));
        m_oracle.Begin();
        const btScalar timeStep = m_made->TimeStep() * (IsOneOf(5) ? m_random.Number(0.3, 3) : btScalar(1));
        // Where it is first is where the application has put it.
        if (number > 0)
            Drive(timeStep);
        if (m_wave != nullptr && number > 20 && number % 2 == 0)
            MoveGround(number);
        m_world.stepSimulation(timeStep, 0);
        const qcSoftBodyStatistics& soft = m_made->Contact().getStatistics();
        const qcMeshContactStatistics& meshes = m_meshContact.getStatistics();
        ck_assert_int_eq(soft.status, qc_statusOk);
        ck_assert_int_eq(meshes.status, qc_statusOk);
        const std::vector<std::string> met = m_oracle.End();
        return soft.unproven + soft.exempt + meshes.unproven == 0 ? met : std::vector<std::string>();
    }

  private:
    int Below(int count)
    {
        return std::min(int(m_random.Number(0, count)), count - 1);
    }
    /// True once in this many calls.
    bool IsOneOf(int count)
    {
        return Below(count) == 0;
    }
    btVector3 Direction()
    {
        return (m_random.Vector(1) + btVector3(0, btScalar(1e-3), 0)).normalized();
    }
    btTransform Turned(const btVector3& at)
    {
        return btTransform(btQuaternion(Direction(), m_random.Number(0, 6)), at);
    }
    btVector3 Beside(double height)
    {
        return btVector3(m_random.Number(-1, 1), btScalar(height), m_random.Number(-1, 1));
    }
    /// A place above all others.
    btVector3 Above()
    {
        m_height += 0.35;
        return Beside(m_height);
    }

    Form* RandomMesh(double size)
    {
        m_forms.emplace_back();
        Form& form = m_forms.back();
        form.name = "mesh";
        form.isConvex = false;
        const btScalar large = m_random.Number(0.05 * size, 0.4 * size),
                       small = m_random.Number(0.01 * size, 0.3 * size);
        switch (Below(4))
        {
            case 0: form.inner = qcBoxModel(btVector3(large, small, large), 1 + Below(4)); break;
            case 1: form.inner = qcTorusModel(0.25 * size, 0.08 * size, 12, 6); break;
            case 2: form.inner = qcSphereModel(0.2 * size, 1 + Below(2)); break;
            default:
                form.inner = qcBoxModel(btScalar(size) * btVector3(btScalar(0.3), btScalar(0.05), btScalar(0.1)), 2);
        }
        form.outer = form.inner;
        form.shapes.push_back(form.inner.MakeShape());
        return &form;
    }
    Form* RandomConvex(double size)
    {
        m_forms.emplace_back();
        Form& form = m_forms.back();
        form.name = "convex shape";
        form.isConvex = true;
        if (IsOneOf(2))
        {
            const double radius = double(m_random.Number(0.05 * size, 0.3 * size));
            form.inner = qcSphereModel(s_inner * radius, 2);
            form.outer = qcSphereModel(s_outer * radius, 2);
            form.shapes.push_back(std::make_unique<btSphereShape>(btScalar(radius)));
            return &form;
        }
        const btVector3 half(m_random.Number(0.05 * size, 0.4 * size), m_random.Number(0.03 * size, 0.3 * size),
                             m_random.Number(0.05 * size, 0.3 * size));
        form.inner = qcBoxModel(btScalar(s_inner) * half, 2);
        form.outer = qcBoxModel(btScalar(s_outer) * half, 2);
        form.shapes.push_back(std::make_unique<btBoxShape>(half));
        return &form;
    }
    /// A compound of meshes or of convex shapes.
    Form* MakeCompound(bool ofMeshes)
    {
        m_forms.emplace_back();
        Form& form = m_forms.back();
        form.name = ofMeshes ? "compound of meshes" : "compound of convex shapes";
        form.isConvex = !ofMeshes;
        auto compound = std::make_unique<btCompoundShape>();
        for (int i = 2 + Below(2); i > 0; i--)
        {
            Form& child = *(ofMeshes ? RandomMesh(0.8) : RandomConvex(0.8));
            const btTransform place = Turned(m_random.Vector(0.25));
            compound->addChildShape(place, child.Shape());
            for (const auto& [from, to] : {std::make_pair(&child.inner, &form.inner), {&child.outer, &form.outer}})
            {
                qcModel moved = *from;
                moved.Move(place);
                to->Append(moved);
            }
        }
        form.shapes.push_back(std::move(compound));
        return &form;
    }

    void Follow(const Form& form, const btCollisionObject* object, bool moves, const void* owner = nullptr)
    {
        auto placed = [object](const qcModel& model)
        { return [&model, object] { return qcWorldMeshOf(model, object->getWorldTransform()); }; };
        m_oracle.Add({form.name, object, owner, moves, form.isConvex, placed(form.inner), placed(form.outer)});
    }
    btRigidBody* AddBody(const Form& form, btScalar mass, const btTransform& place)
    {
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            form.Shape()->calculateLocalInertia(mass, inertia);
        m_bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, form.Shape(), inertia));
        btRigidBody* body = m_bodies.back().get();
        body->setWorldTransform(place);
        body->setInterpolationWorldTransform(place);
        m_world.addRigidBody(body);
        Follow(form, body, mass > 0);
        return body;
    }
    void Throw(btRigidBody* body, double speed)
    {
        body->activate();
        body->setLinearVelocity(m_random.Vector(IsOneOf(2) ? speed : speed / 10));
        body->setAngularVelocity(m_random.Vector(IsOneOf(2) ? speed : speed / 10));
    }
    void AddThrown(const Form& form)
    {
        btRigidBody* body = AddBody(form, m_random.Number(0.2, 5), Turned(Above()));
        body->setRestitution(m_random.Number(0, 1));
        body->setFriction(m_random.Number(0, 1));
        if (IsOneOf(4))
        {
            body->setCcdMotionThreshold(btScalar(0.05));
            body->setCcdSweptSphereRadius(btScalar(0.01));
        }
        m_thrown.push_back(body);
    }
    void RemoveThrown()
    {
        const size_t index = size_t(Below(int(m_thrown.size())));
        btRigidBody* removed = m_thrown[index];
        m_thrown.erase(m_thrown.begin() + std::ptrdiff_t(index));
        m_oracle.Remove(removed);
        m_world.removeRigidBody(removed);
        m_bodies.remove_if([removed](const std::unique_ptr<btRigidBody>& body) { return body.get() == removed; });
    }

    /// Hills, whose triangles the application may move.
    void AddGround()
    {
        m_forms.emplace_back();
        Form& form = m_forms.back();
        form.name = "ground";
        form.isConvex = false;
        form.inner = qcFloorModel(3, 6 + Below(14));
        const double height = double(m_random.Number(0, 0.3));
        for (size_t i = 0; i < form.inner.positions.size(); i += 3)
            form.inner.positions[i + 1] += btScalar(height * std::sin(2.3 * double(form.inner.positions[i]) + 1) *
                                                    std::cos(1.7 * double(form.inner.positions[i + 2])));
        form.outer = form.inner;
        form.shapes.push_back(form.inner.MakeShape());
        m_ground = AddBody(form, 0, btTransform::getIdentity());
        if (!IsOneOf(4))
            return;
        m_oracle.Remove(m_ground);
        m_wave = std::make_unique<qcMovedMesh>(form.inner, false);
        m_ground->setCollisionShape(m_wave->shape.get());
        auto now = [this] { return qcWorldMeshOf(m_wave->model, btTransform::getIdentity()); };
        m_oracle.Add({"ground that moves", m_ground, nullptr, false, false, now, now});
    }
    void MoveGround(int step)
    {
        struct
        {
            MixedWorld& made;
            void updateShape(const btCollisionShape* shape) const
            {
                made.m_meshContact.updateShape(shape);
                made.m_made->Contact().updateShape(shape);
            }
        } contacts{*this};
        auto wave = [](const btVector3& start, int at)
        {
            const btScalar part = std::min(btScalar(at - 20) / 20, btScalar(1));
            return start +
                   btVector3(0, btScalar(0.15) * part * btSin(2 * start.x() + btScalar(0.35) * btScalar(at)), 0);
        };
        m_wave->Move(wave, step, m_ground, &m_world, &contacts);
    }

    void AddDriven()
    {
        Driven driven;
        driven.place = Turned(Beside(double(m_random.Number(0.3, 1.2))));
        driven.body = AddBody(IsOneOf(2) ? *RandomMesh(1.5) : *RandomConvex(1.5), 0, driven.place);
        driven.body->setCollisionFlags(driven.body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        driven.body->setActivationState(DISABLE_DEACTIVATION);
        driven.way = m_random.Vector(IsOneOf(3) ? 1.5 : 0.5);
        driven.axis = Direction();
        driven.speed = m_random.Number(0.5, 8);
        driven.spin = IsOneOf(2) ? m_random.Number(0, 10) : btScalar(0);
        m_driven.push_back(driven);
    }
    void Drive(btScalar timeStep)
    {
        for (Driven& driven : m_driven)
        {
            driven.phase += timeStep * driven.speed;
            driven.turned += timeStep * driven.spin;
            const btTransform moved(btQuaternion(driven.axis, driven.turned), btSin(driven.phase) * driven.way);
            driven.body->setWorldTransform(btTransform(driven.place.getRotation() * moved.getRotation(),
                                                       driven.place.getOrigin() + moved.getOrigin()));
        }
    }

    void AddChain()
    {
        const int links = 1 + Below(4);
        const bool isFixed = IsOneOf(3);
        btVector3 inertia;
        btBoxShape(s_linkHalf).calculateLocalInertia(1, inertia);
        m_forms.emplace_back();
        Form& form = m_forms.back();
        form.name = "link";
        form.isConvex = IsOneOf(2);
        form.inner = qcBoxModel((form.isConvex ? btScalar(s_inner) : btScalar(1)) * s_linkHalf, 2);
        form.outer = qcBoxModel((form.isConvex ? btScalar(s_outer) : btScalar(1)) * s_linkHalf, 2);
        if (form.isConvex)
            form.shapes.push_back(std::make_unique<btBoxShape>(s_linkHalf));
        else
            form.shapes.push_back(form.inner.MakeShape());
        m_chain = std::make_unique<btMultiBody>(links, btScalar(1), inertia, isFixed, IsOneOf(2));
        m_chain->setBasePos(Above());
        const btVector3 half(btScalar(0.21), 0, 0);
        for (int link = 0; link < links; link++)
            if (IsOneOf(3))
                m_chain->setupSpherical(link, 1, inertia, link - 1, btQuaternion::getIdentity(), half, half, true);
            else
                m_chain->setupRevolute(link, 1, inertia, link - 1, btQuaternion::getIdentity(),
                                       IsOneOf(2) ? btVector3(0, 1, 0) : btVector3(0, 0, 1), half, half, true);
        m_chain->finalizeMultiDof();
        m_chain->setHasSelfCollision(false);
        m_world.addMultiBody(m_chain.get());
        for (int link = -1; link < links; link++)
        {
            m_links.push_back(std::make_unique<btMultiBodyLinkCollider>(m_chain.get(), link));
            btMultiBodyLinkCollider* collider = m_links.back().get();
            collider->setCollisionShape(form.Shape());
            if (link < 0)
                m_chain->setBaseCollider(collider);
            else
                m_chain->getLink(link).m_collider = collider;
            m_world.addCollisionObject(collider, 1, -1);
        }
        qcPlaceColliders(*m_chain);
        for (const auto& link : m_links)
            Follow(form, link.get(), !(isFixed && link->m_link < 0), m_chain.get());
    }
    void KickChain()
    {
        if (!m_chain->hasFixedBase())
            m_chain->setBaseVel(m_random.Vector(20));
        m_chain->setJointVel(0, m_random.Number(-30, 30));
        m_chain->wakeUp();
        for (const auto& link : m_links)
            link->activate();
    }

    /// Two bodies that are joined, and may meet each other.
    void AddHinge()
    {
        Form& first = *RandomMesh(1);
        Form& second = *RandomMesh(1);
        const btVector3 at = Above(), apart(btScalar(0.5), 0, 0), up(0, 1, 0);
        btRigidBody* a = AddBody(first, 1, btTransform(btQuaternion::getIdentity(), at));
        btRigidBody* b = AddBody(second, 1, btTransform(btQuaternion::getIdentity(), at + apart));
        for (btRigidBody* body : {a, b})
            m_oracle.Remove(body);
        Follow(first, a, true, this);
        Follow(second, b, true, this);
        m_hinge = std::make_unique<btHingeConstraint>(*a, *b, apart / 2, -apart / 2, up, up);
        m_world.addConstraint(m_hinge.get(), true);
        m_thrown.insert(m_thrown.end(), {a, b});
    }
    void AddCloth()
    {
        m_height += 0.3;
        btSoftBody* cloth = m_made->AddCloth(btScalar(m_height), IsOneOf(3), 8 + Below(8));
        m_cloths.push_back(cloth);
        auto now = [cloth] { return qcWorldMeshOf(cloth); };
        m_oracle.Add({"cloth", cloth, nullptr, true, false, now, now});
    }

    qcRandomNumbers m_random;
    std::list<Form> m_forms;
    std::unique_ptr<qcMovedMesh> m_wave; ///< null: the ground is static
    std::unique_ptr<qcMultiBodyWorld> m_made;
    btMultiBodyDynamicsWorld& m_world;
    qcMeshContact m_meshContact;
    std::list<std::unique_ptr<btRigidBody>> m_bodies;
    std::unique_ptr<btMultiBody> m_chain;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> m_links;
    std::unique_ptr<btHingeConstraint> m_hinge;
    std::vector<btRigidBody*> m_thrown;
    std::vector<btSoftBody*> m_cloths;
    std::vector<Driven> m_driven;
    btRigidBody* m_ground = nullptr;
    double m_height = 0.5;
    qcMeetingOracle m_oracle;
};

START_TEST(what_meets_in_a_mixed_world_is_counted)
{
    for (unsigned start = 1; start <= (qcIsLongForm() ? 1500u : 40u); start++)
    {
        MixedWorld made(_i != 0, start);
        for (int step = 0; step < s_steps; step++)
            for (const std::string& pair : made.Step(step))
                ck_abort_msg("start %u, step %d: %s", start, step, pair.c_str());
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mixed_worlds");
    tcase_set_timeout(tests, 1200); // a bound against hanging, not a claim about speed
    tcase_add_loop_test(tests, what_meets_in_a_mixed_world_is_counted, 0, 2);
    return qcRunCase("mixed_worlds", tests);
}
