// Mass properties of meshes of any size and place: those of a box, or 0 and a status where a type can't hold them.
#include "quickcullide/bullet_mesh.h"

#include "bullet/mesh/mesh_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
const bool s_isFloat = sizeof(btScalar) == sizeof(float);
// Moments of a box of mass 1 with sides of 1, 2 and 3, ascending.
const double s_moments[3] = {5.0 / 12, 10.0 / 12, 13.0 / 12};

qcModel BoxAt(double scale, double x, double y, double z)
{
    qcModel model = qcBoxModel(btVector3(btScalar(0.5), 1, btScalar(1.5)), 2);
    const double place[3] = {x, y, z};
    for (size_t i = 0; i < model.positions.size(); i++)
        model.positions[i] = btScalar(double(model.positions[i]) * scale + place[i % 3]);
    return model;
}

void CheckMoments(const btVector3& moments, double unit, double tolerance)
{
    std::array<double, 3> sorted = {double(moments[0]) / unit, double(moments[1]) / unit, double(moments[2]) / unit};
    std::sort(sorted.begin(), sorted.end());
    for (size_t i = 0; i < 3; i++)
        ck_assert_double_eq_tol(sorted[i], s_moments[i], tolerance);
}

void CheckVolume(const qcMassProperties& mass, double scale)
{
    ck_assert(mass.closed);
    ck_assert_double_eq_tol(mass.volume / scale / scale / scale, 6, 1e-5);
    ck_assert_double_eq_tol(mass.area / scale / scale, 22, 1e-5);
}
} // namespace

START_TEST(boxes_of_any_size_have_the_mass_properties_of_a_box)
{
    int last = s_isFloat ? 18 : 100;
    for (int exponent = -last; exponent <= last; exponent += 2)
    {
        double scale = std::pow(10, exponent);
        auto shape = BoxAt(scale, 0, 0, 0).MakeShape();
        qcMassProperties mass = shape->getMassProperties();
        ck_assert_int_eq(mass.status, qc_statusOk);
        CheckVolume(mass, scale);
        CheckMoments(mass.principalInertia, scale * scale, 1e-5);
        btVector3 inertia;
        shape->calculateLocalInertia(3, inertia);
        CheckMoments(inertia, 3 * scale * scale, 1e-5);
    }
}
END_TEST

START_TEST(moments_that_a_btscalar_can_not_hold_are_0_with_a_status)
{
    double far = s_isFloat ? 1e25 : 1e160;
    for (double scale : {far, 1 / far})
    {
        auto shape = BoxAt(scale, 0, 0, 0).MakeShape();
        qcMassProperties mass = shape->getMassProperties();
        ck_assert_int_eq(mass.status, qc_statusBadInput);
        ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "is out of range"));
        ck_assert(mass.closed);
        if (s_isFloat)
            CheckVolume(mass, scale);
        else
            ck_assert(mass.volume == 0 && mass.area == 0);
        for (int i = 0; i < 3; i++)
        {
            ck_assert(mass.principalInertia[i] == 0);
            ck_assert(mass.inertia[i] == btVector3(0, 0, 0));
        }
        ck_assert_double_eq_tol(double(mass.principalFrame.getBasis().determinant()), 1, 1e-5);
        btVector3 inertia;
        shape->calculateLocalInertia(1, inertia);
        ck_assert(inertia == btVector3(0, 0, 0));
        // With a mass that compensates, btScalar can hold them.
        shape->calculateLocalInertia(btScalar(1 / scale), inertia);
        CheckMoments(inertia, scale, 1e-5);
    }
}
END_TEST

START_TEST(a_box_far_from_its_origin_has_the_mass_properties_of_that_box)
{
    for (double distance : {1e2, 1e5, 1e6, 1e9, 1e12})
    {
        if (s_isFloat && distance > 1e6)
            continue;
        // At 1e6 halves are multiples of a float's resolution, at 1e12 of a double's.
        qcMassProperties mass = BoxAt(1, distance, -distance, 2 * distance).MakeShape()->getMassProperties();
        ck_assert_int_eq(mass.status, qc_statusOk);
        CheckVolume(mass, 1);
        CheckMoments(mass.principalInertia, 1, 1e-5);
        ck_assert_double_eq_tol(double(mass.center[2]), 2 * distance, 1e-6 * distance);
    }
}
END_TEST

START_TEST(a_mesh_that_is_partly_inside_out_has_the_mass_properties_of_a_shell)
{
    // The signed volumes, 6 and -3, put the centre of mass at x = -4: outside, with negative moments about it.
    qcModel model = BoxAt(1, 0, 0, 0), other = BoxAt(std::cbrt(0.5), 4, 0, 0);
    uint32_t offset = uint32_t(model.positions.size() / 3);
    model.positions.insert(model.positions.end(), other.positions.begin(), other.positions.end());
    for (size_t i = 0; i < other.indices.size(); i += 3)
        model.Add(offset + other.indices[i], offset + other.indices[i + 2], offset + other.indices[i + 1]);
    auto shape = model.MakeShape();
    qcMassProperties mass = shape->getMassProperties();
    ck_assert_int_eq(mass.status, qc_statusOk);
    ck_assert(!mass.closed);
    ck_assert_double_eq_tol(double(mass.center.x()), 4 * std::cbrt(0.25) / (1 + std::cbrt(0.25)), 1e-5);
    btVector3 inertia;
    shape->makeRecentered()->calculateLocalInertia(1, inertia);
    for (int i = 0; i < 3; i++)
        ck_assert(mass.principalInertia[i] > 0 && inertia[i] > 0);
}
END_TEST

START_TEST(the_margin_of_a_tiny_mesh_is_a_quarter_of_its_mean_edge)
{
    qcModel one = BoxAt(1, 0, 0, 0), tiny = BoxAt(1e-25, 0, 0, 0);
    auto marginOf = [](const qcModel& model)
    {
        return double(qcMeshShape(model.positions.data(), s_isFloat ? qc_positionF32 : qc_positionF64, 0,
                                  uint32_t(model.positions.size() / 3), model.indices.data(), model.TriangleCount())
                          .getMargin());
    };
    ck_assert_double_eq_tol(marginOf(one), 0.01, 1e-8);
    // Edges are 0.25 to 2.1 long.
    ck_assert_double_gt(marginOf(tiny), 0.25e-25 / 4);
    ck_assert_double_lt(marginOf(tiny), 2.1e-25 / 4);
}
END_TEST

QC_RUN_TESTS("mesh mass", boxes_of_any_size_have_the_mass_properties_of_a_box,
             moments_that_a_btscalar_can_not_hold_are_0_with_a_status,
             a_box_far_from_its_origin_has_the_mass_properties_of_that_box,
             a_mesh_that_is_partly_inside_out_has_the_mass_properties_of_a_shell,
             the_margin_of_a_tiny_mesh_is_a_quarter_of_its_mean_edge)
