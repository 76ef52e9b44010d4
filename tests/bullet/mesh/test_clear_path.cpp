// Hulls that move past meshes at rest: none that is said to pass no triangle meets one, by exact tests on the way.
#include "mesh_contact/limits/clear_path.h"

#include "bullet/mesh/core_model.h"
#include "bullet/mesh/motion_oracle.h"
#include "bullet/random_numbers.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>

namespace
{
constexpr int s_pathRuns = 600;
// How far meshes are from the origin of the world.
constexpr double s_distances[] = {1, 10, 100, 1000};

btTransform RandomFrame(qcRandomNumbers* random, double extent)
{
    btQuaternion turn(random->Number(-1, 1), random->Number(-1, 1), random->Number(-1, 1), random->Number(-1, 1));
    return btTransform(turn.normalized(), random->Vector(extent));
}

/// A mesh at rest.
struct Still
{
    qcModel model;
    std::unique_ptr<qcMeshShape> shape;
    btCollisionObject object;
    qcSweptObject swept;

    Still(qcModel given, const btTransform& place) : model(std::move(given)), shape(model.MakeShape())
    {
        object.setCollisionShape(shape.get());
        object.setWorldTransform(place);
        swept.object = &object;
        swept.start = swept.end = place;
    }
};

/// A convex shape, or a compound of such, that moves by its cores.
struct Moving
{
    std::unique_ptr<btCompoundShape> shape{new btCompoundShape};
    std::vector<std::unique_ptr<btConvexShape>> parts;
    qcConvexCores cores{qcCoreSize};
    qcSweptObject swept;

    void Add(btConvexShape* part, const btTransform& place)
    {
        parts.emplace_back(part);
        shape->addChildShape(place, part);
        swept.hulls.clear();
        cores.ForEachCore(shape.get(),
                          [this](const qcConvexCore& core, const btTransform& local) {
                              swept.hulls.push_back({core.hull.get(), local});
                          });
    }
};

/// True if cores meet no triangle at moments of the step.
bool MeetsNone(const Moving& moving, const Still& still)
{
    qcMotionOracle oracle;
    btCollisionObject body;
    body.setWorldTransform(moving.swept.start);
    const qcModel cores = qcCoreModel(moving.shape.get());
    oracle.Add(cores, &body);
    oracle.Add(still.model, &still.object);
    const size_t atStart = oracle.CountNow();
    body.setWorldTransform(moving.swept.end);
    return oracle.Count() + atStart == 0;
}

qcModel HillsModel(qcRandomNumbers* random)
{
    qcModel model = qcFloorModel(3, 12);
    for (size_t i = 1; i < model.positions.size(); i += 3)
        model.positions[i] = random->Number(0, 0.4);
    return model;
}

qcModel SliversModel(qcRandomNumbers* random)
{
    qcModel model;
    for (int i = 0; i < 40; i++)
    {
        const btVector3 a = random->Vector(2), b = random->Vector(2), c = b + random->Vector(i % 4 == 0 ? 0 : 0.01);
        for (const btVector3& corner : {a, b, c})
            model.Add(double(corner.x()), double(corner.y()), double(corner.z()));
        const uint32_t last = uint32_t(model.positions.size() / 3 - 1);
        model.Add(last - 2, last - 1, last);
    }
    return model;
}

qcModel RandomModel(qcRandomNumbers* random, int kind)
{
    switch (kind)
    {
        case 0: return HillsModel(random);
        case 1: return SliversModel(random);
        case 2: return qcTorusModel(1.5, 0.5, 24, 12);
        case 3: return qcBoxModel(btVector3(1, 2, btScalar(0.01)), 1);
        default: return qcSphereModel(1, 2);
    }
}

void AddRandomParts(qcRandomNumbers* random, int kind, Moving* moving)
{
    const btScalar size = random->Number(0.1, 0.6);
    const btTransform none = btTransform::getIdentity();
    switch (kind)
    {
        case 0: moving->Add(new btSphereShape(size), none); break;
        case 1: moving->Add(new btBoxShape(btVector3(size, size / 2, size / 8)), none); break;
        case 2: moving->Add(new btConeShape(size, 2 * size), none); break;
        default:
            moving->Add(new btBoxShape(btVector3(size / 4, size, size / 4)), RandomFrame(random, 0.5));
            moving->Add(new btSphereShape(size / 2), RandomFrame(random, 0.5));
    }
}
} // namespace

