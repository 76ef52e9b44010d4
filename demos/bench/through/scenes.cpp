// The scenes of `qc-bench through`. Metres, kilograms, seconds; y is up.
#include "bench/through/scenes.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <cstring>

namespace
{
// Cloths lie between the shapes' surfaces and their cores, which are smaller by this factor: nothing that stays outside
// of a shape, give or take its margin, touches the core.
constexpr btScalar s_core = btScalar(0.9);

btTransform At(const btVector3& place)
{
    return btTransform(btQuaternion::getIdentity(), place);
}

//  ---- cloth and cloth -----------------------------------------------------------------------------------------------

void BuildThrow(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    qcClothDef target, thrown;
    target.nodesX = target.nodesZ = 40;
    world->AddCloth(target, jitter);
    // In some runs a step ends while the cloths cross, in others it takes the thrown one past the other.
    thrown.center = btVector3(0, btScalar(0.3) + btScalar(0.1) * jitter->Number(), 0);
    thrown.halfX = thrown.halfZ = btScalar(0.6);
    thrown.nodesX = thrown.nodesZ = 24;
    thrown.tilt = btScalar(0.2);
    thrown.velocity = btVector3(0, -speed, 0);
    world->AddCloth(thrown, jitter);
}

void BuildFilm(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    constexpr int nodes = 26;
    qcClothDef target, thrown;
    target.nodesX = target.nodesZ = nodes;
    btSoftBody* cloth = world->AddCloth(target, jitter);
    for (int corner : {0, nodes - 1, nodes * nodes - nodes, nodes * nodes - 1})
        cloth->setMass(corner, 0);
    thrown.center = btVector3(0, btScalar(0.86), 0);
    thrown.halfX = thrown.halfZ = btScalar(0.5);
    thrown.nodesX = thrown.nodesZ = 16;
    thrown.tilt = btScalar(0.1);
    thrown.mass = btScalar(0.3);
    thrown.velocity = btVector3(0, -speed, 0);
    world->AddCloth(thrown, jitter, btScalar(0.1));
}

/// The halves clap together.
void BuildFold(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    qcClothDef def;
    def.nodesX = def.nodesZ = 40;
    btSoftBody* cloth = world->AddCloth(def, jitter);
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        btSoftBody::Node& node = cloth->m_nodes[i];
        btScalar part = btFabs(node.m_x.x()), side = node.m_x.x() > 0 ? btScalar(1) : btScalar(-1);
        node.m_v = node.m_vn = btVector3(-side, 1, 0) * (btSqrt(btScalar(0.5)) * speed * part);
    }
}

constexpr int s_wringLong = 40, s_wringWide = 12;
constexpr btScalar s_wringHalf = btScalar(0.5), s_wringHalfWidth = btScalar(0.15);

bool IsWringEnd(int node)
{
    int column = node % s_wringLong;
    return column == 0 || column == s_wringLong - 1;
}

void BuildWring(qcThroughWorld* world, qcJitter* jitter, btScalar)
{
    qcClothDef def;
    def.halfX = s_wringHalf;
    def.halfZ = s_wringHalfWidth;
    def.nodesX = s_wringLong;
    def.nodesZ = s_wringWide;
    btSoftBody* cloth = world->AddCloth(def, jitter, 0);
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        if (IsWringEnd(i))
            cloth->setMass(i, 0);
}

/// Turns the ends against each other; `turns` a second each, and draws them together.
void DriveWring(qcThroughWorld* world, double time, btScalar turns)
{
    btSoftBody* cloth = world->Bodies()[0].soft;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        if (!IsWringEnd(i))
            continue;
        btScalar side = i % s_wringLong == 0 ? btScalar(-1) : btScalar(1);
        btScalar angle = side * SIMD_2_PI * turns * btScalar(time);
        btScalar width = s_wringHalfWidth * (2 * btScalar(i / s_wringLong) / btScalar(s_wringWide - 1) - 1);
        btScalar half = s_wringHalf * (1 - btScalar(0.15) * btScalar(time));
        cloth->m_nodes[i].m_x = btVector3(side * half, width * btSin(angle), width * btCos(angle));
    }
}

