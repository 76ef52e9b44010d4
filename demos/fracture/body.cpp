// Models and pieces as rigid bodies.
#include "fracture/body.h"

#include "common/bullet/mesh_body.h"
#include "common/mesh_io/bounds.h"
#include "common/mesh_io/decimate.h"
#include "common/mesh_io/mesh_file.h"

#include <algorithm>

namespace
{
// Metres. Pieces of one body begin with overlapping margins: thin ones separate gently.
constexpr btScalar s_margin = btScalar(0.001);

btRigidBody::btRigidBodyConstructionInfo Material(btScalar mass, btCollisionShape* shape, const btVector3& inertia,
                                                  const btTransform& place)
{
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform = place;
    info.m_friction = btScalar(0.8); // Bullet multiplies those of both bodies: 0.64 is stone on stone
    info.m_rollingFriction = btScalar(0.01);
    return info;
}

void TakePositions(const qcMesh& mesh, btScalar extent, qcFractureModel* model)
{
    double lower[3], upper[3];
    double longest = qcMesh_FindBox(&mesh, 1, lower, upper);
    double scale = longest > 0 ? double(extent) / longest : 1;
    model->vertices.resize(mesh.vertexCount);
    for (size_t i = 0; i < mesh.vertexCount; i++)
    {
        double p[3];
        qcMesh_GetVertex(&mesh, i, p);
        for (int axis = 0; axis < 3; axis++)
            model->vertices[i][axis] = btScalar((p[axis] - lower[axis]) * scale);
        model->vertices[i][3] = 0;
    }
    model->indices.assign(mesh.indices, mesh.indices + 3 * size_t(mesh.triangleCount));
}

/// Flips the triangles of a mesh that is wound clockwise seen from outside.
void FaceOutwards(qcFractureModel* model)
{
    double volume = 0;
    auto corner = [model](size_t i) { return model->vertices[model->indices[i]]; };
    for (size_t i = 0; i < model->indices.size(); i += 3)
        volume += double(corner(i).dot(corner(i + 1).cross(corner(i + 2))));
    for (size_t i = 0; i < model->indices.size() && volume < 0; i += 3)
        std::swap(model->indices[i], model->indices[i + 1]);
}
} // namespace

bool qcReadFractureModel(const std::string& path, uint32_t triangleCount, btScalar extent, qcFractureModel* model,
                         std::string* message)
{
    qcMesh mesh;
    qcMessage failure;
    if (!qcMesh_ReadFile(path.c_str(), qc_meshAsDeclared, &mesh, &failure))
    {
        *message = failure.text;
        return false;
    }
    // Vertices are only merged: a closed mesh stays closed.
    qcMesh coarse;
    if (mesh.triangleCount > triangleCount && qcMesh_Decimate(&mesh, triangleCount, &coarse))
    {
        qcMesh_Free(&mesh);
        mesh = coarse;
    }
    TakePositions(mesh, extent, model);
    qcMesh_Free(&mesh);
    FaceOutwards(model);
    qcMassProperties mass =
        qcMeshShape(model->vertices.data(), qcBulletPositions, sizeof(btVector3), uint32_t(model->vertices.size()),
                    model->indices.data(), uint32_t(model->indices.size() / 3))
            .getMassProperties();
    if (!mass.closed)
    {
        *message = path + ": the mesh is not closed: there is no inside to break";
        return false;
    }
    model->volume = btScalar(mass.volume);
    model->inertia = mass.principalInertia;
    model->upright = mass.principalFrame.getBasis();
    btTransform inward = mass.principalFrame.inverse();
    for (btVector3& vertex : model->vertices)
        vertex = inward * vertex;
    return true;
}

qcFractureBody::qcFractureBody(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices,
                               uint32_t firstOfCuts, btScalar mass, const btVector3& inertia, const btTransform& place)
    : shape(vertices.data(), qcBulletPositions, sizeof(btVector3), uint32_t(vertices.size()), indices.data(),
            uint32_t(indices.size() / 3)),
      body(Material(mass, &shape, mass * inertia, place)), firstCutTriangle(firstOfCuts)
{
    shape.setMargin(s_margin);
}

void qcFractureBody::UseHull()
{
    hull.reset(new btConvexHullShape(*shape.getVertices(), int(shape.getVertexCount()), sizeof(btVector3)));
    hull->optimizeConvexHull();
    hull->setMargin(s_margin);
    body.setCollisionShape(hull.get());
}

btVector3 qcFractureBody::LowestVertex() const
{
    btVector3 down = body.getWorldTransform().getBasis()[1];
    const btVector3* vertices = shape.getVertices();
    return *std::min_element(vertices, vertices + shape.getVertexCount(),
                             [&](const btVector3& a, const btVector3& b) { return down.dot(a) < down.dot(b); });
}

btScalar qcFractureBody::Lowest() const
{
    return (body.getWorldTransform() * LowestVertex()).y();
}

double qcFractureBody::KineticEnergy() const
{
    btVector3 spin = body.getAngularVelocity();
    btMatrix3x3 inertia = body.getInvInertiaTensorWorld().inverse();
    return 0.5 *
           (double(body.getMass()) * double(body.getLinearVelocity().length2()) + double(spin.dot(inertia * spin)));
}

void qcFractureBody::AddMomentum(qcMomentum* sum) const
{
    btVector3 linear = body.getLinearVelocity() * body.getMass();
    sum->linear += linear;
    sum->angular += body.getInvInertiaTensorWorld().inverse() * body.getAngularVelocity() +
                    body.getWorldTransform().getOrigin().cross(linear);
}

qcTransform qcFractureBody::Place() const
{
    return qcBodyTransformOf(body.getWorldTransform());
}

qcStatus qcFractureBody::AddTo(qcScene* scene, qcBodyId* id) const
{
    qcBodyDef def = qcMeshBodyDef(shape, body.getWorldTransform());
    return qcScene_AddBody(scene, &def, id);
}
