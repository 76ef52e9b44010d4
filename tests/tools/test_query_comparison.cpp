// Bodies come, move and go while the demos compare methods on them.
#include "common/bullet/query_comparison.h"

#include "support/suite.h"

#include <vector>

namespace
{
const std::vector<float> s_flat = {0, 0, 0, 4, 0, 0, 0, 4, 0};
const std::vector<float> s_crossing = {1, 1, -1, 1.3f, 1.8f, 1, 2, 1, 1};
const std::vector<float> s_apart = {1, 1, 2, 1.3f, 1.8f, 4, 2, 1, 4};
const uint32_t s_indices[3] = {0, 1, 2};

class Comparison
{
  public:
    Comparison()
    {
        qcDeviceDef def = qcDefaultDeviceDef();
        ck_assert_int_eq(qcDevice_Create(&def, &m_device), qc_statusOk);
        qcDetectDef request = qcDefaultDetectDef();
        request.resolution = 64;
        // Seen along x or y, the flat triangle has no pixels.
        request.views[0] = 'z';
        request.views[1] = 0;
        compared = new qcQueryComparison(m_device, request);
    }
    ~Comparison()
    {
        delete compared;
        qcDevice_Destroy(m_device);
    }
    qcBodyId Add(const std::vector<float>& positions, bool deforming)
    {
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = positions.data();
        def.vertexCount = 3;
        def.indices = s_indices;
        def.triangleCount = 1;
        def.deforming = deforming;
        qcBodyId id;
        Check(compared->Add(def, &id));
        return id;
    }
    void Check(bool done) const
    {
        ck_assert_msg(done, "%s", compared->Message().c_str());
    }

    qcQueryComparison* compared;

  private:
    qcDevice* m_device = nullptr;
};
} // namespace

START_TEST(a_query_that_runs_late_has_all_changes)
{
    Comparison test;
    qcQueryComparison& compared = *test.compared;
    qcBodyId flat = test.Add(s_flat, false), cloth = test.Add(s_apart, true);
    test.Check(compared.Warm());
    qcQueryResults results;
    test.Check(compared.RunEachStep(&results));
    ck_assert_uint_eq(results[qc_querySweep].found, 0);

    // The slot of a body that is gone is taken by another one, and both bodies move.
    test.Check(compared.Remove(flat));
    ck_assert(!compared.SetTransform(flat, qcIdentityTransform()));
    ck_assert(compared.Marked(qc_querySweep, flat).empty());
    qcBodyId again = test.Add(s_flat, false);
    qcTransform down = qcIdentityTransform();
    down.translation[2] = -0.5;
    test.Check(compared.SetTransform(again, down));
    test.Check(compared.SetVertices(cloth, s_crossing));
    test.Check(compared.RunEachStep(&results));
    test.Check(compared.RunSampled(&results));
    test.Check(compared.CountMissed(&results));
    for (size_t i = 0; i < results.size(); i++)
    {
        ck_assert_msg(results[i].counted, "%s", qcComparedQueries[i].label);
        ck_assert_msg(results[i].found == 1 && results[i].missed == 0, "%s", qcComparedQueries[i].label);
        ck_assert_uint_eq(results[i].pcs, 2);
        for (qcBodyId id : {again, cloth})
            ck_assert_uint_eq(compared.Marked(qcComparedQuery(i), id).at(0), 1);
    }
}
END_TEST

START_TEST(only_queries_of_the_present_state_are_compared)
{
    Comparison test;
    qcQueryComparison& compared = *test.compared;
    test.Add(s_flat, false);
    qcBodyId cloth = test.Add(s_crossing, true);
    qcQueryResults old, results;
    test.Check(compared.Run(qc_queryQuick, &old[qc_queryQuick]));
    ck_assert_uint_eq(old[qc_queryQuick].found, 1);
    test.Check(compared.SetVertices(cloth, s_apart));
    test.Check(compared.RunEachStep(&results));
    test.Check(compared.CountMissed(&results));
    ck_assert(results[qc_querySweep].counted && !results[qc_queryQuick].counted);
    ck_assert_uint_eq(results[qc_querySweep].missed, 0);
    ck_assert_uint_eq(compared.Marked(qc_querySweep, cloth).at(0), 0);

    // Begun anew, it has no bodies.
    compared.Clear();
    ck_assert(!compared.SetVertices(cloth, s_apart));
    test.Add(s_flat, false);
    test.Check(compared.RunEachStep(&results));
    ck_assert_uint_eq(results[qc_querySweep].found, 0);
}
END_TEST

QC_RUN_TESTS("query_comparison", a_query_that_runs_late_has_all_changes, only_queries_of_the_present_state_are_compared)