void BuildStack(qcThroughWorld* world, qcJitter* jitter, btScalar)
{
    world->AddMesh(qcMakeFloor(2, 8), 0, At(btVector3(0, 0, 0)));
    for (int i = 0; i < 10; i++)
    {
        qcClothDef def;
        def.halfX = def.halfZ = btScalar(0.4);
        def.nodesX = def.nodesZ = 14;
        def.mass = btScalar(0.2);
        def.center = btVector3(btScalar(0.05) * btScalar(i % 3), btScalar(0.05) + btScalar(0.06) * btScalar(i), 0);
        world->AddCloth(def, jitter, btScalar(0.05));
    }
}

//  ---- cloth and rigid bodies ----------------------------------------------------------------------------------------

void AddDropped(qcThroughWorld* world, qcJitter* jitter, btScalar speed, btScalar height)
{
    qcClothDef def;
    def.center = btVector3(0, height, 0);
    def.halfX = def.halfZ = btScalar(0.5);
    def.nodesX = def.nodesZ = 24;
    def.tilt = btScalar(0.1);
    def.velocity = btVector3(0, -speed, 0);
    world->AddCloth(def, jitter, btScalar(0.05));
}

void BuildDropStatic(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    world->AddMesh(qcMakeFloor(btScalar(1.5), 12, btScalar(0.05)), 0, At(btVector3(0, 0, 0)));
    AddDropped(world, jitter, speed, btScalar(0.5));
}

constexpr btScalar s_kinematicDepth = btScalar(-0.3);

void BuildDropKinematic(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    btRigidBody* bunny = world->AddMesh(qcMakeBunny(1000), 0, At(btVector3(0, s_kinematicDepth, 0)));
    bunny->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    AddDropped(world, jitter, speed, 1);
}

/// Towards the cloth at 5 m/s, turning.
void DriveDropKinematic(qcThroughWorld* world, double time, btScalar)
{
    btQuaternion turn(btVector3(1, 1, 0).normalized(), btScalar(3 * time));
    btVector3 place(0, s_kinematicDepth + btScalar(5 * time), 0);
    world->Bodies()[0].rigid->setWorldTransform(btTransform(turn, place));
}

void BuildDropDynamic(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    btVector3 half(btScalar(0.15), btScalar(0.15), btScalar(0.15));
    btTransform place = jitter->Rotation(btVector3(0, 0, 0), btScalar(0.5));
    world->AddMesh(qcMakeBox(half), 2, place);
    AddDropped(world, jitter, speed, btScalar(0.5));
}

/// The mesh lies on another one: what the cloth pushes must not go through the floor.
void BuildDropResting(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    btVector3 half(btScalar(0.15), btScalar(0.05), btScalar(0.15));
    world->AddMesh(qcMakeFloor(btScalar(1.5), 12), 0, At(btVector3(0, 0, 0)));
    world->AddMesh(qcMakeBox(half), btScalar(0.2), At(btVector3(0, btScalar(0.08), 0)));
    AddDropped(world, jitter, speed, btScalar(0.5));
}

void BuildDropTetrahedra(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    world->AddMesh(qcMakeTetrahedra(btScalar(0.006), 5, btScalar(0.18)), 0, At(btVector3(0, 0, 0)));
    AddDropped(world, jitter, speed, btScalar(0.3));
}

void BuildDropBunny(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    world->AddMesh(qcMakeBunny(2000), 0, At(btVector3(0, 0, 0)));
    AddDropped(world, jitter, speed, 1);
}

void BuildDropPole(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    constexpr btScalar radius = btScalar(0.02);
    std::unique_ptr<btCollisionShape> pole(new btCylinderShapeZ(btVector3(radius, radius, 1)));
    world->AddShape(std::move(pole), qcMakeCylinder(s_core * radius, s_core, 16), At(btVector3(0, 0, 0)));
    AddDropped(world, jitter, speed, btScalar(0.3));
}

void BuildDropSphere(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    constexpr btScalar radius = btScalar(0.2);
    std::unique_ptr<btCollisionShape> sphere(new btSphereShape(radius));
    world->AddShape(std::move(sphere), qcMakeSphere(s_core * radius, 24, 12), At(btVector3(0, 0, 0)));
    AddDropped(world, jitter, speed, btScalar(0.5));
}

