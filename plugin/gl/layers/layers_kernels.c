// Compiles and dispatches the compute kernels of `layers`.
#include "gl/layers/layers_kernels.h"

#include "base/status.h"
#include "gl/compute.h"
#include "gl/programs.h"
#include "layers_shaders.h"
#include "quickcullide/scene.h"

#include <stddef.h>
#include <stdio.h>

typedef struct KernelShape
{
    const char* name;
    const char* source;
    int localSize; ///< invocations of a workgroup; small where items are few, so that all threads get some
    bool forImage, forPairs;
} KernelShape;

static const KernelShape s_shapes[qc_kernelCount] = {
    [qc_kernelVertices] = {"layers, vertices", s_layersVertices, qc_layersChunkSize, true, true},
    [qc_kernelImageBoxes] = {"layers, groups", s_layersImageBoxes, 64, true, false},
    [qc_kernelImageNodes] = {"layers, nodes and groups", s_layersImageNodes, 16, true, false},
    [qc_kernelNodes] = {"layers, nodes", s_layersNodes, 64, false, true},
    [qc_kernelNodePairs] = {"layers, node pairs", s_layersNodePairs, qc_nodeComparers, false, true},
    [qc_kernelTrianglePairs] = {"layers, triangle pairs", s_layersTrianglePairs, qc_pairInvocations, false, true},
    [qc_kernelPairTests] = {"layers, pair tests", s_layersPairTests, qc_testsOfGroup, false, true},
    [qc_kernelOrder] = {"layers, order", s_layersOrder, qc_orderInvocations, false, true},
};
// As the shaders' uniform block Step has them (std140).
_Static_assert(offsetof(qcLayersParameters, origin) == 128 && sizeof(qcLayersParameters) == 176, "the layout std140");
_Static_assert(8 * qc_maxNodePairs <= qc_pairInvocations, "an invocation for each cluster of a node of each pair");
_Static_assert(sizeof(qcLayersParameters) <= qc_parameterWords * sizeof(uint32_t), "room for the parameters");

/// The constants of a program, as its first source.
static void WriteConstants(char* text, size_t size, int kernel, bool imageOnly)
{
    // For pairs the first kernel copies the step's data for the others.
    bool copies = !imageOnly && kernel == qc_kernelVertices, readsCopy = !imageOnly && !copies;
    int length =
        snprintf(text, size,
                 "#version 430 core\n#define BODY_WORDS %zuu\n#define LOCAL_SIZE %du\n"
                 "#define COUNTER_WORDS %du\n#define BOXES_OF_NODE %d\n#define STEP_BINDING %d\n"
                 "#define PARAMETER_BINDING %d\n#define PARAMETER_WORDS %du\n"
                 "#define SOURCE_BINDING %d\n#define EMPTY_LIST %s\n#define TILE_NODES %du\n"
                 "#define MAX_NODE_PAIRS %du\n#define BUCKET_SIZE %du\n#define PENETRATING %du\n",
                 sizeof(qcLayersBody) / sizeof(uint32_t), s_shapes[kernel].localSize, qc_counterWords, qc_boxesOfNode,
                 readsCopy ? qc_copyBinding : qc_streamBinding, readsCopy ? qc_copiedParameters : qc_streamParameters,
                 qc_parameterWords, qc_sourceBinding, imageOnly ? "none" : "highestLevel", qc_tileNodes,
                 qc_maxNodePairs, qc_bucketSize, qc_relationPenetrating);
    if (copies)
        snprintf(text + length, size - (size_t)length, "#define COPY_BINDING %d\n", qc_copyBinding);
}

static qcStatus GetProgram(const struct qcGlFunctions* gl, qcLayersKernels* kernels, int kernel)
{
    const KernelShape* shape = &s_shapes[kernel];
    char constants[448];
    WriteConstants(constants, sizeof constants, kernel, kernels->imageOnly);
    const char* sources[] = {constants, s_layersCommon, shape->source};
    GLuint program;
    QC_TRY(qcGlPrograms_GetCompute(gl, shape->name, sources, 3, &program));
    kernels->programs[kernel] = program;
    gl->UseProgram(program);
    for (int buffer = 0; buffer < qc_layersBufferCount; buffer++)
        if (qcLayersBuffers_SamplerName(buffer) != NULL)
            gl->Uniform1i(gl->GetUniformLocation(program, qcLayersBuffers_SamplerName(buffer)), buffer);
    if (kernel == qc_kernelVertices)
        kernels->foreign = gl->GetUniformLocation(program, "foreignChunks");
    return qc_statusOk;
}

qcStatus qcLayersKernels_Create(const struct qcGlFunctions* gl, qcLayersKernels* kernels)
{
    if (gl->DispatchCompute == NULL)
        return qcFail(qc_statusDevice, "layers: the device has no compute shaders (GL below 4.3)");
    for (int kernel = 0; kernel < qc_kernelCount; kernel++)
        if (kernels->imageOnly ? s_shapes[kernel].forImage : s_shapes[kernel].forPairs)
            QC_TRY(GetProgram(gl, kernels, kernel));
    return qc_statusOk;
}

/// Later kernels see what a kernel has written, parameters too.
static void FinishForKernels(const struct qcGlFunctions* gl)
{
    qcGl_Counted(gl)->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                                    GL_UNIFORM_BARRIER_BIT);
}

/// The processor sees what the last kernel has written, once a fence is reached. Memory that stays mapped is coherent
/// and needs no barrier for that (GL 4.6, 6.2), and no later kernel begins before the fence.
static void FinishForProcessor(const struct qcGlFunctions* gl)
{
    if (gl->BufferStorage == NULL)
        qcGl_Counted(gl)->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void qcLayersKernels_Run(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, qcLayersKernel kernel,
                         uint64_t groups, bool isLast)
{
    qcGl_Counted(gl)->UseProgram(kernels->programs[kernel]);
    qcGl_Dispatch(gl, groups > 0 ? groups : 1);
    if (isLast)
        FinishForProcessor(gl);
    else
        FinishForKernels(gl);
}

void qcLayersKernels_RunForeign(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, uint32_t first,
                                uint32_t end)
{
    qcGl_Counted(gl)->UseProgram(kernels->programs[qc_kernelVertices]);
    qcGl_Counted(gl)->Uniform2ui(kernels->foreign, first, end);
    qcGl_Dispatch(gl, end > first ? end - first : 1);
    qcGl_Counted(gl)->Uniform2ui(kernels->foreign, 0, 0);
    FinishForKernels(gl);
}
