// Two crossing triangles, through the installed headers and library.
#include <quickcullide/quickcullide.h>

#include <stdio.h>

int main(void)
{
    static const float positions[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 1, -1}, {0, 1, 1}, {0, -1, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 3, 4, 5};
    qcScene* scene = NULL;
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcBodyDef bodyDef = qcDefaultBodyDef();
    bodyDef.positions = positions;
    bodyDef.vertexCount = 6;
    bodyDef.indices = indices;
    bodyDef.triangleCount = 2;
    qcDetectDef detectDef = qcDefaultDetectDef();
    qcBodyId id;
    const qcResult* result = NULL;
    if (qcScene_Create(&sceneDef, &scene) != qc_statusOk || qcScene_AddBody(scene, &bodyDef, &id) != qc_statusOk ||
        qcScene_Detect(scene, &detectDef, &result) != qc_statusOk)
    {
        fprintf(stderr, "%s\n", qcLastMessage());
        return 1;
    }
    size_t pairs = result->pairCount;
    qcScene_Destroy(scene);
    printf("%zu pairs\n", pairs);
    return pairs == 1 && qcGetByteCount() == 0 ? 0 : 1;
}
