// The caller's floating-point modes: results don't depend on them, and calls leave them unchanged.
#include "support/devices.h"
#include "support/pairs.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <fenv.h>
#include <float.h>
#include <math.h>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

//  ---- modes ---------------------------------------------------------------------------------------

typedef struct Mode
{
    const char* name;
    int rounding;
    unsigned control; ///< bits of MXCSR to change; 0: none
} Mode;

static const Mode s_modes[] = {
    {"rounds up", FE_UPWARD, 0},          {"rounds down", FE_DOWNWARD, 0},
    {"rounds to zero", FE_TOWARDZERO, 0},
#if defined(__x86_64__)
    {"flushes", FE_TONEAREST, 0x8040},    {"flushes and rounds up", FE_UPWARD, 0x8040},
    {"traps", FE_TONEAREST, 0x0680}, // invalid operations, divisions by zero, overflows
#endif
};

enum
{
    qc_modeCount = sizeof s_modes / sizeof s_modes[0]
};

static void Enter(const Mode* mode)
{
    fesetround(mode->rounding);
#if defined(__x86_64__)
    _mm_setcsr(_mm_getcsr() ^ mode->control);
#endif
}

static bool IsIn(const Mode* mode)
{
    bool is = fegetround() == mode->rounding;
#if defined(__x86_64__)
    is = is && (_mm_getcsr() & 0x9fc0u) == (0x1f80u ^ mode->control);
#endif
    return is;
}

/// Returns to the default mode; checks first that the entered mode is unchanged.
static void Leave(const Mode* mode)
{
    bool is = IsIn(mode);
    fesetenv(FE_DFL_ENV);
    if (!is)
        ck_abort_msg("%s: the mode is another one after the call", mode->name);
}

static const Mode s_default = {"default", FE_TONEAREST, 0};

//  ---- two triangles -------------------------------------------------------------------------------

/// A pair of any kind; every other one is subnormal.
static void MakePair(qcRandom* random, int i, qcTrianglePair* pair)
{
    if (i % 2 == 0)
    {
        qcTrianglePair_MakeAny(random, pair);
        return;
    }
    qcTrianglePair_Make(random, (qcPairKind)qcRandom_Below(random, qc_pairIdentical), pair);
    double scale = ldexp(1.0, -1074 + (int)qcRandom_Below(random, 60));
    for (int k = 0; k < 9; k++)
    {
        pair->a[k / 3][k % 3] *= scale;
        pair->b[k / 3][k % 3] *= scale;
    }
}

START_TEST(relations_of_triangles_are_the_same_in_every_mode)
{
    const Mode* mode = &s_modes[_i];
    qcRandom random = {1};
    int counts[4] = {0};
    for (int i = 0; i < 20000; i++)
    {
        qcTrianglePair pair;
        MakePair(&random, i, &pair);
        qcRelation expected = qcRelateTriangles(&pair.a[0][0], &pair.b[0][0]);
        Enter(mode);
        qcRelation found = qcRelateTriangles(&pair.a[0][0], &pair.b[0][0]);
        Leave(mode);
        char text[1024];
        if (found != expected)
            ck_abort_msg("%s: %s, not %s: %s", mode->name, qcRelation_Name(found), qcRelation_Name(expected),
                         qcTrianglePair_Print(&pair, text));
        counts[expected]++;
    }
    ck_assert(counts[0] > 1000 && counts[1] > 1000 && counts[2] > 1000);
}
END_TEST

START_TEST(proximities_are_the_same_in_every_mode)
{
    const Mode* mode = &s_modes[_i];
    qcRandom random = {2};
    int within = 0;
    for (int i = 0; i < 20000; i++)
    {
        qcTrianglePair pair;
        MakePair(&random, i, &pair);
        double margin = qcRandom_Below(&random, 2) ? 0.0 : 0.1 * qcTrianglePair_GetLargest(&pair);
        qcProximity expected, found;
        memset(&expected, 0, sizeof expected);
        memset(&found, 0, sizeof found);
        bool isWithin = qcTrianglesWithin(&pair.a[0][0], &pair.b[0][0], margin, &expected);
        Enter(mode);
        bool foundWithin = qcTrianglesWithin(&pair.a[0][0], &pair.b[0][0], margin, &found);
        Leave(mode);
        char text[1024];
        if (foundWithin != isWithin || memcmp(&found, &expected, sizeof found) != 0)
            ck_abort_msg("%s: margin %g: another answer: %s", mode->name, margin, qcTrianglePair_Print(&pair, text));
        within += isWithin;
    }
    ck_assert_int_gt(within, 5000);
}
END_TEST

