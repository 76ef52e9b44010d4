// Bullet's own shapes, each with triangles made apart from the library: exact where the shape has flat faces, with
// corners on the surface where it is curved.
#ifndef QC_TESTS_BULLET_SOFT_BODY_SHAPE_MODELS_H
#define QC_TESTS_BULLET_SOFT_BODY_SHAPE_MODELS_H

#include "bullet/mesh/mesh_models.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <btBulletCollisionCommon.h>

/// A shape about one metre in size, whose highest point is near the origin's height plus `top`.
struct qcShapeModel
{
    const char* name;
    btScalar top;
    std::unique_ptr<btCollisionShape> shape;
    qcModel model; ///< in the shape's frame

    std::vector<std::unique_ptr<btCollisionShape>> children;
    std::unique_ptr<btTriangleIndexVertexArray> triangles;
    std::vector<btScalar> heights;
};

inline void qcAddModel(qcModel* model, qcModel other, const btTransform& transform)
{
    other.Move(transform);
    model->Append(other);
}

inline qcModel qcCapsuleModel(double radius, double half)
{
    std::vector<std::pair<double, double>> circles;
    for (int i = -12; i <= 12; i++)
    {
        double angle = qcPi * i / 24;
        circles.emplace_back(radius * std::cos(angle), radius * std::sin(angle) + (i < 0 ? -half : half));
    }
    return qcRevolvedModel(circles, 48);
}

enum qcShapeKind
{
    qc_shapeSphere,
    qc_shapeBox,
    qc_shapeTiltedBox,
    qc_shapeCapsule,
    qc_shapeThinCapsule,
    qc_shapeThinCylinder,
    qc_shapeCylinder,
    qc_shapeCone,
    qc_shapeHull,
    qc_shapeMultiSphere,
    qc_shapeCompound,
    qc_shapeMesh,
    qc_shapePlane,
    qc_shapeTiltedPlane,
    qc_shapeHeightfield,
    qc_shapeCount
};

inline void qcMakeCompound(qcShapeModel* made)
{
    auto* compound = new btCompoundShape;
    made->shape.reset(compound);
    auto add = [&](btCollisionShape* child, const qcModel& model, const btTransform& place)
    {
        made->children.emplace_back(child);
        compound->addChildShape(place, child);
        qcAddModel(&made->model, model, place);
    };
    const btQuaternion turn(btVector3(1, 2, 3).normalized(), btScalar(0.7));
    add(new btBoxShape(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.1))),
        qcBoxModel(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.1)), 1),
        btTransform(turn, btVector3(btScalar(-0.4), 0, 0)));
    add(new btSphereShape(btScalar(0.2)), qcSphereModel(0.2, 3),
        btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.4), 0, 0)));
    add(new btCapsuleShapeZ(btScalar(0.05), btScalar(0.8)), qcCapsuleModel(0.05, 0.4),
        btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(0.1))));
}

inline void qcMakeHeightfield(qcShapeModel* made)
{
    // Waves of 20 cm, and a floor of triangles in Bullet's order of diagonals.
    const int side = 41;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++)
        {
            double h = 0.1 * std::sin(0.6 * i) * std::cos(0.5 * j);
            made->heights.push_back(btScalar(h));
        }
    auto* field = new btHeightfieldTerrainShape(side, side, made->heights.data(), 1, btScalar(-0.1), btScalar(0.1), 1,
                                                sizeof(btScalar) == sizeof(double) ? PHY_DOUBLE : PHY_FLOAT, false);
    made->shape.reset(field);
    field->setLocalScaling(btVector3(btScalar(0.1), 1, btScalar(0.1)));
    const uint32_t n = side;
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t i = 0; i < n; i++)
            made->model.Add((i - (n - 1) / 2.0) * 0.1, double(made->heights[j * n + i]), (j - (n - 1) / 2.0) * 0.1);
    for (uint32_t j = 0; j + 1 < n; j++)
        for (uint32_t i = 0; i + 1 < n; i++)
        {
            uint32_t a = j * n + i;
            made->model.Add(a, a + n, a + 1);
            made->model.Add(a + 1, a + n, a + n + 1);
        }
}

