// Worlds with qcMeshShapes saved by btDefaultSerializer and loaded by Bullet's packaged importer: what is loaded, how
// it moves in Bullet alone, and after qcRestoreMeshes.
#include <BulletWorldImporter/btBulletWorldImporter.h>
#include <LinearMath/btSerializer.h>

#include <array>
#include <string>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/mesh_world.h"

namespace
{
/// A copy of a saved world's buffer.
std::vector<char> Save(qcMeshWorld* world)
{
    btDefaultSerializer serializer;
    static const char* const names[] = {"body 0", "body 1", "body 2", "body 3", "body 4", "body 5", "body 6", "body 7"};
    ck_assert_uint_le(world->bodies.size(), 8);
    for (size_t i = 0; i < world->bodies.size(); i++)
        serializer.registerNameForPointer(world->bodies[i].get(), names[i]);
    world->world.serialize(&serializer);
    const char* buffer = reinterpret_cast<const char*>(serializer.getBufferPointer());
    return std::vector<char>(buffer, buffer + serializer.getCurrentBufferSize());
}

/// A loaded world. The importer owns bodies and shapes, and removes them.
struct Loaded
{
    qcMeshWorld empty;
    btBulletWorldImporter importer{&empty.world};
    std::vector<std::unique_ptr<qcMeshShape>> meshes;

    explicit Loaded(std::vector<char> file)
    {
        ck_assert(importer.loadFileFromMemory(file.data(), int(file.size())));
    }

    ~Loaded()
    {
        importer.deleteAllData();
    }

    btRigidBody* Body(size_t number)
    {
        btRigidBody* body = importer.getRigidBodyByName(("body " + std::to_string(number)).c_str());
        ck_assert_ptr_nonnull(body);
        return body;
    }
};

typedef std::array<btScalar, 9> LoadedTriangle;

struct TriangleCollector : btTriangleCallback
{
    btTransform place;
    std::vector<LoadedTriangle> triangles;

    void processTriangle(btVector3* corners, int, int) override
    {
        LoadedTriangle triangle;
        for (int i = 0; i < 9; i++)
            triangle[size_t(i)] = (place * corners[i / 3])[i % 3];
        triangles.push_back(triangle);
    }
};

void CollectTriangles(const btCollisionShape* shape, const btTransform& place, TriangleCollector* collector)
{
    if (shape->isCompound())
    {
        const auto* compound = static_cast<const btCompoundShape*>(shape);
        for (int i = 0; i < compound->getNumChildShapes(); i++)
            CollectTriangles(compound->getChildShape(i), place * compound->getChildTransform(i), collector);
    }
    else if (shape->isConcave())
    {
        btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        collector->place = place;
        static_cast<const btConcaveShape*>(shape)->processAllTriangles(collector, -far, far);
    }
}

/// Triangles in the frame of the shape, sorted by their corners.
std::vector<LoadedTriangle> TrianglesOf(const btCollisionShape* shape)
{
    TriangleCollector collector;
    CollectTriangles(shape, btTransform::getIdentity(), &collector);
    std::sort(collector.triangles.begin(), collector.triangles.end());
    return collector.triangles;
}

void CheckTriangles(const btCollisionShape* loaded, const btCollisionShape* saved, double tolerance)
{
    std::vector<LoadedTriangle> found = TrianglesOf(loaded), expected = TrianglesOf(saved);
    ck_assert_uint_gt(expected.size(), 0);
    ck_assert_uint_eq(found.size(), expected.size());
    for (size_t t = 0; t < found.size(); t++)
        for (size_t i = 0; i < 9; i++)
            ck_assert_double_le(std::fabs(double(found[t][i] - expected[t][i])), tolerance);
}

/// Indices of the bodies: a floor, two tori of one shape, a compound of a mesh and a box, a kinematic mesh.
enum
{
    s_floor,
    s_torus,
    s_otherTorus,
    s_compound,
    s_kinematic,
    s_count
};

// Numbers that single precision can hold: Bullet's format has margins, scalings and children's transforms in it.
void FillWorld(qcMeshWorld* world)
{
    const btScalar margin = btScalar(1) / 128;
    btCollisionShape* floor = world->Keep(qcFloorModel(1, 8).MakeShape(2 * margin));
    floor->setLocalScaling(btVector3(4, 1, 8));
    world->Add(floor, 0, btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(0.3)), btVector3(0, btScalar(-0.5), 0)));
    btCollisionShape* torus = world->Keep(qcTorusModel(0.5, 0.2, 16, 8).MakeShape(margin));
    torus->setLocalScaling(btVector3(1, btScalar(0.5), btScalar(1.5)));
    btTransform turned(btQuaternion(1, 2, 3, 4).normalized(), btVector3(-2, 1, 0));
    world->Add(torus, 3, turned);
    world->Add(torus, btScalar(0.5), btVector3(2, btScalar(0.5), 0))->setFriction(btScalar(0.25));
    auto* compound = new btCompoundShape;
    world->Keep(std::unique_ptr<btCollisionShape>(compound));
    btTransform aside(btQuaternion::getIdentity(), btVector3(btScalar(-0.5), 0, btScalar(0.25)));
    compound->addChildShape(aside, world->Keep(qcCubeModel(3).MakeShape(margin)));
    btVector3 half(btScalar(0.25), btScalar(0.25), btScalar(0.25));
    compound->addChildShape(aside.inverse(), world->Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(half))));
    world->Add(compound, 2, btVector3(0, btScalar(0.75), 2));
    btRigidBody* kinematic = world->Add(world->Keep(qcCubeModel(1).MakeShape(margin)), 0, btVector3(0, 0, -3));
    kinematic->setCollisionFlags(kinematic->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
}

