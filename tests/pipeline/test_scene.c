// The scene's contract: ids, bad input named and without effect, skips counted, nothing left behind.
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

/// Two crossing triangles and one far away.
static const double s_positions[] = {0, 0,   0,   1, 0, 0, 0, 1, 0, 0.2, 0.2, -1, 0.2, 0.2,
                                     1, 0.3, 0.9, 1, 9, 9, 9, 9, 9, 8,   8,   9,  9};
static const uint32_t s_indices[] = {0, 1, 2, 3, 4, 5, 6, 7, 8};

static qcBodyDef Crossing(void)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = s_positions;
    def.positionType = qc_positionF64;
    def.vertexCount = 9;
    def.indices = s_indices;
    def.triangleCount = 3;
    return def;
}

static qcBodyId Add(qcScene* scene, const qcBodyDef* def)
{
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, def, &id));
    return id;
}

static size_t CountPairs(qcScene* scene)
{
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    return result->pairCount;
}

static void Refused(qcStatus status, const char* place)
{
    ck_assert_int_eq(status, qc_statusBadInput);
    ck_assert_msg(strstr(qcLastMessage(), place) != NULL, "\"%s\" does not name \"%s\"", qcLastMessage(), place);
}

START_TEST(crossing_triangles_of_one_body_are_reported)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = Crossing();
    Add(scene, &def);
    qcDetectDef detect = qcDefaultDetectDef();
    detect.segments = true;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert_uint_eq(result->pairCount, 1);
    ck_assert_uint_eq(result->pairs[0].triangleA, 0);
    ck_assert_uint_eq(result->pairs[0].triangleB, 1);
    ck_assert_int_eq(result->pairs[0].relation, qc_relationPenetrating);
    ck_assert_uint_eq(result->pcsCount, 2);
    ck_assert_str_eq(result->profile.device, "none");
    ck_assert_int_eq(result->profile.method, qc_methodSweep);
    for (int axis = 0; axis < 3; axis++)
        ck_assert(isfinite(result->segments[0].p[axis]));
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(ids_of_removed_bodies_are_refused_also_when_the_slot_is_taken_again)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = Crossing();
    qcBodyId first = Add(scene, &def), second = Add(scene, &def), third = Add(scene, &def);
    ck_assert_uint_eq(first.slot, 0);
    ck_assert_uint_eq(third.slot, 2);
    CHECK_OK(qcScene_RemoveBody(scene, second));
    ck_assert(!qcScene_IsValid(scene, second));
    Refused(qcScene_RemoveBody(scene, second), "slot 1");
    CHECK_OK(qcScene_RemoveBody(scene, first));
    qcBodyId again = Add(scene, &def);
    ck_assert_uint_eq(again.slot, 0);
    ck_assert_uint_ne(again.generation, first.generation);
    ck_assert(qcScene_IsValid(scene, again));
    ck_assert(!qcScene_IsValid(scene, first));
    ck_assert(qcScene_IsValid(scene, third));
    ck_assert_uint_eq(qcScene_GetBodyCount(scene), 2);
    qcBodyId none = {0, 0};
    ck_assert(!qcScene_IsValid(scene, none));
    Refused(qcScene_SetActivity(scene, none, qc_activityMoving), "generation 0");
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(bad_bodies_are_refused_with_the_place_and_change_nothing)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef good = Crossing();
    Add(scene, &good);
    ck_assert_uint_eq(CountPairs(scene), 1);
    size_t bytes = qcGetByteCount();

    qcBodyId id = {77, 77};
    double positions[27];
    memcpy(positions, s_positions, sizeof positions);
    qcBodyDef def = Crossing();
    def.positions = positions;
    positions[3 * 7 + 1] = (double)NAN;
    Refused(qcScene_AddBody(scene, &def, &id), "vertex 7 of body 1 is not finite");
    positions[3 * 7 + 1] = HUGE_VAL;
    Refused(qcScene_AddBody(scene, &def, &id), "vertex 7 of body 1 is not finite");

    uint32_t indices[9];
    memcpy(indices, s_indices, sizeof indices);
    indices[4] = 9;
    def = Crossing();
    def.indices = indices;
    Refused(qcScene_AddBody(scene, &def, &id), "triangle 1 of body 1: corner 1 has index 9");

    def = Crossing();
    def.positions = NULL;
    Refused(qcScene_AddBody(scene, &def, &id), "positions is null");
    def = Crossing();
    def.indices = NULL;
    Refused(qcScene_AddBody(scene, &def, &id), "indices is null");
    def = Crossing();
    def.positionStride = 8;
    Refused(qcScene_AddBody(scene, &def, &id), "stride of 8 bytes");
    def = Crossing();
    def.positionType = (qcPositionType)5;
    Refused(qcScene_AddBody(scene, &def, &id), "position type 5");
    def = Crossing();
    def.activity = (qcActivity)9;
    Refused(qcScene_AddBody(scene, &def, &id), "activity 9");
    def = Crossing();
    def.structSize = 4;
    Refused(qcScene_AddBody(scene, &def, &id), "structSize of qcBodyDef is 4");
    def = Crossing();
    def.transform.linear[4] = (double)NAN;
    Refused(qcScene_AddBody(scene, &def, &id), "linear[4] is not finite");
    def = Crossing();
    def.transform.linear[0] = 1e308;
    def.transform.linear[1] = 1e308;
    Refused(qcScene_AddBody(scene, &def, &id), "takes vertex 6");
    def = Crossing();
    def.margin = -1.0;
    Refused(qcScene_AddBody(scene, &def, &id), "body 1: the margin is -1");
    Refused(qcScene_AddBody(NULL, &good, &id), "scene is null");
    Refused(qcScene_AddBody(scene, NULL, &id), "def is null");
    Refused(qcScene_AddBody(scene, &good, NULL), "id is null");

    ck_assert_uint_eq(id.slot, 77);
    ck_assert_uint_eq(qcScene_GetBodyCount(scene), 1);
    ck_assert_uint_eq(qcGetByteCount(), bytes);
    ck_assert_uint_eq(CountPairs(scene), 1);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(bad_updates_are_refused_and_change_nothing)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = Crossing();
    qcBodyId rigid = Add(scene, &def);
    def.deforming = true;
    qcBodyId cloth = Add(scene, &def);
    CHECK_OK(qcScene_SetFilter(scene, cloth, 0, 0));
    ck_assert_uint_eq(CountPairs(scene), 2);

    double positions[27] = {0};
    positions[26] = (double)NAN;
    Refused(qcScene_SetVertices(scene, cloth, positions, qc_positionF64, 0), "vertex 8 of body 1 is not finite");
    Refused(qcScene_SetVertices(scene, cloth, NULL, qc_positionF64, 0), "positions is null");
    Refused(qcScene_SetVertices(scene, rigid, s_positions, qc_positionF64, 0), "body 0 is rigid");
    qcTransform transform = qcIdentityTransform();
    Refused(qcScene_SetTransform(scene, cloth, &transform), "body 1 is deforming");
    Refused(qcScene_SetTransform(scene, rigid, NULL), "transform is null");
    transform.translation[2] = HUGE_VAL;
    Refused(qcScene_SetTransform(scene, rigid, &transform), "translation[2] is not finite");
    transform = qcIdentityTransform();
    transform.linear[8] = 1e308;
    transform.linear[7] = 1e308;
    Refused(qcScene_SetTransform(scene, rigid, &transform), "takes vertex 5");
    Refused(qcScene_SetMargin(scene, rigid, -0.5), "body 0: the margin is -0.5");
    Refused(qcScene_SetMargin(scene, rigid, (double)NAN), "body 0: the margin is");
    ck_assert_uint_eq(CountPairs(scene), 2);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(bad_requests_are_refused_with_the_field)
{
    qcScene* scene = qcMakeScene(NULL);
    const qcResult* result = (const qcResult*)scene;
    qcDetectDef def = qcDefaultDetectDef();
    def.method = (qcMethod)42;
    Refused(qcScene_Detect(scene, &def, &result), "unknown method 42");
    def = qcDefaultDetectDef();
    def.method = qc_methodCullide;
    def.resolution = 0;
    Refused(qcScene_Detect(scene, &def, &result), "resolution is 0");
    def.resolution = 4097;
    Refused(qcScene_Detect(scene, &def, &result), "resolution is 4097");
    const char* const bad[] = {"", "xx", "xyx", "w", "xyzx", "X"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        def = qcDefaultDetectDef();
        def.method = qc_methodQuick;
        memset(def.views, 0, sizeof def.views);
        memcpy(def.views, bad[i], strlen(bad[i]));
        Refused(qcScene_Detect(scene, &def, &result), "views");
    }
    def = qcDefaultDetectDef();
    def.structSize++;
    Refused(qcScene_Detect(scene, &def, &result), "structSize of qcDetectDef");
    ck_assert_ptr_eq(result, (const qcResult*)scene);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(positions_of_any_type_and_stride_mean_the_same)
{
    typedef struct Vertex
    {
        char tag;
        float position[3];
        double other;
    } Vertex;
    Vertex vertices[9];
    for (int v = 0; v < 9; v++)
        for (int axis = 0; axis < 3; axis++)
            vertices[v].position[axis] = (float)s_positions[3 * v + axis];
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = Crossing();
    def.positions = vertices[0].position;
    def.positionType = qc_positionF32;
    def.positionStride = sizeof(Vertex);
    Add(scene, &def);
    ck_assert_uint_eq(CountPairs(scene), 1);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(moved_deformed_and_filtered_bodies_change_the_result)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = Crossing();
    def.selfCollision = false;
    qcBodyId a = Add(scene, &def);
    def.deforming = true;
    qcBodyId b = Add(scene, &def);
    size_t overlapping = CountPairs(scene);
    ck_assert_uint_ge(overlapping, 3); // each triangle with its twin
    qcTransform away = qcIdentityTransform();
    away.translation[0] = 100;
    CHECK_OK(qcScene_SetTransform(scene, a, &away));
    ck_assert_uint_eq(CountPairs(scene), 0);
    double positions[27];
    for (int i = 0; i < 27; i++)
        positions[i] = s_positions[i] + (i % 3 == 0 ? 100.0 : 0.0);
    CHECK_OK(qcScene_SetVertices(scene, b, positions, qc_positionF64, 0));
    ck_assert_uint_eq(CountPairs(scene), overlapping);
    CHECK_OK(qcScene_SetFilter(scene, b, 2, 2));
    ck_assert_uint_eq(CountPairs(scene), 0);
    CHECK_OK(qcScene_SetFilter(scene, b, 1, 1));
    ck_assert_uint_eq(CountPairs(scene), overlapping);
    CHECK_OK(qcScene_SetSelfCollision(scene, b, true));
    ck_assert_uint_eq(CountPairs(scene), overlapping + 1);
    CHECK_OK(qcScene_SetActivity(scene, a, qc_activityStatic));
    CHECK_OK(qcScene_SetActivity(scene, b, qc_activitySleeping));
    ck_assert_uint_eq(CountPairs(scene), 0);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(an_unchanged_scene_reuses_its_last_result)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = Crossing();
    qcBodyId id = Add(scene, &def);
    qcDetectDef detect = qcDefaultDetectDef();
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert(!result->profile.reused);
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert(result->profile.reused);
    ck_assert_uint_eq(result->pairCount, 1);
    detect.touching = true;
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert(!result->profile.reused);
    qcTransform identity = qcIdentityTransform();
    CHECK_OK(qcScene_SetTransform(scene, id, &identity));
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert(!result->profile.reused);
    CHECK_OK(qcScene_SetActivity(scene, id, qc_activityMoving)); // as it was
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert(result->profile.reused);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(an_empty_scene_and_empty_bodies_have_no_pairs)
{
    qcScene* scene = qcMakeScene(NULL);
    ck_assert_uint_eq(CountPairs(scene), 0);
    qcBodyDef def = qcDefaultBodyDef();
    Add(scene, &def);
    def.deforming = true;
    qcBodyId id = Add(scene, &def);
    ck_assert_uint_eq(CountPairs(scene), 0);
    CHECK_OK(qcScene_SetVertices(scene, id, NULL, qc_positionF32, 0));
    ck_assert_uint_eq(CountPairs(scene), 0);
    qcScene_Destroy(scene);
    qcScene_Destroy(NULL);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(methods_relations_and_statuses_have_names)
{
    ck_assert_str_eq(qcMethod_Name(qc_methodQuick), "quick");
    ck_assert_str_eq(qcRelation_Name(qc_relationTouching), "touching");
    ck_assert_str_eq(qcStatus_Name(qc_statusOutOfMemory), "out of memory");
    ck_assert_str_eq(qcStatus_Name(qc_statusDeviceLost), "device lost");
    ck_assert_str_eq(qcStatus_Name(qc_statusFile), "file");
    ck_assert_str_eq(qcStatus_Name(qc_statusBadInput), "bad input");
    ck_assert_str_eq(qcStatus_Name(qc_statusDevice), "device");
    ck_assert_str_eq(qcStatus_Name(qc_statusTooManyPairs), "too many pairs");
    ck_assert_str_eq(qcStatus_Name((qcStatus)99), "unknown status");
    ck_assert_str_eq(qcMethod_Name((qcMethod)99), "unknown method");
}
END_TEST

QC_RUN_TESTS("scene", crossing_triangles_of_one_body_are_reported,
             ids_of_removed_bodies_are_refused_also_when_the_slot_is_taken_again,
             bad_bodies_are_refused_with_the_place_and_change_nothing, bad_updates_are_refused_and_change_nothing,
             bad_requests_are_refused_with_the_field, positions_of_any_type_and_stride_mean_the_same,
             moved_deformed_and_filtered_bodies_change_the_result, an_unchanged_scene_reuses_its_last_result,
             an_empty_scene_and_empty_bodies_have_no_pairs, methods_relations_and_statuses_have_names)