/// Thin poles have a radius of 1 cm.
inline qcShapeModel qcMakeShape(qcShapeKind kind)
{
    qcShapeModel made;
    const btQuaternion turn(btVector3(1, 2, 3).normalized(), btScalar(0.9));
    const double thin = 0.01;
    switch (kind)
    {
        case qc_shapeSphere:
            made.name = "sphere";
            made.top = btScalar(0.5);
            made.shape.reset(new btSphereShape(btScalar(0.5)));
            made.model = qcSphereModel(0.5, 4);
            break;
        case qc_shapeBox:
            made.name = "box";
            made.top = btScalar(0.3);
            made.shape.reset(new btBoxShape(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.5))));
            made.model = qcBoxModel(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.5)), 1);
            break;
        case qc_shapeTiltedBox:
        {
            made.name = "tilted box";
            made.top = btScalar(0.6);
            auto* compound = new btCompoundShape;
            made.shape.reset(compound);
            made.children.emplace_back(new btBoxShape(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.5))));
            compound->addChildShape(btTransform(turn), made.children[0].get());
            qcAddModel(&made.model, qcBoxModel(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.5)), 1),
                       btTransform(turn));
            break;
        }
        case qc_shapeCapsule:
            made.name = "capsule";
            made.top = btScalar(0.2);
            made.shape.reset(new btCapsuleShapeZ(btScalar(0.2), btScalar(0.6)));
            made.model = qcCapsuleModel(0.2, 0.3);
            break;
        case qc_shapeThinCapsule:
            made.name = "thin capsule";
            made.top = btScalar(thin);
            made.shape.reset(new btCapsuleShapeZ(btScalar(thin), 3));
            made.model = qcCapsuleModel(thin, 1.5);
            break;
        case qc_shapeThinCylinder:
            made.name = "thin cylinder";
            made.top = btScalar(thin);
            made.shape.reset(new btCylinderShapeZ(btVector3(btScalar(thin), btScalar(thin), btScalar(1.5))));
            made.model = qcCylinderModel(thin, 1.5, 48);
            break;
        case qc_shapeCylinder:
            made.name = "cylinder";
            made.top = btScalar(0.3);
            made.shape.reset(new btCylinderShapeZ(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3))));
            made.model = qcCylinderModel(0.3, 0.3, 48);
            break;
        case qc_shapeCone:
            made.name = "cone";
            made.top = btScalar(0.4);
            made.shape.reset(new btConeShape(btScalar(0.4), btScalar(0.8)));
            made.model = qcRevolvedModel({{0, -0.4}, {0.4, -0.4}, {0, 0.4}}, 48);
            made.model.Move(btTransform(btQuaternion(btVector3(1, 0, 0), -SIMD_HALF_PI)));
            break;
        case qc_shapeHull:
        {
            made.name = "hull";
            made.top = btScalar(0.5);
            made.model = qcSphereModel(0.5, 0);
            auto* hull = new btConvexHullShape;
            made.shape.reset(hull);
            for (size_t i = 0; i < made.model.positions.size(); i += 3)
                hull->addPoint(
                    btVector3(made.model.positions[i], made.model.positions[i + 1], made.model.positions[i + 2]));
            break;
        }
        case qc_shapeMultiSphere:
        {
            made.name = "multisphere";
            made.top = btScalar(0.3);
            const btVector3 centers[2] = {btVector3(0, 0, btScalar(-0.3)), btVector3(0, 0, btScalar(0.3))};
            const btScalar radii[2] = {btScalar(0.3), btScalar(0.1)};
            made.shape.reset(new btMultiSphereShape(centers, radii, 2));
            qcAddModel(&made.model, qcSphereModel(0.3, 3), btTransform(btQuaternion::getIdentity(), centers[0]));
            qcAddModel(&made.model, qcSphereModel(0.1, 3), btTransform(btQuaternion::getIdentity(), centers[1]));
            break;
        }
        case qc_shapeCompound:
            made.name = "compound";
            made.top = btScalar(0.3);
            qcMakeCompound(&made);
            break;
        case qc_shapeMesh:
        {
            made.name = "btBvhTriangleMeshShape";
            made.top = btScalar(0.15);
            made.model = qcTorusModel(0.5, 0.15, 24, 12);
            made.triangles = made.model.MakeInterface();
            made.shape.reset(new btBvhTriangleMeshShape(made.triangles.get(), true));
            break;
        }
        case qc_shapePlane:
        case qc_shapeTiltedPlane:
        {
            made.name = kind == qc_shapePlane ? "plane" : "tilted plane";
            made.top = btScalar(kind == qc_shapePlane ? 0.1 : 0.5);
            btVector3 normal =
                kind == qc_shapePlane ? btVector3(0, 1, 0) : btVector3(btScalar(0.3), 1, btScalar(0.2)).normalized();
            made.shape.reset(new btStaticPlaneShape(normal, btScalar(0.1)));
            made.model = qcFloorModel(40, 2);
            made.model.Move(btTransform(shortestArcQuat(btVector3(0, 1, 0), normal), normal * btScalar(0.1)));
            break;
        }
        case qc_shapeHeightfield:
            made.name = "heightfield";
            made.top = btScalar(0.1);
            qcMakeHeightfield(&made);
            break;
        default: break;
    }
    return made;
}

#endif