START_TEST(certificates_of_motion_are_the_same_in_every_mode)
{
    const Mode* mode = &s_modes[_i];
    qcRandom random = {3};
    int certified = 0;
    for (int i = 0; i < 20000; i++)
    {
        qcTrianglePair start, end;
        MakePair(&random, i, &start);
        end = start;
        qcTrianglePair_MoveByUlps(&random, &end);
        double expected[3] = {0.0, 0.0, 0.0}, found[3] = {0.0, 0.0, 0.0};
        bool isApart = qcTrianglesStayApart(&start.a[0][0], &end.a[0][0], &start.b[0][0], &end.b[0][0], expected);
        Enter(mode);
        bool foundApart = qcTrianglesStayApart(&start.a[0][0], &end.a[0][0], &start.b[0][0], &end.b[0][0], found);
        Leave(mode);
        char text[1024];
        if (foundApart != isApart || memcmp(found, expected, sizeof found) != 0)
            ck_abort_msg("%s: another certificate: %s", mode->name, qcTrianglePair_Print(&start, text));
        certified += isApart;
    }
    ck_assert_int_gt(certified, 2000);
}
END_TEST

//  ---- scenes --------------------------------------------------------------------------------------

typedef struct Question
{
    qcMethod method;
    bool floats;        ///< positions are floats; otherwise doubles
    int exponent;       ///< the scene is scaled by this power of two
    bool rest;          ///< also segments, proximities, manifolds and contacts
    double marginShare; ///< margin relative to the size
} Question;

static const Question s_questions[] = {
    {qc_methodSweep, false, 0, true, 0.0},      {qc_methodSweep, false, 0, true, 0.01},
    {qc_methodBrute, false, 0, true, 0.01},     {qc_methodAuto, true, 0, true, 0.01},
    {qc_methodSweep, false, -1040, false, 0.0}, {qc_methodSweep, false, -1040, false, 0.01},
    {qc_methodBrute, false, -1040, false, 0.0}, {qc_methodSweep, true, -140, false, 0.0},
    {qc_methodLayers, false, 0, true, 0.01},    {qc_methodLayers, false, -1040, false, 0.0},
};

enum
{
    qc_questionCount = sizeof s_questions / sizeof s_questions[0]
};

/// The two bodies of a question, with its type of positions.
typedef struct Bodies
{
    qcSoup soups[2];
    void* positions[2];
} Bodies;

static Bodies MakeBodies(const Question* question)
{
    Bodies bodies = {.soups = {qcSoup_MakeFoldedCloth(5, 24, 0.02, 0.02), qcSoup_MakeSphere(2, 0.4)}};
    for (int b = 0; b < 2; b++)
    {
        size_t count = 3 * (size_t)bodies.soups[b].vertexCount;
        double* wide = malloc(count * sizeof *wide);
        float* narrow = malloc(count * sizeof *narrow);
        ck_assert(wide != NULL && narrow != NULL);
        for (size_t i = 0; i < count; i++)
        {
            wide[i] = ldexp(bodies.soups[b].positions[i], question->exponent);
            narrow[i] = (float)wide[i];
        }
        bodies.positions[b] = question->floats ? (void*)narrow : (void*)wide;
        free(question->floats ? (void*)wide : (void*)narrow);
    }
    return bodies;
}

static void FreeBodies(Bodies* bodies)
{
    for (int b = 0; b < 2; b++)
    {
        qcSoup_Free(&bodies->soups[b]);
        free(bodies->positions[b]);
    }
}

