// The C library without Bullet: lists the intersecting triangles of a mesh. Returns 0 if there is exactly one pair.
#include <quickcullide/quickcullide.h>
#include <stdio.h>

int main(void)
{
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.2f, 0.2f, -1, 0.2f, 0.2f, 1, 0.4f, 0.9f, 1};
    const uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    qcDeviceDef deviceDef = qcDefaultDeviceDef(); // a GPU, or software GL, or none
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcBodyDef body = qcDefaultBodyDef();
    body.positions = positions, body.vertexCount = 6, body.indices = indices, body.triangleCount = 2;
    qcDetectDef detect = qcDefaultDetectDef(); // detect.method = qc_methodQuick: the paper's method
    qcStatus status = qcDevice_Create(&deviceDef, &sceneDef.device);

    qcScene* scene = NULL;
    qcBodyId id;
    const qcResult* result = NULL;
    if (status == qc_statusOk)
        status = qcScene_Create(&sceneDef, &scene);
    if (status == qc_statusOk)
        status = qcScene_AddBody(scene, &body, &id);
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &detect, &result);
    for (size_t i = 0; status == qc_statusOk && i < result->pairCount; i++)
        printf("triangles %u and %u\n", result->pairs[i].triangleA, result->pairs[i].triangleB);

    if (status != qc_statusOk)
        printf("%s: %s\n", qcStatus_Name(status), qcLastMessage());
    size_t count = result != NULL ? result->pairCount : 0;
    qcScene_Destroy(scene); // and its result
    qcDevice_Destroy(sceneDef.device);
    return count == 1 ? 0 : 1;
}