START_TEST(bullets_importer_reads_static_dynamic_and_compound_bodies_of_meshes)
{
    qcMeshWorld saved;
    FillWorld(&saved);
    Loaded loaded(Save(&saved));
    ck_assert_int_eq(loaded.empty.world.getNumCollisionObjects(), s_count);
    for (size_t i = 0; i < s_count; i++)
    {
        btRigidBody *was = saved.bodies[i].get(), *is = loaded.Body(i);
        ck_assert(is->getWorldTransform() == was->getWorldTransform());
        ck_assert_double_eq_tol(double(is->getMass()), double(was->getMass()), 1e-6);
        ck_assert(is->getFriction() == was->getFriction());
        CheckTriangles(is->getCollisionShape(), was->getCollisionShape(), 0);
    }
    // Two bodies of one shape.
    ck_assert_ptr_eq(loaded.Body(s_torus)->getCollisionShape(), loaded.Body(s_otherTorus)->getCollisionShape());
    const auto* floor = static_cast<const btCompoundShape*>(loaded.Body(s_floor)->getCollisionShape());
    ck_assert(floor->getChildShape(0)->getMargin() == btScalar(1) / 64);
}
END_TEST

START_TEST(scaling_is_kept_in_the_precision_of_bullets_format)
{
    qcMeshWorld saved;
    btCollisionShape* shape = saved.Keep(qcSphereModel(1, 2).MakeShape());
    shape->setLocalScaling(btVector3(btScalar(0.1), btScalar(0.7), btScalar(1.3)));
    saved.Add(shape, 1, btVector3(0, 0, 0));
    Loaded loaded(Save(&saved));
    // The format has single precision: 24 bits.
    CheckTriangles(loaded.Body(0)->getCollisionShape(), shape, sizeof(btScalar) == sizeof(float) ? 0 : 1e-7);
}
END_TEST

