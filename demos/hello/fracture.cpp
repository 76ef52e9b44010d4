// A cube of triangles falls, breaks into 40 pieces and the pieces land on a plane. Returns 0 if there are
// 40 pieces and all lie above the plane.
#include <quickcullide/bullet.h>
#include <quickcullide/bullet_fracture.h>
#include <btBulletDynamicsCommon.h>
#include <memory>

/// A shape and its body; Bullet keeps pointers to both.
struct Piece
{
    std::unique_ptr<qcMeshShape> shape;
    std::unique_ptr<btRigidBody> body;
};

static Piece MakeBody(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices, btScalar mass)
{
    Piece made;
    made.shape = std::make_unique<qcMeshShape>(vertices.data(), qcBulletPositions, sizeof(btVector3),
                                               uint32_t(vertices.size()), indices.data(), uint32_t(indices.size() / 3));
    btVector3 inertia;
    made.shape->calculateLocalInertia(mass, inertia);
    made.body = std::make_unique<btRigidBody>(mass, nullptr, made.shape.get(), inertia);
    return made;
}

int main()
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcMeshContact meshContact; // contact of meshes with each other
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    meshContact.addTo(&world);

    btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
    btRigidBody ground(0, nullptr, &plane);
    world.addRigidBody(&ground);
    qcFractureDef def; // a cube; any closed mesh will do
    for (int i = 0; i < 8; i++)
        def.vertices.push_back(btVector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    def.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                   2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    Piece cube = MakeBody(def.vertices, def.indices, 100);
    cube.body->setWorldTransform(btTransform(btQuaternion(1, 2, 3, 4).normalized(), btVector3(0, 5, 0)));
    world.addRigidBody(cube.body.get());
    while (cube.body->getWorldTransform().getOrigin().y() > btScalar(1.8))
        world.stepSimulation(btScalar(1.0 / 60));

    std::vector<Piece> pieces;
    btVector3 impact(0, -1, 0);
    def.sites = qcScatterSites(btVector3(-1, -1, -1), btVector3(1, 1, 1), 40, 1, &impact);
    qcFracture fracture = qcFracture_Split(def);
    world.removeRigidBody(cube.body.get());
    for (const qcPiece& piece : fracture.pieces)
    {
        qcPieceMotion motion = qcMotionOfPiece(*cube.body, fracture, piece);
        pieces.push_back(MakeBody(piece.vertices, piece.indices, motion.mass));
        pieces.back().body->setWorldTransform(motion.transform);
        pieces.back().body->setLinearVelocity(motion.linearVelocity);
        pieces.back().body->setAngularVelocity(motion.angularVelocity);
        world.addRigidBody(pieces.back().body.get());
    }

    for (int i = 0; i < 240; i++)
        world.stepSimulation(btScalar(1.0 / 60));
    int lost = 0;
    for (Piece& piece : pieces)
    {
        lost += piece.body->getWorldTransform().getOrigin().y() < 0;
        world.removeRigidBody(piece.body.get());
    }
    world.removeRigidBody(&ground);
    return pieces.size() == 40 && lost == 0 ? 0 : 1;
}
