// The camera of the live window: what it sees, and where its rays go.
#include "view/camera.h"

#include <cmath>

#include "support/suite.h"

namespace
{
/// Clip-space position divided by w.
btVector3 Project(const qcViewCamera& camera, const btVector3& point, btScalar aspect)
{
    qcMatrix m = camera.ViewProjection(aspect, 10);
    double clip[4];
    for (size_t row = 0; row < 4; row++)
        clip[row] = double(m[row]) * double(point.x()) + double(m[4 + row]) * double(point.y()) +
                    double(m[8 + row]) * double(point.z()) + double(m[12 + row]);
    ck_assert_double_gt(clip[3], 0);
    return btVector3(btScalar(clip[0] / clip[3]), btScalar(clip[1] / clip[3]), btScalar(clip[2] / clip[3]));
}

qcViewCamera Placed()
{
    qcViewCamera camera;
    camera.Place(btVector3(3, 4, 5), btVector3(1, btScalar(0.5), -1));
    return camera;
}

START_TEST(the_eye_is_where_it_was_placed_and_the_target_in_the_middle)
{
    qcViewCamera camera = Placed();
    ck_assert_double_lt(double(camera.Eye().distance(btVector3(3, 4, 5))), 1e-5);
    btVector3 middle = Project(camera, camera.Target(), btScalar(1.6));
    ck_assert_double_lt(std::fabs(double(middle.x())) + std::fabs(double(middle.y())), 1e-5);
    // What is above the target is above the middle; what is to the right of it, to the right.
    ck_assert_double_gt(double(Project(camera, camera.Target() + btVector3(0, 1, 0), 1).y()), 0.05);
    ck_assert_double_gt(double(Project(camera, camera.Target() + btVector3(6, 0, -2), 1).x()), 0.05);
}
END_TEST

START_TEST(orbits_keep_the_distance_and_never_turn_over)
{
    qcViewCamera camera = Placed();
    btScalar distance = camera.Distance();
    for (int i = 0; i < 100; i++)
    {
        camera.Orbit(btScalar(0.3), btScalar(0.2));
        ck_assert_double_eq_tol(double(camera.Eye().distance(camera.Target())), double(distance), 1e-4);
        ck_assert_double_gt(double(Project(camera, camera.Target() + btVector3(0, btScalar(0.1), 0), 1).y()), 0);
    }
    camera.Zoom(btScalar(0.5));
    ck_assert_double_eq_tol(double(camera.Distance()), double(distance) / 2, 1e-5);
}
END_TEST

START_TEST(a_ray_goes_through_what_is_drawn_at_its_point)
{
    qcViewCamera camera = Placed();
    camera.Orbit(btScalar(0.7), btScalar(-0.2));
    const btScalar aspect = btScalar(1.6);
    for (const btVector3& point : {btVector3(0, 0, 0), btVector3(1, 2, btScalar(-0.5)), btVector3(-1, 0, 2)})
    {
        btVector3 seen = Project(camera, point, aspect), ray = camera.Ray(seen.x(), seen.y(), aspect);
        btVector3 arm = point - camera.Eye();
        ck_assert_double_lt(double((arm - ray * arm.dot(ray)).length()), 1e-3);
        ck_assert_double_gt(double(arm.dot(ray)), 0);
    }
}
END_TEST

START_TEST(panning_moves_what_is_seen_by_the_given_share_of_the_view)
{
    qcViewCamera camera = Placed();
    btVector3 before = camera.Target();
    camera.Pan(btScalar(0.25), btScalar(0.1));
    btVector3 seen = Project(camera, before, 1);
    // The view is 2 high.
    ck_assert_double_eq_tol(double(seen.x()), 0.5, 1e-4);
    ck_assert_double_eq_tol(double(seen.y()), 0.2, 1e-4);
}
END_TEST
} // namespace

QC_RUN_TESTS("view_camera", the_eye_is_where_it_was_placed_and_the_target_in_the_middle,
             orbits_keep_the_distance_and_never_turn_over, a_ray_goes_through_what_is_drawn_at_its_point,
             panning_moves_what_is_seen_by_the_given_share_of_the_view)
