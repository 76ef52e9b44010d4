// The cloth of the main demo, 20 000 triangles over a round table: no two of them ever penetrate, it comes to rest, and
// slides off when it is pulled.
#include "cloth/world.h"

#include "support/check_ok.h"
#include "support/long_form.h"
#include "support/suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace
{
constexpr int s_shortSteps = 360, s_longSteps = 480, s_fallingStep = 60, s_pulledSteps = 240;

/// Root mean square of the speeds, from positions one step apart.
double SpeedBetween(const std::vector<float>& before, const std::vector<float>& after)
{
    double sum = 0;
    for (size_t i = 0; i < after.size(); i++)
        sum += std::pow((double(after[i]) - double(before[i])) / qcClothWorld::stepSeconds, 2);
    return std::sqrt(3 * sum / double(after.size()));
}

/// Counted by a new scene, without the solver's state.
size_t CountPenetratingCloth(qcClothWorld& cloth)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene;
    CHECK_OK(qcScene_Create(&sceneDef, &scene));
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = cloth.Positions().data();
    def.positionType = qc_positionF32;
    def.vertexCount = uint32_t(cloth.Positions().size() / 3);
    def.indices = cloth.Indices().data();
    def.triangleCount = uint32_t(cloth.Indices().size() / 3);
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    qcDetectDef request = qcDefaultDetectDef();
    request.method = qc_methodSweep;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &request, &result));
    size_t count = result->pairCount;
    qcScene_Destroy(scene);
    return count;
}
} // namespace

START_TEST(a_cloth_over_a_table_comes_to_rest_without_a_penetrating_pair)
{
    qcClothWorld cloth(20000, true, nullptr, qc_methodAuto, 0);
    ck_assert_uint_ge(cloth.Indices().size() / 3, 20000);
    std::vector<float> before;
    double falling = 0, speed = 0;
    int contacts = 0;
    const int steps = qcIsLongForm() ? s_longSteps : s_shortSteps;
    for (int step = 1; step <= steps; step++)
    {
        before = cloth.Positions();
        cloth.Step();
        const qcSoftBodyStatistics& statistics = cloth.Statistics();
        ck_assert_msg(statistics.status == qc_statusOk && statistics.remaining == 0, "step %d: %d pairs penetrate",
                      step, statistics.remaining);
        // All ten rounds: planes don't hold layers apart by themselves. No step takes more than six.
        ck_assert_int_lt(statistics.rounds, 8);
        if (step % s_fallingStep == 0)
            ck_assert_uint_eq(CountPenetratingCloth(cloth), 0);
        speed = SpeedBetween(before, cloth.Positions());
        falling = step == s_fallingStep ? speed : falling;
        contacts = statistics.contacts;
    }
    std::printf("falling %.2f m/s, at rest %.3f m/s, %d contacts\n", falling, speed, contacts);
    ck_assert_int_gt(contacts, 100);
    // Bullet's solver makes the cloth tremble: by 0.1 m/s without self-collision.
    ck_assert_double_lt(speed, falling / 10);
    // The second act of the demo: pulled at one edge it slides off the table, and falls.
    cloth.PullAway();
    for (int step = 1; step <= s_pulledSteps; step++)
    {
        cloth.Step();
        ck_assert_int_eq(cloth.Statistics().remaining, 0);
    }
    float highest = 0;
    for (size_t i = 1; i < cloth.Positions().size(); i += 3)
        highest = std::max(highest, cloth.Positions()[i]);
    ck_assert_double_lt(double(highest), double(qcClothTable::height) / 2);
}
END_TEST

QC_RUN_TESTS("cloth_rest", a_cloth_over_a_table_comes_to_rest_without_a_penetrating_pair)
