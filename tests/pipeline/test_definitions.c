// Definitions of other versions of the headers: smaller structs get defaults, larger ones are taken if the rest is 0.
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>
#include <stddef.h>

static const float s_triangle[9] = {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
static const uint32_t s_indices[3] = {0, 1, 2};

static qcBodyDef OneTriangle(void)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = s_triangle;
    def.vertexCount = 3;
    def.indices = s_indices;
    def.triangleCount = 1;
    return def;
}

static qcDevice* MakeNoDevice(void)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = qc_deviceNone;
    qcDevice* device = NULL;
    CHECK_OK(qcDevice_Create(&def, &device));
    return device;
}

static void IsRefused(qcStatus status, const char* message)
{
    ck_assert_int_eq(status, qc_statusBadInput);
    ck_assert_msg(strstr(qcLastMessage(), message) != NULL, "\"%s\" lacks \"%s\"", qcLastMessage(), message);
}

START_TEST(fields_beyond_a_smaller_body_definition_have_their_defaults)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = OneTriangle();
    qcBodyId id;
    def.margin = -1.0;
    IsRefused(qcScene_AddBody(scene, &def, &id), "margin");
    def.structSize = (uint32_t)offsetof(qcBodyDef, margin);
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    // Its positions alone: no vertices, no triangles, whatever the fields behind contain.
    def.structSize = (uint32_t)offsetof(qcBodyDef, positionType);
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    def.structSize = (uint32_t)offsetof(qcBodyDef, positions);
    IsRefused(qcScene_AddBody(scene, &def, &id), "structSize of qcBodyDef");
    ck_assert_uint_eq(qcScene_GetBodyCount(scene), 2);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(fields_beyond_a_smaller_detect_definition_have_their_defaults)
{
    qcScene* scene = qcMakeScene(NULL);
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result;
    def.method = qc_methodQuick;
    def.resolution = 0;
    IsRefused(qcScene_Detect(scene, &def, &result), "resolution is 0");
    def.structSize = (uint32_t)offsetof(qcDetectDef, resolution);
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    def.structSize = (uint32_t)offsetof(qcDetectDef, method);
    IsRefused(qcScene_Detect(scene, &def, &result), "structSize of qcDetectDef");
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(fields_beyond_a_smaller_device_definition_have_their_defaults)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDevice* device = NULL;
    def.kind = qc_deviceNone;
    def.gpuName = "a GPU";
    IsRefused(qcDevice_Create(&def, &device), "select a GPU for kind egl only; def->kind is none");
    def.structSize = (uint32_t)offsetof(qcDeviceDef, gpuName);
    CHECK_OK(qcDevice_Create(&def, &device));
    qcDevice_Destroy(device);
    def.structSize = (uint32_t)offsetof(qcDeviceDef, kind);
    IsRefused(qcDevice_Create(&def, &device), "structSize of qcDeviceDef");
}
END_TEST

START_TEST(fields_beyond_a_smaller_picture_definition_have_their_defaults)
{
    qcDevice* device = MakeNoDevice();
    qcPictureDef def = qcDefaultPictureDef();
    uint8_t rgb[3];
    def.background[0] = NAN;
    def.meshCount = 1;
    IsRefused(qcDevice_DrawPicture(device, &def, rgb), "background");
    def.structSize = (uint32_t)offsetof(qcPictureDef, background);
    // Accepted, and then there is nothing to draw with.
    ck_assert_int_eq(qcDevice_DrawPicture(device, &def, rgb), qc_statusDevice);
    def.structSize = (uint32_t)offsetof(qcPictureDef, width);
    IsRefused(qcDevice_DrawPicture(device, &def, rgb), "structSize of qcPictureDef");
    qcDevice_Destroy(device);
}
END_TEST

START_TEST(a_scene_definition_without_a_device_field_is_refused)
{
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene = NULL;
    def.structSize = (uint32_t)offsetof(qcSceneDef, device);
    IsRefused(qcScene_Create(&def, &scene), "structSize of qcSceneDef");
    ck_assert_ptr_null(scene);
}
END_TEST

START_TEST(a_larger_definition_is_accepted_if_the_rest_is_zero)
{
    struct
    {
        qcBodyDef def;
        unsigned char newer[256 + 4];
    } body = {.def = OneTriangle()};
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId id;
    body.def.structSize = sizeof(qcBodyDef) + 256;
    CHECK_OK(qcScene_AddBody(scene, &body.def, &id));
    body.newer[256] = 1; // beyond the definition
    CHECK_OK(qcScene_AddBody(scene, &body.def, &id));
    body.newer[255] = 1;
    IsRefused(qcScene_AddBody(scene, &body.def, &id), "a field that this version of the library doesn't have is set");
    body.newer[255] = 0;
    body.def.structSize = sizeof(qcBodyDef) + 2;
    IsRefused(qcScene_AddBody(scene, &body.def, &id), "structSize of qcBodyDef");
    ck_assert_uint_eq(qcScene_GetBodyCount(scene), 2);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(an_uninitialised_size_is_refused_without_reading_that_far)
{
    // An address sanitizer would report the read.
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene = NULL;
    def.structSize = 0xcdcdcdccu;
    IsRefused(qcScene_Create(&def, &scene), "structSize of qcSceneDef");
    def.structSize = sizeof(qcSceneDef) + 260;
    IsRefused(qcScene_Create(&def, &scene), "structSize of qcSceneDef");
    def.structSize = 0;
    IsRefused(qcScene_Create(&def, &scene), "structSize of qcSceneDef");
}
END_TEST

QC_RUN_TESTS("definitions", fields_beyond_a_smaller_body_definition_have_their_defaults,
             fields_beyond_a_smaller_detect_definition_have_their_defaults,
             fields_beyond_a_smaller_device_definition_have_their_defaults,
             fields_beyond_a_smaller_picture_definition_have_their_defaults,
             a_scene_definition_without_a_device_field_is_refused, a_larger_definition_is_accepted_if_the_rest_is_zero,
             an_uninitialised_size_is_refused_without_reading_that_far)