START_TEST(what_passes_none_meets_none)
{
    qcRandomNumbers random(7);
    int clear = 0, proven = 0;
    for (int run = 0; run < s_pathRuns; run++)
    {
        const btTransform place = RandomFrame(&random, s_distances[run % 4]);
        const Still still(RandomModel(&random, run % 5), place);
        Moving moving;
        AddRandomParts(&random, run % 4, &moving);
        const btTransform start = RandomFrame(&random, 2);
        btTransform end(run % 2 == 0 ? start.getBasis() : RandomFrame(&random, 0).getBasis(), start.getOrigin());
        end.getOrigin() += random.Vector(run % 7 == 0 ? 3 : 0.3);
        moving.swept.start = place * start;
        moving.swept.end = place * end;
        const bool meetsNone = MeetsNone(moving, still), isClear = qcHasClearPath(moving.swept, still.swept);
        ck_assert_msg(!isClear || meetsNone, "run %d", run);
        clear += meetsNone;
        proven += isClear;
    }
    // What is not proven costs more.
    ck_assert_int_gt(clear, s_pathRuns / 3);
    ck_assert_int_gt(10 * proven, 9 * clear);
}
END_TEST

/// Moves random parts until they just touch meshes at rest: then their path is not clear. True if it is shortly before.
bool IsClearUntilItTouches(qcRandomNumbers* random, int run, const Still& still)
{
    Moving moving;
    AddRandomParts(random, run % 4, &moving);
    const btTransform start = still.swept.start * RandomFrame(random, 2);
    const btVector3 motion = random->Vector(1);
    auto move = [&](btScalar part)
    {
        moving.swept.start = moving.swept.end = start;
        moving.swept.end.getOrigin() += part * motion;
        return MeetsNone(moving, still);
    };
    if (!move(0) || move(1))
        return false;
    btScalar apart = 0, together = 1;
    for (int i = 0; i < 20; i++)
    {
        const btScalar middle = (apart + together) / 2;
        (move(middle) ? apart : together) = middle;
    }
    for (double further : {0.0, 1e-6, 1e-4, 1e-2})
        ck_assert(move(together + btScalar(further)) || !qcHasClearPath(moving.swept, still.swept));
    // A gap of 2 % of the motion is enough.
    return apart > btScalar(0.02) && move(apart - btScalar(0.02)) && qcHasClearPath(moving.swept, still.swept);
}

START_TEST(what_just_touches_is_not_clear)
{
    qcRandomNumbers random(8);
    int found = 0;
    for (int run = 0; run < s_pathRuns; run++)
    {
        const btTransform place = RandomFrame(&random, s_distances[run % 4]);
        const Still still(RandomModel(&random, run % 5), place);
        found += IsClearUntilItTouches(&random, run, still);
    }
    ck_assert_int_gt(found, s_pathRuns / 20);
}
END_TEST

/// A compound of random meshes at rest, some of them in compounds of their own, and its triangles.
struct StillCompound
{
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    btCompoundShape compound;
    Still still{{}, btTransform::getIdentity()};

