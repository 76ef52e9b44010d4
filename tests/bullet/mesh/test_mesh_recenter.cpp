// A mesh whose origin isn't its centre of mass, recentred: place and free flight of the copy.
#include "bullet/mesh/mesh_world.h"

namespace
{
/// The prism over an L of 3 by 1 and 1 by 1, 0.5 thick: its centre of mass is at (1.25, 0.75, 0.25).
qcModel LModel()
{
    const double outline[6][2] = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
    const uint32_t cap[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}};
    qcModel model;
    for (double z : {0.0, 0.5})
        for (const double* corner : outline)
            model.Add(corner[0], corner[1], z);
    for (const uint32_t* t : cap)
    {
        model.Add(t[0], t[2], t[1]);
        model.Add(t[0] + 6, t[1] + 6, t[2] + 6);
    }
    for (uint32_t i = 0; i < 6; i++)
    {
        uint32_t j = (i + 1) % 6;
        model.Add(i, j, j + 6);
        model.Add(i, j + 6, i + 6);
    }
    return model;
}

START_TEST(a_recentered_copy_lies_where_the_mesh_does_with_its_mass_at_the_origin)
{
    auto shape = LModel().MakeShape(btScalar(0.02));
    shape->setLocalScaling(btVector3(1, 2, 1));
    btTransform frame;
    auto copy = shape->makeRecentered(&frame);
    ck_assert_double_lt(double(frame.getOrigin().distance(btVector3(btScalar(1.25), btScalar(1.5), btScalar(0.25)))),
                        1e-6);
    ck_assert(copy->getMargin() == shape->getMargin() && copy->getLocalScaling() == btVector3(1, 1, 1));
    ck_assert_uint_eq(copy->getVertexCount(), shape->getVertexCount());
    for (uint32_t v = 0; v < copy->getVertexCount(); v++)
        ck_assert_double_lt(double((frame * copy->getVertices()[v]).distance(shape->getVertices()[v])), 1e-6);
    ck_assert(std::equal(copy->getIndices(), copy->getIndices() + 3 * copy->getTriangleCount(), shape->getIndices()));
    qcMassProperties mass = copy->getMassProperties();
    ck_assert(mass.closed);
    ck_assert_double_lt(double(mass.center.length()), 1e-6);
    btVector3 inertia;
    copy->calculateLocalInertia(1, inertia);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            ck_assert_double_eq_tol(double(mass.inertia[i][j]), i == j ? double(inertia[i]) : 0, 1e-5);
}
END_TEST

START_TEST(a_mesh_without_triangles_has_a_recentered_copy_without_triangles)
{
    ck_assert_int_eq(qcModel().MakeShape()->makeRecentered()->getStatus(), qc_statusOk);
    qcModel bad = LModel();
    bad.indices[0] = 99;
    auto copy = bad.MakeShape()->makeRecentered();
    ck_assert_uint_eq(copy->getTriangleCount(), 0);
    ck_assert_int_eq(copy->getStatus(), qc_statusBadInput);
}
END_TEST

constexpr btScalar s_mass = 2, s_timeStep = btScalar(1.0 / 240);
constexpr int s_steps = 480;

/// A throw without damping, measured by the mesh's own mass properties.
struct Throw
{
    qcMeshWorld world;
    qcMassProperties mass;
    btRigidBody* body;
    btVector3 start, velocity; ///< of the centre of mass
    double farthest = 0;       ///< from the parabola
    double energies[2];
    btVector3 momenta[2]; ///< angular, about the centre

    Throw(std::unique_ptr<qcMeshShape> shape, const btTransform& place)
    {
        mass = shape->getMassProperties();
        body = world.Add(world.Keep(std::move(shape)), s_mass, place);
        body->setActivationState(DISABLE_DEACTIVATION);
        body->setAngularVelocity(btVector3(3, 1, 2));
        // Equal motions, whichever point of the mesh is the body's origin.
        btVector3 arm = Centre() - body->getCenterOfMassPosition();
        body->setLinearVelocity(btVector3(4, 6, -2) - body->getAngularVelocity().cross(arm));
        start = Centre();
        velocity = btVector3(4, 6, -2);
        btVector3 before = start;
        for (int i = 1; i <= s_steps; i++)
        {
            world.world.stepSimulation(s_timeStep, 0);
            btScalar time = btScalar(i) * s_timeStep;
            // Semi-implicit Euler steps: t (t + dt) for t^2.
            btVector3 there = start + velocity * time + world.world.getGravity() * (time * (time + s_timeStep) / 2);
            farthest = std::max(farthest, double(Centre().distance(there)));
            Measure(i == 1 ? 0 : 1, (Centre() - before) / s_timeStep);
            before = Centre();
        }
    }

    btVector3 Centre() const
    {
        return body->getWorldTransform() * mass.center;
    }

    /// Energy, and the angular momentum about the centre, by the mesh's own tensor.
    void Measure(int at, const btVector3& centreVelocity)
    {
        const btMatrix3x3& turn = body->getWorldTransform().getBasis();
        btMatrix3x3 tensor = turn * mass.inertia.scaled(btVector3(s_mass, s_mass, s_mass)) * turn.transpose();
        btVector3 spin = body->getAngularVelocity(), momentum = tensor * spin;
        btScalar height = Centre().y() * -world.world.getGravity().y();
        energies[at] = double(spin.dot(momentum) / 2 + s_mass * (centreVelocity.length2() / 2 + height));
        momenta[at] = momentum;
    }
};

START_TEST(a_recentered_body_in_free_flight_keeps_energy_and_angular_momentum_on_a_parabola)
{
    auto shape = LModel().MakeShape();
    btTransform frame, place(btQuaternion(1, 2, 3, 4).normalized(), btVector3(5, 6, 7));
    auto copy = shape->makeRecentered(&frame);
    Throw flight(std::move(copy), place * frame);
    ck_assert_double_lt(flight.farthest, 1e-3);
    ck_assert_double_lt(double(flight.momenta[1].distance(flight.momenta[0])),
                        0.01 * double(flight.momenta[0].length()));
    ck_assert_double_eq_tol(flight.energies[1], flight.energies[0], 0.01 * flight.energies[0]);
    // Not recentred, its centre moves around the origin, and the measures above detect it.
    Throw wobble(std::move(shape), place);
    ck_assert(flight.start.distance(wobble.start) < btScalar(1e-5));
    ck_assert_double_gt(wobble.farthest, 1);
    ck_assert_double_gt(std::fabs(wobble.energies[1] / wobble.energies[0] - 1), 0.1);
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_recenter", a_recentered_copy_lies_where_the_mesh_does_with_its_mass_at_the_origin,
             a_mesh_without_triangles_has_a_recentered_copy_without_triangles,
             a_recentered_body_in_free_flight_keeps_energy_and_angular_momentum_on_a_parabola)
