// Cloth, meshes and fracture in one Bullet world: a cloth lies on a slab over two supports, the slab breaks under it,
// and pieces and cloth fall to the floor. Returns 0 if nothing fell through the floor and nothing penetrates.
//
// Order of construction: collision configuration, dispatcher, broadphase, solvers and mesh contact, then the world,
// which refers to them; shapes before their bodies. Destruction is in reverse order.
#include <quickcullide/bullet.h>
#include <quickcullide/bullet_fracture.h>

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <memory>
#include <vector>

/// A rigid body and what it refers to.
struct Mesh
{
    std::unique_ptr<qcMeshShape> shape;
    std::unique_ptr<btRigidBody> body;
};

struct World
{
    //  Members are constructed in this order and destroyed in reverse.
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase; // instead of btDbvtBroadphase
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver; // cloth with itself, and with meshes
    qcMeshContact meshContact;   // meshes with each other
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration, &softSolver};
    std::vector<Mesh> meshes;
    btSoftBody* cloth = nullptr;

    World()
    {
        meshContact.addTo(&world); // before the world has objects
        // Friction in two directions: without it piles of pieces jitter.
        world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
        world.getWorldInfo().m_gravity = world.getGravity();
    }

    ~World()
    {
        //  What was added is removed before it is destroyed; a soft body was made with new.
        world.removeSoftBody(cloth);
        delete cloth;
        for (Mesh& mesh : meshes)
            world.removeRigidBody(mesh.body.get());
    }

    /// Vertices are in the body's frame, whose origin is the centre of mass. Mass 0: a static body.
    btRigidBody* Add(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices, btScalar mass,
                     const btTransform& transform)
    {
        Mesh mesh;
        mesh.shape =
            std::make_unique<qcMeshShape>(vertices.data(), qcBulletPositions, sizeof(btVector3),
                                          uint32_t(vertices.size()), indices.data(), uint32_t(indices.size() / 3));
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            mesh.shape->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, mesh.shape.get(), inertia);
        info.m_startWorldTransform = transform;
        info.m_friction = btScalar(0.8);
        mesh.body = std::make_unique<btRigidBody>(info);
        world.addRigidBody(mesh.body.get());
        meshes.push_back(std::move(mesh));
        return meshes.back().body.get();
    }

    void AddCloth(btScalar half, btScalar y, int nodes)
    {
        cloth =
            btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-half, y, -half), btVector3(half, y, -half),
                                           btVector3(-half, y, half), btVector3(half, y, half), nodes, nodes, 0, true);
        cloth->m_cfg.piterations = 4;
        cloth->m_cfg.kDP = btScalar(0.01);
        cloth->setTotalMass(1);
        qcSoftBodySettings settings; // the defaults, but for friction
        settings.friction = btScalar(0.5);
        softSolver.setSettings(cloth, settings);
        world.addSoftBody(cloth);
    }

    /// Call it between two steps. The pieces keep the momentum of the body, which is removed.
    bool Break(size_t i, const qcFractureDef& def)
    {
        qcFracture fracture = qcFracture_Split(def);
        if (fracture.status != qc_statusOk)
            return false;                  // fracture.message gives the reason
        Mesh whole = std::move(meshes[i]); // motions are read from it
        meshes.erase(meshes.begin() + std::ptrdiff_t(i));
        world.removeRigidBody(whole.body.get());
        for (const qcPiece& piece : fracture.pieces)
        {
            qcPieceMotion motion = qcMotionOfPiece(*whole.body, fracture, piece);
            btRigidBody* body = Add(piece.vertices, piece.indices, motion.mass, motion.transform);
            body->setLinearVelocity(motion.linearVelocity);
            body->setAngularVelocity(motion.angularVelocity);
        }
        return true;
    }

    /// False: a query failed, or something of the cloth penetrates.
    bool Step(int count)
    {
        bool right = true;
        for (int i = 0; i < count && right; i++)
        {
            world.stepSimulation(btScalar(1.0 / 120), 0);
            const qcSoftBodyStatistics& soft = softSolver.getStatistics();
            right =
                soft.status == qc_statusOk && meshContact.getStatistics().status == qc_statusOk && soft.remaining == 0;
        }
        return right;
    }

    /// Maximum penetration of meshes: the depth of Bullet's contact points beyond both margins.
    btScalar Depth()
    {
        btScalar depth = 0;
        for (int i = 0; i < dispatcher.getNumManifolds(); i++)
        {
            const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
            for (int p = 0; p < manifold->getNumContacts() && manifold->getBody0() != cloth; p++)
                depth = btMax(depth, -manifold->getContactPoint(p).getDistance());
        }
        return depth;
    }

    /// Height of the lowest node of the cloth or vertex of a mesh, the floor (the first mesh) excepted.
    btScalar Lowest() const
    {
        btScalar lowest = BT_LARGE_FLOAT;
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            lowest = btMin(lowest, cloth->m_nodes[i].m_x.y());
        for (size_t m = 1; m < meshes.size(); m++)
            for (uint32_t v = 0; v < meshes[m].shape->getVertexCount(); v++)
                lowest = btMin(lowest, (meshes[m].body->getWorldTransform() * meshes[m].shape->getVertices()[v]).y());
        return lowest;
    }
};

static qcFractureDef MakeBox(const btVector3& half)
{
    qcFractureDef box; // any closed mesh will do
    for (int i = 0; i < 8; i++)
        box.vertices.push_back(btVector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1) * half);
    box.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                   2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    return box;
}

static btTransform At(double x, double y)
{
    return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), 0));
}

int main()
{
    World world;
    world.Add({{-4, 0, -4}, {4, 0, -4}, {-4, 0, 4}, {4, 0, 4}}, {0, 2, 3, 0, 3, 1}, 0, At(0, 0));
    const btVector3 half(btScalar(0.8), btScalar(0.1), btScalar(0.4));
    qcFractureDef slab = MakeBox(half), support = MakeBox(btVector3(btScalar(0.1), btScalar(0.3), btScalar(0.4)));
    world.Add(support.vertices, support.indices, 0, At(-0.7, 0.32));
    world.Add(support.vertices, support.indices, 0, At(0.7, 0.32));
    world.Add(slab.vertices, slab.indices, 50, At(0, 0.75));
    world.AddCloth(1, btScalar(0.95), 31);
    bool right = world.Step(120);
    std::printf("the cloth lies on the slab: %d contacts\n", world.softSolver.getStatistics().contacts);

    const btVector3 middle(0, half.y(), 0);
    slab.sites = qcScatterSites(-half, half, 24, 1, &middle);
    right = right && world.Break(3, slab);
    right = right && world.Step(300);
    size_t landed = 0;
    for (size_t i = 3; i < world.meshes.size(); i++)
        landed += world.meshes[i].body->getWorldTransform().getOrigin().y() < btScalar(0.4);
    const btScalar lowest = world.Lowest(), depth = world.Depth();
    std::printf("it broke into %zu pieces, of which %zu fell to the floor\n", world.meshes.size() - 3, landed);
    std::printf("lowest point %.4f m above the floor; meshes %.4f m in each other; %d pairs of the cloth penetrate\n",
                double(lowest), double(depth), world.softSolver.getStatistics().remaining);
    return right && landed > 0 && lowest > 0 && depth < btScalar(0.02) ? 0 : 1;
}