    /// `extent`: of the places of the meshes.
    StillCompound(qcRandomNumbers* random, int count, double extent, const btTransform& place)
    {
        for (int i = 0; i < count; i++)
        {
            qcModel model = RandomModel(random, int(random->Number(0, 5)));
            btTransform local = RandomFrame(random, extent), inner = RandomFrame(random, 1);
            // The boxes of turned ones are loose.
            if (random->Number(0, 1) < btScalar(0.5))
            {
                local.setBasis(btMatrix3x3::getIdentity());
                inner.setBasis(btMatrix3x3::getIdentity());
            }
            shapes.push_back(model.MakeShape(0));
            if (i % 3 == 0)
            {
                auto nested = std::make_unique<btCompoundShape>();
                nested->addChildShape(inner, shapes.back().get());
                shapes.push_back(std::move(nested));
                model.Move(inner);
            }
            compound.addChildShape(local, shapes.back().get());
            model.Move(local);
            still.model.Append(model);
        }
        still.object.setCollisionShape(&compound);
        still.object.setWorldTransform(place);
        still.swept.start = still.swept.end = place;
    }
};

START_TEST(what_just_touches_a_child_is_not_clear)
{
    qcRandomNumbers random(9);
    int found = 0;
    for (int run = 0; run < s_pathRuns; run++)
    {
        const btTransform place = RandomFrame(&random, s_distances[run % 4]);
        StillCompound level(&random, 1 + run % 3, 1, place);
        level.still.swept.children.Read(&level.compound, nullptr);
        found += IsClearUntilItTouches(&random, run, level.still);
    }
    ck_assert_int_gt(found, s_pathRuns / 20);
}
END_TEST

START_TEST(children_that_are_not_on_the_way_need_no_test)
{
    qcRandomNumbers random(12);
    int clear = 0, met = 0;
    for (int run = 0; run < s_pathRuns; run++)
    {
        const btTransform place = RandomFrame(&random, s_distances[run % 4]);
        StillCompound level(&random, 1 + run % 20, 6, place);
        Moving moving;
        AddRandomParts(&random, run % 4, &moving);
        moving.swept.start = place * RandomFrame(&random, 4);
        moving.swept.end = moving.swept.start * RandomFrame(&random, run % 3 == 0 ? 2 : 0.2);
        const bool isClear = qcHasClearPath(moving.swept, level.still.swept);
        level.still.swept.children.Read(&level.compound, nullptr);
        const bool isReadClear = qcHasClearPath(moving.swept, level.still.swept);
        // A plane between boxes is one between what they have.
        ck_assert(isReadClear || !isClear);
        ck_assert_msg(!isReadClear || MeetsNone(moving, level.still), "run %d", run);
        clear += isReadClear;
        met += !isReadClear;
    }
    ck_assert_int_gt(clear, s_pathRuns / 4);
    ck_assert_int_gt(met, s_pathRuns / 10);
}
END_TEST

/// True if a point of the world is inside of one of the cores of a compound.
bool IsInsideOfCore(const btVector3& point, const btCompoundShape& compound, const btTransform& place,
                    qcConvexCores* cores)
{
    bool isInside = false;
    auto test = [&](const qcConvexCore& core, const btTransform& local)
    {
        const btVector3 inCore = (place * local).invXform(point);
        const std::vector<btVector3>& normals = core.hull->Normals();
        isInside = isInside ||
                   std::all_of(normals.begin(), normals.end(),
                               [&](const btVector3& normal) { return normal.dot(inCore) < core.hull->Max(normal); });
    };
    cores->ForEachCore(&compound, test);
    return isInside;
}