START_TEST(a_loaded_mesh_falls_onto_convex_shapes_in_bullet_alone)
{
    qcMeshWorld saved;
    btVector3 half(2, btScalar(0.5), 2);
    saved.Add(saved.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(half))), 0, btVector3(0, btScalar(-0.5), 0));
    saved.Add(saved.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, 1, 0));
    Loaded loaded(Save(&saved));
    loaded.empty.Step(120);
    ck_assert_double_eq_tol(double(loaded.Body(1)->getWorldTransform().getOrigin().y()), 0.5, 0.06);
    ck_assert_double_lt(double(loaded.Body(1)->getLinearVelocity().length()), 0.01);
}
END_TEST

void CheckRestored(const btCollisionShape* loaded, const btCollisionShape* saved)
{
    const auto *is = dynamic_cast<const qcMeshShape*>(loaded), *was = dynamic_cast<const qcMeshShape*>(saved);
    ck_assert(is != nullptr && was != nullptr);
    ck_assert(is->getLocalScaling() == was->getLocalScaling() && is->getMargin() == was->getMargin());
    ck_assert_uint_eq(is->getVertexCount(), was->getVertexCount());
    ck_assert_uint_eq(is->getTriangleCount(), was->getTriangleCount());
    for (uint32_t v = 0; v < is->getVertexCount(); v++)
        for (int axis = 0; axis < 3; axis++)
            ck_assert(is->getVertices()[v][axis] == was->getVertices()[v][axis]);
    ck_assert(std::equal(is->getIndices(), is->getIndices() + 3 * is->getTriangleCount(), was->getIndices()));
}

START_TEST(restored_meshes_have_the_vertices_indices_scaling_and_margin_that_were_saved)
{
    qcMeshWorld saved;
    FillWorld(&saved);
    Loaded loaded(Save(&saved));
    loaded.meshes = qcRestoreMeshes(&loaded.empty.world);
    ck_assert_uint_eq(loaded.meshes.size(), 4);
    for (size_t i : {s_floor, s_torus, s_otherTorus, s_kinematic})
        CheckRestored(loaded.Body(i)->getCollisionShape(), saved.bodies[i]->getCollisionShape());
    ck_assert_ptr_eq(loaded.Body(s_torus)->getCollisionShape(), loaded.Body(s_otherTorus)->getCollisionShape());
    const auto* is = static_cast<const btCompoundShape*>(loaded.Body(s_compound)->getCollisionShape());
    const auto* was = static_cast<const btCompoundShape*>(saved.bodies[s_compound]->getCollisionShape());
    ck_assert_int_eq(is->getNumChildShapes(), 2);
    CheckRestored(is->getChildShape(0), was->getChildShape(0));
    ck_assert(is->getChildTransform(0) == was->getChildTransform(0));
    ck_assert_int_eq(is->getChildShape(1)->getShapeType(), BOX_SHAPE_PROXYTYPE);
    for (size_t i = 0; i < s_count; i++)
    {
        btVector3 inertia = loaded.Body(i)->getLocalInertia(), expected = saved.bodies[i]->getLocalInertia();
        for (int axis = 0; axis < 3; axis++)
            ck_assert_double_eq_tol(double(inertia[axis]), double(expected[axis]), 1e-5);
    }
    // A second call has nothing to replace.
    ck_assert_uint_eq(qcRestoreMeshes(&loaded.empty.world).size(), 0);
}
END_TEST

START_TEST(a_restored_world_goes_on_as_the_saved_one)
{
    qcMeshWorld saved;
    FillWorld(&saved);
    Loaded loaded(Save(&saved));
    // Algorithms from an earlier step belong to the shapes that Bullet loaded.
    loaded.empty.world.performDiscreteCollisionDetection();
    loaded.meshes = qcRestoreMeshes(&loaded.empty.world);
    saved.Step(60);
    loaded.empty.Step(60);
    for (size_t i = 0; i < s_count; i++)
    {
        btVector3 was = saved.bodies[i]->getWorldTransform().getOrigin();
        btVector3 is = loaded.Body(i)->getWorldTransform().getOrigin();
        ck_assert_double_lt(double(was.distance(is)), 1e-6);
        ck_assert_double_gt(double(is.y()), -0.51);
    }
    ck_assert_int_gt(qcContactsOf(loaded.empty.dispatcher).points, 6);
}
END_TEST

