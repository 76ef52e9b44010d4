// A rigid mesh: a model from a file that is going to break, or a piece of it.
#ifndef QC_DEMOS_FRACTURE_BODY_H
#define QC_DEMOS_FRACTURE_BODY_H

#include "quickcullide/bullet_fracture.h"
#include "quickcullide/bullet_mesh.h"

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

/// A closed mesh, its centre of mass at the origin and its principal axes along the axes of its frame.
struct qcFractureModel
{
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices;
    btScalar volume = 0;
    btVector3 inertia{0, 0, 0};                       ///< moments for mass 1
    btMatrix3x3 upright = btMatrix3x3::getIdentity(); ///< rotation to its orientation in the file
};

/// Reads a PLY or OBJ file, scales it to a length of `extent`, and decimates it if it has more than `triangleCount`
/// triangles. False with a message: it can't be read, or has no inside.
bool qcReadFractureModel(const std::string& path, uint32_t triangleCount, btScalar extent, qcFractureModel* model,
                         std::string* message);

/// Momentum and angular momentum about the world's origin.
struct qcMomentum
{
    btVector3 linear{0, 0, 0}, angular{0, 0, 0};
};

ATTRIBUTE_ALIGNED16(struct) qcFractureBody
{
    BT_DECLARE_ALIGNED_ALLOCATOR();

    /// Triangles from `firstOfCuts` on are faces of cuts. `inertia`: moments for mass 1.
    qcFractureBody(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices, uint32_t firstOfCuts,
                   btScalar mass, const btVector3& inertia, const btTransform& place);

    /// Collides as the convex hull of its vertices from now on.
    void UseHull();
    /// In the body's frame.
    btVector3 LowestVertex() const;
    /// Height of its lowest vertex.
    btScalar Lowest() const;
    double KineticEnergy() const;
    void AddMomentum(qcMomentum * sum) const;
    qcTransform Place() const; ///< its current transform
    /// Adds the mesh to a scene at its current transform, without self-collision.
    qcStatus AddTo(qcScene * scene, qcBodyId * id) const;

    qcMeshShape shape;
    std::unique_ptr<btConvexHullShape> hull; ///< null: it collides as a mesh
    btRigidBody body;
    uint32_t firstCutTriangle;
    std::vector<uint32_t> cuts; ///< for each triangle from there on, the number of its cut
};

#endif