/// Creates a scene, moves it and detects, all in one mode. The result lives as long as the scene.
static const qcResult* Detect(const Mode* mode, const Question* question, qcDevice* device, qcScene** scene)
{
    Bodies bodies = MakeBodies(question);
    const double size = ldexp(1.0, question->exponent);
    const qcTransform transform = {{0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0}, {0.3 * size, 0.1 * size, 0.0}};
    qcPositionType type = question->floats ? qc_positionF32 : qc_positionF64;
    qcBodyDef defs[2] = {qcBodyDefOf(&bodies.soups[0]), qcBodyDefOf(&bodies.soups[1])};
    qcDetectDef def = qcDefaultDetectDef();
    def.method = question->method;
    def.touching = true;
    def.margin = ldexp(question->marginShare, question->exponent);
    def.contactMargin = question->rest ? 0.01 : 0.0;
    def.segments = def.proximities = def.manifolds = question->rest;
    def.threads = 3;
    *scene = qcMakeScene(device);
    const qcResult* result = NULL;
    qcBodyId ids[2];
    qcStatus status = qc_statusOk;
    Enter(mode);
    for (int b = 0; b < 2 && status == qc_statusOk; b++)
    {
        defs[b].positions = bodies.positions[b];
        defs[b].positionType = type;
        defs[b].deforming = b == 0;
        status = qcScene_AddBody(*scene, &defs[b], &ids[b]);
    }
    if (status == qc_statusOk)
        status = qcScene_SetTransform(*scene, ids[1], &transform);
    // From the second time on floats are kept as they are; the start of a motion converts them.
    for (int i = 0; i < 3 && status == qc_statusOk; i++)
    {
        status = qcScene_SetVertices(*scene, ids[0], bodies.positions[0], type, 0);
        if (status == qc_statusOk && i == 2)
            status = qcScene_MarkStart(*scene);
        if (status == qc_statusOk)
            status = qcScene_Detect(*scene, &def, &result);
    }
    Leave(mode);
    CHECK_OK(status);
    FreeBodies(&bodies);
    return result;
}

static void CheckSame(const void* found, const void* expected, size_t count, size_t size, const char* what)
{
    if (count != 0 && memcmp(found, expected, count * size) != 0)
        ck_abort_msg("other %s", what);
}

static void CheckSameResult(const qcResult* found, const qcResult* expected, const char* mode)
{
    qcPairList pairs = qcListOf(expected), others = qcListOf(found);
    qcCheckSamePairs(&pairs, &others, mode);
    ck_assert_uint_eq(found->contactCount, expected->contactCount);
    ck_assert_uint_eq(found->manifoldCount, expected->manifoldCount);
    ck_assert_uint_eq(found->manifoldPointCount, expected->manifoldPointCount);
    if (expected->segments != NULL)
        CheckSame(found->segments, expected->segments, pairs.count, sizeof(qcSegment), "segments");
    if (expected->proximities != NULL)
        CheckSame(found->proximities, expected->proximities, pairs.count, sizeof(qcProximity), "proximities");
    CheckSame(found->contacts, expected->contacts, expected->contactCount, sizeof(qcContact), "contacts");
    CheckSame(found->manifolds, expected->manifolds, expected->manifoldCount, sizeof(qcManifold), "manifolds");
    CheckSame(found->manifoldPoints, expected->manifoldPoints, expected->manifoldPointCount, sizeof(qcManifoldPoint),
              "points");
}

static void CheckQuestion(const Question* question, qcDevice* device)
{
    qcScene *scene, *other;
    const qcResult* expected = Detect(&s_default, question, device, &scene);
    ck_assert_uint_gt(expected->pairCount, 100);
    for (int m = 0; m < qc_modeCount; m++)
    {
        CheckSameResult(Detect(&s_modes[m], question, device, &other), expected, s_modes[m].name);
        qcScene_Destroy(other);
    }
    qcScene_Destroy(scene);
}

START_TEST(results_of_scenes_are_the_same_in_every_mode)
{
    const Question* question = &s_questions[_i];
    if (question->method != qc_methodLayers)
        CheckQuestion(question, NULL);
    else
        QC_FOR_EACH_DEVICE(device)
        {
            qcDeviceInfo info;
            CHECK_OK(qcDevice_GetInfo(device, &info));
            if (info.compute)
                CheckQuestion(question, device);
        }
}
END_TEST

