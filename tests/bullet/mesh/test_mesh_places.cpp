// The search for a mesh of an object by its place, against a search through all.
#include "mesh_contact/scene/mesh_places.h"

#include "bullet/random_numbers.h"

#include <limits>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr btScalar s_distance = btScalar(0.001);

/// The first origin within a distance of the place.
size_t FindFirst(const std::vector<btVector3>& origins, const btVector3& place, btScalar distance)
{
    size_t i = 0;
    while (i < origins.size() && origins[i].distance(place) > distance)
        i++;
    return i;
}

START_TEST(the_first_mesh_near_a_place_is_found)
{
    qcRandomNumbers random(3);
    int found = 0;
    for (int run = 0; run < 400; run++)
    {
        const size_t count = size_t(run) % 200;
        const double size = run % 4 == 0 ? 0.01 : run % 4 == 1 ? 1 : run % 4 == 2 ? 1000 : 1e30;
        std::vector<btVector3> origins;
        for (size_t i = 0; i < count; i++)
            origins.push_back(i % 7 == 6 ? origins[i / 2] : random.Vector(size));
        const qcMeshPlaces places(origins, s_distance);
        // Searches reach as far as cells were made for, less far, and much further.
        for (const btScalar distance : {s_distance, s_distance / 10, 100 * s_distance, btScalar(size)})
            for (size_t i = 0; i <= count; i++)
            {
                const btVector3 near = i < count ? origins[i] : random.Vector(size);
                const btVector3 place = near + random.Vector(0.7 * double(distance));
                auto isNear = [&](size_t index) { return origins[index].distance(place) <= distance; };
                const size_t first = FindFirst(origins, place, distance);
                ck_assert_uint_eq(places.FindFirst(place, distance, isNear), first);
                found += first < count;
            }
    }
    ck_assert_int_gt(found, 50000);
}
END_TEST

START_TEST(places_without_a_distance_or_that_are_not_finite_are_compared)
{
    std::vector<btVector3> origins(40, btVector3(1, 2, 3));
    origins[20].setX(BT_LARGE_FLOAT);
    auto isThere = [&](size_t index) { return index >= 15; };
    ck_assert_uint_eq(qcMeshPlaces(origins, 0).FindFirst(origins[0], 0, isThere), 15);
    ck_assert_uint_eq(qcMeshPlaces().FindFirst(origins[0], 1, isThere), 0);
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    origins[17].setY(nan);
    const qcMeshPlaces places(origins, s_distance);
    ck_assert_uint_eq(places.FindFirst(btVector3(nan, 0, 0), s_distance, [](size_t) { return false; }), 40);
    ck_assert_uint_eq(places.FindFirst(origins[0], nan, isThere), 15);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_places");
    tcase_add_test(tests, the_first_mesh_near_a_place_is_found);
    tcase_add_test(tests, places_without_a_distance_or_that_are_not_finite_are_compared);
    return qcRunCase("mesh_places", tests);
}