void BuildDropBox(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    btVector3 half(btScalar(0.2), btScalar(0.2), btScalar(0.2));
    std::unique_ptr<btCollisionShape> box(new btBoxShape(half));
    world->AddShape(std::move(box), qcMakeBox(s_core * half), At(btVector3(0, 0, 0)));
    AddDropped(world, jitter, speed, btScalar(0.5));
}

void BuildCrush(qcThroughWorld* world, qcJitter* jitter, btScalar)
{
    world->AddMesh(qcMakeFloor(2, 8), 0, At(btVector3(0, 0, 0)));
    btRigidBody* press = world->AddMesh(qcMakeFloor(2, 8), 0, At(btVector3(0, btScalar(0.7), 0)));
    press->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    qcClothDef def;
    def.center = btVector3(0, btScalar(0.1), 0);
    def.nodesX = def.nodesZ = 16;
    def.tilt = btScalar(0.05);
    world->AddCloth(def, jitter);
}

/// The lower edge of the press comes to the floor, and goes on.
void DriveCrush(qcThroughWorld* world, double time, btScalar speed)
{
    btQuaternion tilt(btVector3(1, 0, 0), btScalar(0.2));
    world->Bodies()[1].rigid->setWorldTransform(
        btTransform(tilt, btVector3(0, btScalar(0.7) - speed * btScalar(time), 0)));
}

//  ---- sheets, bunnies, ropes ----------------------------------------------------------------------------------------

void BuildSoftSheets(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    qcClothDef target, thrown;
    target.halfX = target.halfZ = thrown.halfX = thrown.halfZ = btScalar(0.5);
    target.nodesX = target.nodesZ = thrown.nodesX = thrown.nodesZ = 2;
    thrown.center = btVector3(btScalar(0.1), 3, btScalar(0.05));
    thrown.velocity = btVector3(0, -speed, 0);
    world->AddCloth(target, jitter);
    world->AddCloth(thrown, jitter, btScalar(0.2));
}

void BuildRigidSheets(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    qcTriangles sheet = qcMakeFloor(btScalar(0.5), 1);
    world->AddMesh(sheet, 1, At(btVector3(0, 0, 0)));
    btTransform turn = jitter->Rotation(btVector3(0, 0, 0), btScalar(0.2));
    btVector3 place = btVector3(0, 3, 0) + btScalar(0.1) * jitter->Vector();
    world->AddMesh(sheet, 1, At(place) * turn)->setLinearVelocity(btVector3(0, -speed, 0));
}

void BuildBin(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    world->AddMesh(qcMakeBin(btScalar(0.9), 2, 8), 0, At(btVector3(0, 0, 0)));
    for (int i = 0; i < 5; i++)
    {
        btTransform turn = jitter->Rotation(btVector3(0, 0, 0), btScalar(0.5));
        btVector3 place(btScalar(0.15) * btScalar(i % 3 - 1), btScalar(0.7) + btScalar(1.05) * btScalar(i),
                        btScalar(0.1) * btScalar(i % 2));
        world->AddMesh(qcMakeBunny(600), 1, At(place + btScalar(0.02) * jitter->Vector()) * turn)
            ->setLinearVelocity(btVector3(0, -speed, 0));
    }
}

/// Two ropes, fixed at their ends, each through three rings that are thrown to all sides.
void BuildRopes(qcThroughWorld* world, qcJitter* jitter, btScalar speed)
{
    qcTriangles ring = qcMakeTorus(btScalar(0.08), btScalar(0.02), 24, 10);
    for (int rope = 0; rope < 2; rope++)
    {
        btScalar z = btScalar(rope);
        world->AddRope(btVector3(-1, 0, z), btVector3(1, 0, z), 41, jitter);
        for (int i = -1; i <= 1; i++)
        {
            btTransform place(btQuaternion(btVector3(0, 1, 0), SIMD_HALF_PI), btVector3(btScalar(0.5 * i), 0, z));
            btVector3 away = jitter->Vector();
            away.setX(away.x() / 4);
            world->AddMesh(ring, btScalar(0.1), place)->setLinearVelocity(speed * away.normalized());
        }
    }
}

