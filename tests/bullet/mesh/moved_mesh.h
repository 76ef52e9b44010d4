// A mesh whose triangles the application moves between steps.
#ifndef QC_TESTS_BULLET_MESH_MOVED_MESH_H
#define QC_TESTS_BULLET_MESH_MOVED_MESH_H

#include "bullet/mesh/mesh_models.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>

#include <functional>
#include <random>

/// Where a step of the motion has a vertex.
using qcVertexMotion = std::function<btVector3(const btVector3& start, int step)>;

/// A qcMeshShape, which is replaced, or a mesh of Bullet, which is refitted.
struct qcMovedMesh
{
    const qcModel first;
    qcModel model; ///< where the triangles are
    std::unique_ptr<btTriangleIndexVertexArray> triangles;
    std::unique_ptr<btCollisionShape> shape;

    qcMovedMesh(const qcModel& made, bool isBullets) : first(made), model(made)
    {
        if (isBullets)
        {
            triangles = model.MakeInterface();
            shape.reset(new btBvhTriangleMeshShape(triangles.get(), true));
            shape->setMargin(btScalar(0.01));
        }
        else
            shape = model.MakeShape();
    }

    /// Gives the body the triangles of `model`. The previous qcMeshShape is gone when the next step begins.
    template <class Contact> void Reshape(btCollisionObject* object, btCollisionWorld* world, Contact* contact)
    {
        if (triangles != nullptr)
        {
            auto* mesh = static_cast<btBvhTriangleMeshShape*>(shape.get());
            mesh->refitTree(btVector3(-100, -100, -100), btVector3(100, 100, 100));
            mesh->recalcLocalAabb();
            contact->updateShape(mesh);
        }
        else
        {
            shape = model.MakeShape();
            object->setCollisionShape(shape.get());
        }
        world->updateSingleAabb(object);
    }

    template <class Contact>
    void Move(const qcVertexMotion& motion, int step, btCollisionObject* object, btCollisionWorld* world,
              Contact* contact)
    {
        for (size_t i = 0; i < model.positions.size(); i += 3)
        {
            const btVector3 moved =
                motion(btVector3(first.positions[i], first.positions[i + 1], first.positions[i + 2]), step);
            for (int axis = 0; axis < 3; axis++)
                model.positions[i + size_t(axis)] = moved[axis];
        }
        Reshape(object, world, contact);
    }
};

/// Rises by the same in each step.
inline qcVertexMotion qcLift(btScalar rise)
{
    return [rise](const btVector3& start, int step) { return start + btVector3(0, rise * btScalar(step + 1), 0); };
}

/// A wave that grows to a height of 0.2, and jumps by two thirds of its half length in a step.
inline qcVertexMotion qcWave()
{
    return [](const btVector3& start, int step)
    {
        const btScalar amplitude = btScalar(0.02) * btScalar(std::min(step, 10));
        return start + btVector3(0, amplitude * btSin(3 * start.x() + 2 * btScalar(step)), 0);
    };
}

/// A cone that is there at once.
inline qcVertexMotion qcSpike(btScalar height)
{
    return [height](const btVector3& start, int)
    { return start + btVector3(0, std::max(btScalar(0), height - start.length()), 0); };
}

/// Other heights in each step, for each vertex.
inline qcVertexMotion qcNoise(btScalar height)
{
    auto random = std::make_shared<std::mt19937>(1);
    return [random, height](const btVector3& start, int)
    { return start + btVector3(0, std::uniform_real_distribution<btScalar>(-height, height)(*random), 0); };
}

/// A bar along x, from -1.5 to 1.5, that bends by half a metre a step through the plane z = 0.
inline qcModel qcBarModel()
{
    return qcBoxModel(btVector3(btScalar(1.5), btScalar(0.1), btScalar(0.1)), 6);
}

inline qcVertexMotion qcBend()
{
    return [](const btVector3& start, int step)
    {
        const btScalar place = btScalar(-1.25) + btScalar(0.5) * btScalar(std::min(step, 4));
        return start + btVector3(0, 0, btScalar(-0.75) + (place + btScalar(0.75)) * (start.x() + btScalar(1.5)) / 3);
    };
}

#endif