START_TEST(a_mesh_used_alone_and_in_a_compound_comes_back_in_both)
{
    qcMeshWorld saved;
    btCollisionShape* mesh = saved.Keep(qcCubeModel(1).MakeShape());
    auto* compound = new btCompoundShape;
    saved.Keep(std::unique_ptr<btCollisionShape>(compound));
    btTransform aside(btQuaternion::getIdentity(), btVector3(1, 0, 0));
    compound->addChildShape(aside, mesh);
    compound->addChildShape(aside.inverse(), mesh);
    saved.Add(compound, 2, btVector3(0, 5, 0));
    saved.Add(mesh, 1, btVector3(0, 0, 0));
    Loaded loaded(Save(&saved));
    for (size_t i = 0; i < 2; i++)
        CheckTriangles(loaded.Body(i)->getCollisionShape(), saved.bodies[i]->getCollisionShape(), 0);
    loaded.meshes = qcRestoreMeshes(&loaded.empty.world);
    for (size_t i = 0; i < 2; i++)
        CheckTriangles(loaded.Body(i)->getCollisionShape(), saved.bodies[i]->getCollisionShape(), 0);
}
END_TEST

START_TEST(a_body_without_triangles_comes_back_without_triangles)
{
    qcMeshWorld saved;
    saved.Add(saved.Keep(qcModel().MakeShape()), 1, btVector3(1, 2, 3));
    saved.Add(saved.Keep(qcCubeModel(1).MakeShape()), 1, btVector3(0, 0, 0));
    Loaded loaded(Save(&saved));
    ck_assert(loaded.Body(0)->getWorldTransform().getOrigin() == btVector3(1, 2, 3));
    ck_assert_uint_eq(TrianglesOf(loaded.Body(0)->getCollisionShape()).size(), 0);
    CheckTriangles(loaded.Body(1)->getCollisionShape(), saved.bodies[1]->getCollisionShape(), 0);
    loaded.meshes = qcRestoreMeshes(&loaded.empty.world);
    loaded.empty.Step(3);
}
END_TEST

START_TEST(compounds_of_other_kinds_are_not_replaced)
{
    qcMeshWorld world;
    btTransform aside(btQuaternion::getIdentity(), btVector3(1, 0, 0));
    auto* moved = new btCompoundShape;
    world.Keep(std::unique_ptr<btCollisionShape>(moved));
    moved->addChildShape(aside, world.StaticMesh(qcCubeModel(1)));
    auto* box = new btCompoundShape;
    world.Keep(std::unique_ptr<btCollisionShape>(box));
    box->addChildShape(btTransform::getIdentity(),
                       world.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(btVector3(1, 1, 1)))));
    world.Add(moved, 0, btVector3(0, 0, 0));
    btRigidBody* body = world.Add(box, 1, btVector3(9, 9, 9));
    btVector3 inertia = body->getLocalInertia();
    ck_assert_uint_eq(qcRestoreMeshes(&world.world).size(), 0);
    ck_assert_ptr_eq(world.bodies[0]->getCollisionShape(), moved);
    ck_assert_ptr_eq(body->getCollisionShape(), box);
    ck_assert(body->getLocalInertia() == inertia);
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_save", bullets_importer_reads_static_dynamic_and_compound_bodies_of_meshes,
             scaling_is_kept_in_the_precision_of_bullets_format, a_loaded_mesh_falls_onto_convex_shapes_in_bullet_alone,
             restored_meshes_have_the_vertices_indices_scaling_and_margin_that_were_saved,
             a_restored_world_goes_on_as_the_saved_one, a_mesh_used_alone_and_in_a_compound_comes_back_in_both,
             a_body_without_triangles_comes_back_without_triangles, compounds_of_other_kinds_are_not_replaced)
