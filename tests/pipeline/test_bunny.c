// A real mesh, the Stanford bunny: sweep against brute force, pair by pair; pairs of quick are among them.
// The file is the program's argument; without it there is nothing to test.
#include "support/devices.h"
#include "common/mesh_io/mesh_file.h"
#include "support/scenes.h"
#include "support/suite.h"

/// Makes some triangles of a smooth mesh intersect: every vertex moves by up to `size`, on a grid of floats.
static void Crumple(qcMesh* mesh, float size)
{
    qcRandom random = {2005};
    float* positions = mesh->positions;
    for (size_t i = 0; i < 3 * (size_t)mesh->vertexCount; i++)
        positions[i] += (float)qcRandom_Uniform(&random, -size, size);
}

/// The bunny, and a copy of a part of it, moved a little so that both intersect.
static qcScene* MakeScene(qcDevice* device)
{
    qcMesh mesh;
    qcMessage message;
    ck_assert_msg(qcMesh_ReadFile(QC_BUNNY, qc_meshAsDeclared, &mesh, &message), "%s", message.text);
    ck_assert_uint_eq(mesh.triangleCount, 69666);
    ck_assert(!mesh.isDouble);
    Crumple(&mesh, 0.009f);
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = mesh.positions;
    def.vertexCount = mesh.vertexCount;
    def.indices = mesh.indices;
    def.triangleCount = mesh.triangleCount;
    qcScene* scene = qcMakeScene(device);
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    def.triangleCount /= 8;
    def.transform.translation[0] = 0.01;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    qcMesh_Free(&mesh);
    return scene;
}

START_TEST(sweep_equals_brute_force_on_the_bunny)
{
    qcScene* scene = MakeScene(NULL);
    qcDetectDef def = qcDefaultDetectDef();
    def.touching = true;
    def.method = qc_methodBrute;
    qcPairList expected = qcDetectPairs(scene, &def);
    def.method = qc_methodSweep;
    qcPairList found = qcDetectPairs(scene, &def);
    qcCheckSamePairs(&expected, &found, "bunny");
    size_t self = 0;
    for (size_t i = 0; i < found.count; i++)
        self += found.pairs[i].bodyA == found.pairs[i].bodyB;
    ck_assert_uint_gt(self, 100);
    ck_assert_uint_gt(found.count - self, 100);
    free(expected.pairs);
    free(found.pairs);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(every_pair_that_quick_reports_on_the_bunny_is_real)
{
    qcDevice* device = qcOpenOrSkip(qc_deviceOsmesa);
    if (device == NULL)
        return;
    qcScene* scene = MakeScene(device);
    qcDetectDef def = qcDefaultDetectDef();
    qcPairList real = qcDetectPairs(scene, &def);
    def.method = qc_methodQuick;
    def.resolution = 1024;
    def.iterations = 1;
    memcpy(def.views, "z", 2);
    qcPairList found = qcDetectPairs(scene, &def);
    ck_assert_uint_gt(found.count, real.count / 4);
    for (size_t i = 0; i < found.count; i++)
        ck_assert_ptr_nonnull(bsearch(&found.pairs[i], real.pairs, real.count, sizeof(qcPair), qcComparePairs));
    free(real.pairs);
    free(found.pairs);
    qcScene_Destroy(scene);
    qcDevice_Destroy(device);
}
END_TEST

QC_RUN_TESTS("bunny", sweep_equals_brute_force_on_the_bunny, every_pair_that_quick_reports_on_the_bunny_is_real)