START_TEST(a_device_opened_in_any_mode_gives_the_same_results)
{
    qcScene *scene, *other;
    const Question question = {qc_methodLayers, false, 0, true, 0.01};
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        CHECK_OK(qcDevice_GetInfo(device, &info));
        Enter(&s_modes[_i]);
        qcDevice* opened = qcOpenOrSkip(info.kind);
        Leave(&s_modes[_i]);
        ck_assert_ptr_nonnull(opened);
        if (info.compute)
        {
            const qcResult* expected = Detect(&s_default, &question, device, &scene);
            CheckSameResult(Detect(&s_default, &question, opened, &other), expected, s_modes[_i].name);
            qcScene_Destroy(scene);
            qcScene_Destroy(other);
        }
        qcDevice_Destroy(opened);
    }
}
END_TEST

enum
{
    qc_pictureSize = 64
};

static void Draw(const Mode* mode, qcDevice* device, uint8_t rgb[3 * qc_pictureSize * qc_pictureSize])
{
    // So small that squares of normals become subnormal.
    static const float positions[] = {-1e-10f, -7e-11f,  1e-11f, 1.1e-10f,  -9e-11f, 6e-11f,
                                      2e-11f,  1.3e-10f, 0.0f,   -1.4e-10f, 9e-11f,  -8e-11f};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    qcPictureMesh mesh = {.positions = positions,
                          .vertexCount = 4,
                          .indices = indices,
                          .triangleCount = 2,
                          .color = {0.8f, 0.3f, 0.1f},
                          .smooth = true};
    qcPictureDef def = qcDefaultPictureDef();
    def.width = def.height = qc_pictureSize;
    def.meshes = &mesh;
    def.meshCount = 1;
    def.eye[2] = 5e-10f;
    Enter(mode);
    qcStatus status = qcDevice_DrawPicture(device, &def, rgb);
    Leave(mode);
    CHECK_OK(status);
}

START_TEST(pictures_are_the_same_in_every_mode)
{
    static uint8_t expected[3 * qc_pictureSize * qc_pictureSize], found[sizeof expected];
    QC_FOR_EACH_DEVICE(device)
    {
        Draw(&s_default, device, expected);
        Draw(&s_modes[_i], device, found);
        ck_assert_mem_eq(found, expected, sizeof expected);
    }
}
END_TEST

//  ---- boxes ---------------------------------------------------------------------------------------

enum
{
    qc_boxCount = 200,
    qc_foundRoom = 4 * qc_boxCount * qc_boxCount
};

/// All results of a set of boxes.
typedef struct Answers
{
    uint32_t found[qc_foundRoom];
    size_t count;
    double bounds[qc_boxCount][6], total[6];
    const Mode* mode;
    bool modeIsCallers;
} Answers;

static void Note(Answers* answers, uint32_t number)
{
    if (answers->count < qc_foundRoom)
        answers->found[answers->count] = number;
    answers->count++;
}

static bool Visit(uint32_t id, void* userData, void* context)
{
    (void)userData;
    Answers* answers = context;
    answers->modeIsCallers = answers->modeIsCallers && IsIn(answers->mode);
    Note(answers, id);
    return true;
}

static void NotePairs(Answers* answers, const qcBoxPair* pairs, size_t count)
{
    Note(answers, (uint32_t)count);
    for (size_t i = 0; i < count; i++)
    {
        Note(answers, pairs[i].a);
        Note(answers, pairs[i].b);
    }
}

static void RandomBox(qcRandom* random, int exponent, double lower[3], double upper[3])
{
    for (int k = 0; k < 3; k++)
    {
        lower[k] = ldexp(qcRandom_Integer(random, -40, 40), exponent);
        upper[k] = lower[k] + ldexp(qcRandom_Integer(random, 0, 20), exponent);
    }
}