const std::vector<qcThroughScene> s_scenes = {
    // name, title, soft, 240 Hz too, crushes, keeps, seconds, gravity, speed
    {"throw-5", "cloth thrown at cloth, 5 m/s", true, true, false, qc_keepsMomentum, 0.2, 0, 5, BuildThrow, nullptr},
    {"throw-20", "cloth thrown at cloth, 20 m/s", true, true, false, qc_keepsMomentum, 0.2, 0, 20, BuildThrow, nullptr},
    {"throw-50", "cloth thrown at cloth, 50 m/s", true, true, false, qc_keepsMomentum, 0.1, 0, 50, BuildThrow, nullptr},
    {"throw-100", "cloth thrown at cloth, 100 m/s", true, true, false, qc_keepsMomentum, 0.1, 0, 100, BuildThrow,
     nullptr},
    {"fold-50", "halves of a cloth clap, 50 m/s", true, false, false, qc_keepsMomentum, 0.2, 0, 50, BuildFold, nullptr},
    {"wring", "cloth wrung five turns", true, false, false, qc_keepsNothing, 5, 0, btScalar(0.5), BuildWring,
     DriveWring},
    {"stack", "ten cloths dropped on each other", true, false, false, qc_keepsEnergy, 1, 10, 0, BuildStack, nullptr},
    {"drop-static", "cloth on a static mesh, 50 m/s", true, false, false, qc_keepsEnergy, 0.3, 10, 50, BuildDropStatic,
     nullptr},
    {"drop-kinematic", "cloth on a kinematic mesh, 50 m/s", true, false, false, qc_keepsNothing, 0.3, 10, 50,
     BuildDropKinematic, DriveDropKinematic},
    {"drop-dynamic", "cloth on a dynamic mesh, 50 m/s", true, false, false, qc_keepsMomentum, 0.2, 0, 50,
     BuildDropDynamic, nullptr},
    {"drop-resting", "cloth on a mesh on a mesh, 50 m/s", true, false, false, qc_keepsEnergy, 0.3, 10, 50,
     BuildDropResting, nullptr},
    {"drop-tetrahedra", "cloth on 6 mm tetrahedra, 50 m/s", true, false, false, qc_keepsEnergy, 0.2, 10, 50,
     BuildDropTetrahedra, nullptr},
    {"drop-bunny", "cloth on a bunny, 50 m/s", true, false, false, qc_keepsEnergy, 0.3, 10, 50, BuildDropBunny,
     nullptr},
    {"drop-pole", "cloth on Bullet's thin pole, 50 m/s", true, false, false, qc_keepsEnergy, 0.3, 10, 50, BuildDropPole,
     nullptr},
    {"drop-sphere", "cloth on Bullet's sphere, 50 m/s", true, false, false, qc_keepsEnergy, 0.3, 10, 50,
     BuildDropSphere, nullptr},
    {"drop-box", "cloth on Bullet's box, 50 m/s", true, false, false, qc_keepsEnergy, 0.3, 10, 50, BuildDropBox,
     nullptr},
    {"crush", "kinematic mesh crushes cloth", true, false, true, qc_keepsNothing, 1, 10, btScalar(0.6), BuildCrush,
     DriveCrush},
    {"soft-sheets", "sheets of 2 triangles, 100 m/s", true, false, false, qc_keepsMomentum, 0.3, 0, 100,
     BuildSoftSheets, nullptr},
    {"ropes", "ropes through thrown rings, 20 m/s", true, false, false, qc_keepsEnergy, 0.5, 10, 20, BuildRopes,
     nullptr},
    {"rigid-sheets", "sheets of 2 triangles, 100 m/s", false, false, false, qc_keepsMomentum, 0.5, 0, 100,
     BuildRigidSheets, nullptr},
    {"bin", "five bunnies thrown into a bin, 30 m/s", false, false, false, qc_keepsEnergy, 1, 10, 30, BuildBin,
     nullptr},
};
} // namespace

const std::vector<qcThroughScene>& qcThroughScenes()
{
    return s_scenes;
}

const qcThroughScene& qcThroughFilmScene()
{
    static const qcThroughScene scene = {
        "film", "film: a cloth is caught", true, false, false, qc_keepsNothing, 0.4, 10, 20, BuildFilm, nullptr};
    return scene;
}

const qcThroughScene* qcFindThroughScene(const char* name)
{
    for (const qcThroughScene& scene : s_scenes)
        if (std::strcmp(scene.name, name) == 0)
            return &scene;
    return nullptr;
}