START_TEST(cores_are_passed_from_outside)
{
    qcRandomNumbers random(13);
    int clear = 0, met = 0, inside = 0;
    for (int run = 0; run < s_pathRuns; run++)
    {
        const btTransform place = RandomFrame(&random, s_distances[run % 4]);
        StillCompound level(&random, run % 3, 4, place);
        qcConvexCores cores(qcCoreSize);
        std::vector<std::unique_ptr<btConvexShape>> convex;
        for (int i = 0; i < 1 + run % 12; i++)
        {
            const btScalar size = random.Number(0.2, 2);
            if (i % 3 == 0)
                convex.emplace_back(new btSphereShape(size));
            else if (i % 3 == 1)
                convex.emplace_back(new btBoxShape(btVector3(size, random.Number(0.1, 1), 1)));
            else
                convex.emplace_back(new btConeShape(size, 1));
            const btTransform local = RandomFrame(&random, 4);
            level.compound.addChildShape(local, convex.back().get());
            qcModel core = qcCoreModel(convex.back().get());
            core.Move(local);
            level.still.model.Append(core);
        }
        level.still.swept.cores = &cores;
        Moving moving;
        AddRandomParts(&random, run % 4, &moving);
        moving.swept.start = place * RandomFrame(&random, 3);
        moving.swept.end = moving.swept.start * RandomFrame(&random, run % 3 == 0 ? 2 : 0.2);
        ck_assert(!qcHasClearPath(moving.swept, level.still.swept));
        level.still.swept.children.Read(&level.compound, &cores);
        const bool isClear = qcHasClearPath(moving.swept, level.still.swept);
        ck_assert_msg(!isClear || MeetsNone(moving, level.still), "run %d", run);
        for (const qcSweptHull& hull : moving.swept.hulls)
        {
            const btVector3& point = hull.mesh->Triangles().points[0];
            const bool isInside =
                IsInsideOfCore(moving.swept.start * (hull.local * point), level.compound, place, &cores);
            ck_assert_msg(!isClear || !isInside, "run %d", run);
            inside += isInside;
        }
        clear += isClear;
        met += !isClear;
    }
    ck_assert_int_gt(clear, s_pathRuns / 4);
    ck_assert_int_gt(met, s_pathRuns / 10);
    ck_assert_int_gt(inside, s_pathRuns / 20);
}
END_TEST

START_TEST(only_hulls_and_meshes_at_rest_count)
{
    const btTransform above(btQuaternion::getIdentity(), btVector3(0, 1, 0));
    Still still(qcFloorModel(1, 2), btTransform::getIdentity());
    Moving moving;
    moving.Add(new btSphereShape(btScalar(0.5)), btTransform::getIdentity());
    moving.swept.start = moving.swept.end = above;
    ck_assert(qcHasClearPath(moving.swept, still.swept));

    still.swept.moves = true;
    ck_assert(!qcHasClearPath(moving.swept, still.swept));
    still.swept.moves = false;
    still.swept.cores = &moving.cores;
    ck_assert(!qcHasClearPath(moving.swept, still.swept));
    still.swept.cores = nullptr;
    btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
    btCompoundShape floors;
    btTriangleMesh triangles;
    triangles.addTriangle(btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 0, 1));
    btBvhTriangleMeshShape bullets(&triangles, true);
    floors.addChildShape(btTransform::getIdentity(), still.shape.get());
    floors.addChildShape(btTransform::getIdentity(), &bullets);
    still.object.setCollisionShape(&floors);
    ck_assert(!qcHasClearPath(moving.swept, still.swept));
    still.swept.children.Read(&floors, nullptr);
    ck_assert(!qcHasClearPath(moving.swept, still.swept));
    floors.removeChildShape(&bullets);
    // Planes have contact alone.
    floors.addChildShape(btTransform::getIdentity(), &plane);
    still.swept.children.Read(&floors, nullptr);
    ck_assert(qcHasClearPath(moving.swept, still.swept));
    floors.removeChildShape(&plane);
    still.swept.children.Clear();
    ck_assert(qcHasClearPath(moving.swept, still.swept));
    moving.swept.hulls.clear();
    ck_assert(!qcHasClearPath(moving.swept, still.swept));
}
END_TEST

QC_RUN_TESTS("clear paths", what_passes_none_meets_none, what_just_touches_is_not_clear,
             what_just_touches_a_child_is_not_clear, children_that_are_not_on_the_way_need_no_test,
             cores_are_passed_from_outside, only_hulls_and_meshes_at_rest_count)