/// Adds, moves and queries boxes, in coordinates that are small integers times a power of two.
static void AnswerAll(const Mode* mode, int exponent, Answers* answers)
{
    static double boxes[3][qc_boxCount][2][3];
    qcRandom random = {7};
    for (int i = 0; i < 3 * qc_boxCount; i++)
        RandomBox(&random, exponent, boxes[i / qc_boxCount][i % qc_boxCount][0],
                  boxes[i / qc_boxCount][i % qc_boxCount][1]);
    memset(answers, 0, sizeof *answers);
    answers->mode = mode;
    answers->modeIsCallers = true;
    static const double zero[3];
    qcBoxes* set = NULL;
    const qcBoxPair* pairs = NULL;
    size_t count = 0;
    qcBoxChanges changes;
    bool ok = true;
    Enter(mode);
    ok = ok && qcBoxes_Create(&set) == qc_statusOk;
    uint32_t id;
    for (int i = 0; i < qc_boxCount; i++)
        ok = ok && qcBoxes_Add(set, boxes[0][i][0], boxes[0][i][1], NULL, &id) == qc_statusOk;
    ok = ok && qcBoxes_FindMovedPairs(set, &pairs, &count) == qc_statusOk;
    NotePairs(answers, pairs, count);
    for (int step = 1; step < 3; step++)
    {
        for (uint32_t i = 0; i < qc_boxCount; i += (uint32_t)step)
        {
            ok = ok && qcBoxes_Move(set, i, boxes[step][i][0], boxes[step][i][1]) == qc_statusOk;
            if (i < 8)
                qcBoxes_QueryBegun(set, i, Visit, answers);
        }
        ok = ok && qcBoxes_FindChangedPairs(set, &changes) == qc_statusOk;
        NotePairs(answers, changes.began, changes.beganCount);
        NotePairs(answers, changes.ended, changes.endedCount);
    }
    for (int i = 0; i < 20; i++)
        qcBoxes_QueryBox(set, boxes[0][i][0], boxes[0][i][1], Visit, answers);
    for (int i = 0; i < 20; i++)
        qcBoxes_CastBox(set, boxes[0][i][0], boxes[1][i][1], zero, zero, NULL, Visit, answers);
    for (uint32_t i = 0; i < qc_boxCount; i++)
        qcBoxes_GetBounds(set, i, answers->bounds[i], answers->bounds[i] + 3);
    qcBoxes_GetTotalBounds(set, answers->total, answers->total + 3);
    qcBoxes_Destroy(set);
    Leave(mode);
    ck_assert(ok);
}

START_TEST(results_of_boxes_are_the_same_in_every_mode_and_callbacks_run_in_the_callers)
{
    static const int exponents[] = {0, -149, -1074, -1030};
    static Answers expected, found;
    for (int e = 0; e < 4; e++)
    {
        AnswerAll(&s_default, exponents[e], &expected);
        ck_assert_uint_gt(expected.count, 2000);
        ck_assert_uint_le(expected.count, qc_foundRoom);
        AnswerAll(&s_modes[_i], exponents[e], &found);
        ck_assert_uint_eq(found.count, expected.count);
        ck_assert_mem_eq(found.found, expected.found, expected.count * sizeof expected.found[0]);
        ck_assert_mem_eq(found.bounds, expected.bounds, sizeof expected.bounds);
        ck_assert_mem_eq(found.total, expected.total, sizeof expected.total);
        ck_assert(found.modeIsCallers);
    }
}
END_TEST

int main(void)
{
    TCase* tests = qcMakeCase("float modes");
    tcase_add_loop_test(tests, relations_of_triangles_are_the_same_in_every_mode, 0, qc_modeCount);
    tcase_add_loop_test(tests, proximities_are_the_same_in_every_mode, 0, qc_modeCount);
    tcase_add_loop_test(tests, certificates_of_motion_are_the_same_in_every_mode, 0, qc_modeCount);
    tcase_add_loop_test(tests, results_of_scenes_are_the_same_in_every_mode, 0, qc_questionCount);
    tcase_add_loop_test(tests, a_device_opened_in_any_mode_gives_the_same_results, 0, qc_modeCount);
    tcase_add_loop_test(tests, pictures_are_the_same_in_every_mode, 0, qc_modeCount);
    tcase_add_loop_test(tests, results_of_boxes_are_the_same_in_every_mode_and_callbacks_run_in_the_callers, 0,
                        qc_modeCount);
    return qcRunCase("float modes", tests);
}
